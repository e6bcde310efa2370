// One bounce more of a row of a table an item: T_i = integral of (1 - V) albedo/pi T_i(q) max(n.w, 0) dw, q what the ray meets, T(q)
// interpolated from the table before (Gentle Introduction to PRT, 6.2.6.3). The albedo is the met triangle's.
{
    const int width = 3 * coefficients;  // floats a row, coefficients padded to whole packets
    F sum[3 * 64 / SDFPRT_LANES];
    for (int i = 0; i < width / SDFPRT_LANES; i++) sum[i] = Simd::splat(0.0f);
    for (int at = 0; at < rays; at += SDFPRT_LANES) {
        F x, y, z;
        M used;
        directions.packet(at, x, y, z, used);
        Tree::Ray ray;
        tree.start(ray, ox, oy, oz, x, y, z, 0.0f);
        const M met = tree.meet(ray, used);
        const F along = ray.normal_x * x + ray.normal_y * y + ray.normal_z * z;
        for (unsigned left = Simd::bits(met); left; left &= left - 1) {
            const int k = Simd::lowest(left), face = (int)Simd::lane(Simd::as_I(ray.triangle), k);
            const float u = Simd::lane(ray.second, k), v = Simd::lane(ray.third, k), weights[3] = {1.0f - u - v, u, v};
            const bool front = Simd::lane(along, k) < 0.0f;
            const float* row[3];
            bool dark = false;
            for (int j = 0; j < 3; j++) {
                const int vertex = faces.data[3 * face + j], other = front ? vertex : back.data[vertex];
                dark |= other < 0;
                row[j] = table.data + (other < 0 ? 0 : other) * width;
            }
            if (dark) continue;  // the inside of a closed body
            for (int c = 0; c < 3; c++) {
                const float albedo = albedos.data[3 * face + c];
                for (int i = c * coefficients; i < (c + 1) * coefficients; i += SDFPRT_LANES) {
                    const F there = weights[0] * Simd::fill(row[0] + i) + weights[1] * Simd::fill(row[1] + i) + weights[2] * Simd::fill(row[2] + i);
                    sum[i / SDFPRT_LANES] += albedo * there;
                }
            }
        }
    }
    for (int i = 0; i < width; i += SDFPRT_LANES) Simd::spill(out.data + item * width + i, sum[i / SDFPRT_LANES] / (float)rays);
}
