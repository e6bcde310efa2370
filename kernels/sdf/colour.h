// The scene's own albedo and exponent at many points: `rows` holds point and normal, `out` albedo and exponent.
{
    F v[6], r = Simd::splat(0.0f), g = r, b = r, s = r;
    for (int c = 0; c < 6; c++) {
        v[c] = r;
        for (int k = 0; k < SDFPRT_LANES; k++) Simd::set(v[c], k, rows.data[6 * (item * SDFPRT_LANES + k) + c]);
    }
#if SDFPRT_HAS_ALBEDO
    Albedo::value(v[0], v[1], v[2], v[3], v[4], v[5], Simd::ones(), r, g, b);
#endif
#if SDFPRT_HAS_EXPONENT
    s = Exponent::value(v[0], v[1], v[2], v[3], v[4], v[5], Simd::ones());
#endif
    for (int k = 0; k < SDFPRT_LANES; k++) {
        float* to = out.data + 4 * (item * SDFPRT_LANES + k);
        to[0] = Simd::lane(r, k), to[1] = Simd::lane(g, k), to[2] = Simd::lane(b, k), to[3] = Simd::lane(s, k);
    }
}
