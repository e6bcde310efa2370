// One step of rays of transfer, by the field or by the lattice that stands in for it, and the empty balls that spare the first ones.
// Lengths and places are as in packets.h, which moves many rays packet by packet, and in threads.h, where a thread moves one.

// How steps are chosen. No value is a matter of right or wrong, since a gap between two balls is always gone back to: `bench
// transfer` shows for another value the rate, and the share of rays that agree with a plain march. Ratios, where no unit stands.
constexpr float FIRST_SLOPE = -0.15f;  // change of the distance along a ray, assumed before the first step
constexpr float DIVE_SLOPE = -0.2f;    // below this the ray falls towards a surface
constexpr float DIVE_RELAX = 1.3f;     // a falling ray goes so much farther than to where it would meet the surface
constexpr float CLIMB_RELAX = 1.8f;    // another goes so much farther than its ball; 2 would leave a gap wherever the slope falls
constexpr float MOST_SLOPE = 0.8f;     // and is not taken to climb more steeply: at 1 a step would have no end
constexpr float FAR_ENOUGH = 3.0f;     // from the surface, in errors of the lattice: there a ray goes by the lattice again
constexpr float HARDLY_LEFT = 0.5f;    // from its origin, in coarse cells: nearer than this the field decides what is close
constexpr float DOUBT_INSIDE = -2.0f;  // in errors of the lattice: deeper in the solid than this the plane is believed
constexpr float CELL_END = 1.0001f;    // a step to the end of a cell ends beyond its face, by this
constexpr float CELL_MARGIN = 1e-5f;   // and by this, in coarse cells, for the rounding
constexpr float LEAST_STEP = 1e-9f;    // divides in place of a last step of 0
constexpr float BALL_LEAST = 0.01f;    // a ball along the normal that is smaller, of its height, helps no ray
// Balls along the normal: the first at the origin o itself, the next at twice its height above the surface, each of the others
// 1.7 times as high: less than the 2 to which a ball above a plane reaches, so that they overlap.
constexpr float LOG_BALL_GROWTH = 0.530628f;  // the logarithm of 1.7

// Empty balls about places of one line, `radius` the step times the field there
struct Balls : Simd {
    float radius[16], inverse[16], ratio[16], rest[16];

    // Of ball k above an origin that is `offset` above the surface
    static inline CUDA_CALLABLE float height(int k, float offset) {
        return k == 0 ? 0.0f : 2.0f * offset * expf(LOG_BALL_GROWTH * (float)(k - 1));
    }
    inline CUDA_CALLABLE void set(int first, F height, F size) {
        const M small = le(size, BALL_LEAST * height);  // none, or too small to help
        const F inverted = 1.0f / sel(small, splat(1.0f), size), share = height * inverted;
        spill(radius + first, size);
        spill(inverse + first, inverted);
        spill(ratio + first, share);
        spill(rest + first, sel(small, splat(-1e30f), 1.0f - share * share));
    }
    // Where rays that are free as far as t leave ball k, their cosine to the line `c`; those that are not inside stay
    inline CUDA_CALLABLE F past(int k, F t, F c, M& inside) const {
        const F along = ratio[k] * c, half = mad(along, along, splat(rest[k]));  // in radii; half the chord, squared
        const F ahead = mad(t, splat(inverse[k]), -along);
        inside = le(ahead * ahead, half);
        // The root of `half` from below, (3 - half) / 2 of it: no farther than the ball, and much quicker
        const F end = radius[k] * mad(half, mad(half, splat(-0.5f), splat(1.5f)), along);
        return sel(inside, max(t, end), t);
    }
};

struct Steps : Simd {
    struct Rays {
        F x, y, z, u, v, w;   // origin, unit direction
        F s, end;             // how far along the ray is, and where it leaves the bounds
        F hit_radius;         // within so much of the surface it has met it
        F last_radius;        // of the empty ball about the place before
        F last_step;          // from that place to this one; 0 at first, and after a gap
        I ray, sector;        // its number, and that of its direction, as in Lattice
    };

    // What is known where a ray is
    struct Ahead {
        F radius;   // the distance from the surface
        F slope;    // its change along the ray
        F cleared;  // as far along the ray nothing lies
        M doubt;    // the lattice is not to be trusted: the field decides
        M escapes;  // nothing lies ahead at all
    };
    static inline CUDA_CALLABLE Ahead by_field(const Rays& rays, F r) {
        const F measured = (r - rays.last_radius) / max(rays.last_step, splat(LEAST_STEP));
        return {r, sel(lt(splat(0.0f), rays.last_step), measured, splat(FIRST_SLOPE)), rays.s + r, none(), none()};
    }
    static inline CUDA_CALLABLE Ahead by_lattice(const Rays& rays, const Lattice& lattice, const Lattice::Cell& cell) {
        const Lattice::Reading found = lattice.read(cell);
        const F r = found.distance, slope = mad(found.z, rays.w, mad(found.y, rays.v, found.x * rays.u));
        // As far as the end of the cell, if there too the plane is above the surface
        const F end = Lattice::ahead(found, rays.u, rays.v, rays.w) / cell.parts;
        const F last = mad(splat(CELL_END), end, splat(CELL_MARGIN));
        const F clear = sel(lt(rays.hit_radius + lattice.error, min(r, mad(slope, last, r))), max(r, last), r);
        // Where a ray has hardly left, the lattice's error would decide
        const M close = lt(splat(DOUBT_INSIDE * lattice.error), r) & lt(r, rays.hit_radius + lattice.error);
        const M doubt = found.rough | (lt(rays.s, splat(HARDLY_LEFT)) & close);
        return {r, slope, rays.s + clear, doubt, ~eq(cell.clear & rays.sector, splat(0))};
    }

    // Moves rays on; which of them have met the surface, have gone back to a gap, or are out of the bounds (or are no number).
    // A negative distance is met for certain. Where the balls of this step and of the last leave a gap between them, something
    // may lie there: back to the end of the last ball. Else as far as the next ball will touch this one if the slope stays or,
    // where the ray falls, just beyond where it would meet the surface (Balint and Valasek 2018)
    struct Became {
        M met, gap, out;
    };
    static inline CUDA_CALLABLE Became advance(Rays& rays, const Ahead& at) {
        const F r = at.radius, s = rays.s, last_radius = rays.last_radius, last_step = rays.last_step;
        const M gap = lt(last_radius + r, last_step);
        const M met = (lt(r, splat(0.0f)) | (lt(r, rays.hit_radius) & ~gap)) & ~at.doubt;
        const M dive = lt(at.slope, splat(DIVE_SLOPE));
        const F relax = sel(dive, splat(DIVE_RELAX), splat(CLIMB_RELAX));
        const F relaxed = r * relax / sel(dive, -at.slope, 1.0f - min(at.slope, splat(MOST_SLOPE)));
        const F place = sel(gap, s - last_step + last_radius, max(min(s + relaxed, rays.end - rays.hit_radius), at.cleared));
        rays.last_step = sel(at.doubt, last_step, sel(gap, splat(0.0f), place - s));
        rays.last_radius = sel(at.doubt, last_radius, sel(gap, splat(0.0f), at.cleared - s));
        rays.s = sel(at.doubt, s, place);
        return {met, gap, (at.escapes & ~(gap | at.doubt)) | ~(lt(place, rays.end) | at.doubt | met)};
    }

    // Which of them are to change from the field to the lattice
    static inline CUDA_CALLABLE M far_enough(const Lattice& lattice, const Ahead& at, M gap) {
        return le(splat(FAR_ENOUGH * lattice.error), at.radius) & ~gap;
    }
    // A ray that changes goes on from where the ball ends in which it was
    static inline CUDA_CALLABLE void change(Rays& rays) {
        rays.s = rays.s - rays.last_step + rays.last_radius;
        rays.last_step = rays.last_radius = splat(0.0f);
    }
};
