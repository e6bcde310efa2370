// Sphere tracing inside the bounds, over-relaxed by the slope with the safe step to fall back on (Hart 1996, Sec. 2; Balint and
// Valasek 2018), of rays and of cones about many rays.
float sdfprt_distance(vec3 p);
uniform vec3 boundsLow;
uniform vec3 boundsHigh;
uniform float stepFactor;   // of the scene: below 1 where its field overestimates
uniform float hitDistance;  // what counts as the surface, scene units
uniform int marchSteps;

const float FIRST_SLOPE = -0.8;  // of the distance along a ray before two evaluations tell: -0.6 and -1 take 5 and 1 % more of them
const float STEEP = -0.1;        // a slope below it tells where the surface is
const float NEAR_ROOT = 0.25;    // of a sample: a ray so near goes straight there, which spares 16 to 20 % of the evaluations
const int HALVES = 12;           // of a way that led into the solid

// Where the ray enters and leaves the bounds; it enters after it leaves on a miss.
// The bounds are grown to all sides.
vec2 clipToBounds(vec3 o, vec3 d, float grown) {
    vec3 safe = mix(d, vec3(1e-20), lessThan(abs(d), vec3(1e-20)));
    vec3 a = (boundsLow - grown - o) / safe, b = (boundsHigh + grown - o) / safe;
    vec3 low = min(a, b), high = max(a, b);
    return vec2(max(max(low.x, low.y), max(low.z, 0.0)), min(high.x, min(high.y, high.z)));
}

// Radius, where it leaves the bounds, of a cone that has `cone` at distance 1, or more.
float coneAtBounds(vec3 o, float cone) {
    return cone * (length(o - 0.5 * (boundsLow + boundsHigh)) + length(boundsHigh - boundsLow));
}

// Distance along d to the surface, or -1; nothing lies before `begin`. `width` is the size of a sample at distance 1: chords
// through the solid shorter than a hundredth of it are passed over, near a surface those shorter than a quarter, and a ray that
// creeps along a silhouette until the steps run out counts as a hit within half of it. A ray that enters inside hits there.
// With `cone`, the radius at distance 1 of a cone about the ray: how far the cone is free, or -1 where it is to the end.
float march(vec3 o, vec3 d, float width, float begin, float cone) {
    vec2 inside = clipToBounds(o, d, coneAtBounds(o, cone));
    float t = max(inside.x, begin), r = 1e30, slope = FIRST_SLOPE;
    float ball = 0.0, stride = 0.0, taken = 0.0;  // of the evaluation before: radius, the step after it, and that if it was no leap
    bool alive = t < inside.y, met = false;
    for (int i = 0; i < marchSteps && alive; i++) {
        r = sdfprt_distance(o + d * t) * stepFactor - cone * t;
        // Where two balls do not touch, something may lie between: back to the end of the first
        bool apart = taken > 0.0 && ball + r < taken;
        met = r < max(hitDistance, 0.5 * cone * t) && !apart;
        if (stride > 0.0) slope = clamp((r - ball) / stride, -1.0, 0.8);
        // Else as far as the next ball will touch this one if the slope stays
        float least = 0.01 * width * t, ahead = min(1.9 * r / (1.0 - slope), max(inside.y - hitDistance - t, r));
        float root = NEAR_ROOT * width * t;
        if (cone <= 0.0 && stride > 0.0 && slope < STEEP && r < root) least = max(least, min(r / -slope, root));
        bool leap = ahead < least;
        if (!met) {
            t += apart ? ball - taken : leap ? least : ahead;
            stride = apart ? 0.0 : leap ? least : ahead;
            taken = apart || leap ? 0.0 : ahead;
            ball = r;
            if (apart) slope = FIRST_SLOPE;
        }
        alive = !met && t < inside.y;
    }
    if (cone > 0.0) return !met && !alive ? -1.0 : r < 0.0 && taken > 0.0 ? t - taken + ball : t;
    if (!met && !(alive && r < 0.5 * width * t)) return -1.0;
    // Onto the surface itself, by the slope, twice. A field that overestimates lets steps, and the cone about many rays, into the solid
    // deeper than a sample is wide: from there by halves between inside and outside
    float most = 0.1 * width * t, inner = t, outer = stride > 0.0 ? t - stride : t + 2.0 * r;
    bool deep = r < -most;
    for (int i = 0; i < (deep ? HALVES : min(marchSteps, 1)); i++) {
        float move = clamp(r / max(-slope, 0.05), -most, most);
        float there = max(!deep ? t + move : i == 0 && stride <= 0.0 ? outer : 0.5 * (inner + outer), inside.x);
        float next = sdfprt_distance(o + d * there) * stepFactor;
        if (there != t) slope = clamp((next - r) / (there - t), -1.0, 0.0);
        if (next < 0.0) inner = there; else outer = there;
        if (outer >= inner) outer = inner + 2.0 * next;  // still inside
        t = there;
        r = next;
    }
    return max(t + clamp(r / max(-slope, 0.05), -most, most), inside.x);
}
