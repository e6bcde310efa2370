// Path tracing of the SDF itself: item = one ray of the camera, lanes = stratified light paths through its first hit.
// One light sample and one lobe sample a vertex, combined by the balance heuristic (Veach 1997, Sec. 9.2).
// The tracer is its own on purpose: nothing of the fast tracers' is shared, so that each can check the other.
struct Stage : Simd {
    float low[3], high[3], epsilon, step, tap;

    // Distance along the ray, from t on, where the field falls below epsilon, or less where the ray begins so near, in a
    // crease; -1 where it leaves the bounds first. Steps are over-relaxed; back to the safe one where two balls leave a gap
    // (Keinert et al. 2014)
    CUDA_CALLABLE F march(F ox, F oy, F oz, F dx, F dy, F dz, F t, F close, M live) const {
        const F far = leave(ox, low[0], high[0], dx, leave(oy, low[1], high[1], dy, leave(oz, low[2], high[2], dz, splat(1e30f))));
        F found = splat(-1.0f), before = splat(0.0f), taken = before, omega = splat(1.5f);
        live = live & lt(t + epsilon, far);  // from a face where the bounds cut the solid, outwards is free
        for (int k = 0; k < 2048 && any(live); k++) {
            const F d = Scene::distance(ox + t * dx, oy + t * dy, oz + t * dz, live), safe = d * step;
            const M gap = lt(splat(1.0f), omega) & lt(before + safe, taken);
            const M hit = live & ~gap & lt(d, close);
            found = sel(hit, t, found);
            live = live & ~hit;
            const F ahead = sel(gap, before - taken, min(omega * safe, max(safe, far - epsilon - t)));
            t = sel(live, t + ahead, t);
            taken = sel(gap, splat(0.0f), ahead), before = sel(gap, splat(0.0f), safe);
            omega = sel(gap, splat(1.0f), omega);
            live = live & lt(t, far);
        }
        return found;
    }
    // What counts as met for rays that begin where the field is d
    CUDA_CALLABLE F reach(F d) const { return min(splat(epsilon), 0.5f * d); }
    static CUDA_CALLABLE F leave(F o, float low, float high, F d, F far) {
        const F edge = sel(lt(d, splat(0.0f)), splat(low), splat(high));
        const F small = splat(1e-12f);
        return sel(lt(abs(d), small), far, min(far, (edge - o) / sel(lt(abs(d), small), small, d)));
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

// Empty balls with centres along the normal above a point: rays from there start at their far ends
struct Balls : Simd {
    float height[SDFPRT_LANES], radius[SDFPRT_LANES];
    CUDA_CALLABLE Balls(const Stage& stage, float x, float y, float z, float nx, float ny, float nz, float lift) {
        F h = splat(0.0f);
        for (int k = 1; k < SDFPRT_LANES; k++) set(h, k, 2.0f * lift * exp2f(0.75f * (float)(k - 1)));
        const F d = Scene::distance(x + h * nx, y + h * ny, z + h * nz, ones()) * stage.step;
        for (int k = 0; k < SDFPRT_LANES; k++) height[k] = lane(h, k), radius[k] = lane(d, k);
    }
    // How far a ray at this cosine to the normal stays inside balls that follow each other
    CUDA_CALLABLE F safe(F cosine) const {
        F t = splat(0.0f);
        for (int k = 0; k < SDFPRT_LANES && radius[k] > 0.0f; k++) {
            const F along = height[k] * cosine, inside = along * along - (height[k] * height[k] - radius[k] * radius[k]);
            const F half = sqrt(max(inside, splat(0.0f)));
            t = sel(le(splat(0.0f), inside) & le(along - half, t) & lt(t, along + half), along + half, t);
        }
        return t;
    }
};

struct Environment : Simd {
    const float *pixels, *density, *rows, *columns, *turn;  // turn: world = turn @ map, row by row
    int height, width;

    CUDA_CALLABLE void look(F u, F v, F& r, F& g, F& b) const {
        const F x = u * (float)width - 0.5f, y = clamp(v * (float)height - 0.5f, splat(0.0f), splat((float)(height - 1)));
        const F fx = fract(x), fy = fract(y);
        const I y0 = to_I(floor(y)), x0 = to_I(floor(x));
        r = splat(0.0f), g = r, b = r;
        for (int corner = 0; corner < 4; corner++) {
            I column = x0 + (corner & 1), row = y0 + (corner >> 1);
            column = sel(lt(column, splat(0)), column + width, sel(lt(column, splat(width)), column, column - width));
            row = clamp_index(row, height);
            const F weight = ((corner & 1) ? fx : 1.0f - fx) * ((corner >> 1) ? fy : 1.0f - fy);
            const I at = (row * width + clamp_index(column, width)) * 3;
            r += weight * gather(pixels, at), g += weight * gather(pixels, at + 1), b += weight * gather(pixels, at + 2);
        }
    }
    // Radiance from a world direction, and the density with which `sample` draws it
    CUDA_CALLABLE void evaluate(F dx, F dy, F dz, F& r, F& g, F& b, F& pdf) const {
        const F x = turn[0] * dx + turn[3] * dy + turn[6] * dz, y = turn[1] * dx + turn[4] * dy + turn[7] * dz;
        const F z = turn[2] * dx + turn[5] * dy + turn[8] * dz;
        F u = 0.5f - atan2(x, z) * 0.159154943f;
        u = u - floor(u);
        const F v = acos(clamp(y, splat(-1.0f), splat(1.0f))) * 0.318309886f;
        look(u, v, r, g, b);
        const I at = clamp_index(to_I(v * (float)height), height) * width + clamp_index(to_I(u * (float)width), width);
        pdf = gather(density, at) / max(sqrt(max(1.0f - y * y, splat(0.0f))), splat(1e-6f));
    }
    CUDA_CALLABLE void sample(F s, F t, F& dx, F& dy, F& dz, F& r, F& g, F& b, F& pdf) const {
        F u = s, v = t, p = s;
        for (int k = 0; k < SDFPRT_LANES; k++) {
            float a, c;
            const int row = find(rows, height, lane(t, k), a), column = find(columns + row * width, width, lane(s, k), c);
            set(v, k, ((float)row + a) / (float)height);
            set(u, k, ((float)column + c) / (float)width);
            set(p, k, density[row * width + column]);
        }
        F sine, cosine, east, north;
        sincos(v * 3.14159265f, sine, cosine);
        sincos((0.5f - u) * 6.28318531f, east, north);
        const F x = sine * east, z = sine * north;
        dx = turn[0] * x + turn[1] * cosine + turn[2] * z;
        dy = turn[3] * x + turn[4] * cosine + turn[5] * z;
        dz = turn[6] * x + turn[7] * cosine + turn[8] * z;
        look(u, v, r, g, b);
        pdf = p / max(sine, splat(1e-6f));
    }
    // First entry above x in a cumulative table; `rest`: where x lies within the entry, 0 to 1
    static CUDA_CALLABLE int find(const float* table, int count, float x, float& rest) {
        int low = 0, high = count - 1;
        while (low < high) {
            const int middle = (low + high) / 2;
            if (table[middle] > x) high = middle;
            else low = middle + 1;
        }
        const float before = low ? table[low - 1] : 0.0f, width = table[low] - before;
        rest = width > 0.0f ? (x - before) / width : 0.5f;
        rest = rest < 0.0f ? 0.0f : (rest > 1.0f ? 1.0f : rest);
        return low;
    }
};

// kd / pi + ks (s+2)/(2 pi) cos^s about the mirrored view; drawn as a mixture of both
struct Lobes : Simd {
    F kd[3], ks[3], s, diffuse;  // diffuse: probability of drawing the diffuse lobe

    CUDA_CALLABLE Lobes(const float* v) {
        for (int c = 0; c < 3; c++) kd[c] = splat(v[c]), ks[c] = splat(v[3 + c]);
        s = splat(v[6]);
    }
    CUDA_CALLABLE void choose() {
        const F a = kd[0] + kd[1] + kd[2], b = ks[0] + ks[1] + ks[2];
        diffuse = sel(lt(splat(0.0f), a + b), a / max(a + b, splat(1e-20f)), splat(1.0f));
    }
    CUDA_CALLABLE F power(F cosine) const {
        return sel(lt(splat(0.0f), cosine), exp2(s * log2(max(cosine, splat(1e-30f)))), sel(eq(s, splat(0.0f)), splat(1.0f), splat(0.0f)));
    }
    // BRDF times cosine, and the density of `sample`; cosines to the normal and to the mirrored view
    CUDA_CALLABLE void evaluate(F n, F m, F* f, F& pdf) const {
        const F up = max(n, splat(0.0f)), lobe = power(m);
        for (int c = 0; c < 3; c++) f[c] = (kd[c] * 0.318309886f + ks[c] * lobe * (s + 2.0f) * 0.159154943f) * up;
        pdf = diffuse * up * 0.318309886f + (1.0f - diffuse) * lobe * (s + 1.0f) * 0.159154943f;
    }
    CUDA_CALLABLE void sample(F u, F v, F nx, F ny, F nz, F mx, F my, F mz, F& dx, F& dy, F& dz) const {
        const M base = lt(u, diffuse);
        u = sel(base, u / max(diffuse, splat(1e-6f)), (u - diffuse) / max(1.0f - diffuse, splat(1e-6f)));
        u = clamp(u, splat(0.0f), splat(1.0f));
        const F ax = sel(base, nx, mx), ay = sel(base, ny, my), az = sel(base, nz, mz);
        const F cosine = sel(base, sqrt(1.0f - u), exp2(log2(max(u, splat(1e-30f))) / (s + 1.0f)));
        const F r = sqrt(max(1.0f - cosine * cosine, splat(0.0f)));
        F sine, turn;
        sincos(v * 6.28318531f, sine, turn);
        const F x = r * turn, y = r * sine;
        // Frame about the axis (Duff et al. 2017)
        const F sign = sel(lt(az, splat(0.0f)), splat(-1.0f), splat(1.0f)), a = -1.0f / (sign + az), b = ax * ay * a;
        dx = x * (1.0f + sign * ax * ax * a) + y * b + cosine * ax;
        dy = x * sign * b + y * (sign + ay * ay * a) + cosine * ay;
        dz = -x * sign * ax - y * ay + cosine * az;
    }
};

// Sixteen stratified points of the square a dimension, shifted and shuffled at random; packets are independent
struct Random : Simd {
    unsigned state;
    static CUDA_CALLABLE unsigned hash(unsigned v) {  // PCG (Jarzynski and Olano 2020)
        const unsigned s = v * 747796405u + 2891336453u, w = ((s >> ((s >> 28) + 4)) ^ s) * 277803737u;
        return (w >> 22) ^ w;
    }
    CUDA_CALLABLE float next() {
        state = hash(state + 0x9e3779b9u);
        return (float)(state >> 8) * 5.9604645e-8f;
    }
    CUDA_CALLABLE void pair(F& u, F& v) {
        const float a = next(), b = next();
        const int shuffle = (int)(next() * 16.0f);
        for (int k = 0; k < SDFPRT_LANES; k++) {
            const int i = k ^ shuffle, back = ((i & 1) << 3) | ((i & 2) << 1) | ((i & 4) >> 1) | ((i & 8) >> 3);
            set(u, k, (float)i * 0.0625f + a), set(v, k, (float)back * 0.0625f + b);
        }
        u = u - floor(u), v = v - floor(v);
    }
};

{
    Stage stage;
    for (int c = 0; c < 3; c++) stage.low[c] = numbers.data[c], stage.high[c] = numbers.data[3 + c];
    stage.epsilon = numbers.data[6], stage.step = numbers.data[7], stage.tap = numbers.data[8];
    Environment light;
    light.pixels = pixels.data, light.density = density.data, light.rows = rows.data, light.columns = columns.data;
    light.turn = numbers.data + 19, light.height = height, light.width = width;
    const F zero = Simd::splat(0.0f), one = Simd::splat(1.0f);

    // First hit: on the entry face of the bounds, or by marching, then a few steps onto the surface
    const float* way = directions.data + 3 * item;
    const F ex = Simd::splat(numbers.data[9]), ey = Simd::splat(numbers.data[10]), ez = Simd::splat(numbers.data[11]);
    const F vx = Simd::splat(way[0]), vy = Simd::splat(way[1]), vz = Simd::splat(way[2]);
    const F entry = stage.enter(ex, ey, ez, vx, vy, vz);
    const M met = Simd::lt(entry, Simd::splat(1e29f));
    const F near = Simd::splat(stage.epsilon);
    const F ahead = stage.march(ex + entry * vx, ey + entry * vy, ez + entry * vz, vx, vy, vz, zero, near, met);
    const M seen = met & Simd::le(zero, ahead);
    alpha.data[item] = Simd::any(seen) ? 1.0f : 0.0f;
    if (Simd::any(seen)) {
        F t = entry + ahead;
        // Backwards where a field that overestimates let the ray into the solid; a cut face keeps the place of entry
        for (int k = 0; k < 5; k++)
            t = Simd::max(t + Scene::distance(ex + t * vx, ey + t * vy, ez + t * vz, seen) * stage.step, entry);
        const F hx = ex + t * vx, hy = ey + t * vy, hz = ez + t * vz;
        F gx, gy, gz;
        stage.normal(hx, hy, hz, seen, gx, gy, gz);

        const float lift = 4.0f * stage.epsilon;
        const float qx = Simd::lane(gx, 0), qy = Simd::lane(gy, 0), qz = Simd::lane(gz, 0);
        const Balls balls(stage, Simd::lane(hx, 0) + lift * qx, Simd::lane(hy, 0) + lift * qy, Simd::lane(hz, 0) + lift * qz, qx, qy, qz, lift);

        Random random;
        random.state = Random::hash((unsigned)(start + item)) ^ Random::hash((unsigned)seed * 0x85ebca6bu + 1u);
        float sum[3] = {0, 0, 0}, square[3] = {0, 0, 0};
        for (int packet = 0; packet < packets; packet++) {
            F x = hx, y = hy, z = hz, nx = gx, ny = gy, nz = gz, ox = -vx, oy = -vy, oz = -vz;
            F through[3] = {one, one, one}, radiance[3] = {zero, zero, zero};
            M live = Simd::ones();
            for (int depth = 0; depth <= bounces; depth++) {
                Lobes lobes(numbers.data + 12);
                SDFPRT_SURFACE
                lobes.choose();
                const F wn = nx * ox + ny * oy + nz * oz;
                const F mx = 2.0f * wn * nx - ox, my = 2.0f * wn * ny - oy, mz = 2.0f * wn * nz - oz;
                const F sx = x + lift * nx, sy = y + lift * ny, sz = z + lift * nz;
                F close = Simd::splat(balls.radius[0] / stage.step);
                if (depth > 0) close = Scene::distance(sx, sy, sz, live);
                close = stage.reach(close);
                F u, v, dx, dy, dz, r[3], f[3], here, there;

                // Towards the light
                random.pair(u, v);
                light.sample(u, v, dx, dy, dz, r[0], r[1], r[2], there);
                const F up = nx * dx + ny * dy + nz * dz;
                lobes.evaluate(up, mx * dx + my * dy + mz * dz, f, here);
                M useful = live & Simd::lt(zero, up);
                F found = stage.march(sx, sy, sz, dx, dy, dz, depth > 0 ? zero : balls.safe(up), close, useful);
                M free = useful & Simd::lt(found, zero);
                for (int c = 0; c < 3; c++)
                    radiance[c] += Simd::sel(free, through[c] * f[c] * r[c] / (here + there), zero);

                // Along the lobe
                random.pair(u, v);
                lobes.sample(u, v, nx, ny, nz, mx, my, mz, dx, dy, dz);
                const F cosine = nx * dx + ny * dy + nz * dz;
                lobes.evaluate(cosine, mx * dx + my * dy + mz * dz, f, here);
                useful = live & Simd::lt(zero, cosine) & Simd::lt(Simd::splat(1e-12f), here);
                found = stage.march(sx, sy, sz, dx, dy, dz, depth > 0 ? zero : balls.safe(cosine), close, useful);
                free = useful & Simd::lt(found, zero);
                light.evaluate(dx, dy, dz, r[0], r[1], r[2], there);
                for (int c = 0; c < 3; c++)
                    radiance[c] += Simd::sel(free, through[c] * f[c] * r[c] / (here + there), zero);

                // On from where the lobe's ray hit; Russian roulette after three bounces
                live = useful & Simd::le(zero, found);
                if (depth == bounces || !Simd::any(live)) break;
                for (int c = 0; c < 3; c++) through[c] = Simd::sel(live, through[c] * f[c] / here, zero);
                if (depth >= 3) {
                    random.pair(u, v);
                    const F stay = Simd::clamp(Simd::max(through[0], Simd::max(through[1], through[2])), Simd::splat(0.05f), one);
                    live = live & Simd::lt(u, stay);
                    for (int c = 0; c < 3; c++) through[c] = through[c] / stay;
                }
                x = sx + found * dx, y = sy + found * dy, z = sz + found * dz;
                const F d = Scene::distance(x, y, z, live);
                x += d * dx, y += d * dy, z += d * dz;
                stage.normal(x, y, z, live, nx, ny, nz);
                ox = -dx, oy = -dy, oz = -dz;
            }
            for (int c = 0; c < 3; c++) {
                float mean = 0.0f;
                for (int k = 0; k < SDFPRT_LANES; k++) mean += Simd::lane(radiance[c], k);
                mean /= (float)SDFPRT_LANES;
                sum[c] += mean, square[c] += mean * mean;
            }
        }
        for (int c = 0; c < 3; c++) total.data[3 * item + c] = sum[c], squares.data[3 * item + c] = square[c];
    }
}
