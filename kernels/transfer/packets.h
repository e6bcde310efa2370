// Which rays of a batch leave the bounds. A batch is SDFPRT_GROUP origins with SDFPRT_SHARE rays each; all its rays move on by one
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
#if SDFPRT_LANES == 1
#define SDFPRT_GROUP 4  // origins in a batch
#else
#define SDFPRT_GROUP 32
#endif
#define SDFPRT_SHARE (SDFPRT_BATCH / SDFPRT_GROUP)
#define SDFPRT_CHUNK 16  // packets whose cells are looked for together

// How steps are chosen. No value is a matter of right or wrong, since a gap between two balls is always gone back to: `bench
// transfer` shows for another value the rate, and the share of rays that agree with a plain march. Ratios, where no unit stands.
constexpr float FIRST_SLOPE = -0.15f;  // change of the distance along a ray, assumed before the first step
constexpr float DIVE_SLOPE = -0.2f;    // below this the ray falls towards a surface
constexpr float DIVE_RELAX = 1.3f;     // a falling ray goes so much farther than to where it would meet the surface
constexpr float CLIMB_RELAX = 1.8f;    // another goes so much farther than its ball; 2 would leave a gap wherever the slope falls
constexpr float MOST_SLOPE = 0.8f;     // and is not taken to climb more steeply: at 1 a step would have no end
constexpr float FAR_ENOUGH = 3.0f;     // from the surface, in errors of the lattice: there a ray goes by the lattice again
constexpr float HARDLY_LEFT = 0.5f;    // from its origin, in coarse cells: nearer than this the field decides what is close
constexpr float DOUBT_INSIDE = -2.0f;  // in errors of the lattice: deeper in the solid than this the plane is believed
constexpr float CELL_END = 1.0001f;    // a step to the end of a cell ends beyond its face, by this
constexpr float CELL_MARGIN = 1e-5f;   // and by this, in coarse cells, for the rounding
constexpr float LEAST_STEP = 1e-9f;    // divides in place of a last step of 0
constexpr int SKIPS = 16;              // balls along the middle of a packet, at most
constexpr float SKIP_AHEAD = 1.5f;     // radii from one ball's centre to the next: less than 2, so that they overlap
constexpr float SKIP_GROWTH = 0.4f;    // the next ball is at least so much farther, of the way so far
constexpr float SKIP_LEAST = 0.1f;     // a ball that is smaller, of the way so far, helps no ray
constexpr float BALL_LEAST = 0.01f;    // the same of a ball along the normal, of its height

// Empty balls about places of one line, `radius` the step times the field there
struct Balls : Simd {
    float radius[16], inverse[16], ratio[16], rest[16];

    inline CUDA_CALLABLE void set(int first, F height, F size) {
        const M small = le(size, BALL_LEAST * height);  // none, or too small to help
        const F inverted = 1.0f / sel(small, splat(1.0f), size), share = height * inverted;
        spill(radius + first, size);
        spill(inverse + first, inverted);
        spill(ratio + first, share);
        spill(rest + first, sel(small, splat(-1e30f), 1.0f - share * share));
    }
    // Where rays that are free as far as t leave ball k, their cosine to the line `c`; those that are not inside stay
    inline CUDA_CALLABLE F past(int k, F t, F c, M& inside) const {
        const F along = ratio[k] * c, half = mad(along, along, splat(rest[k]));  // in radii; half the chord, squared
        const F ahead = mad(t, splat(inverse[k]), -along);
        inside = le(ahead * ahead, half);
        // The root of `half` from below, (3 - half) / 2 of it: no farther than the ball, and much quicker
        const F end = radius[k] * mad(half, mad(half, splat(-0.5f), splat(1.5f)), along);
        return sel(inside, max(t, end), t);
    }
};

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

#if SDFPRT_LANES > 1
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
#endif

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
                const F s = rays.s, last_radius = rays.last_radius, last_step = rays.last_step, hit_radius = rays.hit_radius;
                F r, slope, cleared;
                M doubt = none(), escapes = none();
                if (by_the_field) {
                    r = field(mad(rays.u, s, rays.x), mad(rays.v, s, rays.y), mad(rays.w, s, rays.z), step);
                    const F measured = (r - last_radius) / max(last_step, splat(LEAST_STEP));
                    slope = sel(lt(splat(0.0f), last_step), measured, splat(FIRST_SLOPE));
                    cleared = s + r;
                } else {
                    const Lattice::Reading found = lattice.read(cells[n]);
                    r = found.distance;
                    slope = mad(found.z, rays.w, mad(found.y, rays.v, found.x * rays.u));
                    escapes = ~eq(cells[n].clear & rays.sector, splat(0));
                    // As far as the end of the cell, if there too the plane is above the surface
                    const F ahead = Lattice::ahead(found, rays.u, rays.v, rays.w) / cells[n].parts;
                    const F last = mad(splat(CELL_END), ahead, splat(CELL_MARGIN));
                    cleared = s + sel(lt(hit_radius + lattice.error, min(r, mad(slope, last, r))), max(r, last), r);
                    // Where a ray has hardly left, the lattice's error would decide
                    const M close = lt(splat(DOUBT_INSIDE * lattice.error), r) & lt(r, hit_radius + lattice.error);
                    doubt = found.rough | (lt(s, splat(HARDLY_LEFT)) & close);
                }
                // A negative distance is met for certain. Where the balls of this step and of the last leave a gap between them,
                // something may lie there: back to the end of the last ball. Else as far as the next ball will touch this one if
                // the slope stays or, where the ray falls, just beyond where it would meet the surface (Balint and Valasek 2018)
                const M gap = lt(last_radius + r, last_step);
                const M met = (lt(r, splat(0.0f)) | (lt(r, hit_radius) & ~gap)) & ~doubt;
                const M dive = lt(slope, splat(DIVE_SLOPE));
                const F relax = sel(dive, splat(DIVE_RELAX), splat(CLIMB_RELAX));
                const F relaxed = r * relax / sel(dive, -slope, 1.0f - min(slope, splat(MOST_SLOPE)));
                const F place = sel(gap, s - last_step + last_radius, max(min(s + relaxed, rays.end - hit_radius), cleared));
                rays.last_step = sel(doubt, last_step, sel(gap, splat(0.0f), place - s));
                rays.last_radius = sel(doubt, last_radius, sel(gap, splat(0.0f), cleared - s));
                rays.s = sel(doubt, s, place);

                // What becomes of them
                M turn = doubt;
                if (by_the_field) turn = lattice.nx > 0 ? le(splat(FAR_ENOUGH * lattice.error), r) & ~gap : none();
                const M out = (escapes & ~(gap | doubt)) | ~(lt(place, rays.end) | doubt | met);  // or is no number
                const unsigned on = bits(lt(lanes(), splat(count - first))), ended = on & bits(met);
                const unsigned under_way = on & ~bits(met | out), leaving = under_way & bits(turn);
                queue.add(rays, under_way & ~leaving);
                spill(blocked + blocked_count, permute(rays.ray, packing(ended)));
                blocked_count += ones_of(ended);
                if (leaving) {
                    rays.s = rays.s - rays.last_step + rays.last_radius;
                    rays.last_step = rays.last_radius = splat(0.0f);
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
