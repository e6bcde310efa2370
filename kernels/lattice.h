// Distances as planes in cubic cells that are finer where the field bends: what stands in for a dear field (sdfprt/lattice.py;
// adaptively sampled distance fields, Frisken et al. 2000). Lengths and places are in sides of a coarse cell, from the first
// corner; where there is no lattice, in scene units.
struct Lattice : Simd {
    const int* record;             // see Lattice of sdfprt/lattice.py
    const int* clear;              // the same
    int nx, ny;                    // coarse cells along x and y, 0 where there is no lattice
    float ox, oy, oz, cell, unit;  // first corner and side of a coarse cell in scene units, distance of one integer
    float error;                   // of a distance near the surface

    inline CUDA_CALLABLE void read(const int* records, const int* clears, const float* frame) {
        record = records;
        clear = clears;
        nx = (int)frame[0];
        ny = (int)frame[1];
        ox = frame[2];
        oy = frame[3];
        oz = frame[4];
        cell = frame[5];
        unit = frame[6] / cell;
        error = frame[7] / cell;
    }

    // The bit of a direction among 24, its octant and the longest of its components
    static inline CUDA_CALLABLE I sector(F u, F v, F w) {
        const F a = abs(u), b = abs(v), c = abs(w);
        const I x = sel(le(b, a) & le(c, a), splat(1), sel(le(c, b), splat(2), splat(4)));
        const I y = sel(lt(u, splat(0.0f)), x << 3, x), z = sel(lt(v, splat(0.0f)), y << 6, y);
        return sel(lt(w, splat(0.0f)), z << 12, z);
    }

    inline CUDA_CALLABLE I coarse(F u, F v, F w) const {
        return to_I(fma(trunc(w), splat((float)(nx * ny)), fma(trunc(v), splat((float)nx), trunc(u))));
    }

    // Where no ray of its sector meets a surface any more. Places lie in the lattice.
    inline CUDA_CALLABLE M escape(F u, F v, F w, I sector) const {
        return ~eq(gather(clear, coarse(u, v, w)) & sector, splat(0));
    }

    struct Reading {
        F distance, x, y, z;  // by the plane, and its change along the axes
        I clear;              // sectors in which `escape` holds
        M rough;              // where the plane does not
    };
    __attribute__((always_inline)) inline CUDA_CALLABLE Reading at(F u, F v, F w) const {
        I place = coarse(u, v, w);
        I low, high;
        gather_pairs(record, place, low, high);
        Reading found;
        found.clear = gather(clear, place);

        // An odd first word: the 64 finer cells, z slowest, begin at the record that the second tells, -1 where none hold
        const I i = to_I(16.0f * u), j = to_I(16.0f * v), k = to_I(16.0f * w);
        F parts = splat(1.0f);
        for (int shift = 2; shift >= 0; shift -= 2) {
            const M cut = eq(low & 1, splat(1)) & le(splat(0), high);
            if (!any(cut)) break;
            const I inner = ((k >> shift & 3) << 4) + ((j >> shift & 3) << 2) + (i >> shift & 3);
            place = sel(cut, high + inner, place);
            parts = sel(cut, 4.0f * parts, parts);
            gather_pairs(record, place, low, high);
        }
        found.rough = eq(low & 1, splat(1));
        const F a = part(parts * u), b = part(parts * v), c = part(parts * w), scale = parts * unit;
        found.x = to_F(low >> 16), found.y = to_F((high << 16) >> 16), found.z = to_F(high >> 16);
        found.distance = (to_F((low << 16) >> 16) + found.x * a + (found.y * b + found.z * c)) * unit;
        found.x *= scale, found.y *= scale, found.z *= scale;
        return found;
    }

    static inline CUDA_CALLABLE F part(F a) { return a - trunc(a); }
};
