// A sitting rabbit on a round patch of ground; it looks along +z.
#include "lib/solids.glsl"
#include "lib/operators.glsl"

float limb(vec3 p, vec3 a, vec3 b, float ra, float rb) {
    vec3 axis = b - a;
    float t = clamp(dot(p - a, axis) / dot(axis, axis), 0.0, 1.0);
    return length(p - a - t * axis) - mix(ra, rb, t);
}

const vec3 HEAD = vec3(0.0, 0.2, 0.22);

// An ear: a long leaf, hollow in front, leaning out and back.
float ear(vec3 q) {
    vec3 e = q - vec3(0.075, 0.34, 0.18);
    e.xy = mat2(0.966, 0.259, -0.259, 0.966) * e.xy;
    e.yz = mat2(0.94, -0.342, 0.342, 0.94) * e.yz;
    float leaf = sdEllipsoid3(e - vec3(0.0, 0.21, 0.0), vec3(0.068, 0.235, 0.042));
    float hollow = sdEllipsoid3(e - vec3(0.0, 0.22, 0.045), vec3(0.043, 0.19, 0.042));
    return opSmoothSubtraction(leaf, hollow, 0.02);
}

float fur(vec3 p) {
    vec3 q = vec3(abs(p.x), p.y, p.z);
    // Trunk: rump, back, chest
    float d = sdEllipsoid3(p - vec3(0.0, -0.27, -0.2), vec3(0.27, 0.29, 0.3));
    d = opSmoothUnion(d, sdEllipsoid3(p - vec3(0.0, -0.2, 0.06), vec3(0.21, 0.27, 0.2)), 0.14);
    d = opSmoothUnion(d, length(p - vec3(0.0, -0.06, 0.16)) - 0.15, 0.1);
    // Head with cheeks and muzzle
    float h = sdEllipsoid3(p - HEAD, vec3(0.165, 0.16, 0.185));
    h = opSmoothUnion(h, length(q - HEAD - vec3(0.075, -0.05, 0.1)) - 0.085, 0.05);
    h = opSmoothUnion(h, length(q - HEAD - vec3(0.032, -0.055, 0.185)) - 0.045, 0.025);
    h = opSmoothUnion(h, length(p - HEAD - vec3(0.0, -0.1, 0.15)) - 0.045, 0.03);
    // Eye sockets and brows
    h = opSmoothSubtraction(h, length(q - HEAD - vec3(0.128, 0.03, 0.105)) - 0.052, 0.03);
    h = opSmoothUnion(h, limb(q, HEAD + vec3(0.085, 0.085, 0.125), HEAD + vec3(0.145, 0.07, 0.05), 0.022, 0.018), 0.03);
    h = opSmoothUnion(h, ear(q), 0.05);
    d = opSmoothUnion(d, h, 0.08);
    // Haunches and hind feet
    float leg = sdEllipsoid3(q - vec3(0.2, -0.36, -0.12), vec3(0.115, 0.19, 0.215));
    leg = opSmoothUnion(leg, limb(q, vec3(0.225, -0.545, -0.1), vec3(0.215, -0.55, 0.17), 0.06, 0.058), 0.06);
    // Fore legs and paws
    float arm = limb(q, vec3(0.12, -0.18, 0.19), vec3(0.105, -0.52, 0.27), 0.075, 0.05);
    arm = opSmoothUnion(arm, sdEllipsoid3(q - vec3(0.105, -0.56, 0.31), vec3(0.06, 0.045, 0.085)), 0.04);
    // Toes: grooves between them
    float toes = 1e3;
    for (int i = 0; i < 2; i++) {
        float s = float(2 * i - 1) * 0.02;
        toes = min(toes, limb(q, vec3(0.105 + s, -0.53, 0.38), vec3(0.105 + s, -0.6, 0.4), 0.011, 0.011));
        toes = min(toes, limb(q, vec3(0.215 + s, -0.52, 0.21), vec3(0.215 + s, -0.6, 0.24), 0.011, 0.011));
    }
    float limbs = opSmoothSubtraction(min(leg, arm), toes, 0.012);
    d = opSmoothUnion(d, limbs, 0.05);
    // Tail: a tuft of balls
    float tail = length(p - vec3(0.0, -0.38, -0.52)) - 0.075;
    tail = opSmoothUnion(tail, length(q - vec3(0.05, -0.34, -0.53)) - 0.05, 0.03);
    tail = opSmoothUnion(tail, length(p - vec3(0.0, -0.31, -0.51)) - 0.05, 0.03);
    return opSmoothUnion(d, tail, 0.03);
}

float eyes(vec3 p) { return length(vec3(abs(p.x), p.yz) - HEAD - vec3(0.112, 0.028, 0.095)) - 0.05; }
float nose(vec3 p) { return sdEllipsoid3(p - HEAD - vec3(0.0, -0.022, 0.222), vec3(0.028, 0.02, 0.02)); }
float teeth(vec3 p) { return sdRoundBox3(p - HEAD - vec3(0.0, -0.105, 0.192), vec3(0.02, 0.03, 0.012), 0.008); }

// A low mound, a carrot with leaves, three stones
float mound(vec3 p) {
    float d = sdRoundDisc3(vec3(p.x, p.z, p.y + 0.63), 0.78, 0.03, 0.02);
    return opSmoothUnion(d, sdEllipsoid3(p - vec3(0.0, -0.62, -0.05), vec3(0.55, 0.055, 0.55)), 0.05);
}
float carrot(vec3 p) {
    vec3 root = vec3(0.34, -0.535, 0.36), tip = vec3(0.6, -0.565, 0.22);
    float t = clamp(dot(p - root, tip - root) / dot(tip - root, tip - root), 0.0, 1.0);
    return limb(p, root, tip, 0.055, 0.016) + 0.003 * cos(30.0 * t);
}
float leaves(vec3 p) {
    float d = limb(p, vec3(0.32, -0.53, 0.37), vec3(0.2, -0.5, 0.47), 0.016, 0.012);
    d = min(d, limb(p, vec3(0.32, -0.53, 0.37), vec3(0.26, -0.47, 0.5), 0.016, 0.012));
    return min(d, limb(p, vec3(0.32, -0.53, 0.37), vec3(0.19, -0.55, 0.4), 0.016, 0.012));
}
float stones(vec3 p) {
    float d = sdEllipsoid3(p - vec3(-0.5, -0.57, 0.25), vec3(0.1, 0.07, 0.085));
    d = min(d, sdEllipsoid3(p - vec3(-0.58, -0.58, 0.06), vec3(0.065, 0.05, 0.075)));
    return min(d, sdEllipsoid3(p - vec3(-0.4, -0.585, 0.4), vec3(0.05, 0.035, 0.045)));
}

float sdf(vec3 p) {
    float d = min(mound(p), min(min(carrot(p), leaves(p)), stones(p)));
    return min(d, min(fur(p), min(eyes(p), min(nose(p), teeth(p)))));
}

vec3 albedo(vec3 p, vec3 n) {
    float f = fur(p), e = eyes(p), o = nose(p), m = min(mound(p), 1e3), c = carrot(p), l = leaves(p), s = stones(p), t = teeth(p);
    float d = min(min(min(f, e), min(o, m)), min(min(c, l), min(s, t)));
    if (d == m) return mix(vec3(0.2, 0.15, 0.1), vec3(0.16, 0.26, 0.07), smoothstep(-0.62, -0.59, p.y));
    if (d == c) return vec3(0.65, 0.24, 0.04);
    if (d == l) return vec3(0.12, 0.32, 0.06);
    if (d == s) return vec3(0.35, 0.34, 0.32);
    if (d == e) return vec3(0.03, 0.02, 0.015);
    if (d == o) return vec3(0.5, 0.22, 0.2);
    if (d == t) return vec3(0.7, 0.68, 0.6);
    vec3 coat = mix(vec3(0.4, 0.3, 0.21), vec3(0.52, 0.42, 0.31), smoothstep(-0.5, 0.3, p.y));
    float white = smoothstep(0.02, -0.06, length(p - vec3(0.0, -0.12, 0.36)) - 0.17);
    white = max(white, smoothstep(0.01, -0.03, length(p - vec3(0.0, -0.36, -0.55)) - 0.1));
    white = max(white, smoothstep(-0.49, -0.53, p.y));
    coat = mix(coat, vec3(0.68, 0.64, 0.58), white);
    bool inside = p.y > 0.4 && n.z > 0.2 && abs(abs(p.x) - 0.14) < 0.045;
    return inside ? vec3(0.56, 0.33, 0.29) : coat;
}
