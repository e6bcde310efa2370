// Which rays of a batch leave the bounds, on a CPU. A batch is SDFPRT_GROUP origins with SDFPRT_SHARE rays each; all its rays move on by one
// step, those that have not ended are packed anew, and so on: no lane waits for another ray.
//
//   ball    the empty ball about a place near an origin (called by transfer.h, for the balls along the normal)
//   skip    past the empty balls along the middle of each packet of directions, before any ray moves by itself
//   trace   puts every ray into a queue and runs `march` until both queues are empty
//   march   one queue, step by step. The two queues are
//               by_lattice   the distance is the plane of the lattice's cell; where that is not to be trusted (a rough cell, or so
//                            near the surface that its error would decide) the ray goes over to
//               by_field     the scene's own distance; back to by_lattice as soon as it is FAR_ENOUGH from the surface
//           and a ray leaves both as `blocked`, where it meets the surface, or as free, beyond the bounds.
//
// Without a lattice all rays are in by_field. Places and lengths are in sides of the lattice's coarse cells, from its first corner,
// in scene units where there is no lattice; distances are the field's times the scene's step.
#define SDFPRT_GROUP 32  // origins in a batch
#define SDFPRT_SHARE (SDFPRT_BATCH / SDFPRT_GROUP)
#define SDFPRT_CHUNK 16  // packets whose cells are looked for together

// How the middle of a packet is followed
constexpr int SKIPS = 16;              // balls along the middle of a packet, at most
constexpr float SKIP_AHEAD = 1.5f;     // radii from one ball's centre to the next: less than 2, so that they overlap
constexpr float SKIP_GROWTH = 0.4f;    // the next ball is at least so much farther, of the way so far
constexpr float SKIP_LEAST = 0.1f;     // a ball that is smaller, of the way so far, helps no ray

struct Packets : Simd {
    // Of each origin; its rays are SDFPRT_SHARE from those of the one before
    float ox[SDFPRT_GROUP], oy[SDFPRT_GROUP], oz[SDFPRT_GROUP];
    float reach[SDFPRT_GROUP];  // distance within which its rays have met the surface

    // Of each ray
    float dx[SDFPRT_BATCH], dy[SDFPRT_BATCH], dz[SDFPRT_BATCH];  // unit direction
    float t[SDFPRT_BATCH], far[SDFPRT_BATCH];                    // as far as it is known to be free, where it leaves the bounds
    float free[SDFPRT_BATCH];                                    // 1 where it leaves them, 0 where it meets the surface
    float cosine[SDFPRT_BATCH];                                  // to the middle of its packet
    RayQueue by_lattice, by_field;                               // rays under way
    int blocked[SDFPRT_ROOM], blocked_count;                     // those that have met the surface
    int turns;                                                   // left until rays that are still under way count as met
    Lattice lattice;

    // The field, times its step
    inline CUDA_CALLABLE F field(F x, F y, F z, float step) const {
        const F cell = splat(lattice.cell);
        const F p = mad(x, cell, splat(lattice.ox)), q = mad(y, cell, splat(lattice.oy)), r = mad(z, cell, splat(lattice.oz));
        return Scene::distance(p, q, r, ones()) * (step / lattice.cell);
    }

    // Balls about places near the surface, by the lattice where it holds in all of them and gives `least` or more
    inline CUDA_CALLABLE F ball(F x, F y, F z, float least, float step) const {
        if (lattice.nx > 0) {
            const Lattice::Reading found = lattice.at(x, y, z);
            const F r = found.distance - lattice.error;
            if (!any(found.rough | lt(r, splat(least)))) return r;
        }
        return field(x, y, z, step);
    }

    // The cells in which the rays of a queue are, those of a chunk from `begin` on
    inline CUDA_CALLABLE void find(const RayQueue& queue, int begin, int count, Lattice::Cell* cells) const {
        const int most = begin + SDFPRT_CHUNK * SDFPRT_LANES, end = count < most ? count : most;
        for (int i = begin, n = 0; i < end; i += SDFPRT_LANES, n++) {
            const RayQueue::Rays at = queue.at(i);
            cells[n] = lattice.find(mad(at.u, at.s, at.x), mad(at.v, at.s, at.y), mad(at.w, at.s, at.z));
        }
        for (int shift = 2; shift >= 0; shift -= 2)
            for (int i = begin, n = 0; i < end; i += SDFPRT_LANES, n++) lattice.refine(cells[n], shift);
    }

    // Moves the rays of each packet past empty balls along the middle of their directions: by the lattice or, if there is none, by
    // the field
    inline void skip(const float* box, float least, float step, int origins, int share) {
        RayQueue& middles = by_field;
        middles.count = 0;
        const int each = share / SDFPRT_LANES, packets = origins * each;
        for (int first = 0; first < packets; first += SDFPRT_LANES) {
            const int count = packets - first < SDFPRT_LANES ? packets - first : SDFPRT_LANES;
            int begins[SDFPRT_LANES];
            float start[SDFPRT_LANES], along[3][SDFPRT_LANES], from[3][SDFPRT_LANES];
            for (int k = 0; k < SDFPRT_LANES; k++) {
                const int packet = first + (k < count ? k : 0), g = packet / each;
                const int i = begins[k] = g * SDFPRT_SHARE + (packet - g * each) * SDFPRT_LANES;
                const F begin = fill(t + i), zero = splat(0.0f);
                const M begun = lt(begin, fill(far + i)) & lt(zero, fill(free + i));
                start[k] = smallest(sel(begun, begin, splat(1e30f)));
                along[0][k] = total(sel(begun, fill(dx + i), zero));
                along[1][k] = total(sel(begun, fill(dy + i), zero));
                along[2][k] = total(sel(begun, fill(dz + i), zero));
                from[0][k] = ox[g], from[1][k] = oy[g], from[2][k] = oz[g];
            }
            RayQueue::Rays rays;
            rays.x = fill(from[0]), rays.y = fill(from[1]), rays.z = fill(from[2]);
            rays.u = fill(along[0]), rays.v = fill(along[1]), rays.w = fill(along[2]);
            const F scale = rsqrt(mad(rays.w, rays.w, mad(rays.v, rays.v, mad(rays.u, rays.u, splat(1e-20f)))));
            rays.u *= scale, rays.v *= scale, rays.w *= scale;
            F enter;
            Tracer::clip(rays.x, rays.y, rays.z, rays.u, rays.v, rays.w, box, enter, rays.end);
            rays.s = SKIP_AHEAD * max(fill(start), splat(least));
            rays.hit_radius = rays.last_radius = rays.last_step = splat(0.0f);
            rays.ray = fill(begins), rays.sector = splat(0);  // the packet's first ray
            spill(along[0], rays.u), spill(along[1], rays.v), spill(along[2], rays.w);
            for (int k = 0; k < count; k++) {
                const int i = begins[k];
                const F x = splat(along[0][k]), y = splat(along[1][k]), z = splat(along[2][k]);
                spill(cosine + i, mad(fill(dz + i), z, mad(fill(dy + i), y, fill(dx + i) * x)));
            }
            middles.add(rays, bits(lt(rays.s, rays.end) & lt(lanes(), splat(count))));
        }
        for (int turn = 0; middles.count > 0 && turn < SKIPS; turn++) {
            const int count = middles.restart();
            Lattice::Cell cells[SDFPRT_CHUNK];
            for (int first = 0; first < count; first += SDFPRT_LANES) {
                const int n = first / SDFPRT_LANES % SDFPRT_CHUNK;
                if (lattice.nx > 0 && n == 0) find(middles, first, count, cells);
                RayQueue::Rays rays = middles.at(first);
                int begins[SDFPRT_LANES];
                spill(begins, rays.ray);
                const F at = rays.s;
                F r;
                if (lattice.nx > 0) {
                    const Lattice::Reading found = lattice.read(cells[n]);
                    r = sel(found.rough, splat(0.0f), found.distance - lattice.error);
                } else r = field(mad(at, rays.u, rays.x), mad(at, rays.v, rays.y), mad(at, rays.w, rays.z), step);
                Balls balls;
                balls.set(0, at, r);
                float begin[SDFPRT_LANES];
                spill(begin, at - r);
                rays.s = max(min(at + max(SKIP_AHEAD * r, SKIP_GROWTH * at), rays.end), splat(0.0f));
                unsigned stay = 0;
                for (unsigned left = bits(lt(lanes(), splat(count - first))); left; left &= left - 1) {
                    const int k = lowest(left), i = begins[k];
                    const F here = fill(t + i);
                    M inside;
                    spill(t + i, balls.past(k, here, fill(cosine + i), inside));
                    const M later = lt(splat(begin[k]), here) & lt(here, fill(far + i));  // some may get as far as the next ball
                    stay |= (unsigned)any(inside | later) << k;
                }
                middles.add(rays, stay & bits(lt(at, rays.end) & lt(SKIP_LEAST * at, r)));
            }
        }
    }

    // The rays of one queue until they meet the surface, leave the bounds or are for the other queue
    __attribute__((always_inline)) inline CUDA_CALLABLE void march(bool by_the_field, RayQueue& queue, RayQueue& other,
                                                                   float step) {
        Lattice::Cell cells[SDFPRT_CHUNK];
        // Work for a few lanes can wait until there is more
        while (queue.count > 0 && (queue.count >= SDFPRT_LANES || other.count < SDFPRT_LANES)) {
            const int count = queue.restart();
            for (int first = 0; first < count; first += SDFPRT_LANES) {
                const int n = first / SDFPRT_LANES % SDFPRT_CHUNK;
                if (!by_the_field && n == 0) find(queue, first, count, cells);
                RayQueue::Rays rays = queue.at(first);
                Steps::Ahead at;
                if (by_the_field) {
                    const F s = rays.s, x = mad(rays.u, s, rays.x), y = mad(rays.v, s, rays.y), z = mad(rays.w, s, rays.z);
                    at = Steps::by_field(rays, field(x, y, z, step));
                } else {
                    at = Steps::by_lattice(rays, lattice, cells[n]);
                }
                const Steps::Became became = Steps::advance(rays, at);
                M turn = at.doubt;
                if (by_the_field) turn = lattice.nx > 0 ? Steps::far_enough(lattice, at, became.gap) : none();
                const unsigned on = bits(lt(lanes(), splat(count - first))), ended = on & bits(became.met);
                const unsigned under_way = on & ~bits(became.met | became.out), leaving = under_way & bits(turn);
                queue.add(rays, under_way & ~leaving);
                spill(blocked + blocked_count, permute(rays.ray, packing(ended)));
                blocked_count += ones_of(ended);
                if (leaving) {
                    Steps::change(rays);
                    other.add(rays, leaving);
                }
            }
            if (--turns < 0) break;
        }
    }

    // The first `share` rays of each origin, whose direction, t, far and `free` are set. Steps are over-relaxed by the slope
    // (Balint and Valasek 2018; Ban and Valasek 2023). Rays still under way after 2 `steps` turns graze and count as met.
    inline CUDA_CALLABLE void trace(float step, int steps, int origins, int share) {
        const bool has_lattice = lattice.nx > 0;
        RayQueue& all = has_lattice ? by_lattice : by_field;
        by_lattice.count = by_field.count = blocked_count = 0;
        turns = 2 * steps;
        for (int g = 0; g < origins; g++)
            for (int i = g * SDFPRT_SHARE; i < g * SDFPRT_SHARE + share; i += SDFPRT_LANES) {
                RayQueue::Rays rays;
                rays.x = splat(ox[g]), rays.y = splat(oy[g]), rays.z = splat(oz[g]);
                rays.u = fill(dx + i), rays.v = fill(dy + i), rays.w = fill(dz + i);
                rays.s = fill(t + i), rays.end = fill(far + i), rays.hit_radius = splat(reach[g]);
                rays.last_radius = rays.last_step = splat(0.0f);
                rays.ray = lanes() + i, rays.sector = splat(0);
                // On a face where the bounds cut the solid, outwards is free
                M begins = lt(splat(0.0f), fill(free + i)) & lt(rays.s + reach[g], rays.end);
                if (!any(begins)) continue;
                if (has_lattice) {
                    rays.sector = Lattice::sector(rays.u, rays.v, rays.w);
                    const F at = sel(begins, rays.s, splat(0.0f));
                    const F x = mad(rays.u, at, rays.x), y = mad(rays.v, at, rays.y), z = mad(rays.w, at, rays.z);
                    begins = begins & ~lattice.escape(x, y, z, rays.sector);
                }
                all.add(rays, bits(begins));
            }
        while (by_lattice.count + by_field.count > 0 && turns >= 0) {
            if (has_lattice) march(false, by_lattice, by_field, step);
            march(true, by_field, by_lattice, step);
        }
        for (int k = 0; k < by_lattice.count; k++) free[by_lattice.ray[k]] = 0.0f;
        for (int k = 0; k < by_field.count; k++) free[by_field.ray[k]] = 0.0f;
        for (int k = 0; k < blocked_count; k++) free[blocked[k]] = 0.0f;
    }
};
