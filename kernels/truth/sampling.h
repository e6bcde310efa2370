// What path tracing draws: directions of the light and of the lobes, and random numbers; the same for every kind of scene.
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
        // Lat-long; twins: latlong_uv of sdfprt/maths/sphere.py, shaders/rendering/latlong.glsl. Tests of the reference hold it
        F u = 0.5f - atan2(x, z) * 0.159154943f;
        u = u - floor(u);
        const F v = acos(clamp(y, splat(-1.0f), splat(1.0f))) * 0.318309886f;
        look(u, v, r, g, b);
        const I at = clamp_index(to_I(v * (float)height), height) * width + clamp_index(to_I(u * (float)width), width);
        pdf = gather(density, at) / max(sqrt(max(1.0f - y * y, splat(0.0f))), splat(1e-6f));
    }
    CUDA_CALLABLE void sample(F s, F t, F& dx, F& dy, F& dz, F& r, F& g, F& b, F& pdf) const {
        F a, c;
        const I row = find(rows, splat(0), height, t, a), column = find(columns, row * width, width, s, c);
        F sine, cosine, east, north;
        sincos((to_F(row) + a) * (3.14159265f / (float)height), sine, cosine);
        const F u = (to_F(column) + c) / (float)width;
        sincos((0.5f - u) * 6.28318531f, east, north);
        const F x = sine * east, z = sine * north;
        dx = turn[0] * x + turn[1] * cosine + turn[2] * z;
        dy = turn[3] * x + turn[4] * cosine + turn[5] * z;
        dz = turn[6] * x + turn[7] * cosine + turn[8] * z;
        look(u, (to_F(row) + a) / (float)height, r, g, b);
        pdf = gather(density, row * width + column) / max(sine, splat(1e-6f));
    }
    // First of `count` entries above x in the cumulative table that begins at `first`; `rest`: where x lies in it, 0 to 1
    static CUDA_CALLABLE I find(const float* table, I first, int count, F x, F& rest) {
        I low = splat(0), high = splat(count - 1);
        for (int reach = 1; reach < count; reach *= 2) {
            const I middle = (low + high) >> 1;
            const M above = lt(x, gather(table, first + middle)) | eq(low, high);
            high = sel(above, middle, high), low = sel(above, low, middle + 1);
        }
        const F before = sel(lt(splat(0), low), gather(table, first + clamp_index(low - 1, count)), splat(0.0f));
        const F width = gather(table, first + low) - before;
        rest = sel(lt(splat(0.0f), width), clamp((x - before) / width, splat(0.0f), splat(1.0f)), splat(0.5f));
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

// Sixteen stratified points of the square a dimension, shifted and shuffled at random in each packet. What a path draws depends on
// its packet and its place in there alone, wherever it goes on.
struct Random : Simd {
    U state;
    I place;
    CUDA_CALLABLE Random(I begin, I lane) : state(as_U(begin)), place(lane & 15) {}
    static CUDA_CALLABLE U hash(U v) {  // PCG (Jarzynski and Olano 2020)
        const U s = v * 747796405u + 2891336453u, w = ((s >> ((s >> 28u) + 4u)) ^ s) * 277803737u;
        return (w >> 22u) ^ w;
    }
    CUDA_CALLABLE U next() { return state = hash(state + 0x9e3779b9u); }
    CUDA_CALLABLE void pair(F& u, F& v) {
        const F a = to_F(as_I(next() >> 8u)) * 5.9604645e-8f, b = to_F(as_I(next() >> 8u)) * 5.9604645e-8f;
        const I i = place ^ as_I(next() >> 28u), back = ((i & 1) << 3) | ((i & 2) << 1) | ((i & 4) >> 1) | ((i & 8) >> 3);
        u = fract(to_F(i) * 0.0625f + a), v = fract(to_F(back) * 0.0625f + b);
    }
};

// A sample towards the light, drawn by the product of light and lobes: of CANDIDATES from the light's texels one, as often as it would
// bring, MIS weight included (Talbot et al. 2005). One ray is traced for all of them.
struct Towards : Simd {
    F x, y, z, gain[3];  // direction; what it brings if it is free, the path's throughput and all weights included
    M useful;

    // n the normal, m the mirrored view
    CUDA_CALLABLE Towards(const Environment& light, const Lobes& lobes, Random& random, const F* n, const F* m, const F* through, M live) {
        const int CANDIDATES = 4;  // variance times time of 1: 1.0 to 2.0 of it, median 1.4; of 8: no less (docs/bounces.md)
        const F zero = splat(0.0f);
        F total = zero, own = zero, pick, rest;
        random.pair(pick, rest);
        x = n[0], y = n[1], z = n[2];
        for (int c = 0; c < 3; c++) gain[c] = zero;
        for (int k = 0; k < CANDIDATES; k++) {
            F u, v, wx, wy, wz, r[3], f[3], here, there, brought[3];
            random.pair(u, v);
            light.sample(u, v, wx, wy, wz, r[0], r[1], r[2], there);
            const F up = n[0] * wx + n[1] * wy + n[2] * wz;
            lobes.evaluate(up, m[0] * wx + m[1] * wy + m[2] * wz, f, here);
            const M can = live & lt(zero, up) & lt(zero, here);
            for (int c = 0; c < 3; c++) brought[c] = sel(can, through[c] * f[c] * r[c] / (here + there), zero);
            const F weight = brought[0] + brought[1] + brought[2];
            total += weight;
            const F share = sel(lt(zero, weight), weight / max(total, splat(1e-30f)), zero);
            const M take = lt(pick, share);
            pick = sel(take, pick / max(share, splat(1e-12f)), (pick - share) / max(1.0f - share, splat(1e-12f)));
            pick = clamp(pick, zero, splat(0.99999994f));
            x = sel(take, wx, x), y = sel(take, wy, y), z = sel(take, wz, z), own = sel(take, weight, own);
            for (int c = 0; c < 3; c++) gain[c] = sel(take, brought[c], gain[c]);
        }
        useful = live & lt(zero, own);
        const F scale = sel(useful, total / ((float)CANDIDATES * max(own, splat(1e-30f))), zero);
        for (int c = 0; c < 3; c++) gain[c] = gain[c] * scale;
    }
};
