// Transfer of SDFPRT_GROUP points an item: T_i = integral of V max(n.w, 0) y_i(w) dw by cosine-weighted directions, an R2 sequence
// shifted differently at each point. Rays begin where empty balls end, along the normal and then along the middle of each packet:
// the creeping zone is never marched.
struct Projection : Simd {
    float re[SDFPRT_SHARE], im[SDFPRT_SHARE];  // (x + i y)^m of each direction of a point, 0 where a ray is not free

    // Adds the basis at `count` directions to `total`
    inline CUDA_CALLABLE void add(const Packets& packets, int first, int count, int bands, const float* recurrence, F* total) {
        for (int at = 0; at < count; at += SDFPRT_LANES) {
            spill(re + at, fill(packets.free + first + at));
            spill(im + at, splat(0.0f));
        }
        if (bands == 4) {  // known beforehand: sums stay in registers
            order(packets, first, count, 0, 4, recurrence, total);
            order(packets, first, count, 1, 4, recurrence, total);
            order(packets, first, count, 2, 4, recurrence, total);
            order(packets, first, count, 3, 4, recurrence, total);
        } else {
            for (int m = 0; m < bands; m++) order(packets, first, count, m, bands, recurrence, total);
        }
    }

    // The functions of order m and -m, by the recurrence in l whose constants are from sdfprt/transfer.py
    __attribute__((always_inline)) inline CUDA_CALLABLE void order(const Packets& packets, int first, int count, int m, int bands,
                                                                   const float* recurrence, F* total) {
        F even[8], odd[8];
        for (int l = m; l < bands; l++) even[l] = odd[l] = splat(0.0f);
        for (int at = 0; at < count; at += SDFPRT_LANES) {
            const F x = fill(packets.dx + first + at), y = fill(packets.dy + first + at), z = fill(packets.dz + first + at);
            const F a = fill(re + at), b = fill(im + at);
            F before = splat(0.0f), here = splat(recurrence[3 * (m * bands + m)]);
            for (int l = m; l < bands; l++) {
                const float* constants = recurrence + 3 * (m * bands + l);
                even[l] = mad(here, a, even[l]);
                odd[l] = mad(here, b, odd[l]);
                const F next = mad(constants[1] * z, here, -constants[2] * before);
                before = here;
                here = next;
            }
            spill(re + at, mad(a, x, -b * y));
            spill(im + at, mad(a, y, b * x));
        }
        for (int l = m; l < bands; l++) {
            total[l * (l + 1) + m] += even[l];
            if (m > 0) total[l * (l + 1) - m] += odd[l];
        }
    }
};
{
    const int SHIFTS = 16;  // orders of a point's rays, for as many parts of the shift of u
    const int all = (rays + 7) / 8 * 8;  // in an order
    const int begin = item * SDFPRT_GROUP, members = total - begin < SDFPRT_GROUP ? total - begin : SDFPRT_GROUP;
    Packets packets;
    Projection projection;
    packets.lattice.read(records.data, clear.data, frame.data);
    const float ax = packets.lattice.ox, ay = packets.lattice.oy, az = packets.lattice.oz, scale = 1.0f / packets.lattice.cell;
    const float bounds[6] = {(box.data[0] - ax) * scale, (box.data[1] - ay) * scale, (box.data[2] - az) * scale,
                             (box.data[3] - ax) * scale, (box.data[4] - ay) * scale, (box.data[5] - az) * scale};
    F sum[SDFPRT_GROUP][64];
    for (int g = 0; g < members; g++)
        for (int i = 0; i < bands * bands; i++) sum[g][i] = Simd::splat(0.0f);

    // Empty balls of each point: centres o + h n, the first at o itself, then h growing by 1.7 a ball
    const int NEAR = SDFPRT_LANES == 1 ? 16 : 8;
    float height[NEAR];
    for (int k = 0; k < NEAR; k++) height[k] = k == 0 ? 0.0f : 2.0f * offset * scale * expf(0.530628f * (float)(k - 1));
    Balls balls[SDFPRT_GROUP];
    for (int g = 0; g < members; g++) {
        const float* p = points.data + 3 * (begin + g);
        const float* n = normals.data + 3 * (begin + g);
        const float ox = packets.ox[g] = (p[0] + n[0] * offset - ax) * scale;
        const float oy = packets.oy[g] = (p[1] + n[1] * offset - ay) * scale;
        const float oz = packets.oz[g] = (p[2] + n[2] * offset - az) * scale;
        const F x = Simd::splat(ox), y = Simd::splat(oy), z = Simd::splat(oz);
        const F u = Simd::splat(n[0]), v = Simd::splat(n[1]), w = Simd::splat(n[2]);
        F enter, leave;
        Tracer::clip(x, y, z, u, v, w, bounds, enter, leave);
        for (int first = 0; first < NEAR && shadowed; first += SDFPRT_LANES) {
            const F h = Simd::max(Simd::min(Simd::fill(height + first), leave), Simd::splat(0.0f));
            balls[g].set(first, h, packets.around(Simd::mad(h, u, x), Simd::mad(h, v, y), Simd::mad(h, w, z), 2.0f * near * scale, step));
        }
        // Less where o itself lies so near, in a crease
        const float half = shadowed ? 0.5f * balls[g].radius[0] : 0.0f;
        packets.reach[g] = 0.0f < half && half < near * scale ? half : near * scale;
    }

    for (int batch = 0; batch < rays; batch += SDFPRT_SHARE) {
        const int share = rays - batch < SDFPRT_SHARE ? rays - batch : SDFPRT_SHARE;
        const int padded = (share + SDFPRT_LANES - 1) / SDFPRT_LANES * SDFPRT_LANES;
        for (int g = 0; g < members; g++) {
            const float nx = normals.data[3 * (begin + g)], ny = normals.data[3 * (begin + g) + 1];
            const float nz = normals.data[3 * (begin + g) + 2];

            // Frame about the normal (Duff et al. 2017)
            const float sign = nz >= 0.0f ? 1.0f : -1.0f;
            const float a = -1.0f / (sign + nz), b = nx * ny * a;
            const float tx = 1.0f + sign * nx * nx * a, ty = sign * b, tz = -sign * nx;
            const float bx = b, by = sign + ny * ny * a, bz = -ny;

            // A shift of the directions that depends on the point's number and the seed alone
            unsigned s = ((unsigned)numbers.data[begin + g] * 2654435761u) ^ ((unsigned)seed * 2246822519u);
            s ^= s >> 16; s *= 0x7feb352du; s ^= s >> 15; s *= 0x846ca68bu; s ^= s >> 16;
            const float shift_u = (float)(s & 0xffffu) / 65536.0f, shift_v = (float)(s >> 16) / 65536.0f;

            // The shift of v turns the frame
            const float turn = 6.28318531f * shift_v, cs = cosf(turn), sn = sinf(turn);
            const float px = cs * tx + sn * bx, py = cs * ty + sn * by, pz = cs * tz + sn * bz;
            const float qx = cs * bx - sn * tx, qy = cs * by - sn * ty, qz = cs * bz - sn * tz;

            const float* first_of = sequence.data + (int)(shift_u * (float)SHIFTS) * 3 * all + batch;
            for (int first = 0; first < padded; first += SDFPRT_LANES) {
                const int at = g * SDFPRT_SHARE + first;
                const F number = Simd::fill(first_of + first), u = Simd::fract(number + shift_u);
                const M used = Simd::le(Simd::splat(0.0f), number);
                const F c = Simd::sqrt(Simd::max(1.0f - u, Simd::splat(1e-9f))), r = Simd::sqrt(u);
                const F lx = r * Simd::fill(first_of + all + first), ly = r * Simd::fill(first_of + 2 * all + first);
                const F dx = Simd::mad(c, Simd::splat(nx), Simd::mad(ly, Simd::splat(qx), lx * px));
                const F dy = Simd::mad(c, Simd::splat(ny), Simd::mad(ly, Simd::splat(qy), lx * py));
                const F dz = Simd::mad(c, Simd::splat(nz), Simd::mad(ly, Simd::splat(qz), lx * pz));
                Packets::spill(packets.dx + at, dx);
                Packets::spill(packets.dy + at, dy);
                Packets::spill(packets.dz + at, dz);
                Packets::spill(packets.free + at, Simd::sel(used, Simd::splat(1.0f), Simd::splat(0.0f)));
                if (!shadowed) continue;
                F t = Simd::splat(0.0f);
                M inside;
                for (int k = 0; k < NEAR; k++) t = balls[g].past(k, t, c, inside);
                F enter, leave;
                Tracer::clip(Simd::splat(packets.ox[g]), Simd::splat(packets.oy[g]), Simd::splat(packets.oz[g]), dx, dy, dz, bounds,
                             enter, leave);
                Packets::spill(packets.t + at, t);
                Packets::spill(packets.far + at, leave);
            }
        }
#if SDFPRT_LANES > 1
        if (shadowed) packets.pass(bounds, offset * scale, step, members, padded);
#endif
        if (shadowed) packets.trace(step, steps, members, padded);

        for (int g = 0; g < members; g++) projection.add(packets, g * SDFPRT_SHARE, padded, bands, recurrence.data, sum[g]);
    }
    for (int g = 0; g < members; g++)
        for (int i = 0; i < bands * bands; i++) {
            float all = 0.0f;
            for (int k = 0; k < SDFPRT_LANES; k++) all += Simd::lane(sum[g][i], k);
            out.data[(begin + g) * bands * bands + i] = all * 3.14159265f / (float)rays;
        }
}
