// Transfer of SDFPRT_GROUP points an item: T_i = integral of V max(n.w, 0) y_i(w) dw by cosine-weighted directions, an R2 sequence
// shifted differently at each point. Rays begin where empty balls end, along the normal and then along the middle of each packet:
// the creeping zone is never marched.
{
    const int SHARE = SDFPRT_BATCH / SDFPRT_GROUP;  // rays of a point in a batch
    const int SHIFTS = 16;  // orders of a point's rays, for as many parts of the shift along u
    const int all = (rays + 7) / 8 * 8;  // in an order
    const int begin = item * SDFPRT_GROUP, members = total - begin < SDFPRT_GROUP ? total - begin : SDFPRT_GROUP;
    Packets packets;
    packets.lattice.read(records.data, frame.data);
    F sum[SDFPRT_GROUP][64];
    for (int g = 0; g < members; g++)
        for (int i = 0; i < bands * bands; i++) sum[g][i] = Simd::splat(0.0f);

    // Empty balls of each point: centres o + h n, the first at o itself, then h growing by 1.7 a ball
    const int NEAR = SDFPRT_LANES == 1 ? 16 : 8;
    float height[NEAR], radius[SDFPRT_GROUP][NEAR];
    for (int k = 0; k < NEAR; k++) height[k] = k == 0 ? 0.0f : 2.0f * offset * expf(0.530628f * (float)(k - 1));
    for (int g = 0; g < members && shadowed; g++) {
        const float* p = points.data + 3 * (begin + g);
        const float* n = normals.data + 3 * (begin + g);
        for (int first = 0; first < NEAR; first += SDFPRT_LANES) {
            const F h = offset + Simd::fill(height + first);
            const F d = Scene::distance(p[0] + n[0] * h, p[1] + n[1] * h, p[2] + n[2] * h, Simd::ones()) * step;
            Simd::spill(radius[g] + first, d);
        }
    }

    for (int batch = 0; batch < rays; batch += SHARE) {
        const int share = rays - batch < SHARE ? rays - batch : SHARE;
        const int padded = (share + SDFPRT_LANES - 1) / SDFPRT_LANES * SDFPRT_LANES;
        for (int g = 0; g < members; g++) {
            const float* p = points.data + 3 * (begin + g);
            const float nx = normals.data[3 * (begin + g)], ny = normals.data[3 * (begin + g) + 1];
            const float nz = normals.data[3 * (begin + g) + 2];
            const float ox = p[0] + nx * offset, oy = p[1] + ny * offset, oz = p[2] + nz * offset;

            // Frame about the normal (Duff et al. 2017)
            const float sign = nz >= 0.0f ? 1.0f : -1.0f;
            const float a = -1.0f / (sign + nz), b = nx * ny * a;
            const float tx = 1.0f + sign * nx * nx * a, ty = sign * b, tz = -sign * nx;
            const float bx = b, by = sign + ny * ny * a, bz = -ny;

            // A shift of the directions that depends on the point's number and the seed alone
            unsigned s = ((unsigned)numbers.data[begin + g] * 2654435761u) ^ ((unsigned)seed * 2246822519u);
            s ^= s >> 16; s *= 0x7feb352du; s ^= s >> 15; s *= 0x846ca68bu; s ^= s >> 16;
            const float shift_u = (float)(s & 0xffffu) / 65536.0f, shift_v = (float)(s >> 16) / 65536.0f;

            const int* turns = order.data + (int)(shift_u * (float)SHIFTS) * all;
            for (int first = 0; first < padded; first += SDFPRT_LANES) {
                const int at = g * padded + first;
                const F number = Simd::to_F(Simd::fill(turns + batch + first)) + 0.5f;
                const F u = Simd::fract(number * 0.7548776662f + shift_u);
                const F v = Simd::fract(number * 0.5698402910f + shift_v);
                const M used = Simd::lt(number, Simd::splat((float)rays));
                const F c = Simd::sqrt(Simd::max(1.0f - u, Simd::splat(1e-9f))), r = Simd::sqrt(u);
                F sn, cs;
                Simd::sincos(6.28318531f * v, sn, cs);
                const F lx = r * cs, ly = r * sn;
                const F dx = lx * tx + ly * bx + c * nx, dy = lx * ty + ly * by + c * ny, dz = lx * tz + ly * bz + c * nz;
                Packets::spill(packets.dx + at, dx);
                Packets::spill(packets.dy + at, dy);
                Packets::spill(packets.dz + at, dz);
                Packets::spill(packets.free + at, Simd::sel(used, Simd::splat(1.0f), Simd::splat(0.0f)));
                if (!shadowed) continue;
                F t = Simd::splat(0.0f);
                for (int k = 0; k < NEAR; k++) {
                    if (radius[g][k] <= 0.0f) break;
                    t = Packets::past(t, height[k], radius[g][k], c);
                }
                F enter, leave;
                Tracer::clip(Simd::splat(ox), Simd::splat(oy), Simd::splat(oz), dx, dy, dz, box.data, enter, leave);
                Packets::spill(packets.t + at, t);
                Packets::spill(packets.far + at, leave);
                // Less where o itself lies so near, in a crease
                const float half = 0.5f * radius[g][0];
                Packets::spill(packets.reach + at, Simd::splat(0.0f < half && half < near ? half : near));
                Packets::spill(packets.ox + at, Simd::splat(ox));
                Packets::spill(packets.oy + at, Simd::splat(oy));
                Packets::spill(packets.oz + at, Simd::splat(oz));
            }
        }
#if SDFPRT_LANES > 1
        if (shadowed) packets.pass(box.data, offset, step, members * padded / SDFPRT_LANES);
#endif
        if (shadowed) packets.trace(step, steps, members * padded);

        // Basis by the recurrence in l of each order m, its constants from sdfprt/transfer.py
        for (int at = 0; at < members * padded; at += SDFPRT_LANES) {
            const F dx = Packets::fill(packets.dx + at), dy = Packets::fill(packets.dy + at);
            const F dz = Packets::fill(packets.dz + at), one = Packets::fill(packets.free + at);
            if (!Simd::any(Simd::lt(Simd::splat(0.0f), one))) continue;
            F* total_of = sum[at / padded];
            F re = one, im = Simd::splat(0.0f);
            for (int m = 0; m < bands; m++) {
                const float* constants = recurrence.data + 3 * (m * bands + m);
                F before = Simd::splat(0.0f), here = Simd::splat(constants[0]);
                for (int l = m; l < bands; l++, constants += 3) {
                    const int i = l * (l + 1);
                    total_of[i + m] += here * re;
                    if (m > 0) total_of[i - m] += here * im;
                    const F next = constants[1] * dz * here - constants[2] * before;
                    before = here;
                    here = next;
                }
                const F turned = re * dx - im * dy;
                im = re * dy + im * dx;
                re = turned;
            }
        }
    }
    for (int g = 0; g < members; g++)
        for (int i = 0; i < bands * bands; i++) {
            float all = 0.0f;
            for (int k = 0; k < SDFPRT_LANES; k++) all += Simd::lane(sum[g][i], k);
            out.data[(begin + g) * bands * bands + i] = all * 3.14159265f / (float)rays;
        }
}
