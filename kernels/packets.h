// Visibility of a batch of rays, by the field or, where that holds, by the lattice that stands in for it. A lane whose ray has
// ended takes the next one, so that few lanes are idle.
#if SDFPRT_LANES == 1
#define SDFPRT_BATCH 16
#define SDFPRT_GROUP 4  // origins in a batch
#else
#define SDFPRT_BATCH 2048
#define SDFPRT_GROUP 16
#endif
struct Packets : Simd {
    float ox[SDFPRT_BATCH], oy[SDFPRT_BATCH], oz[SDFPRT_BATCH];  // origin
    float dx[SDFPRT_BATCH], dy[SDFPRT_BATCH], dz[SDFPRT_BATCH];  // unit direction
    float t[SDFPRT_BATCH], far[SDFPRT_BATCH];                    // where the ray is, where it leaves the bounds
    float reach[SDFPRT_BATCH];                                   // distance within which it has met the surface
    float free[SDFPRT_BATCH];                                    // 1 where it leaves them, 0 where it meets the surface
    float ball[SDFPRT_BATCH], taken[SDFPRT_BATCH];               // of the evaluation before: radius, and the step after it
    int spent[SDFPRT_BATCH];                                     // evaluations and readings
    int readers[SDFPRT_BATCH], askers[SDFPRT_BATCH];             // rays under way: by the lattice, by the field
    int reading, asking;                                         // how many
    Lattice lattice;

    // Rays side by side, one a lane
    struct Lanes {
        int ray[SDFPRT_LANES], spent[SDFPRT_LANES];
        float x[SDFPRT_LANES], y[SDFPRT_LANES], z[SDFPRT_LANES], u[SDFPRT_LANES], v[SDFPRT_LANES], w[SDFPRT_LANES];
        float end[SDFPRT_LANES], touch[SDFPRT_LANES], s[SDFPRT_LANES], before[SDFPRT_LANES], came[SDFPRT_LANES];
    };
    inline CUDA_CALLABLE void enter(Lanes& lanes, int k, int i) const {
        lanes.ray[k] = i;
        lanes.x[k] = ox[i];
        lanes.y[k] = oy[i];
        lanes.z[k] = oz[i];
        lanes.u[k] = dx[i];
        lanes.v[k] = dy[i];
        lanes.w[k] = dz[i];
        lanes.end[k] = far[i];
        lanes.touch[k] = reach[i];
        lanes.s[k] = t[i];
        lanes.before[k] = ball[i];
        lanes.came[k] = taken[i];
        lanes.spent[k] = spent[i];
    }
    inline CUDA_CALLABLE int leave(const Lanes& lanes, int k) {
        const int i = lanes.ray[k];
        t[i] = lanes.s[k];
        ball[i] = lanes.before[k];
        taken[i] = lanes.came[k];
        spent[i] = lanes.spent[k];
        return i;
    }

    // A lane without a ray stays where one began: places lie in the lattice
    static inline CUDA_CALLABLE void rest(Lanes& lanes, int k) { lanes.u[k] = lanes.v[k] = lanes.w[k] = 0.0f; }

    // Where rays that are free as far as t leave an empty ball whose centre lies `h` from their origin, the cosine `c` off them
    static inline CUDA_CALLABLE F past(F t, float h, float radius, F c) {
        const F along = h * c, ahead = t - along;
        const F inside = fma(along, along, splat(radius * radius - h * h));  // half the chord, squared
        const F share = inside * (1.0f / (radius * radius));
        const F chord = radius * share * (1.5f - 0.5f * share);  // no more than the root, and much quicker
        return sel(le(ahead * ahead, inside), max(t, along + chord), t);
    }

#if SDFPRT_LANES > 1
    // Moves the rays of each packet, which have one origin, past empty balls along the middle of their directions: by the lattice
    // or, if there is none, by the field; the balls of as many packets side by side
    inline void pass(const float* box, float least, float step, int packets) {
        for (int first = 0; first < packets; first += SDFPRT_LANES) {
            const int count = packets - first < SDFPRT_LANES ? packets - first : SDFPRT_LANES;
            float start[SDFPRT_LANES], along[3][SDFPRT_LANES], from[3][SDFPRT_LANES];
            for (int k = 0; k < SDFPRT_LANES; k++) {
                const int i = (first + (k < count ? k : 0)) * SDFPRT_LANES;
                const F begin = fill(t + i), zero = splat(0.0f);
                const M begun = lt(begin, fill(far + i)) & lt(zero, fill(free + i));
                start[k] = smallest(sel(begun, begin, splat(1e30f)));
                along[0][k] = total(sel(begun, fill(dx + i), zero));
                along[1][k] = total(sel(begun, fill(dy + i), zero));
                along[2][k] = total(sel(begun, fill(dz + i), zero));
                from[0][k] = ox[i], from[1][k] = oy[i], from[2][k] = oz[i];
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
                F side;
                M rough = none();
                const F at = max(min(h, last), splat(0.0f)), px = fma(at, u, x), py = fma(at, v, y), pz = fma(at, w, z);
                const F r = lattice.nx > 0 ? lattice.at(px, py, pz, side, rough) - lattice.error
                                           : Scene::distance(px, py, pz, ones()) * step;
                float height[SDFPRT_LANES], radius[SDFPRT_LANES];
                spill(height, at);
                spill(radius, sel(rough, splat(0.0f), r));
                h = at + max(r, 0.2f * at);
                const unsigned more = bits(lt(at, last) & lt(0.1f * at, r));
                for (unsigned left = on; left; left &= left - 1) {
                    const int k = lowest(left), i = (first + k) * SDFPRT_LANES;
                    const F here = fill(t + i);
                    if (!any(lt(splat(height[k] - radius[k]), here) & lt(here, fill(far + i)))) {
                        on &= ~(1u << k);  // none is left that gets to this ball
                    } else if (0.0f < radius[k]) {
                        const F c = fill(dx + i) * along[0][k] + fill(dy + i) * along[1][k] + fill(dz + i) * along[2][k];
                        spill(t + i, past(here, height[k], radius[k], c));
                    }
                }
                on &= more;
            }
        }
    }
#endif

    static inline CUDA_CALLABLE bool few(unsigned bits) {
        int count = 0;
        for (; bits; bits &= bits - 1) count++;
        return count < SDFPRT_LANES / 2;
    }

    // March the rays of a list, by the field or by what stands in for it, until they meet the surface, leave the bounds or are
    // for the other list: for the askers where only the field holds, for the readers where the lattice does again
    inline CUDA_CALLABLE void march(bool field, int* list, int& count, int* others, int& waiting, float step, int steps) {
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
            const F px = fma(fill(at.u), s, fill(at.x)), py = fma(fill(at.v), s, fill(at.y)), pz = fma(fill(at.w), s, fill(at.z));
            const I turns = fill(at.spent) + 1;
            F side = splat(0.0f);
            M doubt = none();
            const F r = field ? Scene::distance(px, py, pz, ones()) * step : lattice.at(px, py, pz, side, doubt);
            // Where a ray has hardly left, the lattice's error would decide
            if (!field) doubt = doubt | (lt(s, splat(0.5f * lattice.cell)) & lt(r, touch + lattice.error));
            // Negative is met for certain. Where the balls of this step and the one before leave a gap, go back to the end
            // of the ball before; else step as far as the next ball will touch this one if the slope stays or, where it falls,
            // just beyond where the ray would meet the surface
            const M gap = lt(before + r, came);
            const M met = (lt(r, splat(0.0f)) | (lt(r, touch) & ~gap)) & ~doubt;
            const F drop = before - r, bend = clamp(came + drop, 0.2f * came, 2.0f * came);
            const M dive = lt(0.2f * came, drop);
            const F ahead = sel(lt(splat(0.0f), came), r * sel(dive, 1.3f * came, 1.8f * came) / sel(dive, drop, bend), 1.2f * r);
            const F away = sel(gap, s - came + before, min(s + ahead, max(s + r, end - touch)));
            // A chord through the surface shorter than a leap stays within the lattice's error of it
            const F leap = 0.125f * side;
            const M creeps = field ? none() : lt(away - s, leap) & ~gap;
            const F place = sel(creeps, s + leap, away);
            spill(at.came, sel(doubt, came, sel(gap | creeps, splat(0.0f), away - s)));
            spill(at.before, sel(doubt, before, sel(gap, splat(0.0f), r)));
            spill(at.s, sel(doubt, s, place));
            spill(at.spent, turns);

            // What becomes of them; so many evaluations: it grazes
            const M out = ~(lt(place, end) | doubt | met);  // or is no number
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
            if (field && next == count && waiting > 0 && few(on)) break;
        }
        count = 0;
        for (; on; on &= on - 1) list[count++] = leave(at, lowest(on));
    }

    // Rays 0 … count - 1, whose origin, direction, t, far, reach and `free` are set. Steps are over-relaxed by the slope (Balint
    // and Valasek 2018; Ban and Valasek 2023). Rays still under way after `steps` evaluations and readings count as met.
    inline CUDA_CALLABLE void trace(float step, int steps, int count) {
        const bool by_lattice = lattice.nx > 0;
        int* list = by_lattice ? readers : askers;
        int begun = 0;
        for (int first = 0; first < count; first += SDFPRT_LANES) {
            spill(ball + first, splat(0.0f));
            spill(taken + first, splat(0.0f));
            spill(spent + first, splat(0));
            // On a face where the bounds cut the solid, outwards is free
            unsigned on = bits(lt(splat(0.0f), fill(free + first)) & lt(fill(t + first) + fill(reach + first), fill(far + first)));
            for (; on; on &= on - 1) list[begun++] = first + lowest(on);
        }
        reading = by_lattice ? begun : 0;
        asking = begun - reading;
        while (reading + asking > 0) {
            if (reading > 0) march(false, readers, reading, askers, asking, step, steps);
            if (asking > 0) march(true, askers, asking, readers, reading, step, steps);
        }
    }
};
