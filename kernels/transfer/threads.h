// Transfer of an SDF on a card: the threads of a warp follow the rays of some points, each thread one ray. The same as transfer.h,
// where a CPU moves packets: directions and basis are those of projection.h, balls and steps those of steps.h.
//
//   balls    first what is asked for are the empty balls along the points' normals
//   rays     then a batch of rays of every point. One turn of the loop is one step of each thread's ray. Threads whose rays have ended
//            wait until BUSY or fewer are left under way; then they take the next of the batch together, whichever point's they are
//   project  after a batch each thread adds up the basis at free rays of one point: always the same ones in the same order, so
//            that it does not matter who followed a ray
//
// The field stands in one place of the text, since compilers copy it to each place where it is asked for, and that takes them long.
// With a lattice a turn is by the lattice or, where nobody needs that or FULL threads wait for it, by the field. `parts` points
// share a warp, 1, 2, 4 or 8: those at `begin` to `end` - 1 in `order`, whose last is repeated, so that warps are whole.
constexpr int BUSY = 26;    // of 32 threads, whose rays have not ended
constexpr int FULL = 16;    // of 32 threads, whose rays need the field
constexpr int NEAR = 16;    // balls of a point
constexpr int POOL = 1024;  // rays of a batch, of all its points
#if defined(__CUDA_ARCH__) && !defined(SDFPRT_WARP)
#define SDFPRT_WARP  // else a test defines it, which has 32 threads of a CPU stand for a warp
#endif
#if defined(SDFPRT_WARP)
constexpr int WARPS = 8, MOST = 8;  // of a block; points of a warp
#endif

// The threads of a warp. A thread of a CPU is alone.
struct Team {
#if defined(SDFPRT_WARP)
    static inline CUDA_CALLABLE int size() { return 32; }
    static inline CUDA_CALLABLE int lane() { return threadIdx.x % 32; }
    static inline CUDA_CALLABLE int count(bool which) { return __popc(__ballot_sync(0xffffffffu, which)); }
    static inline CUDA_CALLABLE int before(bool which) {  // of those, how many stand before this one
        return __popc(__ballot_sync(0xffffffffu, which) & ((1u << threadIdx.x % 32) - 1u));
    }
    static inline CUDA_CALLABLE float sum(float value, int neighbours) {
        for (int apart = neighbours / 2; apart > 0; apart /= 2) value += __shfl_xor_sync(0xffffffffu, value, apart);
        return value;
    }
    static inline CUDA_CALLABLE void wait() { __syncwarp(); }
#else
    static inline CUDA_CALLABLE int size() { return 1; }
    static inline CUDA_CALLABLE int lane() { return 0; }
    static inline CUDA_CALLABLE int count(bool which) { return which ? 1 : 0; }
    static inline CUDA_CALLABLE int before(bool) { return 0; }
    static inline CUDA_CALLABLE float sum(float value, int) { return value; }
    static inline CUDA_CALLABLE void wait() {}
#endif
};
{
    // What the threads of a warp share: the balls of its points, and which rays of the batch are free
#if defined(SDFPRT_WARP)
    __shared__ Balls balls_of_warps[WARPS][MOST];
    __shared__ unsigned char free_of_warps[WARPS][POOL];
    Balls* balls = balls_of_warps[threadIdx.x / 32];
    unsigned char* free = free_of_warps[threadIdx.x / 32];
#else
    Balls balls[1];
    unsigned char free[POOL];
#endif
    const int first = begin + item / Team::size() * parts;
    Lattice lattice;
    lattice.read(records.data, clear.data, frame.data);
    const bool has_lattice = lattice.nx > 0;
    const float ax = lattice.ox, ay = lattice.oy, az = lattice.oz, scale = 1.0f / lattice.cell;
    const float bounds[6] = {(box.data[0] - ax) * scale, (box.data[1] - ay) * scale, (box.data[2] - az) * scale,
                             (box.data[3] - ax) * scale, (box.data[4] - ay) * scale, (box.data[5] - az) * scale};
    const int share = POOL / parts, padded = (rays + 7) / 8 * 8;

    // The thread's point when it projects, and a share of that point's rays
    const int each = Team::size() / parts, own = Team::lane() / each, offset_in_batch = Team::lane() - own * each;
    float sum[64];
    for (int i = 0; i < bands * bands; i++) sum[i] = 0.0f;

    Steps::Rays ray;
    ray.ray = ray.sector = 0;
    int holder = -1, left = 0;  // the point whose ray it is; turns left until a ray that is still under way counts as met
    Directions directions(normals.data, 0, seed, sequence.data, rays);
    bool under_way = false, by_field = true;
    int batch = -1, count = NEAR, taken = 0;  // first ray of the batch, -1 for balls; rays, or balls, of a point; handed out
    if (!shadowed) taken = parts * count;
    for (;;) {
        if (Team::count(under_way) <= BUSY) {
            // The next of the batch
            const int next = taken + Team::before(!under_way);
            taken += Team::count(!under_way);
            if (!under_way && next < parts * count) {
                const int which = next / count, point = order.data[first + which < end ? first + which : end - 1];
                const float* n = normals.data + 3 * point;
                if (holder != which) {
                    holder = which;
                    const float* p = points.data + 3 * point;
                    directions = Directions(n, start + point, seed, sequence.data, rays);
                    ray.x = (p[0] + n[0] * offset - ax) * scale;
                    ray.y = (p[1] + n[1] * offset - ay) * scale;
                    ray.z = (p[2] + n[2] * offset - az) * scale;
                }
                ray.ray = next;
                ray.s = ray.last_radius = ray.last_step = 0.0f;
                float enter;
                if (batch < 0) {
                    ray.u = n[0], ray.v = n[1], ray.w = n[2];
                    Tracer::clip(ray.x, ray.y, ray.z, ray.u, ray.v, ray.w, bounds, enter, ray.end);
                    ray.s = Simd::max(Simd::min(Balls::height(next - which * count, offset * scale), ray.end), 0.0f);
                    under_way = true;
                } else {
                    M used, inside;
                    const float c = directions.packet(batch + next - which * count, ray.u, ray.v, ray.w, used);
                    free[next] = used ? 1 : 0;
                    if (used && shadowed) {
                        // It has met the surface within `near`; within less where its origin itself lies so near, in a crease
                        const float half = 0.5f * balls[which].radius[0];
                        ray.hit_radius = 0.0f < half && half < near * scale ? half : near * scale;
#pragma unroll 1
                        for (int k = 0; k < NEAR; k++) ray.s = balls[which].past(k, ray.s, c, inside);
                        Tracer::clip(ray.x, ray.y, ray.z, ray.u, ray.v, ray.w, bounds, enter, ray.end);
                        // On a face where the bounds cut the solid, outwards is free
                        under_way = ray.s + ray.hit_radius < ray.end;
                        by_field = !has_lattice;
                        left = 2 * steps;
                        if (has_lattice && under_way) {
                            ray.sector = Lattice::sector(ray.u, ray.v, ray.w);
                            const float s = ray.s, x = Simd::mad(ray.u, s, ray.x), y = Simd::mad(ray.v, s, ray.y);
                            if (lattice.escape(x, y, Simd::mad(ray.w, s, ray.z), ray.sector)) under_way = false;
                        }
                    }
                }
            }
            if (Team::count(under_way) == 0) {
                if (taken < parts * count) continue;
                // The batch is done
                Team::wait();
                if (batch >= 0) {
                    const int point = order.data[first + own < end ? first + own : end - 1];
                    const Directions of_own(normals.data + 3 * point, start + point, seed, sequence.data, rays);
#pragma unroll 1
                    for (int k = offset_in_batch; k < count; k += each)
                        if (free[own * count + k]) {
                            float x, y, z, open = 1.0f;
                            M used;
                            of_own.packet(batch + k, x, y, z, used);
                            const Fan fan = {&x, &y, &z, &open};
                            Projection projection;
                            projection.add(fan, 1, bands, recurrence.data, sum);
                        }
                    Team::wait();
                }
                batch = batch < 0 ? 0 : batch + share;
                if (batch >= padded) break;
                count = padded - batch < share ? padded - batch : share;
                taken = 0;
                continue;
            }
        }
        // A turn by the lattice or by the field, for those who need it
        bool by_lattice = false;
        if (has_lattice && batch >= 0) {
            const int waiting = Team::count(under_way && by_field);
            by_lattice = waiting < FULL && Team::count(under_way && !by_field) > 0;
        }
        if (!under_way || (batch >= 0 && by_field == by_lattice)) continue;
        const float s = ray.s, x = Simd::mad(ray.u, s, ray.x), y = Simd::mad(ray.v, s, ray.y), z = Simd::mad(ray.w, s, ray.z);
        Steps::Ahead at;
        if (by_lattice) {
            Lattice::Cell cell = lattice.find(x, y, z);
            lattice.refine(cell, 2);
            lattice.refine(cell, 0);
            at = Steps::by_lattice(ray, lattice, cell);
        } else {
            const float a = Simd::mad(x, lattice.cell, ax), b = Simd::mad(y, lattice.cell, ay), c = Simd::mad(z, lattice.cell, az);
            const float r = Scene::distance(a, b, c, Simd::ones()) * (step / lattice.cell);
            if (batch < 0) {
                balls[holder].set(ray.ray - holder * count, s, r);
                under_way = false;
                continue;
            }
            at = Steps::by_field(ray, r);
        }
        const Steps::Became became = Steps::advance(ray, at);
        const bool changes = by_lattice ? at.doubt : has_lattice && Steps::far_enough(lattice, at, became.gap);
        if (became.met || (!became.out && --left < 0)) {  // or it grazes
            free[ray.ray] = 0;
            under_way = false;
        } else if (became.out) {
            under_way = false;
        } else if (changes) {
            Steps::change(ray);
            by_field = !by_field;
        }
    }
    for (int i = 0; i < bands * bands; i++) {
        const float all = Team::sum(sum[i], each);
        if (first + own < end && offset_in_batch == 0)
            out.data[order.data[first + own] * bands * bands + i] = all * 3.14159265f / (float)rays;
    }
}
