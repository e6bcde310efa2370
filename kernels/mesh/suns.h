// Sums over the discs that were taken out of a light, at a point of a mesh an item: the share of each disc that is free by SAMPLES rays
// into it, spread by a spiral that each point turns its own way. The lobe is that of kernels/sdf/suns.h, as are `rows` and `out`.
{
    const int SAMPLES = 8;
    Tree tree(handles.data);
    const float *v = rows.data + 10 * item, *p = v, *n = v + 3, *e = v + 6, s = v[9];
    float sum[6] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
    const float facing = 2.0f * (n[0] * e[0] + n[1] * e[1] + n[2] * e[2]);
    const float mirrored[3] = {facing * n[0] - e[0], facing * n[1] - e[1], facing * n[2] - e[2]};
    const F ox = Simd::splat(p[0] + lift * n[0]), oy = Simd::splat(p[1] + lift * n[1]), oz = Simd::splat(p[2] + lift * n[2]);
    unsigned hash = (unsigned)item * 2654435761u;
    hash ^= hash >> 15, hash *= 0x846ca68bu, hash ^= hash >> 16;
    const float turn = 6.28318531f * (float)(hash & 0xffffu) / 65536.0f;
    for (int number = 0; number < count; number++) {
        const float* sun = suns.data + 7 * number;
        const float x = sun[0], y = sun[1], z = sun[2], angle = sun[3], tangent = tanf(angle);
        if (n[0] * x + n[1] * y + n[2] * z <= -sinf(angle)) continue;

        // A frame about the direction
        float side[3];
        if (fabsf(x) < 0.7f) side[0] = 0.0f, side[1] = z, side[2] = -y;
        else side[0] = -z, side[1] = 0.0f, side[2] = x;
        const float length = sqrtf(side[0] * side[0] + side[1] * side[1] + side[2] * side[2]);
        for (int c = 0; c < 3; c++) side[c] /= length;
        const float other[3] = {y * side[2] - z * side[1], z * side[0] - x * side[2], x * side[1] - y * side[0]};

        // The mean of visibility times cosine over the disc
        float lit = 0.0f;
        for (int first = 0; first < SAMPLES; first += SDFPRT_LANES) {
            float ways[3][SDFPRT_LANES];
            for (int k = 0; k < SDFPRT_LANES; k++) {
                const float part = (float)(first + k), far = tangent * sqrtf((part + 0.5f) / (float)SAMPLES), around = turn + 2.39996323f * part;
                const float a = far * cosf(around), b = far * sinf(around), size = sqrtf(1.0f + far * far);
                for (int c = 0; c < 3; c++) ways[c][k] = (sun[c] + a * side[c] + b * other[c]) / size;
            }
            const F wx = Simd::fill(ways[0]), wy = Simd::fill(ways[1]), wz = Simd::fill(ways[2]);
            const F cosine = n[0] * wx + n[1] * wy + n[2] * wz;
            Tree::Ray ray;
            tree.start(ray, ox, oy, oz, wx, wy, wz, 0.0f);
            const M open = tree.free(ray, Simd::lt(Simd::splat(0.0f), cosine));
            const F share = Simd::sel(open, cosine, Simd::splat(0.0f));
            for (int k = 0; k < SDFPRT_LANES; k++) lit += Simd::lane(share, k);
        }
        const float given = lit / (float)SAMPLES, wide = 1.0f / (1.0f + 0.25f * s * angle * angle);
        const float near_lobe = mirrored[0] * x + mirrored[1] * y + mirrored[2] * z;
        const float lobe = near_lobe > 0.0f ? (s + 2.0f) * 0.159154943f * wide * powf(near_lobe, s * wide) : 0.0f;
        for (int c = 0; c < 3; c++) {
            sum[c] += given * 0.318309886f * sun[4 + c];
            sum[3 + c] += given * lobe * sun[4 + c];
        }
    }
    for (int c = 0; c < 6; c++) out.data[6 * item + c] = sum[c];
}
