// Does each ray leave the bounds? Item k does lanes k*LANES …; `out` gets 1 where it does, 0 where it meets the surface.
{
    F t = Simd::max(enter, Simd::splat(0.0f));
    // Within `near` a ray has met the surface; less where it begins so near, in a crease
    const F origin = Scene::distance(o[0], o[1], o[2], Simd::ones()) * step;
    const F reach = Simd::sel(Simd::lt(Simd::splat(0.0f), origin), Simd::min(Simd::splat(near), 0.5f * origin), Simd::splat(near));
    const M hit = Tracer::march(o[0], o[1], o[2], d[0], d[1], d[2], t, leave, reach, step, relaxation, steps,
                                Simd::le(t, leave));
    for (int k = 0; k < SDFPRT_LANES; k++) out.data[base + k] = Simd::lane(hit, k) ? 0.0f : 1.0f;
}
