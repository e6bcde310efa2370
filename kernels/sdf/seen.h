// What a camera sees, samples in tiles of 8 x 4, which a warp has together: item k does lanes k*LANES …
// `camera`: eye, and the axes of the image plane as far as its edges; `cones`: how far those about GRAIN x GRAIN samples are free.
// In fours: `points`, place and 1 where the ray hit; where it did, `normals` and 0, `colours`, the scene's own albedo and exponent.
{
    struct alignas(16) Row {
        float x, y, z, w;
    };
    const int across = (width + 7) / 8, base = item * SDFPRT_LANES;
    const float* axes = camera.data + 3;
    F d[3], begin = Simd::splat(-1.0f);
    for (int axis = 0; axis < 3; axis++) d[axis] = Simd::splat(1.0f);
    for (int k = 0; k < SDFPRT_LANES; k++) {
        const int tile = (base + k) / 32, x = tile % across * 8 + (base + k) % 8, y = tile / across * 4 + (base + k) % 32 / 8;
        const float u = ((float)x + 0.5f) / (float)width * 2.0f - 1.0f, v = 1.0f - ((float)y + 0.5f) / (float)height * 2.0f;
        for (int axis = 0; axis < 3; axis++) Simd::set(d[axis], k, u * axes[axis] + v * axes[3 + axis] + axes[6 + axis]);
        if (x < width && y < height) Simd::set(begin, k, cones.data[y / GRAIN * ((width + GRAIN - 1) / GRAIN) + x / GRAIN]);
    }
    const F size = Simd::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int axis = 0; axis < 3; axis++) d[axis] = d[axis] / size;

    // Through free space, to the surface, onto it
    const F o[3] = {Simd::splat(camera.data[0]), Simd::splat(camera.data[1]), Simd::splat(camera.data[2])};
    F enter, leave;
    Tracer::clip(o[0], o[1], o[2], d[0], d[1], d[2], box.data, enter, leave);
    const F first = Simd::max(enter, Simd::splat(0.0f));
    F t = Simd::max(first, begin);
    const M inside = Simd::le(Simd::splat(0.0f), begin) & Simd::le(t, leave);
    const float sample = 2.0f * sqrtf(axes[3] * axes[3] + axes[4] * axes[4] + axes[5] * axes[5]) / (float)height;
    const M hit = Tracer::approach(o[0], o[1], o[2], d[0], d[1], d[2], t, first, leave, Simd::splat(near), 0.5f * sample, step, steps, inside);
    F n[3], red = Simd::splat(0.0f), green = red, blue = red, s = red, p[3] = {red, red, red};
    for (int axis = 0; axis < 3; axis++) n[axis] = red;
    if (Simd::any(hit)) {
        for (int axis = 0; axis < 3; axis++) p[axis] = o[axis] + t * d[axis];

        // Differences at the corners of a tetrahedron, by one call, as in distance.h
        for (int tap = 0; tap < 4; tap++) {
            const float sx = tap == 0 || tap == 3 ? 1.0f : -1.0f, sy = tap >= 2 ? 1.0f : -1.0f, sz = tap % 2 ? 1.0f : -1.0f;
            const F r = Scene::distance(p[0] + sx * taps, p[1] + sy * taps, p[2] + sz * taps, hit);
            n[0] += sx * r;
            n[1] += sy * r;
            n[2] += sz * r;
        }
        const F length = Simd::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        const M flat = Simd::le(length, Simd::splat(4e-12f * taps)) | ~Simd::lt(length, Simd::splat(1e30f));
        for (int axis = 0; axis < 3; axis++) n[axis] = Simd::sel(flat, Simd::splat(axis == 1 ? 1.0f : 0.0f), n[axis] / length);
#if SDFPRT_HAS_ALBEDO
        Albedo::value(p[0], p[1], p[2], n[0], n[1], n[2], hit, red, green, blue);
#endif
#if SDFPRT_HAS_EXPONENT
        s = Exponent::value(p[0], p[1], p[2], n[0], n[1], n[2], hit);
#endif
    }
    for (int k = 0; k < SDFPRT_LANES; k++) {
        const bool met = Simd::lane(hit, k) != 0;
        ((Row*)points.data)[base + k] = Row{Simd::lane(p[0], k), Simd::lane(p[1], k), Simd::lane(p[2], k), met ? 1.0f : 0.0f};
        if (!met) continue;
        ((Row*)normals.data)[base + k] = Row{Simd::lane(n[0], k), Simd::lane(n[1], k), Simd::lane(n[2], k), 0.0f};
#if SDFPRT_HAS_ALBEDO || SDFPRT_HAS_EXPONENT
        ((Row*)colours.data)[base + k] = Row{Simd::lane(red, k), Simd::lane(green, k), Simd::lane(blue, k), Simd::lane(s, k)};
#endif
    }
}
