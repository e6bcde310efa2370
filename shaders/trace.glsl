// Sphere tracing inside the bounds, over-relaxed with the safe step to fall back on (Hart 1996, Sec. 2; Keinert et al. 2014).
float sdfprt_distance(vec3 p);
uniform vec3 boundsLow;
uniform vec3 boundsHigh;
uniform float stepFactor;   // of the scene: below 1 where its field overestimates
uniform float relaxation;
uniform float hitDistance;  // what counts as the surface, scene units
uniform int marchSteps;

// Where the ray enters and leaves the bounds; it enters after it leaves on a miss.
vec2 clipToBounds(vec3 o, vec3 d) {
    vec3 safe = mix(d, vec3(1e-20), lessThan(abs(d), vec3(1e-20)));
    vec3 a = (boundsLow - o) / safe, b = (boundsHigh - o) / safe;
    vec3 low = min(a, b), high = max(a, b);
    return vec2(max(max(low.x, low.y), max(low.z, 0.0)), min(high.x, min(high.y, high.z)));
}

// Distance along d to the surface, or -1. `width` is the size of a sample at distance 1: a ray that creeps along a
// silhouette until the steps run out counts as a hit within half of it. A ray that enters inside the solid hits there.
float march(vec3 o, vec3 d, float width) {
    vec2 inside = clipToBounds(o, d);
    float t = inside.x, free = 0.0, taken = 0.0, omega = relaxation, nearest = 1e30;
    bool alive = inside.x < inside.y;
    for (int i = 0; i < marchSteps && alive; i++) {
        float r = sdfprt_distance(o + d * t) * stepFactor;
        if (omega > 1.0 && r + free < taken) {
            // The two balls do not touch, something may lie between: go back and take the safe step
            t += free - taken;
            omega = 1.0;
            taken = 0.0;
            continue;
        }
        nearest = r;
        free = r;
        alive = r > hitDistance && t + r <= inside.y;
        taken = alive ? min(r * omega, inside.y - t) : 0.0;
        t += taken;
    }
    bool creeping = alive && nearest < 0.5 * width * t;
    if (nearest > hitDistance && !creeping) return -1.0;
    // Onto the surface itself, backwards where a field that overestimates let the ray into the solid
    for (int i = 0; i < min(marchSteps, 5); i++) t = max(t + sdfprt_distance(o + d * t) * stepFactor, inside.x);
    return t;
}
