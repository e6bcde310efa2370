// Does each ray leave the bounds? Item k does lanes k*LANES …; `out` gets 1 where it does, 0 where it meets the surface.
{
    const int base = item * SDFPRT_LANES;
    F o[3], d[3];
    for (int axis = 0; axis < 3; axis++) {
        o[axis] = Simd::splat(0.0f);
        d[axis] = Simd::splat(1.0f);
        for (int k = 0; k < SDFPRT_LANES; k++) {
            Simd::set(o[axis], k, origins.data[3 * (base + k) + axis]);
            Simd::set(d[axis], k, directions.data[3 * (base + k) + axis]);
        }
    }
    F enter, leave;
    Tracer::clip(o[0], o[1], o[2], d[0], d[1], d[2], box.data, enter, leave);
    F t = Simd::max(enter, Simd::splat(0.0f));
    // Within `near` a ray has met the surface; less where it begins so near, in a crease
    const F origin = Scene::distance(o[0], o[1], o[2], Simd::ones()) * step;
    const F reach = Simd::sel(Simd::lt(Simd::splat(0.0f), origin), Simd::min(Simd::splat(near), 0.5f * origin), Simd::splat(near));
    const M hit = Tracer::march(o[0], o[1], o[2], d[0], d[1], d[2], t, leave, reach, step, relaxation, steps,
                                Simd::le(t, leave));
    for (int k = 0; k < SDFPRT_LANES; k++) out.data[base + k] = Simd::lane(hit, k) ? 0.0f : 1.0f;
}
