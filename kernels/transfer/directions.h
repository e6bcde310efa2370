// The directions in which points look (projection.h), a point an item, `rays` of three numbers each.
{
    const Directions directions(normals.data + 3 * item, numbers.data[item], seed, sequence.data, rays);
    for (int at = 0; at < rays; at += SDFPRT_LANES) {
        F x, y, z;
        M used;
        directions.packet(at, x, y, z, used);
        for (int k = 0; k < SDFPRT_LANES && at + k < rays; k++) {
            float* to = out.data + 3 * ((long long)item * rays + at + k);
            to[0] = Simd::lane(x, k), to[1] = Simd::lane(y, k), to[2] = Simd::lane(z, k);
        }
    }
}
