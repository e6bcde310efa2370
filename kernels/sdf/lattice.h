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
        return to_I(mad(trunc(w), splat((float)(nx * ny)), mad(trunc(v), splat((float)nx), trunc(u))));
    }

    // Where no ray of its sector meets a surface any more. Places lie in the lattice.
    inline CUDA_CALLABLE M escape(F u, F v, F w, I sector) const {
        return ~eq(gather(clear, coarse(u, v, w)) & sector, splat(0));
    }

    // The cell that holds a place, found level by level, so that many packets can wait for memory together
    struct Cell {
        F u, v, w;    // the place
        I low, high;  // the record
        I clear;      // sectors in which `escape` holds
        I next;       // the record of the finer cell, if there is one
        F parts;      // of a coarse cell's side
    };
    inline CUDA_CALLABLE Cell find(F u, F v, F w) const {
        Cell cell;
        cell.u = u, cell.v = v, cell.w = w;
        const I place = coarse(u, v, w);
        gather_pairs(record, place, cell.low, cell.high);
        cell.clear = gather(clear, place);
        cell.parts = splat(1.0f);
        fetch(cell, 2);
        return cell;
    }

    // One level further; `shift` is 2 at the first, 0 at the second
    inline CUDA_CALLABLE void refine(Cell& cell, int shift) const {
        const M is_cut = cut(cell);
        if (!any(is_cut)) return;
        I low, high;
        gather_pairs(record, cell.next, low, high);
        cell.low = sel(is_cut, low, cell.low);
        cell.high = sel(is_cut, high, cell.high);
        cell.parts = sel(is_cut, 4.0f * cell.parts, cell.parts);
        if (shift > 0) fetch(cell, shift - 2);
    }

    // An odd first word: the 64 finer cells, z slowest, begin at the record that the second tells, -1 where none hold
    static inline CUDA_CALLABLE M cut(const Cell& cell) { return eq(cell.low & 1, splat(1)) & le(splat(0), cell.high); }

    // Asks for the memory of the finer cell
    inline CUDA_CALLABLE void fetch(Cell& cell, int shift) const {
        const I i = to_I(16.0f * cell.u), j = to_I(16.0f * cell.v), k = to_I(16.0f * cell.w);
        const I inner = ((k >> shift & 3) << 4) + ((j >> shift & 3) << 2) + (i >> shift & 3);
        cell.next = sel(cut(cell), cell.high + inner, splat(0));
#if SDFPRT_LANES > 1
        int at[SDFPRT_LANES];
        spill(at, cell.next);
        for (int n = 0; n < SDFPRT_LANES; n++) __builtin_prefetch(record + 2ull * at[n]);
#endif
    }

    struct Reading {
        F distance, x, y, z;  // by the plane, and its change along the axes
        M rough;              // where the plane does not hold
        F a, b, c;            // the place in the cell, in sides of it
    };
    inline CUDA_CALLABLE Reading read(const Cell& cell) const {
        Reading found;
        found.rough = eq(cell.low & 1, splat(1));
        found.a = part(cell.parts * cell.u), found.b = part(cell.parts * cell.v), found.c = part(cell.parts * cell.w);
        const F x = to_F(cell.low >> 16), y = to_F((cell.high << 16) >> 16), z = to_F(cell.high >> 16);
        found.distance = mad(z, found.c, mad(y, found.b, mad(x, found.a, to_F((cell.low << 16) >> 16)))) * unit;
        const F scale = cell.parts * unit;
        found.x = x * scale, found.y = y * scale, found.z = z * scale;
        return found;
    }
    static inline CUDA_CALLABLE F part(F a) { return a - trunc(a); }

    // How far a ray from the place is in the cell, in sides of it
    static inline CUDA_CALLABLE F ahead(const Reading& from, F u, F v, F w) {
        const F x = 1.0f / u, y = 1.0f / v, z = 1.0f / w;
        const F a = max((1.0f - from.a) * x, -from.a * x), b = max((1.0f - from.b) * y, -from.b * y);
        return min(min(a, b), max((1.0f - from.c) * z, -from.c * z));
    }

    inline CUDA_CALLABLE Reading at(F u, F v, F w) const {
        Cell cell = find(u, v, w);
        refine(cell, 2);
        refine(cell, 0);
        return read(cell);
    }
};
