// Transfer of a point of a mesh an item: T_i = integral of V max(n.w, 0) y_i(w) dw by cosine-weighted directions, V by Embree.
{
    Projection projection;
    F sum[64];
    for (int i = 0; i < bands * bands; i++) sum[i] = Simd::splat(0.0f);
    float dx[SDFPRT_SHARE], dy[SDFPRT_SHARE], dz[SDFPRT_SHARE], open[SDFPRT_SHARE];
    const Fan fan = {dx, dy, dz, open};
    for (int batch = 0; batch < rays; batch += SDFPRT_SHARE) {
        const int share = rays - batch < SDFPRT_SHARE ? rays - batch : SDFPRT_SHARE;
        const int padded = (share + SDFPRT_LANES - 1) / SDFPRT_LANES * SDFPRT_LANES;
        for (int at = 0; at < padded; at += SDFPRT_LANES) {
            F x, y, z;
            M used;
            directions.packet(batch + at, x, y, z, used);
            Simd::spill(dx + at, x), Simd::spill(dy + at, y), Simd::spill(dz + at, z);
            if (shadowed) {
                Tree::Ray ray;
                tree.start(ray, ox, oy, oz, x, y, z, 0.0f);
                used = tree.free(ray, used);
            }
            Simd::spill(open + at, Simd::sel(used, Simd::splat(1.0f), Simd::splat(0.0f)));
        }
        projection.add(fan, padded, bands, recurrence.data, sum);
    }
    for (int i = 0; i < bands * bands; i++) {
        float all = 0.0f;
        for (int k = 0; k < SDFPRT_LANES; k++) all += Simd::lane(sum[i], k);
        out.data[item * bands * bands + i] = all * 3.14159265f / (float)rays;
    }
}
