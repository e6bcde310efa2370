// What a camera sees, samples in tiles of 8 x 4: one evaluation of the field a lane and turn, whatever its ray is at.
//     MARCH   steps as far as the next ball will touch this one if the slope stays (Balint and Valasek 2018), near the surface to where
//             the slope says that it is: up to half a sample, and 3e-4 of the scene, may lie between the balls, and what is so thin
//             may be passed over
//     SETTLE  onto the surface itself, backwards where a field that overestimates let the ray into the solid; a cut face keeps the
//             place where the ray entered
//     TAPS    four differences at the corners of a tetrahedron, for the normal
// On CUDA lanes that are through take the next samples, which `next` counts: no warp waits for one long ray. On the CPU item k has lanes
// k*LANES … `camera`: eye, and the axes of the image plane as far as its edges; `cones`: how far those about GRAIN x GRAIN samples are
// free. `points`, in fours: place and 1 where the ray hit; `normals` there, and 0.
{
    struct alignas(16) Row {
        float x, y, z, w;
    };
    enum { MARCH = 0, SETTLE = 1, TAPS = 2, DONE = 6 };
    const int across = (width + 7) / 8, count = across * ((height + 3) / 4) * 32;
    const float *axes = camera.data + 3, *eye = camera.data;
    const float chord = sqrtf(axes[3] * axes[3] + axes[4] * axes[4] + axes[5] * axes[5]) / (float)height;  // half a sample at distance 1
    const F zero = Simd::splat(0.0f), one = Simd::splat(1.0f);
    F d[3] = {one, one, one}, n[3] = {zero, zero, zero}, t = zero, first = zero, far = zero;
    F before = zero, taken = zero, slope = zero;  // of the last evaluation: the ball, the step after it; how the field falls
    I phase = Simd::splat((int)DONE), turns = Simd::splat(0), at = Simd::splat(-1);
#if !defined(__CUDA_ARCH__)
    bool fresh = true;
#endif
    for (;;) {
        // Lanes that are through take the next samples
#if defined(__CUDA_ARCH__)
        const unsigned idle = __ballot_sync(0xffffffffu, phase == DONE);
        M begins = 0;
        if (__popc(idle) >= 16) {
            const int lane = threadIdx.x & 31, leader = __ffs(idle) - 1;
            int taken_from = 0;
            if (lane == leader) taken_from = atomicAdd(next.data, __popc(idle));
            taken_from = __shfl_sync(0xffffffffu, taken_from, leader);
            if (phase == DONE) {
                at = taken_from + __popc(idle & ((1u << lane) - 1u));
                begins = -(at < count);
            }
            if (idle == 0xffffffffu && taken_from >= count) break;
        }
#else
        if (!fresh && !Simd::any(Simd::lt(phase, Simd::splat((int)DONE)))) break;
        const M begins = fresh ? Simd::ones() : Simd::none();
        if (fresh) at = Simd::lanes() + item * SDFPRT_LANES;
        fresh = false;
#endif
        if (Simd::any(begins)) {
            F way[3] = {one, one, one}, begin = Simd::splat(-1.0f);
            for (int k = 0; k < SDFPRT_LANES; k++) {
                if (!Simd::lane(begins, k)) continue;
                const int sample = Simd::lane(at, k), tile = sample / 32;
                const int x = tile % across * 8 + sample % 8, y = tile / across * 4 + sample % 32 / 8;
                const float u = ((float)x + 0.5f) / (float)width * 2.0f - 1.0f, v = 1.0f - ((float)y + 0.5f) / (float)height * 2.0f;
                for (int axis = 0; axis < 3; axis++) Simd::set(way[axis], k, u * axes[axis] + v * axes[3 + axis] + axes[6 + axis]);
                if (x < width && y < height) Simd::set(begin, k, cones.data[y / GRAIN * ((width + GRAIN - 1) / GRAIN) + x / GRAIN]);
            }
            const F size = Simd::sqrt(way[0] * way[0] + way[1] * way[1] + way[2] * way[2]);
            for (int axis = 0; axis < 3; axis++) d[axis] = Simd::sel(begins, way[axis] / size, d[axis]), n[axis] = Simd::sel(begins, zero, n[axis]);
            F enter, leave;
            Tracer::clip(Simd::splat(eye[0]), Simd::splat(eye[1]), Simd::splat(eye[2]), d[0], d[1], d[2], box.data, enter, leave);
            first = Simd::sel(begins, Simd::max(enter, zero), first);
            far = Simd::sel(begins, leave, far);
            t = Simd::sel(begins, Simd::max(first, begin), t);
            before = Simd::sel(begins, zero, before), taken = Simd::sel(begins, zero, taken);
            slope = Simd::sel(begins, Simd::splat(Tracer::guess()), slope);
            turns = Simd::sel(begins, Simd::splat(0), turns);
            const M inside = Simd::le(zero, begin) & Simd::lt(t + near, far);
            phase = Simd::sel(begins, Simd::sel(inside, Simd::splat((int)MARCH), Simd::splat((int)DONE)), phase);
            for (int k = 0; k < SDFPRT_LANES; k++)
                if (Simd::lane(begins & ~inside, k)) ((Row*)points.data)[Simd::lane(at, k)] = Row{0.0f, 0.0f, 0.0f, 0.0f};
        }

        // The field where each lane asks for it
        const M live = Simd::lt(phase, Simd::splat((int)DONE)), march = Simd::eq(phase, Simd::splat((int)MARCH));
        const M settle = Simd::eq(phase, Simd::splat((int)SETTLE)), taps = live & ~march & ~settle;
        if (!Simd::any(live)) continue;
        const M third = Simd::eq(phase, Simd::splat(TAPS + 3)), second = Simd::eq(phase, Simd::splat(TAPS + 2));
        const F sx = Simd::sel(Simd::eq(phase, Simd::splat((int)TAPS)) | third, one, -one), sy = Simd::sel(second | third, one, -one);
        const F sz = Simd::sel(Simd::eq(phase, Simd::splat(TAPS + 1)) | third, one, -one);
        const F p[3] = {eye[0] + t * d[0], eye[1] + t * d[1], eye[2] + t * d[2]}, reach = Simd::sel(taps, Simd::splat(tap), zero);
        const F value = Scene::distance(p[0] + sx * reach, p[1] + sy * reach, p[2] + sz * reach, live), now = value * step;

        // March: where two balls do not touch, back to the end of the first; no number ends the ray, no surface is there
        const M known = Simd::ne(taken, zero);
        const F passed = Simd::min(chord * t, Simd::splat(30.0f * near)), change = Tracer::change(now, before, taken, known);
        const M gap = march & Simd::lt(zero, taken) & Simd::lt(Simd::abs(now) + before + passed, taken);
        slope = Simd::sel(gap, Simd::splat(Tracer::guess()), Simd::sel((march | settle) & known, change, slope));
        turns = turns + 1;
        // What is still under way after so many steps grazes a surface
        const M found = march & ~gap & (Simd::lt(now, Simd::splat(near)) | Simd::le(Simd::splat(steps), turns));
        const F falls = Simd::min(slope, Simd::splat(-0.1f));
        const F root = Simd::sel(Simd::lt(slope, Simd::splat(-0.05f)), Simd::min(now / -slope, now + passed), now);
        const F ahead = Simd::sel(gap, before - taken, Simd::min(Simd::max(1.9f * now / (1.0f - slope), root), Simd::max(far - near - t, now)));
        const M goes = march & ~found;
        const F there = Simd::max(t - now / falls, first);
        const F onto = Simd::sel(goes, t + ahead, there);
        taken = Simd::sel(goes, Simd::sel(gap, zero, ahead), Simd::sel(found, there - t, taken));
        before = Simd::sel(gap, zero, Simd::sel(march, now, before));
        t = Simd::sel(march | settle, onto, t);
        const M missed = goes & ~Simd::lt(t, far);
        n[0] += Simd::sel(taps, sx * value, zero), n[1] += Simd::sel(taps, sy * value, zero), n[2] += Simd::sel(taps, sz * value, zero);
        phase = Simd::sel(missed, Simd::splat((int)DONE), Simd::sel(found | settle | taps, phase + 1, phase));

        // Those that are through
        const M through = live & Simd::eq(phase, Simd::splat((int)DONE));
        if (Simd::any(through)) {
            const F length = Simd::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
            const M flat = Simd::le(length, Simd::splat(4e-12f * tap)) | ~Simd::lt(length, Simd::splat(1e30f));
            F unit[3];
            for (int axis = 0; axis < 3; axis++) unit[axis] = Simd::sel(flat, Simd::splat(axis == 1 ? 1.0f : 0.0f), n[axis] / length);
            for (int k = 0; k < SDFPRT_LANES; k++) {
                if (!Simd::lane(through, k)) continue;
                const int sample = Simd::lane(at, k);
                const bool met = !Simd::lane(missed, k);
                ((Row*)points.data)[sample] = Row{Simd::lane(p[0], k), Simd::lane(p[1], k), Simd::lane(p[2], k), met ? 1.0f : 0.0f};
                if (met) ((Row*)normals.data)[sample] = Row{Simd::lane(unit[0], k), Simd::lane(unit[1], k), Simd::lane(unit[2], k), 0.0f};
            }
        }
    }
}
