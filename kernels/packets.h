// Visibility of up to BATCH rays from one origin. Each is marched on the grid until it is near the surface or gone; the near
// ones are then packed side by side, so that no lane of the scene's evaluation is idle; what they clear runs on the grid again.
#define SDFPRT_BATCH (16 * SDFPRT_LANES)
struct Packets : Simd {
    float t[SDFPRT_BATCH], far[SDFPRT_BATCH], dx[SDFPRT_BATCH], dy[SDFPRT_BATCH], dz[SDFPRT_BATCH];
    float ball[SDFPRT_BATCH], taken[SDFPRT_BATCH];  // of the evaluation before: radius, and the step that followed it
    float free[SDFPRT_BATCH];  // 1 where the ray leaves the bounds, 0 where it meets the surface
    int running[SDFPRT_BATCH], near[SDFPRT_BATCH], again[SDFPRT_BATCH];

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

    static inline CUDA_CALLABLE F gather(const float* v, const int* at, int count) {
        F r = splat(0.0f);
        for (int k = 0; k < SDFPRT_LANES; k++) set(r, k, v[at[k < count ? k : 0]]);
        return r;
    }

    // Rays 0 … count - 1, whose t, far, direction and `free` are set, from one origin; within `reach` a ray has met the
    // surface. Steps are as long as lets the next empty ball touch this one if the distance goes on as it did (Balint and
    // Valasek 2018; Ban and Valasek 2023). Rays that are still under way after `steps` evaluations graze and count as met.
    inline CUDA_CALLABLE void trace(const Grid& grid, float ox, float oy, float oz, float reach, float step, int steps,
                                    int count) {
        int left = 0;
        for (int i = 0; i < count; i++) {
            running[left] = i;
            ball[i] = taken[i] = 0.0f;
            left += free[i] > 0.0f && t[i] + reach < far[i];  // on a face where the bounds cut the solid, outwards is free
        }
        const float margin = grid.measure[5];
        for (int turn = 0; turn < steps && left > 0; turn++) {
            int waiting = 0;
            for (int pass = 0; left > 0; pass++) {
                int rest = 0;
                for (int first = 0; first < left; first += SDFPRT_LANES) {
                    const int* at = running + first;
                    const int lanes_used = left - first < SDFPRT_LANES ? left - first : SDFPRT_LANES;
                    const F x = gather(dx, at, lanes_used), y = gather(dy, at, lanes_used), z = gather(dz, at, lanes_used);
                    const F end = gather(far, at, lanes_used);
                    F s = gather(t, at, lanes_used), came = gather(taken, at, lanes_used), r = splat(0.0f);
                    const F before = gather(ball, at, lanes_used);
                    M live = lt(Simd::lanes(), splat(lanes_used)), open = live;
                    for (int k = 0; k < 6; k++) {
                        r = grid.bound(fma(x, s, ox), fma(y, s, oy), fma(z, s, oz));
                        open = live & lt(splat(0.5f * margin), r) & le(came, before + r);
                        if (!any(open)) break;
                        s = sel(open, s + r, s);
                        came = sel(open, splat(0.0f), came);
                        live = live & lt(s, end);
                        open = open & live;
                    }
                    for (int k = 0; k < lanes_used; k++) {
                        const int i = at[k];
                        t[i] = lane(s, k);
                        taken[i] = lane(came, k);
                        const bool on = lane(live, k), far_off = lane(open, k);
                        again[rest] = i;
                        rest += on && far_off;
                        near[waiting] = i;
                        waiting += on && !far_off;
                    }
                }
                for (int i = 0; i < rest; i++) running[i] = again[i];
                left = rest;
            }
            for (int first = 0; first < waiting; first += SDFPRT_LANES) {
                const int* at = near + first;
                const int lanes_used = waiting - first < SDFPRT_LANES ? waiting - first : SDFPRT_LANES;
                const F x = gather(dx, at, lanes_used), y = gather(dy, at, lanes_used), z = gather(dz, at, lanes_used);
                const F end = gather(far, at, lanes_used), s = gather(t, at, lanes_used);
                const M live = lt(Simd::lanes(), splat(lanes_used));
                const F r = Scene::distance(fma(x, s, ox), fma(y, s, oy), fma(z, s, oz), live) * step;
                const F before = gather(ball, at, lanes_used), came = gather(taken, at, lanes_used);
                // Negative is met for certain. Where the balls of this step and the one before leave a gap, go back to the
                // end of the ball before; else step as far as the next ball will touch this one if the slope stays
                const M found = lt(r, splat(reach)) & (lt(r, splat(0.0f)) | le(came, before + r));
                const M gap = ~found & lt(before + r, came);
                const F slope = max(min((r - before) / max(came, splat(1e-9f)), splat(0.8f)), splat(-1.0f));
                const F ahead = sel(lt(splat(0.0f), came), 1.9f * r / (1.0f - slope), 1.2f * r);
                const F next = sel(gap, s - came + before, min(s + ahead, max(s + r, end - reach)));
                for (int k = 0; k < lanes_used; k++) {
                    const int i = at[k];
                    if (lane(found, k)) free[i] = 0.0f;
                    t[i] = lane(next, k);
                    ball[i] = lane(gap, k) ? 0.0f : lane(r, k);
                    taken[i] = lane(gap, k) ? 0.0f : lane(next, k) - lane(s, k);
                    running[left] = i;
                    left += !lane(found, k) && t[i] < lane(end, k);
                }
            }
        }
        for (int k = 0; k < left; k++) free[running[k]] = 0.0f;
    }
};
