// Transfer of an SDF, SDFPRT_GROUP points an item: T_i = integral of V max(n.w, 0) y_i(w) dw by cosine-weighted directions, an R2
// sequence shifted differently at each point (projection.h).
//
//   1  balls      of each point: the empty balls along its normal, through which its rays need not march
//   then for each batch of SDFPRT_SHARE rays a point:
//   2  directions each ray's direction, how far the balls have it free (t), and where it leaves the bounds (far)
//   3  skip       on past empty balls along the middle of each packet of directions (packets.h)
//   4  trace      the rays, by two queues (packets.h); `free` becomes 0 where a ray meets the surface
//   5  project    the SH basis at the directions of free rays, added up (projection.h)
//   6  mean       of the sums, times pi, since directions are drawn with density cos / pi
//
// Nothing moves from one item to another. Inside, lengths are in sides of the coarse cells (1 / scale scene units), places are from the
// first corner of the lattice; the arguments offset and near are in scene units.

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

    // 1: empty balls of each point, with centres o + h n
    const int NEAR = 8;  // a packet
    float height[NEAR];
    for (int k = 0; k < NEAR; k++) height[k] = Balls::height(k, offset * scale);
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
            const F px = Simd::mad(h, u, x), py = Simd::mad(h, v, y), pz = Simd::mad(h, w, z);
            balls[g].set(first, h, packets.ball(px, py, pz, 2.0f * near * scale, step));
        }
        // Less where o itself lies so near, in a crease
        const float half = shadowed ? 0.5f * balls[g].radius[0] : 0.0f;
        packets.reach[g] = 0.0f < half && half < near * scale ? half : near * scale;
    }

    for (int batch = 0; batch < rays; batch += SDFPRT_SHARE) {
        const int share = rays - batch < SDFPRT_SHARE ? rays - batch : SDFPRT_SHARE;
        const int padded = (share + SDFPRT_LANES - 1) / SDFPRT_LANES * SDFPRT_LANES;
        // 2: directions, and how far each ray is free
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
        // 3 and 4: which rays are free
        if (shadowed) packets.skip(bounds, offset * scale, step, members, padded);
        if (shadowed) packets.trace(step, steps, members, padded);

        // 5: their basis
        for (int g = 0; g < members; g++) {
            const int at = g * SDFPRT_SHARE;
            const Fan fan = {packets.dx + at, packets.dy + at, packets.dz + at, packets.free + at};
            projection.add(fan, padded, bands, recurrence.data, sum[g]);
        }
    }
    // 6: the mean
    for (int g = 0; g < members; g++)
        for (int i = 0; i < bands * bands; i++) {
            float all = 0.0f;
            for (int k = 0; k < SDFPRT_LANES; k++) all += Simd::lane(sum[g][i], k);
            out.data[(begin + g) * bands * bands + i] = all * 3.14159265f / (float)rays;
        }
}
