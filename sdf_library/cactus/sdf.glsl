// A ribbed cactus with two arms and flowers in a clay pot on a saucer.
#include "lib/solids.glsl"
#include "lib/operators.glsl"

// bound: an upright ribbed stroke from height a to b, radius r, n ribs
float ribbed(vec3 p, float a, float b, float r, float n) {
    vec3 q = vec3(p.x, p.y - clamp(p.y, a, b), p.z);
    float top = length(q.xz) / max(length(q), 1e-4);
    return 0.85 * (length(q) - r + 0.12 * r * top * (1.0 - abs(cos(0.5 * n * atan(p.z, p.x)))));
}

float green(vec3 p) {
    float d = ribbed(p, -0.3, 0.5, 0.2, 12.0);
    // Arms: out of the stem, a bend, and up
    vec3 l = p - vec3(-0.4, 0.0, 0.0), r = p - vec3(0.36, 0.0, 0.03);
    float arm = opSmoothUnion(ribbed(l, -0.02, 0.24, 0.105, 9.0), sdSegment3(p, vec3(-0.14, -0.06, 0.0), vec3(-0.39, -0.04, 0.0), 0.088), 0.08);
    d = opSmoothUnion(d, arm, 0.04);
    arm = opSmoothUnion(ribbed(r, 0.2, 0.36, 0.09, 9.0), sdSegment3(p, vec3(0.14, 0.16, 0.02), vec3(0.35, 0.19, 0.03), 0.075), 0.07);
    return opSmoothUnion(d, arm, 0.04);
}

// A flower: two rings of petals
float flower(vec3 p, float s) {
    vec3 q = p / s;
    if (length(q) > 2.0) return s * (length(q) - 1.2);
    vec2 g = opPolar(q.xz, 7.0);
    vec3 leaf = vec3(g.x, q.y, g.y) - vec3(0.5, 0.25, 0.0);
    leaf.xy = mat2(0.83, -0.56, 0.56, 0.83) * leaf.xy;
    float d = sdEllipsoid3(leaf, vec3(0.5, 0.13, 0.24));
    return s * min(d, sdEllipsoid3(q - vec3(0.0, 0.15, 0.0), vec3(0.22, 0.3, 0.22)));
}
float flowers(vec3 p) {
    float d = flower(p - vec3(0.0, 0.7, 0.0), 0.15);
    d = min(d, flower(p - vec3(-0.4, 0.345, 0.0), 0.1));
    return min(d, flower(p - vec3(0.36, 0.45, 0.03), 0.085));
}

float pot(vec3 p) {
    vec2 q = vec2(length(p.xz), p.y);
    // Wall that leans outwards, rim, saucer
    float wall = 0.97 * (q.x - 0.36 - 0.2 * (q.y + 0.65));
    float d = max(wall, abs(q.y + 0.63) - 0.24);
    vec2 rim = abs(q - vec2(0.41, -0.4)) - vec2(0.035, 0.05);
    d = min(d, length(max(rim, 0.0)) + min(max(rim.x, rim.y), 0.0) - 0.015);
    d = opSmoothSubtraction(d, max(q.x - 0.365, -0.46 - q.y), 0.02);
    float saucer = sdRoundDisc3(vec3(p.x, p.z, p.y + 0.875), 0.52, 0.035, 0.02);
    saucer = max(saucer, -max(q.x - 0.46, -0.87 - q.y));
    return min(d, saucer);
}
float pebbles(vec3 p) {
    float d = p.y + 0.44, r = length(p.xz);
    d = max(d, max(r - 0.37, -0.5 - p.y));
    vec2 g = opPolar(p.xz, 9.0);
    d = min(d, sdEllipsoid3(vec3(g.x - 0.29, p.y + 0.43, g.y), vec3(0.065, 0.04, 0.075)));
    return d;
}

float sdf(vec3 p) { return min(min(green(p), flowers(p)), min(pot(p), pebbles(p))); }

vec3 albedo(vec3 p, vec3 n) {
    float g = green(p), f = flowers(p), c = pot(p), s = pebbles(p), d = min(min(g, f), min(c, s));
    if (d == c) return vec3(0.55, 0.22, 0.12);
    if (d == s) return vec3(0.42, 0.38, 0.33);
    if (d == f) {
        float middle = min(length(p.xz), min(length(p.xz + vec2(0.4, 0.0)), length(p.xz - vec2(0.36, 0.03))));
        return mix(vec3(0.75, 0.6, 0.1), vec3(0.7, 0.14, 0.32), smoothstep(0.02, 0.045, middle));
    }
    return mix(vec3(0.1, 0.26, 0.1), vec3(0.2, 0.42, 0.16), smoothstep(-0.4, 0.7, p.y));
}
