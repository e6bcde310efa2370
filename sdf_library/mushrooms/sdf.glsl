// Three toadstools with gills, spots and skirts on a mossy mound, and a snail beside them.
#include "lib/solids.glsl"
#include "lib/operators.glsl"

float limb(vec3 p, vec3 a, vec3 b, float ra, float rb) {
    vec3 axis = b - a;
    float t = clamp(dot(p - a, axis) / dot(axis, axis), 0.0, 1.0);
    return length(p - a - t * axis) - mix(ra, rb, t);
}

// The three: foot and size
const vec4 PLANTS[3] = vec4[3](vec4(-0.05, -0.56, -0.1, 1.0), vec4(0.36, -0.56, 0.2, 0.58), vec4(-0.4, -0.57, 0.3, 0.42));

float stalk(vec3 q) {
    float d = limb(q, vec3(0.0), vec3(0.05, 0.75, 0.0), 0.11, 0.075);
    d = opSmoothUnion(d, sdEllipsoid3(q - vec3(0.0, 0.03, 0.0), vec3(0.16, 0.12, 0.16)), 0.08);
    // Skirt: a thin cone that hangs from the stalk
    vec2 s = vec2(length(q.xz - vec2(0.035, 0.0)), q.y - 0.5);
    return opSmoothUnion(d, sdBox3(vec3(0.8 * s.x + 0.6 * s.y - 0.065, 0.8 * s.y - 0.6 * s.x + 0.085, 0.0), vec3(0.012, 0.06, 1.0)) - 0.012, 0.03);
}

// The cap, hollow below, where gills hang; returns cap and gills
vec2 cap(vec3 q) {
    vec3 c = q - vec3(0.05, 0.72, 0.0);
    float outer = sdEllipsoid3(c, vec3(0.46, 0.36, 0.46)), under = -c.y - 0.02 + 0.1 * dot(c.xz, c.xz);
    float d = opSmoothIntersection(outer, under, 0.06);
    d = opSmoothSubtraction(d, sdEllipsoid3(c + vec3(0.0, 0.05, 0.0), vec3(0.4, 0.13, 0.4)), 0.03);
    vec2 g = opPolar(c.xz, 36.0);
    float gill = max(max(abs(g.y) - 0.009, sdEllipsoid3(c + vec3(0.0, 0.02, 0.0), vec3(0.41, 0.12, 0.41))), c.y - 0.1);
    return vec2(d, 0.9 * gill);
}

float spots(vec3 q) {
    vec3 c = q - vec3(0.05, 0.72, 0.0);
    float d = length(c - vec3(0.03, 0.35, 0.02)) - 0.075;
    vec2 g = opPolar(c.xz, 6.0);
    d = min(d, length(vec3(g.x - 0.24, c.y - 0.29, g.y)) - 0.06);
    float k = 0.5235988;
    g = opPolar(vec2(c.x * cos(k) + c.z * sin(k), c.z * cos(k) - c.x * sin(k)), 6.0);
    d = min(d, length(vec3(g.x - 0.385, c.y - 0.17, g.y)) - 0.05);
    return max(d, sdEllipsoid3(c, vec3(0.485, 0.378, 0.485)));
}

float ground(vec3 p) {
    float d = sdRoundDisc3(vec3(p.x, p.z, p.y + 0.66), 0.8, 0.03, 0.02);
    return opSmoothUnion(d, sdEllipsoid3(p - vec3(-0.02, -0.61, 0.0), vec3(0.62, 0.07, 0.58)), 0.06);
}

// The snail: a shell wound in turns, a foot, two horns
float shell(vec3 p) {
    vec3 q = p - vec3(0.1, -0.42, 0.5);
    float a = atan(q.y, q.x), r = length(q.xy), d = length(q + vec3(0.105, 0.0, 0.0)) - 0.052;
    for (int i = 0; i < 3; i++) {
        float turn = float(i) + 0.5 - a / 6.28318531, w = 0.105 * exp2(-0.9 * turn);
        d = min(d, length(vec2(r - w, q.z)) - 0.5 * w);
    }
    return 0.85 * d;
}
float snail(vec3 p) {
    vec3 q = vec3(p.x, p.y, 0.5 + abs(p.z - 0.5));
    float d = limb(p, vec3(-0.1, -0.525, 0.5), vec3(0.22, -0.535, 0.5), 0.042, 0.018);
    d = opSmoothUnion(d, limb(p, vec3(-0.1, -0.52, 0.5), vec3(-0.145, -0.44, 0.5), 0.042, 0.036), 0.03);
    return opSmoothUnion(d, limb(q, vec3(-0.15, -0.43, 0.515), vec3(-0.19, -0.34, 0.545), 0.011, 0.013), 0.012);
}

// Stalk, cap, gills, spots over all three
vec4 plants(vec3 p) {
    vec4 d = vec4(1e3);
    for (int i = 0; i < 3; i++) {
        float s = PLANTS[i].w;
        vec3 q = (p - PLANTS[i].xyz) / s;
        float near = sdBox3(q - vec3(0.05, 0.5, 0.0), vec3(0.48, 0.64, 0.48));
        if (near > 0.2) { d = min(d, s * vec4(near)); continue; }
        vec2 c = cap(q);
        d = min(d, s * vec4(stalk(q), c, spots(q)));
    }
    return d;
}

float sdf(vec3 p) {
    vec4 d = plants(p);
    return min(min(min(d.x, d.y), min(d.z, d.w)), min(ground(p), min(shell(p), snail(p))));
}

vec3 albedo(vec3 p, vec3 n) {
    vec4 m = plants(p);
    float g = ground(p), h = shell(p), b = snail(p);
    float d = min(min(min(m.x, m.y), min(m.z, m.w)), min(g, min(h, b)));
    if (d == g) return mix(vec3(0.22, 0.16, 0.1), vec3(0.17, 0.3, 0.08), smoothstep(-0.66, -0.62, p.y));
    if (d == h) return mix(vec3(0.5, 0.28, 0.12), vec3(0.65, 0.5, 0.3), smoothstep(0.03, 0.0, abs(p.z - 0.5)));
    if (d == b) return vec3(0.55, 0.46, 0.34);
    if (d == m.w) return vec3(0.75, 0.72, 0.64);
    if (d == m.y && n.y > -0.3) return vec3(0.6, 0.06, 0.03);
    return vec3(0.68, 0.62, 0.5);
}
