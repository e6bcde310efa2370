// The scene's own albedo and exponent where a picture's rays hit: `colours` of `points`, and 1 where they did, and `normals`, all in
// fours; item k does lanes k*LANES …
{
    struct alignas(16) Row {
        float x, y, z, w;
    };
    F p[3], n[3], red = Simd::splat(0.0f), green = red, blue = red, s = red, there = red;
    for (int axis = 0; axis < 3; axis++) p[axis] = n[axis] = red;
    for (int k = 0; k < SDFPRT_LANES; k++) {
        const Row point = ((const Row*)points.data)[item * SDFPRT_LANES + k];
        if (!(point.w > 0.5f)) continue;
        const Row normal = ((const Row*)normals.data)[item * SDFPRT_LANES + k];
        Simd::set(there, k, 1.0f);
        Simd::set(p[0], k, point.x), Simd::set(p[1], k, point.y), Simd::set(p[2], k, point.z);
        Simd::set(n[0], k, normal.x), Simd::set(n[1], k, normal.y), Simd::set(n[2], k, normal.z);
    }
    const M hit = Simd::lt(Simd::splat(0.5f), there);
    if (!Simd::any(hit)) return;
#if SDFPRT_HAS_ALBEDO
    Albedo::value(p[0], p[1], p[2], n[0], n[1], n[2], hit, red, green, blue);
#endif
#if SDFPRT_HAS_EXPONENT
    s = Exponent::value(p[0], p[1], p[2], n[0], n[1], n[2], hit);
#endif
    for (int k = 0; k < SDFPRT_LANES; k++)
        if (Simd::lane(hit, k))
            ((Row*)colours.data)[item * SDFPRT_LANES + k] = Row{Simd::lane(red, k), Simd::lane(green, k), Simd::lane(blue, k), Simd::lane(s, k)};
}
