// Transfer of an SDF on a card: a thread follows a share of a point's rays, one after the other. The same as transfer.h, where a CPU
// moves packets: directions and basis are those of projection.h, balls and steps those of steps.h.
//
//   balls   the turns of the loop before any ray: the empty balls along a point's normal, shared out among its threads
//   ray     one turn, one step of each thread's ray. A thread whose ray has ended waits until so many of its warp have that fewer than
//           BUSY are left; then they add the basis to their sums and begin their next rays, together
//   sums    of the threads of a point
//
// The field stands in one place of the text, since compilers copy it to each place where it is asked for, and that takes them long.
// With a lattice a turn is by the lattice or, where nobody needs that or FULL threads wait for it, by the field. `parts` threads share
// a point, 1, 2, 4, 8 or 16, which are neighbours in a warp; threads beyond the last point repeat it, so that warps are whole.
constexpr int BUSY = 24;  // of 32 threads, whose rays have not ended
constexpr int FULL = 16;  // of 32 threads, whose rays need the field
constexpr int NEAR = 16;  // balls

// The threads of a warp, `parts` of which share a point. A thread of a CPU is alone.
struct Team {
    int parts;
#if defined(__CUDA_ARCH__)
    static inline CUDA_CALLABLE int count(bool which) { return __popc(__ballot_sync(0xffffffffu, which)); }
    inline CUDA_CALLABLE float from(float value, int part) const { return __shfl_sync(0xffffffffu, value, part, parts); }
    inline CUDA_CALLABLE float sum(float value) const {
        for (int apart = parts / 2; apart > 0; apart /= 2) value += __shfl_xor_sync(0xffffffffu, value, apart);
        return value;
    }
#else
    static inline CUDA_CALLABLE int count(bool which) { return which ? 1 : 0; }
    inline CUDA_CALLABLE float from(float value, int) const { return value; }
    inline CUDA_CALLABLE float sum(float value) const { return value; }
#endif
};

enum State { UNDER_WAY, FREE, MET, DONE };  // of the thread's ray; DONE: it has no more
{
    const Team team = {parts};
    const int number = item / parts, part = item - number * parts, point = number < total ? number : total - 1;
    Lattice lattice;
    lattice.read(records.data, clear.data, frame.data);
    const bool has_lattice = lattice.nx > 0;
    const float ax = lattice.ox, ay = lattice.oy, az = lattice.oz, scale = 1.0f / lattice.cell;
    const float bounds[6] = {(box.data[0] - ax) * scale, (box.data[1] - ay) * scale, (box.data[2] - az) * scale,
                             (box.data[3] - ax) * scale, (box.data[4] - ay) * scale, (box.data[5] - az) * scale};
    const float* p = points.data + 3 * point;
    const float* n = normals.data + 3 * point;
    const Directions directions(n, numbers.data[point], seed, sequence.data, rays);
    float sum[64];
    for (int i = 0; i < bands * bands; i++) sum[i] = 0.0f;

    // The first places asked for are on the normal
    Steps::Rays ray;
    ray.x = (p[0] + n[0] * offset - ax) * scale, ray.y = (p[1] + n[1] * offset - ay) * scale, ray.z = (p[2] + n[2] * offset - az) * scale;
    ray.u = n[0], ray.v = n[1], ray.w = n[2];
    ray.s = ray.last_radius = ray.last_step = 0.0f;
    ray.ray = ray.sector = 0;
    float enter;
    Tracer::clip(ray.x, ray.y, ray.z, ray.u, ray.v, ray.w, bounds, enter, ray.end);
    const float above = ray.end;
    const int ball_turns = shadowed ? NEAR / parts : 0;
    float own[NEAR];
    Balls balls;

    State state = MET;
    bool by_field = true;
    int next = part, left = 0;
    for (int turn = 0;; turn++) {
        const bool of_balls = turn < ball_turns;
        if (shadowed && turn == ball_turns) {
#pragma unroll 1
            for (int k = 0; k < NEAR; k++) {
                const float height = Simd::max(Simd::min(Balls::height(k, offset * scale), above), 0.0f);
                balls.set(k, height, team.from(own[k / parts], k % parts));
            }
            // A ray has met the surface within `near`; within less where o itself lies so near, in a crease
            const float half = 0.5f * balls.radius[0];
            ray.hit_radius = 0.0f < half && half < near * scale ? half : near * scale;
        }
        // Rays that have ended, and the next ones
        if (!of_balls && Team::count(state == UNDER_WAY) <= BUSY) {
            if (state == FREE) {
                float free = 1.0f;
                const Fan fan = {&ray.u, &ray.v, &ray.w, &free};
                Projection projection;
                projection.add(fan, 1, bands, recurrence.data, sum);
            }
            if (state == FREE || state == MET) {
                state = DONE;
                if (next < directions.all) {
                    M used, inside;
                    const float c = directions.packet(next, ray.u, ray.v, ray.w, used);
                    next += parts;
                    state = used ? FREE : MET;
                    if (used && shadowed) {
                        ray.s = ray.last_radius = ray.last_step = 0.0f;
#pragma unroll 1
                        for (int k = 0; k < NEAR; k++) ray.s = balls.past(k, ray.s, c, inside);
                        Tracer::clip(ray.x, ray.y, ray.z, ray.u, ray.v, ray.w, bounds, enter, ray.end);
                        // On a face where the bounds cut the solid, outwards is free
                        if (ray.s + ray.hit_radius < ray.end) {
                            state = UNDER_WAY;
                            by_field = !has_lattice;
                            left = 2 * steps;
                            if (has_lattice) {
                                ray.sector = Lattice::sector(ray.u, ray.v, ray.w);
                                const float s = ray.s, x = Simd::mad(ray.u, s, ray.x), y = Simd::mad(ray.v, s, ray.y);
                                if (lattice.escape(x, y, Simd::mad(ray.w, s, ray.z), ray.sector)) state = FREE;
                            }
                        }
                    }
                }
            }
            if (Team::count(state != DONE) == 0) break;
        }
        // A turn by the lattice or by the field, for those who need it
        bool by_lattice = false;
        if (has_lattice && !of_balls) {
            const int waiting = Team::count(state == UNDER_WAY && by_field);
            by_lattice = waiting < FULL && Team::count(state == UNDER_WAY && !by_field) > 0;
        }
        if (!of_balls && (state != UNDER_WAY || by_field == by_lattice)) continue;
        const float s = of_balls ? Simd::max(Simd::min(Balls::height(part + turn * parts, offset * scale), above), 0.0f) : ray.s;
        const float x = Simd::mad(ray.u, s, ray.x), y = Simd::mad(ray.v, s, ray.y), z = Simd::mad(ray.w, s, ray.z);
        Steps::Ahead at;
        if (by_lattice) {
            Lattice::Cell cell = lattice.find(x, y, z);
            lattice.refine(cell, 2);
            lattice.refine(cell, 0);
            at = Steps::by_lattice(ray, lattice, cell);
        } else {
            const float a = Simd::mad(x, lattice.cell, ax), b = Simd::mad(y, lattice.cell, ay), c = Simd::mad(z, lattice.cell, az);
            const float r = Scene::distance(a, b, c, Simd::ones()) * (step / lattice.cell);
            if (of_balls) {
                own[turn] = r;
                continue;
            }
            at = Steps::by_field(ray, r);
        }
        const Steps::Became became = Steps::advance(ray, at);
        const bool changes = by_lattice ? at.doubt : has_lattice && Steps::far_enough(lattice, at, became.gap);
        if (became.met) {
            state = MET;
        } else if (became.out) {
            state = FREE;
        } else if (--left < 0) {  // it grazes
            state = MET;
        } else if (changes) {
            Steps::change(ray);
            by_field = !by_field;
        }
    }
    for (int i = 0; i < bands * bands; i++) {
        const float all = team.sum(sum[i]);
        if (number < total && part == 0) out.data[point * bands * bands + i] = all * 3.14159265f / (float)rays;
    }
}
