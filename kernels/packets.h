// Visibility of a batch of rays, by the field or, where that holds, by the lattice that stands in for it. A lane whose ray has
// ended takes the next one, so that few lanes are idle. Lengths and places are the lattice's.
#if SDFPRT_LANES == 1
#define SDFPRT_BATCH 16
#define SDFPRT_GROUP 4  // origins in a batch
#else
#define SDFPRT_BATCH 2048
#define SDFPRT_GROUP 16
#endif
#define SDFPRT_SHARE (SDFPRT_BATCH / SDFPRT_GROUP)

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
        const F along = ratio[k] * c, half = along * along + rest[k];  // in radii; half the chord, squared
        const F ahead = t * inverse[k] - along;
        inside = le(ahead * ahead, half);
        const F end = radius[k] * (half * (1.5f - 0.5f * half) + along);  // no farther than by the root, and much quicker
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
    int spent[SDFPRT_BATCH];                                     // evaluations and readings
    int sector[SDFPRT_BATCH];                                    // of the direction, as in Lattice
    int readers[SDFPRT_BATCH], askers[SDFPRT_BATCH];             // rays under way: by the lattice, by the field
    int reading, asking;                                         // how many
    Lattice lattice;

    // Rays side by side, one a lane
    struct Lanes {
        int ray[SDFPRT_LANES], spent[SDFPRT_LANES], sector[SDFPRT_LANES];
        float x[SDFPRT_LANES], y[SDFPRT_LANES], z[SDFPRT_LANES], u[SDFPRT_LANES], v[SDFPRT_LANES], w[SDFPRT_LANES];
        float end[SDFPRT_LANES], touch[SDFPRT_LANES], s[SDFPRT_LANES], before[SDFPRT_LANES], came[SDFPRT_LANES];
    };
    inline CUDA_CALLABLE void enter(Lanes& lanes, int k, int i) const {
        const int g = i / SDFPRT_SHARE;
        lanes.ray[k] = i;
        lanes.x[k] = ox[g];
        lanes.y[k] = oy[g];
        lanes.z[k] = oz[g];
        lanes.touch[k] = reach[g];
        lanes.u[k] = dx[i];
        lanes.v[k] = dy[i];
        lanes.w[k] = dz[i];
        lanes.end[k] = far[i];
        lanes.s[k] = t[i];
        lanes.before[k] = lanes.came[k] = 0.0f;
        lanes.spent[k] = spent[i];
        lanes.sector[k] = sector[i];
    }
    inline CUDA_CALLABLE int leave(const Lanes& lanes, int k) {
        const int i = lanes.ray[k];
        t[i] = lanes.s[k] - lanes.came[k] + lanes.before[k];
        spent[i] = lanes.spent[k];
        return i;
    }

    // The field, times its step
    inline CUDA_CALLABLE F ask(F x, F y, F z, float step) const {
        const float cell = lattice.cell;
        return Scene::distance(x * cell + lattice.ox, y * cell + lattice.oy, z * cell + lattice.oz, ones()) * (step / cell);
    }

    // A lane without a ray stays where one began: places lie in the lattice
    static inline CUDA_CALLABLE void rest(Lanes& lanes, int k) { lanes.u[k] = lanes.v[k] = lanes.w[k] = 0.0f; }

#if SDFPRT_LANES > 1
    // Moves the rays of each packet past empty balls along the middle of their directions: by the lattice or, if there is none, by
    // the field; the balls of as many packets side by side
    inline void pass(const float* box, float least, float step, int origins, int share) {
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
            const F x = fill(from[0]), y = fill(from[1]), z = fill(from[2]);
            F u = fill(along[0]), v = fill(along[1]), w = fill(along[2]);
            const F scale = rsqrt(u * u + v * v + w * w + 1e-20f);
            u *= scale, v *= scale, w *= scale;
            F enter, last;
            Tracer::clip(x, y, z, u, v, w, box, enter, last);
            F h = 1.5f * max(fill(start), splat(least));
            unsigned on = bits(lt(h, last) & lt(lanes(), splat(count)));
            spill(along[0], u), spill(along[1], v), spill(along[2], w);
            for (int turn = 0; on && turn < 16; turn++) {
                const F at = max(min(h, last), splat(0.0f)), px = fma(at, u, x), py = fma(at, v, y), pz = fma(at, w, z);
                F r = splat(0.0f);
                if (lattice.nx > 0) {
                    const Lattice::Reading found = lattice.at(px, py, pz);
                    r = sel(found.rough, r, found.distance - lattice.error);
                } else r = ask(px, py, pz, step);
                Balls balls;
                balls.set(0, at, r);
                float begin[SDFPRT_LANES];
                spill(begin, at - r);
                h = at + max(1.5f * r, 0.4f * at);
                const unsigned more = bits(lt(at, last) & lt(0.1f * at, r));
                for (unsigned left = on; left; left &= left - 1) {
                    const int k = lowest(left), i = begins[k];
                    const F here = fill(t + i);
                    const F c = fill(dx + i) * along[0][k] + fill(dy + i) * along[1][k] + fill(dz + i) * along[2][k];
                    M inside;
                    const F there = balls.past(k, here, c, inside);
                    if (any(inside)) spill(t + i, there);
                    else if (!any(lt(splat(begin[k]), here) & lt(here, fill(far + i)))) on &= ~(1u << k);  // no ray gets this far
                }
                on &= more;
            }
        }
    }
#endif

    // March the rays of a list, by the field or by what stands in for it, until they meet the surface, leave the bounds or are
    // for the other list: for the askers where only the field holds, for the readers where the lattice does again
    __attribute__((always_inline)) inline CUDA_CALLABLE void march(bool field, int* list, int& count, int* others,
                                                                   int& waiting, float step, int steps) {
        Lanes at;
        int next = 0;
        unsigned on = 0;  // lanes with a ray
        for (int k = 0; k < SDFPRT_LANES; k++) {
            enter(at, k, list[next < count ? next : 0]);
            if (next == count) rest(at, k);
            else on |= 1u << k;
            next += next < count;
        }
        while (on) {
            const F s = fill(at.s), before = fill(at.before), came = fill(at.came), end = fill(at.end), touch = fill(at.touch);
            const F u = fill(at.u), v = fill(at.v), w = fill(at.w);
            const F px = fma(u, s, fill(at.x)), py = fma(v, s, fill(at.y)), pz = fma(w, s, fill(at.z));
            const I turns = fill(at.spent) + 1;
            F r, slope;
            M doubt = none(), escapes = none();
            if (field) {
                r = ask(px, py, pz, step);
                slope = sel(lt(splat(0.0f), came), (r - before) / max(came, splat(1e-9f)), splat(-0.15f));
            } else {
                const Lattice::Reading found = lattice.at(px, py, pz);
                r = found.distance;
                slope = found.x * u + found.y * v + found.z * w;
                escapes = ~eq(found.clear & fill(at.sector), splat(0));
                // Where a ray has hardly left, the lattice's error would decide
                const M close = lt(splat(-2.0f * lattice.error), r) & lt(r, touch + lattice.error);
                doubt = found.rough | (lt(s, splat(0.5f)) & close);
            }
            // Negative is met for certain. Where the balls of this step and the one before leave a gap, go back to the end of the
            // ball before; else step as far as the next ball will touch this one if the slope stays or, where it falls, just
            // beyond where the ray would meet the surface
            const M gap = lt(before + r, came);
            const M met = (lt(r, splat(0.0f)) | (lt(r, touch) & ~gap)) & ~doubt;
            const M dive = lt(slope, splat(-0.2f));
            const F ahead = r * sel(dive, splat(1.3f), splat(1.8f)) / sel(dive, -slope, 1.0f - min(slope, splat(0.8f)));
            const F place = sel(gap, s - came + before, min(s + ahead, max(s + r, end - touch)));
            spill(at.came, sel(doubt, came, sel(gap, splat(0.0f), place - s)));
            spill(at.before, sel(doubt, before, sel(gap, splat(0.0f), r)));
            spill(at.s, sel(doubt, s, place));
            spill(at.spent, turns);

            // What becomes of them; so many evaluations: it grazes
            const M out = (escapes & ~(gap | doubt)) | ~(lt(place, end) | doubt | met);  // or is no number
            const M lost = le(splat(steps), turns) & ~out;
            M turn = doubt;
            if (field) turn = lattice.nx > 0 ? le(splat(3.0f * lattice.error), r) & ~gap : none();
            const unsigned blocked = bits(met | lost), leaving = bits(turn & ~out) & ~blocked;
            for (unsigned ended = on & (blocked | leaving | bits(out)); ended; ended &= ended - 1) {
                const int k = lowest(ended);
                const int i = leave(at, k);
                if (blocked >> k & 1) free[i] = 0.0f;
                others[waiting] = i;
                waiting += leaving >> k & 1;
                if (next < count) enter(at, k, list[next++]);
                else {
                    on &= ~(1u << k);
                    rest(at, k);
                }
            }
            // An evaluation for a few lanes can wait until more rays ask for one
            if (field && next == count && waiting > 0 && ones_of(on) < SDFPRT_LANES / 2) break;
        }
        count = 0;
        for (; on; on &= on - 1) list[count++] = leave(at, lowest(on));
    }

    // The first `share` rays of each origin, whose direction, t, far and `free` are set. Steps are over-relaxed by the slope (Balint
    // and Valasek 2018; Ban and Valasek 2023). Rays still under way after `steps` evaluations and readings count as met.
    inline CUDA_CALLABLE void trace(float step, int steps, int origins, int share) {
        const bool by_lattice = lattice.nx > 0;
        int* list = by_lattice ? readers : askers;
        int begun = 0;
        for (int g = 0; g < origins; g++)
            for (int i = g * SDFPRT_SHARE; i < g * SDFPRT_SHARE + share; i += SDFPRT_LANES) {
                // On a face where the bounds cut the solid, outwards is free
                const F s = fill(t + i), u = fill(dx + i), v = fill(dy + i), w = fill(dz + i);
                M begins = lt(splat(0.0f), fill(free + i)) & lt(s + reach[g], fill(far + i));
                unsigned on = bits(begins);
                if (by_lattice && on) {
                    const I way = Lattice::sector(u, v, w);
                    const F at = sel(begins, s, splat(0.0f));
                    on &= ~bits(lattice.escape(u * at + ox[g], v * at + oy[g], w * at + oz[g], way));
                    spill(sector + i, way);
                }
                spill(spent + i, splat(0));
                for (; on; on &= on - 1) list[begun++] = i + lowest(on);
            }
        reading = by_lattice ? begun : 0;
        asking = begun - reading;
        while (reading + asking > 0) {
            if (reading > 0) march(false, readers, reading, askers, asking, step, steps);
            if (asking > 0) march(true, askers, asking, readers, reading, step, steps);
        }
    }
};
