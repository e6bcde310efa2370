// Path tracing of the SDF itself: an item is a packet of the camera's rays. Through the first hit of each go packets of stratified
// light paths; at a vertex one sample is drawn towards the light and one along the lobe, and the balance heuristic combines the two
// (Veach 1997, Sec. 9.2). The tracer is its own on purpose: it shares nothing with the fast ones, so that each can check the other.
//
//   1  first hits   one a lane: from the entry face of the bounds, then a few steps onto the surface; alpha, points, normals
//   2  balls        the empty balls above each first hit, through which paths need not march
//   then until every packet of every hit has been through, SDFPRT_PATHS paths side by side:
//   3  begin        whole packets of paths at the first hits, with their random numbers; `owner` says whose a packet is
//   4  vertex       for each path: normal, colour, and two rays with the light that each would bring (`gain`)
//   5  march        all those rays, packed anew every Rays::STEPS steps
//   6  gather       `gain` of the rays that are free goes to `radiance`; the lobe's ray that met the surface is the path's next
//                   vertex, by Russian roulette after three bounces. Back to 4 while paths are left and bounces too
//   7  mean         of each packet, and its square, added to the sums of its hit: from both comes the error of the picture
//
// A path keeps its number in the batch and the state of its random numbers as it moves up in the arrays, so that what it draws
// depends on its packet alone. Lengths are scene units; distances are the field's, times the scene's step where they are steps.
#if SDFPRT_LANES == 1
#define SDFPRT_PATHS 4  // that go on side by side; the more, the fewer lanes are idle
#else
#define SDFPRT_PATHS 512
#endif
struct Stage : Simd {
    float low[3], high[3], epsilon, step, tap;

    // What counts as met for rays that begin where the field is d
    CUDA_CALLABLE F reach(F d) const { return min(splat(epsilon), 0.5f * d); }
    // Distance to the far face of the bounds
    CUDA_CALLABLE F leave(F ox, F oy, F oz, F dx, F dy, F dz) const {
        return far(ox, low[0], high[0], dx, far(oy, low[1], high[1], dy, far(oz, low[2], high[2], dz, splat(1e30f))));
    }
    static CUDA_CALLABLE F far(F o, float low, float high, F d, F least) {
        const F edge = sel(lt(d, splat(0.0f)), splat(low), splat(high));
        const F small = splat(1e-12f);
        return sel(lt(abs(d), small), least, min(least, (edge - o) / sel(lt(abs(d), small), small, d)));
    }
    // Signed distance to the near face of the bounds, for rays that start outside; 0 inside
    CUDA_CALLABLE F enter(F ox, F oy, F oz, F dx, F dy, F dz) const {
        const F a = near(ox, low[0], high[0], dx), b = near(oy, low[1], high[1], dy), c = near(oz, low[2], high[2], dz);
        return max(splat(0.0f), max(a, max(b, c)));
    }
    static CUDA_CALLABLE F near(F o, float low, float high, F d) {
        const F edge = sel(lt(d, splat(0.0f)), splat(high), splat(low));
        const F small = splat(1e-12f);
        const M inside = le(splat(low), o) & le(o, splat(high));
        const F beside = sel(inside, splat(-1e30f), splat(1e30f));
        return sel(lt(abs(d), small), beside, (edge - o) / sel(lt(abs(d), small), small, d));
    }
    CUDA_CALLABLE void normal(F x, F y, F z, M live, F& nx, F& ny, F& nz) const {
        const F a = Scene::distance(x + tap, y - tap, z - tap, live), b = Scene::distance(x - tap, y - tap, z + tap, live);
        const F c = Scene::distance(x - tap, y + tap, z - tap, live), d = Scene::distance(x + tap, y + tap, z + tap, live);
        nx = a - b - c + d, ny = c - a - b + d, nz = b - a - c + d;
        const F length = sqrt(nx * nx + ny * ny + nz * nz);
        const M flat = lt(length, splat(1e-12f));
        const F s = 1.0f / sel(flat, splat(1.0f), length);
        nx = sel(flat, splat(0.0f), nx * s), ny = sel(flat, splat(1.0f), ny * s), nz = sel(flat, splat(0.0f), nz * s);
    }
};

// Two rays from each of many points, marched until they have met the surface or left the bounds. Those under way are packed side
// by side every few steps, so that few lanes are idle.
struct Rays : Simd {
    enum { COUNT = 2 * SDFPRT_PATHS, STEPS = 4, PACKINGS = 512 };
    float ox[SDFPRT_PATHS], oy[SDFPRT_PATHS], oz[SDFPRT_PATHS];  // origin of rays k and k + SDFPRT_PATHS
    float close[SDFPRT_PATHS];                                   // distance within which they have met the surface
    float dx[COUNT], dy[COUNT], dz[COUNT];                       // unit direction
    float t[COUNT], far[COUNT];                                  // where the ray is, where it leaves the bounds
    float ball[COUNT], taken[COUNT];                             // of the evaluation before: radius, and the step after it
    float found[COUNT];                                          // where it met the surface, or -1
    int list[COUNT];                                             // rays under way
    int count;

    // Rays `first` … `first` + LANES - 1 have origin and direction, and are free of the surface as far as `start`
    CUDA_CALLABLE void begin(const Stage& stage, int first, F dx0, F dy0, F dz0, F start, M live) {
        const int from = first % SDFPRT_PATHS;
        const F end = stage.leave(fill(ox + from), fill(oy + from), fill(oz + from), dx0, dy0, dz0);
        spill(dx + first, dx0), spill(dy + first, dy0), spill(dz + first, dz0);
        spill(t + first, start), spill(far + first, end), spill(found + first, splat(-1.0f));
        spill(ball + first, splat(0.0f)), spill(taken + first, splat(0.0f));
        int on[SDFPRT_LANES];
        spill(on, live & lt(start + stage.epsilon, end));  // from a face where the bounds cut the solid, outwards is free
        for (int k = 0; k < SDFPRT_LANES; k++) {
            list[count] = first + k;
            count -= on[k];
        }
    }
    // Steps go as far as the balls touch if the slope stays (Balint and Valasek 2018); back to the end of the ball before where
    // they do not touch (Keinert et al. 2014)
    CUDA_CALLABLE void march(const Stage& stage) {
        for (int packing = 0; packing < PACKINGS && count > 0; packing++) {
            const int all = count;
            count = 0;
            for (int first = 0; first < all; first += SDFPRT_LANES) {
                int ray[SDFPRT_LANES], on[SDFPRT_LANES];
                for (int k = 0; k < SDFPRT_LANES; k++) ray[k] = list[first + k < all ? first + k : first];
                const I at = fill(ray), from = at & (SDFPRT_PATHS - 1);
                const F x = gather(ox, from), y = gather(oy, from), z = gather(oz, from), near = gather(close, from);
                const F u = gather(dx, at), v = gather(dy, at), w = gather(dz, at), end = gather(far, at);
                F s = gather(t, at), before = gather(ball, at), came = gather(taken, at), where = splat(-1.0f);
                M live = lt(lanes(), splat(all - first));
                for (int k = 0; k < STEPS && any(live); k++) {
                    const F d = Scene::distance(x + s * u, y + s * v, z + s * w, live), r = d * stage.step;
                    const M gap = lt(splat(0.0f), came) & lt(before + r, came);
                    const M met = live & ~gap & lt(d, near);
                    where = sel(met, s, where);
                    live = live & ~met;
                    const F slope = clamp((r - before) / max(came, splat(1e-9f)), splat(-1.0f), splat(0.8f));
                    const F ahead = sel(lt(splat(0.0f), came), 1.9f * r / (1.0f - slope), 1.2f * r);
                    const F on_from_here = min(ahead, max(end - stage.epsilon - s, r));  // where d is no number, the ray ends
                    s = sel(live, s + sel(gap, before - came, on_from_here), s);
                    came = sel(gap, splat(0.0f), on_from_here), before = sel(gap, splat(0.0f), r);
                    live = live & lt(s, end);
                }
                float place[SDFPRT_LANES], radius[SDFPRT_LANES], stride[SDFPRT_LANES], hit[SDFPRT_LANES];
                spill(place, s), spill(radius, before), spill(stride, came), spill(hit, where), spill(on, live);
                for (int k = 0; k < SDFPRT_LANES && first + k < all; k++) {
                    const int i = ray[k];
                    t[i] = place[k], ball[i] = radius[k], taken[i] = stride[k], found[i] = hit[k];
                    list[count] = i;
                    count -= on[k];
                }
            }
        }
        count = 0;
    }
};

// Empty balls with centres along the normal above a point: rays from there start at their far ends
struct Balls : Simd {
    enum { COUNT = 16 };
    float height[COUNT], radius[COUNT];
    CUDA_CALLABLE void measure(const Stage& stage, float x, float y, float z, float nx, float ny, float nz, float lift) {
        height[0] = 0.0f;
        for (int k = 1; k < COUNT; k++) height[k] = 2.0f * lift * exp2f(0.75f * (float)(k - 1));
        for (int k = 0; k < COUNT; k += SDFPRT_LANES) {
            const F h = fill(height + k);
            spill(radius + k, Scene::distance(x + h * nx, y + h * ny, z + h * nz, ones()) * stage.step);
        }
    }
    // How far a ray at this cosine to the normal stays inside balls that follow each other
    CUDA_CALLABLE F safe(F cosine) const {
        F t = splat(0.0f);
        for (int k = 0; k < COUNT && radius[k] > 0.0f; k++) {
            const F along = height[k] * cosine, inside = along * along - (height[k] * height[k] - radius[k] * radius[k]);
            const F half = sqrt(max(inside, splat(0.0f)));
            t = sel(le(splat(0.0f), inside) & le(along - half, t) & lt(t, along + half), along + half, t);
        }
        return t;
    }
};

// Paths side by side as long as they go on
struct Paths : Simd {
    float x[SDFPRT_PATHS], y[SDFPRT_PATHS], z[SDFPRT_PATHS];     // where it met the surface
    float dx[SDFPRT_PATHS], dy[SDFPRT_PATHS], dz[SDFPRT_PATHS];  // the way it came
    float through[3][SDFPRT_PATHS];                              // what arrives of the light there
    int number[SDFPRT_PATHS], state[SDFPRT_PATHS];               // in the batch; of its random numbers
    float gain[3][2 * SDFPRT_PATHS];                             // light along its two rays, if they are free
    float radiance[3][SDFPRT_PATHS];                             // so far, by number
};

{
    Stage stage;
    for (int c = 0; c < 3; c++) stage.low[c] = numbers.data[c], stage.high[c] = numbers.data[3 + c];
    stage.epsilon = numbers.data[6], stage.step = numbers.data[7], stage.tap = numbers.data[8];
    Environment light;
    light.pixels = pixels.data, light.density = density.data, light.rows = rows.data, light.columns = columns.data;
    light.turn = numbers.data + 19, light.height = height, light.width = width;
    const F zero = Simd::splat(0.0f), one = Simd::splat(1.0f);
    const float lift = 4.0f * stage.epsilon;
    Rays rays;
    Paths paths;

    // 1: first hits, one a lane: on the entry face of the bounds, or by marching, then a few steps onto the surface
    const int base = item * SDFPRT_LANES, members = total - base < SDFPRT_LANES ? total - base : SDFPRT_LANES;
    float way[3][SDFPRT_LANES], point[3][SDFPRT_LANES], normal[3][SDFPRT_LANES];
    for (int c = 0; c < 3; c++)
        for (int g = 0; g < SDFPRT_LANES; g++) way[c][g] = directions.data[3 * (base + (g < members ? g : 0)) + c];
    const F ex = Simd::splat(numbers.data[9]), ey = Simd::splat(numbers.data[10]), ez = Simd::splat(numbers.data[11]);
    const F vx = Simd::fill(way[0]), vy = Simd::fill(way[1]), vz = Simd::fill(way[2]);
    const F entry = stage.enter(ex, ey, ez, vx, vy, vz);
    Simd::spill(rays.ox, ex + entry * vx), Simd::spill(rays.oy, ey + entry * vy), Simd::spill(rays.oz, ez + entry * vz);
    Simd::spill(rays.close, Simd::splat(stage.epsilon));
    rays.count = 0;
    rays.begin(stage, 0, vx, vy, vz, zero, Simd::lt(Simd::lanes(), Simd::splat(members)) & Simd::lt(entry, Simd::splat(1e29f)));
    rays.march(stage);
    const F ahead = Simd::fill(rays.found);
    const M met = Simd::le(zero, ahead);
    int seen[SDFPRT_LANES];
    Simd::spill(seen, met);
    for (int g = 0; g < members; g++) alpha.data[base + g] = seen[g] ? 1.0f : 0.0f;
    if (Simd::any(met)) {
        F t = entry + ahead, nx, ny, nz;
        // Backwards where a field that overestimates let the ray into the solid; a cut face keeps the place of entry
        for (int k = 0; k < 5; k++)
            t = Simd::max(t + Scene::distance(ex + t * vx, ey + t * vy, ez + t * vz, met) * stage.step, entry);
        stage.normal(ex + t * vx, ey + t * vy, ez + t * vz, met, nx, ny, nz);
        Simd::spill(point[0], ex + t * vx), Simd::spill(point[1], ey + t * vy), Simd::spill(point[2], ez + t * vz);
        Simd::spill(normal[0], nx), Simd::spill(normal[1], ny), Simd::spill(normal[2], nz);
    }
    // Reflection mapping of what the camera sees: the light from the mirrored view, unoccluded
    float mirror[3][SDFPRT_LANES];
    for (int c = 0; c < 3; c++) Simd::spill(mirror[c], zero);
    const float* shine = numbers.data + 28;
    if (Simd::any(met) && shine[0] + shine[1] + shine[2] > 0.0f) {
        const F nx = Simd::fill(normal[0]), ny = Simd::fill(normal[1]), nz = Simd::fill(normal[2]);
        const F wn = -(nx * vx + ny * vy + nz * vz);
        F r[3], pdf;
        light.evaluate(2.0f * wn * nx + vx, 2.0f * wn * ny + vy, 2.0f * wn * nz + vz, r[0], r[1], r[2], pdf);
        for (int c = 0; c < 3; c++) Simd::spill(mirror[c], shine[c] * r[c]);
    }
    Balls balls[SDFPRT_LANES];
    float sum[3][SDFPRT_LANES], square[3][SDFPRT_LANES];
    for (int g = 0; g < members; g++) {
        for (int c = 0; c < 3; c++) sum[c][g] = square[c][g] = 0.0f;
        const float qx = normal[0][g], qy = normal[1][g], qz = normal[2][g];
        if (seen[g])
            balls[g].measure(stage, point[0][g] + lift * qx, point[1][g] + lift * qy, point[2][g] + lift * qz, qx, qy, qz, lift);
    }

    for (int next = 0; next < members * packets;) {
        // 3: whole packets from the first hits
        int owner[SDFPRT_PATHS / SDFPRT_LANES], begun = 0;
        for (; begun < SDFPRT_PATHS && next < members * packets; next++) {
            const int g = next / packets;
            if (!seen[g]) continue;
            const unsigned key = (unsigned)(start + base + g) * 0x9e3779b9u + (unsigned)(next % packets);
            const U state = Random::hash(Random::hash(Simd::splat(key)) ^ Random::hash(Simd::splat((unsigned)seed * 0x85ebca6bu + 1u)));
            Simd::spill(paths.state + begun, Simd::as_I(state)), Simd::spill(paths.number + begun, Simd::lanes() + begun);
            Simd::spill(paths.x + begun, Simd::splat(point[0][g])), Simd::spill(paths.dx + begun, Simd::splat(way[0][g]));
            Simd::spill(paths.y + begun, Simd::splat(point[1][g])), Simd::spill(paths.dy + begun, Simd::splat(way[1][g]));
            Simd::spill(paths.z + begun, Simd::splat(point[2][g])), Simd::spill(paths.dz + begun, Simd::splat(way[2][g]));
            for (int c = 0; c < 3; c++) Simd::spill(paths.through[c] + begun, one), Simd::spill(paths.radiance[c] + begun, zero);
            owner[begun / SDFPRT_LANES] = g;
            begun += SDFPRT_LANES;
        }

        int count = begun;
        for (int depth = 0; depth <= bounces && count > 0; depth++) {
            // 4: two rays from each vertex
            for (int first = 0; first < count; first += SDFPRT_LANES) {
                const M live = Simd::lt(Simd::lanes(), Simd::splat(count - first));
                const F dx = Simd::fill(paths.dx + first), dy = Simd::fill(paths.dy + first), dz = Simd::fill(paths.dz + first);
                F x = Simd::fill(paths.x + first), y = Simd::fill(paths.y + first), z = Simd::fill(paths.z + first), nx, ny, nz;
                const int g = owner[first / SDFPRT_LANES];
                if (depth == 0) {
                    nx = Simd::splat(normal[0][g]), ny = Simd::splat(normal[1][g]), nz = Simd::splat(normal[2][g]);
                } else {
                    const F d = Scene::distance(x, y, z, live);
                    x += d * dx, y += d * dy, z += d * dz;
                    stage.normal(x, y, z, live, nx, ny, nz);
                }
                Lobes lobes(numbers.data + 12);
                SDFPRT_SURFACE
                lobes.choose();
                const F wn = -(nx * dx + ny * dy + nz * dz);
                const F mx = 2.0f * wn * nx + dx, my = 2.0f * wn * ny + dy, mz = 2.0f * wn * nz + dz;
                const F sx = x + lift * nx, sy = y + lift * ny, sz = z + lift * nz;
                const F near = depth == 0 ? Simd::splat(balls[g].radius[0] / stage.step) : Scene::distance(sx, sy, sz, live);
                Simd::spill(rays.ox + first, sx), Simd::spill(rays.oy + first, sy), Simd::spill(rays.oz + first, sz);
                Simd::spill(rays.close + first, stage.reach(near));
                Random random(Simd::fill(paths.state + first), Simd::fill(paths.number + first));

                // Towards the light
                F through[3];
                for (int c = 0; c < 3; c++) through[c] = Simd::fill(paths.through[c] + first);
                const F above[3] = {nx, ny, nz}, mirrored[3] = {mx, my, mz};
                const Towards sun(light, lobes, random, above, mirrored, through, live);
                F up = nx * sun.x + ny * sun.y + nz * sun.z;
                rays.begin(stage, first, sun.x, sun.y, sun.z, depth == 0 ? balls[g].safe(up) : zero, sun.useful);
                for (int c = 0; c < 3; c++) Simd::spill(paths.gain[c] + first, sun.gain[c]);

                // Along the lobe
                F u, v, wx, wy, wz, r[3], f[3], here, there;
                random.pair(u, v);
                lobes.sample(u, v, nx, ny, nz, mx, my, mz, wx, wy, wz);
                light.evaluate(wx, wy, wz, r[0], r[1], r[2], there);
                up = nx * wx + ny * wy + nz * wz;
                lobes.evaluate(up, mx * wx + my * wy + mz * wz, f, here);
                const M useful = live & Simd::lt(zero, up) & Simd::lt(Simd::splat(1e-12f), here);
                const int at = first + SDFPRT_PATHS;
                rays.begin(stage, at, wx, wy, wz, depth == 0 ? balls[g].safe(up) : zero, useful);
                for (int c = 0; c < 3; c++) {
                    Simd::spill(paths.gain[c] + at, Simd::sel(useful, through[c] * f[c] * r[c] / (here + there), zero));
                    Simd::spill(paths.through[c] + first, Simd::sel(useful, through[c] * f[c] / here, zero));
                }
                Simd::spill(paths.state + first, Simd::as_I(random.state));
            }
            rays.march(stage);

            // 6: light where a ray is free; on from where the lobe's ray met the surface, by roulette after three bounces
            int kept = 0;
            for (int first = 0; first < count; first += SDFPRT_LANES) {
                const F shadow = Simd::fill(rays.found + first), found = Simd::fill(rays.found + SDFPRT_PATHS + first);
                float bright[3][SDFPRT_LANES];
                for (int c = 0; c < 3; c++) {
                    const F a = Simd::fill(paths.gain[c] + first), b = Simd::fill(paths.gain[c] + SDFPRT_PATHS + first);
                    Simd::spill(bright[c], Simd::sel(Simd::lt(shadow, zero), a, zero) + Simd::sel(Simd::lt(found, zero), b, zero));
                }
                M live = Simd::le(zero, found);
                if (depth >= 3) {
                    Random random(Simd::fill(paths.state + first), Simd::fill(paths.number + first));
                    F u, v, through[3];
                    random.pair(u, v);
                    for (int c = 0; c < 3; c++) through[c] = Simd::fill(paths.through[c] + first);
                    const F stay = Simd::clamp(Simd::max(through[0], Simd::max(through[1], through[2])), Simd::splat(0.05f), one);
                    live = live & Simd::lt(u, stay);
                    for (int c = 0; c < 3; c++) Simd::spill(paths.through[c] + first, through[c] / stay);
                    Simd::spill(paths.state + first, Simd::as_I(random.state));
                }
                int on[SDFPRT_LANES];
                Simd::spill(on, live);
                for (int k = 0; k < SDFPRT_LANES && first + k < count; k++) {
                    const int i = first + k, ray = SDFPRT_PATHS + i;
                    for (int c = 0; c < 3; c++) paths.radiance[c][paths.number[i]] += bright[c][k];
                    paths.x[kept] = rays.ox[i] + rays.found[ray] * rays.dx[ray], paths.dx[kept] = rays.dx[ray];
                    paths.y[kept] = rays.oy[i] + rays.found[ray] * rays.dy[ray], paths.dy[kept] = rays.dy[ray];
                    paths.z[kept] = rays.oz[i] + rays.found[ray] * rays.dz[ray], paths.dz[kept] = rays.dz[ray];
                    for (int c = 0; c < 3; c++) paths.through[c][kept] = paths.through[c][i];
                    paths.number[kept] = paths.number[i], paths.state[kept] = paths.state[i];
                    kept -= on[k];
                }
            }
            count = kept;
        }
        for (int first = 0; first < begun; first += SDFPRT_LANES) {
            const int g = owner[first / SDFPRT_LANES];
            for (int c = 0; c < 3; c++) {
                float mean = 0.0f;
                for (int k = 0; k < SDFPRT_LANES; k++) mean += paths.radiance[c][first + k];
                mean = mean / (float)SDFPRT_LANES + mirror[c][g];
                sum[c][g] += mean, square[c][g] += mean * mean;
            }
        }
    }
    for (int g = 0; g < members; g++)
        for (int c = 0; c < 3; c++) all.data[3 * (base + g) + c] = sum[c][g], squares.data[3 * (base + g) + c] = square[c][g];
}
