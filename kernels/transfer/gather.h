// What other surfaces send to a point, an item: G_i = integral of B(q) max(n.w, 0) y_i(w) dw of each channel, q what the ray meets
// (transfer textures, Sec. 4.2). B is that of q's texel, three channels, in layers of `side` texels squared; `layers` are those of
// each triangle's front and back, -1 for none: the inside of a closed body sends nothing. `flats` are unit normals of the triangles that
// the points lie on: what a normal map or smooth normals bring below them meets the surface itself, and nothing comes from there.
{
    Projection projection;
    F sum[3][64];
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < bands * bands; i++) sum[c][i] = Simd::splat(0.0f);
    float dx[SDFPRT_SHARE], dy[SDFPRT_SHARE], dz[SDFPRT_SHARE], light[3][SDFPRT_SHARE];
    for (int batch = 0; batch < rays; batch += SDFPRT_SHARE) {
        const int share = rays - batch < SDFPRT_SHARE ? rays - batch : SDFPRT_SHARE;
        const int padded = (share + SDFPRT_LANES - 1) / SDFPRT_LANES * SDFPRT_LANES;
        for (int at = 0; at < padded; at += SDFPRT_LANES) {
            F x, y, z;
            M used;
            directions.packet(batch + at, x, y, z, used);
            used = used & Simd::lt(Simd::splat(0.0f), flats.data[3 * item] * x + flats.data[3 * item + 1] * y + flats.data[3 * item + 2] * z);
            Simd::spill(dx + at, x), Simd::spill(dy + at, y), Simd::spill(dz + at, z);
            for (int c = 0; c < 3; c++) Simd::spill(light[c] + at, Simd::splat(0.0f));
            Tree::Ray ray;
            tree.start(ray, ox, oy, oz, x, y, z, 0.0f);
            const M met = tree.meet(ray, used);
            const F along = ray.normal_x * x + ray.normal_y * y + ray.normal_z * z;
            for (unsigned left = Simd::bits(met); left; left &= left - 1) {
                const int k = Simd::lowest(left), face = (int)Simd::lane(Simd::as_I(ray.triangle), k);
                const int layer = layers.data[2 * face + (Simd::lane(along, k) < 0.0f ? 0 : 1)];
                if (layer < 0) continue;
                const float u = Simd::lane(ray.second, k), v = Simd::lane(ray.third, k);
                const float* corner = uvs.data + 6 * face;
                const float across = (1.0f - u - v) * corner[0] + u * corner[2] + v * corner[4];
                const float down = (1.0f - u - v) * corner[1] + u * corner[3] + v * corner[5];
                int column = (int)(across * (float)side), row = (int)(down * (float)side);
                column = column < 0 ? 0 : column < side ? column : side - 1;
                row = row < 0 ? 0 : row < side ? row : side - 1;
                const float* texel = sent.data + 3 * (((long long)layer * side + row) * side + column);
                for (int c = 0; c < 3; c++) light[c][at + k] = texel[c];
            }
        }
        for (int c = 0; c < 3; c++) {
            const Fan fan = {dx, dy, dz, light[c]};
            projection.add(fan, padded, bands, recurrence.data, sum[c]);
        }
    }
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < bands * bands; i++) {
            float all = 0.0f;
            for (int k = 0; k < SDFPRT_LANES; k++) all += Simd::lane(sum[c][i], k);
            out.data[(item * 3 + c) * bands * bands + i] = all * 3.14159265f / (float)rays;
        }
}
