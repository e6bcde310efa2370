// Distances as planes in cubic cells that are finer where the field bends: what stands in for a dear field (sdfprt/lattice.py;
// adaptively sampled distance fields, Frisken et al. 2000).
struct Lattice : Simd {
    const int* record;             // see Lattice of sdfprt/lattice.py
    int nx, ny;                    // coarse cells along x and y, 0 where there is no lattice
    float ox, oy, oz, cell, unit;  // first corner, side of a coarse cell, distance of one integer
    float error;                   // of a distance near the surface

    inline CUDA_CALLABLE void read(const int* records, const float* frame) {
        record = records;
        nx = (int)frame[0];
        ny = (int)frame[1];
        ox = frame[2];
        oy = frame[3];
        oz = frame[4];
        cell = frame[5];
        unit = frame[6];
        error = frame[7];
    }

    // Distance by the plane, and the side of the cell it is of; `rough` where it does not hold. Places lie in the lattice.
    inline CUDA_CALLABLE F at(F x, F y, F z, F& side, M& rough) const {
        const float scale = 1.0f / cell;
        const F u = (x - ox) * scale, v = (y - oy) * scale, w = (z - oz) * scale;
        I place = to_I(fma(trunc(w), splat((float)(nx * ny)), fma(trunc(v), splat((float)nx), trunc(u))));
        I low, high;
        gather_pairs(record, place, low, high);

        // An odd first word: the 64 finer cells, z slowest, begin at the record that the second tells, -1 where none hold
        const I i = to_I(16.0f * u), j = to_I(16.0f * v), k = to_I(16.0f * w);
        F parts = splat(1.0f);
        side = splat(cell);
        for (int shift = 2; shift >= 0; shift -= 2) {
            const M cut = eq(low & 1, splat(1)) & le(splat(0), high);
            if (!any(cut)) break;
            const I inner = ((k >> shift & 3) << 4) + ((j >> shift & 3) << 2) + (i >> shift & 3);
            place = sel(cut, high + inner, place);
            parts = sel(cut, 4.0f * parts, parts);
            side = sel(cut, 0.25f * side, side);
            gather_pairs(record, place, low, high);
        }
        rough = eq(low & 1, splat(1));
        const F a = part(parts * u), b = part(parts * v), c = part(parts * w);
        const F rest = to_F((high << 16) >> 16) * b + to_F(high >> 16) * c;
        return (to_F((low << 16) >> 16) + to_F(low >> 16) * a + rest) * unit;
    }

    static inline CUDA_CALLABLE F part(F a) { return a - trunc(a); }
};
