// Distance and gradient at many points: item k does lanes k*LANES …, `points` is padded to whole packets.
{
    const int base = item * SDFPRT_LANES;
    F x = Simd::splat(0.0f), y = x, z = x;
    for (int k = 0; k < SDFPRT_LANES; k++) {
        Simd::set(x, k, points.data[3 * (base + k)]);
        Simd::set(y, k, points.data[3 * (base + k) + 1]);
        Simd::set(z, k, points.data[3 * (base + k) + 2]);
    }
    const M all = Simd::ones();
    if (step == 0.0f) {
        const F d = Scene::distance(x, y, z, all);
        for (int k = 0; k < SDFPRT_LANES; k++) out.data[base + k] = Simd::lane(d, k);
    } else {
        // Four taps at the corners of a tetrahedron
        const F a = Scene::distance(x + step, y - step, z - step, all);
        const F b = Scene::distance(x - step, y - step, z + step, all);
        const F c = Scene::distance(x - step, y + step, z - step, all);
        const F d = Scene::distance(x + step, y + step, z + step, all);
        const F s = Simd::splat(0.25f / step);
        const F gx = (a - b - c + d) * s, gy = (c - a - b + d) * s, gz = (b - a - c + d) * s;
        for (int k = 0; k < SDFPRT_LANES; k++) {
            out.data[3 * (base + k)] = Simd::lane(gx, k);
            out.data[3 * (base + k) + 1] = Simd::lane(gy, k);
            out.data[3 * (base + k) + 2] = Simd::lane(gz, k);
        }
    }
}
