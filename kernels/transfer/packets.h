// Visibility of a batch of rays, by the field or, where that holds, by the lattice that stands in for it. All the rays move on by
// one step, and those that have not ended move on again. Lengths and places are the lattice's.
#if SDFPRT_LANES == 1
#define SDFPRT_GROUP 4  // origins in a batch
#else
#define SDFPRT_GROUP 32
#endif
#define SDFPRT_SHARE (SDFPRT_BATCH / SDFPRT_GROUP)
#define SDFPRT_CHUNK 16  // packets whose cells are looked for together

// Empty balls about places of one line, `radius` the step times the field there
struct Balls : Simd {
    float radius[16], inverse[16], ratio[16], rest[16];

    inline CUDA_CALLABLE void set(int first, F height, F size) {
        const M small = le(size, 0.01f * height);  // none, or too small to help
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
        const F end = radius[k] * mad(half, mad(half, splat(-0.5f), splat(1.5f)), along);  // no farther than by the root, and much quicker
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
    Front readers, askers;                                       // under way: by the lattice, by the field
    int blocked[SDFPRT_ROOM], blocked_count;                     // those that have met the surface
    int turns;                                                   // left until rays that are still under way count as met
    Lattice lattice;

    // The field, times its step
    inline CUDA_CALLABLE F ask(F x, F y, F z, float step) const {
        const F cell = splat(lattice.cell);
        const F p = mad(x, cell, splat(lattice.ox)), q = mad(y, cell, splat(lattice.oy)), r = mad(z, cell, splat(lattice.oz));
        return Scene::distance(p, q, r, ones()) * (step / lattice.cell);
    }

    // Balls about places near the surface, by the lattice where it holds in all of them and gives `least` or more
    inline CUDA_CALLABLE F around(F x, F y, F z, float least, float step) const {
        if (lattice.nx > 0) {
            const Lattice::Reading found = lattice.at(x, y, z);
            const F r = found.distance - lattice.error;
            if (!any(found.rough | lt(r, splat(least)))) return r;
        }
        return ask(x, y, z, step);
    }

    // The cells in which the rays of a front are, those of a chunk from `begin` on
    inline CUDA_CALLABLE void find(const Front& front, int begin, int count, Lattice::Cell* cells) const {
        const int most = begin + SDFPRT_CHUNK * SDFPRT_LANES, end = count < most ? count : most;
        for (int i = begin, n = 0; i < end; i += SDFPRT_LANES, n++) {
            const Front::Rays at = front.at(i);
            cells[n] = lattice.find(mad(at.u, at.s, at.x), mad(at.v, at.s, at.y), mad(at.w, at.s, at.z));
        }
        for (int shift = 2; shift >= 0; shift -= 2)
            for (int i = begin, n = 0; i < end; i += SDFPRT_LANES, n++) lattice.refine(cells[n], shift);
    }

#if SDFPRT_LANES > 1
    // Moves the rays of each packet past empty balls along the middle of their directions: by the lattice or, if there is none, by
    // the field
    inline void pass(const float* box, float least, float step, int origins, int share) {
        Front& middles = askers;
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
            Front::Rays rays;
            rays.x = fill(from[0]), rays.y = fill(from[1]), rays.z = fill(from[2]);
            rays.u = fill(along[0]), rays.v = fill(along[1]), rays.w = fill(along[2]);
            const F scale = rsqrt(mad(rays.w, rays.w, mad(rays.v, rays.v, mad(rays.u, rays.u, splat(1e-20f)))));
            rays.u *= scale, rays.v *= scale, rays.w *= scale;
            F enter;
            Tracer::clip(rays.x, rays.y, rays.z, rays.u, rays.v, rays.w, box, enter, rays.end);
            rays.s = 1.5f * max(fill(start), splat(least));
            rays.touch = rays.before = rays.came = splat(0.0f);
            rays.ray = fill(begins), rays.sector = splat(0);  // the packet's first ray
            spill(along[0], rays.u), spill(along[1], rays.v), spill(along[2], rays.w);
            for (int k = 0; k < count; k++) {
                const int i = begins[k];
                const F x = splat(along[0][k]), y = splat(along[1][k]), z = splat(along[2][k]);
                spill(cosine + i, mad(fill(dz + i), z, mad(fill(dy + i), y, fill(dx + i) * x)));
            }
            middles.add(rays, bits(lt(rays.s, rays.end) & lt(lanes(), splat(count))));
        }
        for (int turn = 0; middles.count > 0 && turn < 16; turn++) {
            const int count = middles.restart();
            Lattice::Cell cells[SDFPRT_CHUNK];
            for (int first = 0; first < count; first += SDFPRT_LANES) {
                const int n = first / SDFPRT_LANES % SDFPRT_CHUNK;
                if (lattice.nx > 0 && n == 0) find(middles, first, count, cells);
                Front::Rays rays = middles.at(first);
                int begins[SDFPRT_LANES];
                spill(begins, rays.ray);
                const F at = rays.s;
                F r;
                if (lattice.nx > 0) {
                    const Lattice::Reading found = lattice.read(cells[n]);
                    r = sel(found.rough, splat(0.0f), found.distance - lattice.error);
                } else r = ask(mad(at, rays.u, rays.x), mad(at, rays.v, rays.y), mad(at, rays.w, rays.z), step);
                Balls balls;
                balls.set(0, at, r);
                float begin[SDFPRT_LANES];
                spill(begin, at - r);
                rays.s = max(min(at + max(1.5f * r, 0.4f * at), rays.end), splat(0.0f));
                unsigned stay = 0;
                for (unsigned left = bits(lt(lanes(), splat(count - first))); left; left &= left - 1) {
                    const int k = lowest(left), i = begins[k];
                    const F here = fill(t + i);
                    M inside;
                    spill(t + i, balls.past(k, here, fill(cosine + i), inside));
                    const M later = lt(splat(begin[k]), here) & lt(here, fill(far + i));  // some may get as far as the next ball
                    stay |= (unsigned)any(inside | later) << k;
                }
                middles.add(rays, stay & bits(lt(at, rays.end) & lt(0.1f * at, r)));
            }
        }
    }
#endif

    // March rays, by the field or by what stands in for it, until they meet the surface, leave the bounds or are for the others:
    // for the askers where only the field holds, for the readers where the lattice does again
    __attribute__((always_inline)) inline CUDA_CALLABLE void march(bool field, Front& front, Front& others, float step) {
        Lattice::Cell cells[SDFPRT_CHUNK];
        // Work for a few lanes can wait until there is more
        while (front.count > 0 && (front.count >= SDFPRT_LANES || others.count < SDFPRT_LANES)) {
            const int count = front.restart();
            for (int first = 0; first < count; first += SDFPRT_LANES) {
                const int n = first / SDFPRT_LANES % SDFPRT_CHUNK;
                if (!field && n == 0) find(front, first, count, cells);
                Front::Rays rays = front.at(first);
                const F s = rays.s, before = rays.before, came = rays.came, touch = rays.touch;
                F r, slope, cleared;
                M doubt = none(), escapes = none();
                if (field) {
                    r = ask(mad(rays.u, s, rays.x), mad(rays.v, s, rays.y), mad(rays.w, s, rays.z), step);
                    slope = sel(lt(splat(0.0f), came), (r - before) / max(came, splat(1e-9f)), splat(-0.15f));
                    cleared = s + r;
                } else {
                    const Lattice::Reading found = lattice.read(cells[n]);
                    r = found.distance;
                    slope = mad(found.z, rays.w, mad(found.y, rays.v, found.x * rays.u));
                    escapes = ~eq(cells[n].clear & rays.sector, splat(0));
                    // As far as the end of the cell, if there too the plane is above the surface
                    const F last = mad(splat(1.0001f), Lattice::ahead(found, rays.u, rays.v, rays.w) / cells[n].parts, splat(1e-5f));
                    cleared = s + sel(lt(touch + lattice.error, min(r, mad(slope, last, r))), max(r, last), r);
                    // Where a ray has hardly left, the lattice's error would decide
                    const M close = lt(splat(-2.0f * lattice.error), r) & lt(r, touch + lattice.error);
                    doubt = found.rough | (lt(s, splat(0.5f)) & close);
                }
                // Negative is met for certain. Where the balls of this step and the one before leave a gap, go back to the end of
                // the ball before; else step as far as the next ball will touch this one if the slope stays or, where it falls,
                // just beyond where the ray would meet the surface
                const M gap = lt(before + r, came);
                const M met = (lt(r, splat(0.0f)) | (lt(r, touch) & ~gap)) & ~doubt;
                const M dive = lt(slope, splat(-0.2f));
                const F relaxed = r * sel(dive, splat(1.3f), splat(1.8f)) / sel(dive, -slope, 1.0f - min(slope, splat(0.8f)));
                const F place = sel(gap, s - came + before, max(min(s + relaxed, rays.end - touch), cleared));
                rays.came = sel(doubt, came, sel(gap, splat(0.0f), place - s));
                rays.before = sel(doubt, before, sel(gap, splat(0.0f), cleared - s));
                rays.s = sel(doubt, s, place);

                // What becomes of them
                M turn = doubt;
                if (field) turn = lattice.nx > 0 ? le(splat(3.0f * lattice.error), r) & ~gap : none();
                const M out = (escapes & ~(gap | doubt)) | ~(lt(place, rays.end) | doubt | met);  // or is no number
                const unsigned on = bits(lt(lanes(), splat(count - first))), ended = on & bits(met);
                const unsigned under_way = on & ~bits(met | out), leaving = under_way & bits(turn);
                front.add(rays, under_way & ~leaving);
                spill(blocked + blocked_count, permute(rays.ray, packing(ended)));
                blocked_count += ones_of(ended);
                if (leaving) {
                    rays.s = rays.s - rays.came + rays.before;
                    rays.came = rays.before = splat(0.0f);
                    others.add(rays, leaving);
                }
            }
            if (--turns < 0) break;
        }
    }

    // The first `share` rays of each origin, whose direction, t, far and `free` are set. Steps are over-relaxed by the slope
    // (Balint and Valasek 2018; Ban and Valasek 2023). Rays still under way after 2 `steps` turns graze and count as met.
    inline CUDA_CALLABLE void trace(float step, int steps, int origins, int share) {
        const bool by_lattice = lattice.nx > 0;
        Front& all = by_lattice ? readers : askers;
        readers.count = askers.count = blocked_count = 0;
        turns = 2 * steps;
        for (int g = 0; g < origins; g++)
            for (int i = g * SDFPRT_SHARE; i < g * SDFPRT_SHARE + share; i += SDFPRT_LANES) {
                Front::Rays rays;
                rays.x = splat(ox[g]), rays.y = splat(oy[g]), rays.z = splat(oz[g]);
                rays.u = fill(dx + i), rays.v = fill(dy + i), rays.w = fill(dz + i);
                rays.s = fill(t + i), rays.end = fill(far + i), rays.touch = splat(reach[g]);
                rays.before = rays.came = splat(0.0f);
                rays.ray = lanes() + i, rays.sector = splat(0);
                // On a face where the bounds cut the solid, outwards is free
                M begins = lt(splat(0.0f), fill(free + i)) & lt(rays.s + reach[g], rays.end);
                if (!any(begins)) continue;
                if (by_lattice) {
                    rays.sector = Lattice::sector(rays.u, rays.v, rays.w);
                    const F at = sel(begins, rays.s, splat(0.0f));
                    begins = begins & ~lattice.escape(mad(rays.u, at, rays.x), mad(rays.v, at, rays.y), mad(rays.w, at, rays.z), rays.sector);
                }
                all.add(rays, bits(begins));
            }
        while (readers.count + askers.count > 0 && turns >= 0) {
            if (by_lattice) march(false, readers, askers, step);
            march(true, askers, readers, step);
        }
        for (int k = 0; k < readers.count; k++) free[readers.ray[k]] = 0.0f;
        for (int k = 0; k < askers.count; k++) free[askers.ray[k]] = 0.0f;
        for (int k = 0; k < blocked_count; k++) free[blocked[k]] = 0.0f;
    }
};
