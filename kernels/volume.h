// Textures of three dimensions and one channel, x fastest, as OpenGL reads them: linear between texel centres, clamped at the faces.
struct Volume : Simd {
    static inline CUDA_CALLABLE F fetch(const float* data, int nx, int ny, int nz, I x, I y, I z) {
        return gather(data, (clamp_index(z, nz) * ny + clamp_index(y, ny)) * nx + clamp_index(x, nx));
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
