// Textures of three dimensions and one channel, x fastest, as OpenGL reads them: linear between texel centres, clamped at the faces.
struct Volume : Simd {
    static inline CUDA_CALLABLE F fetch(const float* data, int nx, int ny, int nz, I x, I y, I z) {
        return gather(data, (clamp_index(z, nz) * ny + clamp_index(y, ny)) * nx + clamp_index(x, nx));
    }
    static inline CUDA_CALLABLE F texel(const float* data, int nx, int ny, int nz, I x, I y, I z) {  // nothing outside
        const M inside = eq(x, clamp_index(x, nx)) & eq(y, clamp_index(y, ny)) & eq(z, clamp_index(z, nz));
        return sel(inside, fetch(data, nx, ny, nz, x, y, z), splat(0.0f));
    }
    static inline CUDA_CALLABLE F sample(const float* data, int nx, int ny, int nz, F u, F v, F w) {
        // Clamped before the floor: far outside, an integer would not hold the place
        const F x = clamp(u * (float)nx - 0.5f, splat(0.0f), splat((float)(nx - 1)));
        const F y = clamp(v * (float)ny - 0.5f, splat(0.0f), splat((float)(ny - 1)));
        const F z = clamp(w * (float)nz - 0.5f, splat(0.0f), splat((float)(nz - 1)));
        const I i = to_I_safe(floor(x)), j = to_I_safe(floor(y)), k = to_I_safe(floor(z));
        const F a = x - to_F(i), b = y - to_F(j), c = z - to_F(k);
        F r = splat(0.0f);
        for (int corner = 0; corner < 8; corner++) {
            const int p = corner & 1, q = (corner >> 1) & 1, s = corner >> 2;
            r += fetch(data, nx, ny, nz, i + p, j + q, k + s) * (p ? a : 1.0f - a) * (q ? b : 1.0f - b) * (s ? c : 1.0f - c);
        }
        return r;
    }
};
// Pictures of four channels, lowest row first: one of the channels, linear between texel centres, repeated.
struct Picture : Simd {
    static inline CUDA_CALLABLE F fetch(const float* data, int nx, int ny, I x, I y) {
        return gather(data, clamp_index(y, ny) * nx + clamp_index(x, nx));
    }
    static inline CUDA_CALLABLE F texel(const float* data, int nx, int ny, I x, I y) {  // nothing outside
        const M inside = eq(x, clamp_index(x, nx)) & eq(y, clamp_index(y, ny));
        return sel(inside, fetch(data, nx, ny, x, y), splat(0.0f));
    }
    static inline CUDA_CALLABLE F sample(const float* data, int nx, int ny, F u, F v) {
        const F x = fract(u) * (float)nx - 0.5f, y = fract(v) * (float)ny - 0.5f;
        const F left = floor(x), low = floor(y), a = x - left, b = y - low;
        const I i = to_I_safe(left), j = to_I_safe(low);
        const I from = sel(lt(i, splat(0)), splat(nx - 1), i), to = sel(lt(i + 1, splat(nx)), i + 1, splat(0));
        const I down = sel(lt(j, splat(0)), splat(ny - 1), j), up = sel(lt(j + 1, splat(ny)), j + 1, splat(0));
        const F lower = mix(fetch(data, nx, ny, from, down), fetch(data, nx, ny, to, down), a);
        return mix(lower, mix(fetch(data, nx, ny, from, up), fetch(data, nx, ny, to, up), a), b);
    }
};
