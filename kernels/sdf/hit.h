// Nearest hit of many rays: item k does lanes k*LANES …; `out` gets t, or -1 where the ray leaves the bounds.
{
    F t = Simd::max(enter, Simd::splat(0.0f));
    const M inside = Simd::le(t, leave);
    const M hit = Tracer::march(o[0], o[1], o[2], d[0], d[1], d[2], t, leave, Simd::splat(near), step, relaxation, steps, inside);
    // Onto the surface itself, backwards where a field that overestimates let the ray into the solid; a cut face keeps the
    // place where the ray entered
    const F first = Simd::max(enter, Simd::splat(0.0f));
    for (int k = 0; k < 5; k++) {
        const F r = Scene::distance(o[0] + d[0] * t, o[1] + d[1] * t, o[2] + d[2] * t, hit);
        t = Simd::max(t + r * step, first);
    }
    for (int k = 0; k < SDFPRT_LANES; k++) out.data[base + k] = Simd::lane(hit, k) ? Simd::lane(t, k) : -1.0f;
}
