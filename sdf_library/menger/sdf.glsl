// A Menger sponge of two levels with one corner cut away across the diagonal.
#include "lib/solids.glsl"

float sdf(vec3 p) {
    vec3 q = p;
    float d = sdBox3(p, vec3(0.78)), size = 0.78;
    for (int level = 0; level < 2; level++) {
        // Nearest cell of this level, then the cross of square bars that is taken from it
        vec3 cell = q - 2.0 * size * clamp(round(q / (2.0 * size)), -float(level > 0), float(level > 0));
        vec3 a = abs(cell);
        vec2 x = vec2(max(a.y, a.z), max(a.x, a.z));
        float cross = min(min(x.x, x.y), max(a.x, a.y)) - size / 3.0;
        d = max(d, -cross);
        q = cell;
        size /= 3.0;
    }
    return max(d, dot(p, vec3(0.57735027)) - 0.42);
}

vec3 albedo(vec3 p, vec3 n) {
    if (dot(n, vec3(0.57735027)) > 0.98) return vec3(0.66, 0.24, 0.1);
    vec3 depth = abs(p) / 0.78;
    float outer = max(depth.x, max(depth.y, depth.z));
    return mix(vec3(0.62, 0.42, 0.16), vec3(0.66, 0.62, 0.54), smoothstep(0.6, 1.0, outer));
}
