// A queue of rays under way. It is read packet by packet from the front and written anew from the front, rays that ended left out:
// packets stay full and do not wait for each other. Lengths are those of packets.h.
#define SDFPRT_BATCH 4096                // rays, at most
#define SDFPRT_ROOM (SDFPRT_BATCH + 80)  // more than a packet, which is written whole; rows do not fall on the same cache lines

struct RayQueue : Simd {
    typedef Steps::Rays Rays;
    float x[SDFPRT_ROOM], y[SDFPRT_ROOM], z[SDFPRT_ROOM], u[SDFPRT_ROOM], v[SDFPRT_ROOM], w[SDFPRT_ROOM];
    float s[SDFPRT_ROOM], end[SDFPRT_ROOM], hit_radius[SDFPRT_ROOM], last_radius[SDFPRT_ROOM], last_step[SDFPRT_ROOM];
    int ray[SDFPRT_ROOM], sector[SDFPRT_ROOM];
    int count;

    inline CUDA_CALLABLE Rays at(int i) const {
        return {fill(x + i),          fill(y + i),           fill(z + i),         fill(u + i),   fill(v + i),
                fill(w + i),          fill(s + i),           fill(end + i),
                fill(hit_radius + i), fill(last_radius + i), fill(last_step + i), fill(ray + i), fill(sector + i)};
    }

    // Adds those of a packet whose bits are set. While a queue is read, what stays is written over what has been read.
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
        spill(hit_radius + count, permute(rays.hit_radius, order));
        spill(last_radius + count, permute(rays.last_radius, order));
        spill(last_step + count, permute(rays.last_step, order));
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
