// Distances at the corners of cubic cells that are finer where the field bends: what stands in for a dear field
// (sdfprt/lattice.py; adaptively sampled distance fields, Frisken et al. 2000).
struct Lattice : Simd {
    const int *entry, *record;     // see Lattice of sdfprt/lattice.py
    int nx, ny, nz;                // coarse cells, 0 where there is no lattice
    float ox, oy, oz, cell, unit;  // first corner, side of a coarse cell, distance of one integer
    float error;                   // of a distance near the surface

    inline CUDA_CALLABLE void read(const int* entries, const int* records, const float* frame) {
        entry = entries;
        record = records;
        nx = (int)frame[0];
        ny = (int)frame[1];
        nz = (int)frame[2];
        ox = frame[3];
        oy = frame[4];
        oz = frame[5];
        cell = frame[6];
        unit = frame[7];
        error = frame[8];
    }

    // Interpolated distance, and the side of the cell it is of; `rough` where it does not hold
    inline CUDA_CALLABLE F at(F x, F y, F z, F& side, M& rough) const {
        const float scale = 1.0f / cell;
        F u = clamp((x - ox) * scale, splat(0.0f), splat((float)nx - 0.001f));
        F v = clamp((y - oy) * scale, splat(0.0f), splat((float)ny - 0.001f));
        F w = clamp((z - oz) * scale, splat(0.0f), splat((float)nz - 0.001f));

        // Whole places in the cells of the third level; of a finer cell among its 64, z slowest
        const I i = to_I(16.0f * u), j = to_I(16.0f * v), k = to_I(16.0f * w);
        const I second = ((k >> 2 & 3) << 4) + ((j >> 2 & 3) << 2) + (i >> 2 & 3);
        const I from = gather(entry, ((k >> 4) * ny + (j >> 4)) * nx + (i >> 4));
        const M fine = eq(from & 1, splat(1));
        const I place = (from >> 1) + sel(fine, second, splat(0));
        I low, high, far_low, far_high;  // two neighbours along x in a word
        gather(record, place << 2, low, high, far_low, far_high);

        // An odd first corner: the cells of the third level begin at the record that the second word tells, -1 where even those
        // do not hold
        const M finer = eq(low & 1, splat(1));
        rough = finer & lt(high, splat(0));
        if (any(finer & ~rough)) {
            const I third = ((k & 3) << 4) + ((j & 3) << 2) + (i & 3);
            gather(record, sel(finer & ~rough, high + third, place) << 2, low, high, far_low, far_high);
            rough = rough | (finer & eq(low & 1, splat(1)));
        }
        const F parts = sel(finer, splat(16.0f), sel(fine, splat(4.0f), splat(1.0f)));
        side = cell / parts;
        u *= parts;
        v *= parts;
        w *= parts;
        const F a = u - to_F(to_I(u)), b = v - to_F(to_I(v)), c = w - to_F(to_I(w));
        const F near = mix(along(low, a), along(high, a), b), far = mix(along(far_low, a), along(far_high, a), b);
        return mix(near, far, c) * unit;
    }

    static inline CUDA_CALLABLE F along(I word, F a) { return mix(to_F((word << 16) >> 16), to_F(word >> 16), a); }
};
