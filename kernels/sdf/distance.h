// Distance (`step` 0) or gradient at many points: item k does lanes k*LANES …, `points` is padded to whole packets.
{
    const int base = item * SDFPRT_LANES;
    F x = Simd::splat(0.0f), y = x, z = x;
    for (int k = 0; k < SDFPRT_LANES; k++) {
        Simd::set(x, k, points.data[3 * (base + k)]);
        Simd::set(y, k, points.data[3 * (base + k) + 1]);
        Simd::set(z, k, points.data[3 * (base + k) + 2]);
    }
    // Four taps at the corners of a tetrahedron, by one call, since a large scene is slow to compile twice
    F d = x, gx = Simd::splat(0.0f), gy = gx, gz = gx;
    for (int tap = 0; tap < (step == 0.0f ? 1 : 4); tap++) {
        const float sx = tap == 0 || tap == 3 ? 1.0f : -1.0f, sy = tap >= 2 ? 1.0f : -1.0f, sz = tap % 2 ? 1.0f : -1.0f;
        d = Scene::distance(x + sx * step, y + sy * step, z + sz * step, Simd::ones());
        gx += sx * d;
        gy += sy * d;
        gz += sz * d;
    }
    for (int k = 0; k < SDFPRT_LANES; k++) {
        if (step == 0.0f) {
            out.data[base + k] = Simd::lane(d, k);
        } else {
            out.data[3 * (base + k)] = Simd::lane(gx, k) * 0.25f / step;
            out.data[3 * (base + k) + 1] = Simd::lane(gy, k) * 0.25f / step;
            out.data[3 * (base + k) + 2] = Simd::lane(gz, k) * 0.25f / step;
        }
    }
}
