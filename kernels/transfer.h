// Transfer of one point a item: T_i = integral of V max(n.w, 0) y_i(w) dw by cosine-weighted directions, an R2 sequence
// shifted differently at each point. Rays begin where empty balls along the normal end: the creeping zone is never marched.
{
    const float px = points.data[3 * item], py = points.data[3 * item + 1], pz = points.data[3 * item + 2];
    const float nx = normals.data[3 * item], ny = normals.data[3 * item + 1], nz = normals.data[3 * item + 2];
    Grid grid;
    grid.data = cells.data;
    grid.counts = counts.data;
    grid.measure = measure.data;
    const float ox = px + nx * offset, oy = py + ny * offset, oz = pz + nz * offset;

    // Frame about the normal (Duff et al. 2017)
    const float sign = nz >= 0.0f ? 1.0f : -1.0f;
    const float a = -1.0f / (sign + nz), b = nx * ny * a;
    const float tx = 1.0f + sign * nx * nx * a, ty = sign * b, tz = -sign * nx;
    const float bx = b, by = sign + ny * ny * a, bz = -ny;

    // Empty balls: centres o + h n, h growing by 1.7 a ball
    float height[16], radius[16];
    if (shadowed) {
        for (int first = 0; first < 16; first += SDFPRT_LANES) {
            F h = Simd::splat(0.0f);
            for (int k = 0; k < SDFPRT_LANES; k++) {
                height[first + k] = 2.0f * offset * expf(0.530628f * (float)(first + k));
                Simd::set(h, k, height[first + k]);
            }
            const F d = Scene::distance(ox + nx * h, oy + ny * h, oz + nz * h, Simd::ones()) * step;
            for (int k = 0; k < SDFPRT_LANES; k++) radius[first + k] = Simd::lane(d, k);
        }
    }

    // A shift of the directions that depends on the point's number and the seed alone
    unsigned s = ((unsigned)(item + start) * 2654435761u) ^ ((unsigned)seed * 2246822519u);
    s ^= s >> 16; s *= 0x7feb352du; s ^= s >> 15; s *= 0x846ca68bu; s ^= s >> 16;
    const float shift_u = (float)(s & 0xffffu) / 65536.0f, shift_v = (float)(s >> 16) / 65536.0f;

    F sum[64];
    for (int i = 0; i < bands * bands; i++) sum[i] = Simd::splat(0.0f);
    Packets packets;
    for (int batch = 0; batch < rays; batch += SDFPRT_BATCH) {
        const int count = rays - batch < SDFPRT_BATCH ? rays - batch : SDFPRT_BATCH;
        for (int first = 0; first < count; first += SDFPRT_LANES) {
            F number = Simd::splat(0.0f);
            for (int k = 0; k < SDFPRT_LANES; k++) Simd::set(number, k, (float)order.data[batch + first + k] + 0.5f);
            const F u = Simd::fract(number * 0.7548776662f + shift_u), v = Simd::fract(number * 0.5698402910f + shift_v);
            const M live = Simd::lt(number, Simd::splat((float)rays));
            const F c = Simd::sqrt(Simd::max(1.0f - u, Simd::splat(1e-9f))), r = Simd::sqrt(u);
            F sn, cs;
            Simd::sincos(6.28318531f * v, sn, cs);
            const F lx = r * cs, ly = r * sn;
            const F dx = lx * tx + ly * bx + c * nx, dy = lx * ty + ly * by + c * ny, dz = lx * tz + ly * bz + c * nz;
            Packets::store(packets.dx + first, dx);
            Packets::store(packets.dy + first, dy);
            Packets::store(packets.dz + first, dz);
            Packets::store(packets.free + first, Simd::sel(live, Simd::splat(1.0f), Simd::splat(0.0f)));
            if (shadowed) {
                F t = Simd::splat(0.0f);
                for (int k = 0; k < 16; k++) {
                    const float h = height[k], d = radius[k];
                    if (d <= 0.0f) break;
                    const F along = h * c, inside = along * along - (h * h - d * d);
                    const F half = Simd::sqrt(Simd::max(inside, Simd::splat(0.0f)));
                    const M reach = Simd::le(Simd::splat(0.0f), inside) & Simd::le(along - half, t) & Simd::lt(t, along + half);
                    t = Simd::sel(reach, along + half, t);
                }
                F enter, leave;
                Tracer::clip(Simd::splat(ox), Simd::splat(oy), Simd::splat(oz), dx, dy, dz, box.data, enter, leave);
                Packets::store(packets.t + first, t);
                Packets::store(packets.far + first, leave);
            }
        }
        if (shadowed) packets.trace(grid, ox, oy, oz, near, step, steps, count);
        for (int first = 0; first < count; first += SDFPRT_LANES) {
            const F dx = Packets::load(packets.dx + first), dy = Packets::load(packets.dy + first);
            const F dz = Packets::load(packets.dz + first), one = Packets::load(packets.free + first);
            // Basis by the recurrence in l of each order m; the constants come from sh.py's normalisation, passed in
            if (Simd::any(Simd::lt(Simd::splat(0.0f), one))) {
                F re = one, im = Simd::splat(0.0f);
                float diagonal = 1.0f;
                for (int m = 0; m < bands; m++) {
                    F before = Simd::splat(0.0f), here = Simd::splat(diagonal);
                    for (int l = m; l < bands; l++) {
                        const float scale = norms.data[l * (l + 1) + m];
                        const int at = l * (l + 1);
                        sum[at + m] += scale * here * re;
                        if (m > 0) sum[at - m] += scale * here * im;
                        const F next = ((float)(2 * l + 1) * dz * here - (float)(l + m) * before) / (float)(l - m + 1);
                        before = here;
                        here = next;
                    }
                    const F turned = re * dx - im * dy;
                    im = re * dy + im * dx;
                    re = turned;
                    diagonal *= -(float)(2 * m + 1);
                }
            }
        }
    }
    for (int i = 0; i < bands * bands; i++) {
        float total = 0.0f;
        for (int k = 0; k < SDFPRT_LANES; k++) total += Simd::lane(sum[i], k);
        out.data[item * bands * bands + i] = total * 3.14159265f / (float)rays;
    }
}
