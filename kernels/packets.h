// Visibility of a batch of rays, by the field or, where that holds, by the lattice that stands in for it. Rays still under way
// are packed side by side every few steps, so that few lanes are idle.
#if SDFPRT_LANES == 1
#define SDFPRT_BATCH 16
#define SDFPRT_GROUP 4  // origins in a batch
#else
#define SDFPRT_BATCH 512
#define SDFPRT_GROUP 4
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
    enum { STEPS = 3 };  // evaluations, or readings of the lattice, between two packings

    static inline CUDA_CALLABLE F gather(const float* v, const int* at, int used) {
        float r[SDFPRT_LANES];
        for (int k = 0; k < SDFPRT_LANES; k++) r[k] = v[at[k < used ? k : 0]];
        return fill(r);
    }

    // A few steps of the first packet of rays at[0] … at[count - 1], by the field or by what stands in for it. Those that neither
    // met the surface nor left the bounds go to the readers where the lattice holds, to the askers where only the field does;
    // `at` may be the list that they go to, since no more are written than were read
    inline CUDA_CALLABLE void advance(bool field, const int* at, int count, float step, int steps) {
        const int used = count < SDFPRT_LANES ? count : SDFPRT_LANES;
        const F x = gather(ox, at, used), y = gather(oy, at, used), z = gather(oz, at, used);
        const F u = gather(dx, at, used), v = gather(dy, at, used), w = gather(dz, at, used), end = gather(far, at, used);
        const F touch = gather(reach, at, used);
        F s = gather(t, at, used), before = gather(ball, at, used), came = gather(taken, at, used);
        // Within `error` the lattice may be wrong (settings.Lattice.near, and some room)
        const float error = 0.05f * lattice.cell, leap = 0.125f * lattice.cell;
        M live = lt(lanes(), splat(used)), blocked = none(), out = none();
        for (int k = 0; k < STEPS && any(live); k++) {
            const F px = fma(u, s, x), py = fma(v, s, y), pz = fma(w, s, z);
            M doubt = none();
            const F r = field ? Scene::distance(px, py, pz, live) * step : lattice.at(px, py, pz, doubt);
            // Where a ray has hardly left, the lattice's error would decide
            if (!field) doubt = doubt | (lt(s, splat(lattice.cell)) & lt(r, splat(error)));
            out = out | (live & doubt);
            live = live & ~doubt;
            // Negative is met for certain. Where the balls of this step and the one before leave a gap, go back to the end
            // of the ball before; else step as far as the next ball will touch this one if the slope stays
            const M gap = lt(before + r, came);
            const M met = live & (lt(r, splat(0.0f)) | (lt(r, touch) & ~gap));
            const F slope = max(min((r - before) / max(came, splat(1e-9f)), splat(0.8f)), splat(-1.0f));
            const F ahead = sel(lt(splat(0.0f), came), 1.9f * r / (1.0f - slope), 1.2f * r);
            const F next = sel(gap, s - came + before, min(s + ahead, max(s + r, end - touch)));
            // A chord through the surface shorter than a leap stays within the lattice's error of it
            const M creeps = field ? none() : lt(next - s, splat(leap)) & ~gap;
            blocked = blocked | met;
            live = live & ~met;
            came = sel(live, sel(gap | creeps, splat(0.0f), next - s), came);
            before = sel(live, sel(gap, splat(0.0f), r), before);
            s = sel(live, sel(creeps, s + leap, next), s);
            live = live & lt(s, end);
        }
        // Back to the lattice as soon as the surface is beyond its error
        if (field) out = lattice.nx > 0 ? live & lt(before, splat(2.0f * error)) : live;
        live = live & ~out;
        float place[SDFPRT_LANES], radius[SDFPRT_LANES], stride[SDFPRT_LANES];
        int ended[SDFPRT_LANES], on[SDFPRT_LANES], doubted[SDFPRT_LANES];
        spill(place, s);
        spill(radius, before);
        spill(stride, came);
        spill(ended, blocked);
        spill(on, live);
        spill(doubted, out);
        for (int k = 0; k < used; k++) {
            const int i = at[k];
            const bool lost = (spent[i] += STEPS) >= steps;  // so many evaluations: it grazes
            if (ended[k] || (lost && (on[k] || doubted[k]))) free[i] = 0.0f;
            t[i] = place[k];
            ball[i] = radius[k];
            taken[i] = stride[k];
            readers[reading] = i;
            reading -= lost ? 0 : on[k];
            askers[asking] = i;
            asking -= lost ? 0 : doubted[k];
        }
    }

    // Rays 0 … count - 1, whose origin, direction, t, far, reach and `free` are set. Steps are over-relaxed by the slope (Balint
    // and Valasek 2018; Ban and Valasek 2023). Rays still under way after `steps` evaluations and readings count as met.
    inline CUDA_CALLABLE void trace(float step, int steps, int count) {
        const bool by_lattice = lattice.nx > 0;
        int* list = by_lattice ? readers : askers;
        int begun = 0;
        for (int i = 0; i < count; i++) {
            list[begun] = i;
            ball[i] = taken[i] = 0.0f;
            spent[i] = 0;
            begun += free[i] > 0.0f && t[i] + reach[i] < far[i];  // on a face where the bounds cut the solid, outwards is free
        }
        reading = by_lattice ? begun : 0;
        asking = begun - reading;
        while (reading + asking > 0) {
            const int read = reading;
            reading = 0;
            for (int first = 0; first < read; first += SDFPRT_LANES) advance(false, readers + first, read - first, step, steps);
            // The field when two packets wait for it, or nothing else is left
            if (asking < 2 * SDFPRT_LANES && reading > 0) continue;
            const int ask = asking;
            asking = 0;
            for (int first = 0; first < ask; first += SDFPRT_LANES) advance(true, askers + first, ask - first, step, steps);
        }
    }
};
