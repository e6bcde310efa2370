// Transfer of SDFPRT_GROUP points an item: T_i = integral of V max(n.w, 0) y_i(w) dw by cosine-weighted directions, an R2 sequence
// shifted differently at each point. Rays begin where empty balls end, along the normal and then along the middle of each packet:
// the creeping zone is never marched.
{
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
            const Directions directions(normals.data + 3 * (begin + g), numbers.data[begin + g], seed, sequence.data, rays);
            for (int first = 0; first < padded; first += SDFPRT_LANES) {
                const int at = g * SDFPRT_SHARE + first;
                F dx, dy, dz;
                M used;
                const F c = directions.packet(batch + first, dx, dy, dz, used);
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

        for (int g = 0; g < members; g++) {
            const int at = g * SDFPRT_SHARE;
            const Fan fan = {packets.dx + at, packets.dy + at, packets.dz + at, packets.free + at};
            projection.add(fan, padded, bands, recurrence.data, sum[g]);
        }
    }
    for (int g = 0; g < members; g++)
        for (int i = 0; i < bands * bands; i++) {
            float all = 0.0f;
            for (int k = 0; k < SDFPRT_LANES; k++) all += Simd::lane(sum[g][i], k);
            out.data[(begin + g) * bands * bands + i] = all * 3.14159265f / (float)rays;
        }
}
