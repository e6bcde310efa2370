// Distances at the corners of cubic cells over the bounds, 16 bits each, rounded down: cheap steps while the surface is far.
struct Grid : Simd {
    const short* data;
    const int* counts;     // corners along x, y, z
    const float* measure;  // origin x, y, z, cells per length, distance per count, what interpolation may overestimate

    // A lower bound of the safe step at x, y, z, negative near the surface: trilinear, less that margin
    inline CUDA_CALLABLE F bound(F x, F y, F z) const {
        const F gx = clamped((x - measure[0]) * measure[3], counts[0]);
        const F gy = clamped((y - measure[1]) * measure[3], counts[1]);
        const F gz = clamped((z - measure[2]) * measure[3], counts[2]);
        const I ix = to_I(gx), iy = to_I(gy), iz = to_I(gz);
        const F fx = gx - to_F(ix), fy = gy - to_F(iy), fz = gz - to_F(iz);
        const I base = (ix * counts[1] + iy) * counts[2] + iz;
        const int right = counts[1] * counts[2];
        const F a = along(base, fz), b = along(base + counts[2], fz);
        const F c = along(base + right, fz), d = along(base + right + counts[2], fz);
        const F low = fma(fy, b - a, a), high = fma(fy, d - c, c);
        return fma(fx, high - low, low) * measure[4] - measure[5];
    }

    // Between a corner and the next along z
    inline CUDA_CALLABLE F along(I at, F f) const {
#if SDFPRT_LANES == 1
        const F low = (float)data[at], high = (float)data[at + 1];
#else
        I pair = splat(0);
        for (int k = 0; k < SDFPRT_LANES; k++) {  // both in one load
            int both;
            __builtin_memcpy(&both, data + lane(at, k), 4);
            set(pair, k, both);
        }
        const F low = to_F((pair << 16) >> 16), high = to_F(pair >> 16);
#endif
        return fma(f, high - low, low);
    }

    static inline CUDA_CALLABLE F clamped(F v, int count) {
        return min(max(v, splat(0.0f)), splat((float)count - 1.001f));
    }
};
