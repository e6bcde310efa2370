// Sphere tracing of packets inside the bounds (Hart 1996), over-relaxed with the safe step to fall back on (Keinert 2014).
struct Tracer : Simd {
    // Where the line o + t d is inside the box: from `enter` to `leave`, empty where leave < enter
    static inline CUDA_CALLABLE void clip(F ox, F oy, F oz, F dx, F dy, F dz, const float* box, F& enter, F& leave) {
        const F tiny = splat(1e-12f);
        const F ix = 1.0f / sel(lt(abs(dx), tiny), tiny, dx);
        const F iy = 1.0f / sel(lt(abs(dy), tiny), tiny, dy);
        const F iz = 1.0f / sel(lt(abs(dz), tiny), tiny, dz);
        const F ax = (box[0] - ox) * ix, bx = (box[3] - ox) * ix;
        const F ay = (box[1] - oy) * iy, by = (box[4] - oy) * iy;
        const F az = (box[2] - oz) * iz, bz = (box[5] - oz) * iz;
        enter = max(max(min(ax, bx), min(ay, by)), min(az, bz));
        leave = min(min(max(ax, bx), max(ay, by)), max(az, bz));
    }

    // March live lanes from t towards `far`; true where the distance falls below `near`. t is where each lane stopped.
    static inline CUDA_CALLABLE M march(F ox, F oy, F oz, F dx, F dy, F dz, F& t, F far, F near, float step,
                                        float relaxation, int steps, M live) {
        M hit = none();
        F before = splat(0.0f), taken = splat(0.0f), omega = splat(relaxation);
        live = live & lt(t + near, far);  // on a face where the bounds cut the solid, outwards is free
        for (int k = 0; k < steps; k++) {
            if (!any(live)) break;
            const F r = Scene::distance(fma(dx, t, ox), fma(dy, t, oy), fma(dz, t, oz), live) * step;
            // The balls of this step and the one before do not touch: something may lie between, go back
            const M gap = lt(splat(1.0f), omega) & lt(r + before, taken);
            const M found = ~gap & lt(r, near) & live;
            hit = hit | found;
            live = live & ~found;
            // Not past the end by relaxation alone: what a gap would tell is told there. No number ends the ray: no surface is there
            const F ahead = sel(gap, before - taken, min(omega * r, max(far - near - t, r)));
            t = sel(live, t + ahead, t);
            taken = sel(gap, splat(0.0f), ahead);
            before = sel(gap, splat(0.0f), r);
            omega = sel(gap, splat(1.0f), omega);
            live = live & lt(t, far);
        }
        return hit | live;  // what is still under way after so many steps grazes a surface
    }

    // Steps of a camera's rays and of cones about them are as long as the next ball will touch this one if the slope stays (Balint and
    // Valasek 2018); where two balls do not touch, something may lie between: back to the end of the first.
    static inline CUDA_CALLABLE float guess() { return -0.6f; }  // slope of a ray of which nothing is known
    static inline CUDA_CALLABLE F change(F now, F before, F taken, M known) {
        return min(max((now - before) / sel(known, taken, splat(1.0f)), splat(-1.0f)), splat(0.8f));
    }

    // How far the cone with radius `cone` at distance 1 is free, from t on; -1 where to `far`.
    static inline CUDA_CALLABLE F free_cone(F ox, F oy, F oz, F dx, F dy, F dz, F t, F far, float cone, float step, int steps) {
        F before = splat(0.0f), taken = splat(0.0f), slope = splat(guess()), free = splat(-1.0f);
        M live = lt(t, far);
        for (int k = 0; k < steps && any(live); k++) {
            const F r = Scene::distance(ox + dx * t, oy + dy * t, oz + dz * t, live) * step - cone * t;
            const M known = lt(splat(0.0f), taken), gap = known & lt(r + before, taken);
            // As near as half its radius a cone is no longer worth a step; no number says nothing of what lies about the place
            const M met = live & ~gap & ~lt(0.5f * cone * t, r);
            free = sel(met, sel(is_nan(r), t - taken + min(before, taken), t), free);
            live = live & ~met;
            slope = sel(gap, splat(guess()), sel(known, change(r, before, taken, known), slope));
            const F ahead = sel(gap, before - taken, min(1.9f * r / (1.0f - slope), max(far - cone * t - t, r)));
            t = sel(live, t + ahead, t);
            taken = sel(gap, splat(0.0f), ahead);
            before = sel(gap, splat(0.0f), r);
            live = live & lt(t, far);
        }
        return sel(live, t - taken + min(before, taken), free);
    }
};
