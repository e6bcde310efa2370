// Rays under way, packed: read, moved on and written back packet by packet, which do not wait for each other.
#if SDFPRT_LANES == 1
#define SDFPRT_BATCH 16
#define SDFPRT_ROOM (SDFPRT_BATCH + 1)
#else
#define SDFPRT_BATCH 4096                // rays, at most
#define SDFPRT_ROOM (SDFPRT_BATCH + 80)  // more than a packet, which is written whole; rows do not fall on the same cache lines
#endif

struct Front : Simd {
    struct Rays {
        F x, y, z, u, v, w;  // origin, unit direction
        F s, end, touch;     // how far along it is, where it leaves the bounds, the distance that has met the surface
        F before, came;      // how far it was free before the last step, and that step
        I ray, sector;       // its number, and that of its direction, as in Lattice
    };
    float x[SDFPRT_ROOM], y[SDFPRT_ROOM], z[SDFPRT_ROOM], u[SDFPRT_ROOM], v[SDFPRT_ROOM], w[SDFPRT_ROOM];
    float s[SDFPRT_ROOM], end[SDFPRT_ROOM], touch[SDFPRT_ROOM], before[SDFPRT_ROOM], came[SDFPRT_ROOM];
    int ray[SDFPRT_ROOM], sector[SDFPRT_ROOM];
    int count;

    inline CUDA_CALLABLE Rays at(int i) const {
        return {fill(x + i),   fill(y + i),     fill(z + i),      fill(u + i),    fill(v + i),   fill(w + i),     fill(s + i),
                fill(end + i), fill(touch + i), fill(before + i), fill(came + i), fill(ray + i), fill(sector + i)};
    }

    // Adds those of a packet whose bits are set. While a front is read, what stays is written over what has been read.
    __attribute__((always_inline)) inline CUDA_CALLABLE void add(const Rays& rays, unsigned keep) {
        const I order = packing(keep);
        spill(x + count, permute(rays.x, order));
        spill(y + count, permute(rays.y, order));
        spill(z + count, permute(rays.z, order));
        spill(u + count, permute(rays.u, order));
        spill(v + count, permute(rays.v, order));
        spill(w + count, permute(rays.w, order));
        spill(s + count, permute(rays.s, order));
        spill(end + count, permute(rays.end, order));
        spill(touch + count, permute(rays.touch, order));
        spill(before + count, permute(rays.before, order));
        spill(came + count, permute(rays.came, order));
        spill(ray + count, permute(rays.ray, order));
        spill(sector + count, permute(rays.sector, order));
        count += ones_of(keep);
    }

    // Empties it to be read anew; how many there are. Lanes after the last are where the first ray began: in the lattice.
    inline CUDA_CALLABLE int restart() {
        const int all = count;
        const F none = splat(0.0f);
        spill(x + all, splat(x[0])), spill(y + all, splat(y[0])), spill(z + all, splat(z[0]));
        spill(u + all, none), spill(v + all, none), spill(w + all, none), spill(s + all, none);
        count = 0;
        return all;
    }
};
