// Visibility of a batch of rays. Those still under way are packed side by side every few steps, so that few lanes of the
// scene's evaluation are idle.
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
    float ball[SDFPRT_BATCH], taken[SDFPRT_BATCH];  // of the evaluation before: radius, and the step that followed it
    int running[SDFPRT_BATCH], again[SDFPRT_BATCH];
    enum { STEPS = 3 };  // evaluations between two packings

#if SDFPRT_LANES == 1
    static inline CUDA_CALLABLE F load(const float* v) { return *v; }
    static inline CUDA_CALLABLE void store(float* v, F x) { *v = x; }
#else
    static inline F load(const float* v) {
        F r = splat(0.0f);
        __builtin_memcpy(&r, v, sizeof(F));
        return r;
    }
    static inline void store(float* v, F x) { __builtin_memcpy(v, &x, sizeof(F)); }
#endif

    static inline CUDA_CALLABLE F gather(const float* v, const int* at, int used) {
        F r = splat(0.0f);
        for (int k = 0; k < SDFPRT_LANES; k++) set(r, k, v[at[k < used ? k : 0]]);
        return r;
    }

    // A few steps of rays at[0] …; those that neither met the surface nor left the bounds go to `again`
    inline CUDA_CALLABLE void advance(const int* at, int used, float step, int& left) {
        const F x = gather(ox, at, used), y = gather(oy, at, used), z = gather(oz, at, used);
        const F u = gather(dx, at, used), v = gather(dy, at, used), w = gather(dz, at, used), end = gather(far, at, used);
        const F touch = gather(reach, at, used);
        F s = gather(t, at, used), before = gather(ball, at, used), came = gather(taken, at, used);
        M live = lt(lanes(), splat(used)), blocked = none();
        for (int k = 0; k < STEPS && any(live); k++) {
            const F r = Scene::distance(fma(u, s, x), fma(v, s, y), fma(w, s, z), live) * step;
            // Negative is met for certain. Where the balls of this step and the one before leave a gap, go back to the end
            // of the ball before; else step as far as the next ball will touch this one if the slope stays
            const M gap = lt(before + r, came);
            const M met = live & (lt(r, splat(0.0f)) | (lt(r, touch) & ~gap));
            const F slope = max(min((r - before) / max(came, splat(1e-9f)), splat(0.8f)), splat(-1.0f));
            const F ahead = sel(lt(splat(0.0f), came), 1.9f * r / (1.0f - slope), 1.2f * r);
            const F next = sel(gap, s - came + before, min(s + ahead, max(s + r, end - touch)));
            blocked = blocked | met;
            live = live & ~met;
            came = sel(live, sel(gap, splat(0.0f), next - s), came);
            before = sel(live, sel(gap, splat(0.0f), r), before);
            s = sel(live, next, s);
            live = live & lt(s, end);
        }
        for (int k = 0; k < used; k++) {
            const int i = at[k];
            if (lane(blocked, k)) free[i] = 0.0f;
            t[i] = lane(s, k);
            ball[i] = lane(before, k);
            taken[i] = lane(came, k);
            again[left] = i;
            left += lane(live, k) != 0;
        }
    }

    // Rays 0 … count - 1, whose origin, direction, t, far, reach and `free` are set. Steps are over-relaxed by the slope (Balint and Valasek 2018; Ban and Valasek 2023). Rays that are still under way after
    // `steps` evaluations graze and count as met.
    inline CUDA_CALLABLE void trace(float step, int steps, int count) {
        int left = 0;
        for (int i = 0; i < count; i++) {
            running[left] = i;
            ball[i] = taken[i] = 0.0f;
            left += free[i] > 0.0f && t[i] + reach[i] < far[i];  // on a face where the bounds cut the solid, outwards is free
        }
        for (int turn = 0; turn < steps && left > 0; turn += STEPS) {
            const int all = left;
            left = 0;
            for (int first = 0; first < all; first += SDFPRT_LANES)
                advance(running + first, all - first < SDFPRT_LANES ? all - first : SDFPRT_LANES, step, left);
            for (int i = 0; i < left; i++) running[i] = again[i];
        }
        for (int k = 0; k < left; k++) free[running[k]] = 0.0f;
    }
};
