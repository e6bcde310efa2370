// Path tracing of a mesh: item = a ray of the camera, whose first hit is given; packets of stratified paths go on from there. One light
// sample and one lobe sample a vertex, combined by the balance heuristic (Veach 1997, Sec. 9.2), as for SDFs. A normal map sends nothing
// through the surface.
struct Surface : Simd {
    F x, y, z, nx, ny, nz, gx, gy, gz;  // point, unit shading normal on the side that was met, geometric normal
    F red, green, blue, exponent;
    F open;  // cosine to the geometric normal above which a ray may leave: 0 by a normal map, else any

    // A row of `hits`, for all lanes
    CUDA_CALLABLE Surface(const float* v) {
        x = splat(v[0]), y = splat(v[1]), z = splat(v[2]), nx = splat(v[3]), ny = splat(v[4]), nz = splat(v[5]);
        gx = splat(v[6]), gy = splat(v[7]), gz = splat(v[8]);
        red = splat(v[12]), green = splat(v[13]), blue = splat(v[14]), exponent = splat(v[15]);
        open = splat(v[16]);
    }
    CUDA_CALLABLE M leaves(F u, F v, F w) const { return lt(open, gx * u + gy * v + gz * w); }
    // Where a ray has left the surface, on the side to which it goes
    CUDA_CALLABLE void leave(F u, F v, F w, float lift, F& ox, F& oy, F& oz) const {
        const F side = sel(lt(gx * u + gy * v + gz * w, splat(0.0f)), splat(-lift), splat(lift));
        ox = x + side * gx, oy = y + side * gy, oz = z + side * gz;
    }
};
// The twin of relief.mapped_normals: the unit normal of a front where a map changes it, in place of the interpolated one
struct Relief {
    // `there`: tangent, handedness and place in the map (v upwards); `size`: rows, columns and first texel, of three bytes a number
    static inline CUDA_CALLABLE void apply(float* n, const float* there, const int* size, float scale, const int* texels) {
        const int height = size[0], width = size[1];
        const float x = there[4] * (float)width - 0.5f, y = (1.0f - there[5]) * (float)height - 0.5f;
        const float left = floorf(x), top = floorf(y), across = x - left, down = y - top;
        const int column = wrapped((int)left, width), row = wrapped((int)top, height);
        const int next = column + 1 < width ? column + 1 : 0, below = row + 1 < height ? row + 1 : 0;
        float found[3];
        for (int c = 0; c < 3; c++) {
            const float a = read(texels, size, row, column, c), b = read(texels, size, row, next, c);
            const float d = read(texels, size, below, column, c), e = read(texels, size, below, next, c);
            found[c] = (a * (1.0f - across) + b * across) * (1.0f - down) + (d * (1.0f - across) + e * across) * down;
        }
        const float LEAST = 0.02f;  // as in relief.py
        const float lean = there[0] * n[0] + there[1] * n[1] + there[2] * n[2];
        float t[3] = {there[0] - lean * n[0], there[1] - lean * n[1], there[2] - lean * n[2]};
        const float length = sqrtf(t[0] * t[0] + t[1] * t[1] + t[2] * t[2]), hand = there[3] < 0.0f ? -1.0f : 1.0f;
        for (int c = 0; c < 3; c++) t[c] /= length > 1e-12f ? length : 1e-12f;
        const float u[3] = {n[1] * t[2] - n[2] * t[1], n[2] * t[0] - n[0] * t[2], n[0] * t[1] - n[1] * t[0]};
        const float above = found[2] > LEAST ? found[2] : LEAST;
        float made[3], square = 0.0f;
        for (int c = 0; c < 3; c++) {
            made[c] = scale * (found[0] * t[c] + found[1] * hand * u[c]) + above * n[c];
            square += made[c] * made[c];
        }
        for (int c = 0; c < 3; c++) n[c] = made[c] / sqrtf(square);
    }
    static inline CUDA_CALLABLE float read(const int* texels, const int* size, int row, int column, int channel) {
        return (float)(texels[size[2] + row * size[1] + column] >> 8 * channel & 255) * (2.0f / 255.0f) - 1.0f;
    }
    static inline CUDA_CALLABLE int wrapped(int at, int count) { return at % count < 0 ? at % count + count : at % count; }
};
{
    Tree tree(handles.data);
    Environment light;
    light.pixels = pixels.data, light.density = density.data, light.rows = rows.data, light.columns = columns.data;
    light.turn = numbers.data + 7, light.height = height, light.width = width;
    const F zero = Simd::splat(0.0f), one = Simd::splat(1.0f);
    const float* row = hits.data + 17 * item;
    float sum[3] = {0.0f, 0.0f, 0.0f}, square[3] = {0.0f, 0.0f, 0.0f};
    // Reflection mapping of what the camera sees: the light from the mirrored view, unoccluded
    float mirror[3] = {0.0f, 0.0f, 0.0f};
    const float* shine = numbers.data + 16;
    if (row[11] < 1e29f && shine[0] + shine[1] + shine[2] > 0.0f) {
        const float wn = -(row[3] * row[9] + row[4] * row[10] + row[5] * row[11]);
        F r[3], pdf;
        light.evaluate(Simd::splat(2.0f * wn * row[3] + row[9]), Simd::splat(2.0f * wn * row[4] + row[10]),
                       Simd::splat(2.0f * wn * row[5] + row[11]), r[0], r[1], r[2], pdf);
        for (int c = 0; c < 3; c++) mirror[c] = shine[c] * Simd::lane(r[c], 0);
    }
    for (int packet = 0; packet < packets && row[11] < 1e29f; packet++) {
        const unsigned key = (unsigned)(start + item) * 0x9e3779b9u + (unsigned)packet;
        const U state = Random::hash(Random::hash(Simd::splat(key)) ^ Random::hash(Simd::splat((unsigned)seed * 0x85ebca6bu + 1u)));
        Random random(Simd::as_I(state), Simd::lanes());
        Surface at(row);
        F dx = Simd::splat(row[9]), dy = Simd::splat(row[10]), dz = Simd::splat(row[11]);
        F through[3] = {one, one, one}, radiance[3] = {zero, zero, zero};
        M live = Simd::ones();
        for (int depth = 0; depth <= bounces && Simd::any(live); depth++) {
            Lobes lobes(numbers.data);
            if (has_albedo) lobes.kd[0] = at.red, lobes.kd[1] = at.green, lobes.kd[2] = at.blue;
            if (has_exponent) lobes.s = at.exponent;
            lobes.choose();
            const F wn = -(at.nx * dx + at.ny * dy + at.nz * dz);
            const F mx = 2.0f * wn * at.nx + dx, my = 2.0f * wn * at.ny + dy, mz = 2.0f * wn * at.nz + dz;

            // Towards the light
            const F normal[3] = {at.nx, at.ny, at.nz}, mirrored[3] = {mx, my, mz};
            const Towards sun(light, lobes, random, normal, mirrored, through, live);
            Tree::Ray ray;
            F ox, oy, oz;
            at.leave(sun.x, sun.y, sun.z, lift, ox, oy, oz);
            tree.start(ray, ox, oy, oz, sun.x, sun.y, sun.z, 0.0f);
            M open = tree.free(ray, sun.useful & at.leaves(sun.x, sun.y, sun.z));
            for (int c = 0; c < 3; c++) radiance[c] += Simd::sel(open, sun.gain[c], zero);

            // Along the lobe: light where it is free, on from what it meets
            F u, v, wx, wy, wz, r[3], f[3], here, there;
            random.pair(u, v);
            lobes.sample(u, v, at.nx, at.ny, at.nz, mx, my, mz, wx, wy, wz);
            light.evaluate(wx, wy, wz, r[0], r[1], r[2], there);
            const F up = at.nx * wx + at.ny * wy + at.nz * wz;
            lobes.evaluate(up, mx * wx + my * wy + mz * wz, f, here);
            const M useful = live & at.leaves(wx, wy, wz) & Simd::lt(zero, up) & Simd::lt(Simd::splat(1e-12f), here);
            at.leave(wx, wy, wz, lift, ox, oy, oz);
            tree.start(ray, ox, oy, oz, wx, wy, wz, 0.0f);
            const M met = tree.meet(ray, useful);
            open = useful & ~met;
            for (int c = 0; c < 3; c++) {
                radiance[c] += Simd::sel(open, through[c] * f[c] * r[c] / (here + there), zero);
                through[c] = Simd::sel(met, through[c] * f[c] / here, zero);
            }
            live = met;
            dx = wx, dy = wy, dz = wz;
            if (depth == bounces || !Simd::any(live)) break;

            // What it meets: interpolated normal on the side that is met; the inside of a closed body ends the path
            const I face = Simd::sel(live, Simd::as_I(ray.triangle), Simd::splat(0));
            const F weights[3] = {one - ray.second - ray.third, ray.second, ray.third};
            F p[3] = {zero, zero, zero}, n[3] = {zero, zero, zero};
            for (int k = 0; k < 3; k++) {
                const I vertex = Simd::gather(faces.data, 3 * face + k);
                for (int c = 0; c < 3; c++) {
                    p[c] += weights[k] * Simd::gather(vertices.data, 3 * vertex + c);
                    n[c] += weights[k] * Simd::gather(normals.data, 3 * vertex + c);
                }
            }
            const F across = ray.normal_x * wx + ray.normal_y * wy + ray.normal_z * wz;
            const M front = Simd::lt(across, zero);
            live = live & (front | Simd::lt(zero, Simd::gather(two_sided.data, face)));
            const F side = Simd::sel(front, one, -one);
            const F shade = side / Simd::sqrt(Simd::max(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], Simd::splat(1e-24f)));
            const F flat = side / Simd::sqrt(Simd::max(ray.normal_x * ray.normal_x + ray.normal_y * ray.normal_y + ray.normal_z * ray.normal_z, Simd::splat(1e-38f)));
            at.x = p[0], at.y = p[1], at.z = p[2], at.open = Simd::splat(-2.0f);
            at.nx = n[0] * shade, at.ny = n[1] * shade, at.nz = n[2] * shade;
            for (unsigned left = has_relief ? Simd::bits(live) : 0u; left; left &= left - 1) {
                const int k = Simd::lowest(left), met_face = Simd::lane(face, k), number = maps.data[met_face];
                if (number < 0) continue;
                const float way = Simd::lane(side, k);
                float there[6] = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, 0.0f};
                for (int j = 0; j < 3; j++)
                    for (int c = 0; c < 6; c++)
                        there[c] += Simd::lane(weights[j], k) * relief.data[6 * faces.data[3 * met_face + j] + c];
                float own[3] = {way * Simd::lane(at.nx, k), way * Simd::lane(at.ny, k), way * Simd::lane(at.nz, k)};
                Relief::apply(own, there, sizes.data + 3 * number, scales.data[number], texels.data);
                Simd::set(at.nx, k, way * own[0]), Simd::set(at.ny, k, way * own[1]), Simd::set(at.nz, k, way * own[2]);
                Simd::set(at.open, k, 0.0f);
            }
            at.gx = ray.normal_x * flat, at.gy = ray.normal_y * flat, at.gz = ray.normal_z * flat;
            at.red = Simd::gather(colours.data, 4 * face), at.green = Simd::gather(colours.data, 4 * face + 1);
            at.blue = Simd::gather(colours.data, 4 * face + 2), at.exponent = Simd::gather(colours.data, 4 * face + 3);

            // Russian roulette after three bounces
            if (depth >= 3) {
                random.pair(u, v);
                const F stay = Simd::clamp(Simd::max(through[0], Simd::max(through[1], through[2])), Simd::splat(0.05f), one);
                live = live & Simd::lt(u, stay);
                for (int c = 0; c < 3; c++) through[c] = through[c] / stay;
            }
        }
        for (int c = 0; c < 3; c++) {
            float mean = 0.0f;
            for (int k = 0; k < SDFPRT_LANES; k++) mean += Simd::lane(radiance[c], k);
            mean = mean / (float)SDFPRT_LANES + mirror[c];
            sum[c] += mean, square[c] += mean * mean;
        }
    }
    for (int c = 0; c < 3; c++) all.data[3 * item + c] = sum[c], squares.data[3 * item + c] = square[c];
}
