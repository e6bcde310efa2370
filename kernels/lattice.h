// Distances at the corners of cubic cells, as 16-bit integers: what stands in for a dear field (sdfprt/lattice.py).
struct Lattice : Simd {
    const short* corner;           // x fastest; the lowest bit of a cell's first corner: interpolation does not hold in it
    int nx, ny, nz;                // corners, 0 where there is no lattice
    float ox, oy, oz, cell, unit;  // first corner, side of a cell, distance of one integer

    inline CUDA_CALLABLE void read(const short* corners, const float* frame) {
        corner = corners;
        nx = (int)frame[0];
        ny = (int)frame[1];
        nz = (int)frame[2];
        ox = frame[3];
        oy = frame[4];
        oz = frame[5];
        cell = frame[6];
        unit = frame[7];
    }

    // Interpolated distance; `rough` where it does not hold
    inline CUDA_CALLABLE F at(F x, F y, F z, M& rough) const {
        const float scale = 1.0f / cell;
        const F u = clamp((x - ox) * scale, splat(0.0f), splat((float)nx - 1.01f));
        const F v = clamp((y - oy) * scale, splat(0.0f), splat((float)ny - 1.01f));
        const F w = clamp((z - oz) * scale, splat(0.0f), splat((float)nz - 1.01f));
        const I i = to_I(u), j = to_I(v), k = to_I(w), first = (k * ny + j) * nx + i;

        // Two neighbours along x lie in one word
        int at[SDFPRT_LANES], word[4][SDFPRT_LANES];
        spill(at, first);
        for (int n = 0; n < SDFPRT_LANES; n++) {
            const short* from = corner + at[n];
            word[0][n] = pair(from);
            word[1][n] = pair(from + nx);
            word[2][n] = pair(from + nx * ny);
            word[3][n] = pair(from + nx * ny + nx);
        }
        const I near_low = fill(word[0]), near_high = fill(word[1]), far_low = fill(word[2]), far_high = fill(word[3]);
        rough = eq(near_low & 1, splat(1));
        const F a = u - to_F(i), b = v - to_F(j), c = w - to_F(k);
        const F near = mix(along(near_low, a), along(near_high, a), b), far = mix(along(far_low, a), along(far_high, a), b);
        return mix(near, far, c) * unit;
    }

    static inline CUDA_CALLABLE int pair(const short* from) { return (int)(unsigned short)from[0] | ((int)from[1] << 16); }
    static inline CUDA_CALLABLE F along(I word, F a) { return mix(to_F((word << 16) >> 16), to_F(word >> 16), a); }
};
