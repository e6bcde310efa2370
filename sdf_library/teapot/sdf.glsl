// A teapot with two cups and saucers on a round-cornered tray; the spout points along +x.
#include "lib/solids.glsl"
#include "lib/operators.glsl"

const vec3 POT = vec3(0.0, -0.06, -0.18);

float limb(vec3 p, vec3 a, vec3 b, float ra, float rb) {
    vec3 axis = b - a;
    float t = clamp(dot(p - a, axis) / dot(axis, axis), 0.0, 1.0);
    return length(p - a - t * axis) - mix(ra, rb, t);
}

float pot(vec3 p) {
    vec2 q = vec2(length(p.xz), p.y);
    float d = sdEllipsoid3(p, vec3(0.37, 0.31, 0.37));
    d = opSmoothUnion(d, sdRoundDisc3(p.xzy - vec3(0.0, 0.0, -0.29), 0.2, 0.035, 0.015), 0.04);
    // Spout: wide below, drawn out into a lip, open at its end
    float spout = opSmoothUnion(limb(p, vec3(0.3, -0.12, 0.0), vec3(0.5, 0.03, 0.0), 0.115, 0.065), limb(p, vec3(0.5, 0.03, 0.0), vec3(0.62, 0.25, 0.0), 0.062, 0.042), 0.06);
    d = opSmoothUnion(d, spout, 0.06);
    d = opSmoothSubtraction(d, limb(p, vec3(0.58, 0.18, 0.0), vec3(0.66, 0.33, 0.0), 0.02, 0.036), 0.012);
    // Handle: an ear of a ring
    vec3 h = p - vec3(-0.38, 0.03, 0.0);
    float ear = sdCappedTorus3(vec3(h.y, -h.x, h.z), vec2(0.94, -0.34), 0.19, 0.036);
    d = opSmoothUnion(d, ear, 0.04);
    // The rim in which the lid sits
    return min(d, length(q - vec2(0.185, 0.268)) - 0.022);
}

float lid(vec3 p) {
    float d = max(sdEllipsoid3(p - vec3(0.0, 0.25, 0.0), vec3(0.175, 0.1, 0.175)), 0.25 - p.y);
    d = opSmoothUnion(d, limb(p, vec3(0.0, 0.33, 0.0), vec3(0.0, 0.4, 0.0), 0.03, 0.025), 0.03);
    return opSmoothUnion(d, length(p - vec3(0.0, 0.425, 0.0)) - 0.052, 0.02);
}

float cup(vec3 p) {
    vec2 q = vec2(length(p.xz), p.y);
    // A bowl with a foot, its wall rounded at the lip
    float shell = max(abs(length(q - vec2(0.0, 0.04)) - 0.16) - 0.008, q.y - 0.045);
    shell = min(shell, length(q - vec2(0.16, 0.045)) - 0.012);
    float d = min(shell, sdRoundDisc3(p.xzy - vec3(0.0, 0.0, -0.13), 0.075, 0.022, 0.01));
    vec3 h = p - vec3(0.165, -0.03, 0.0);
    return min(d, max(length(vec2(length(h.xy) - 0.06, h.z)) - 0.016, 0.145 - length(q - vec2(0.0, 0.04))));
}

float tea(vec3 p) { return max(length(p - vec3(0.0, 0.04, 0.0)) - 0.155, p.y + 0.02); }

float saucer(vec3 p) {
    vec2 q = vec2(length(p.xz), p.y);
    float d = max(abs(length(q - vec2(0.0, 0.4)) - 0.575) - 0.009, q.x - 0.25);
    return min(d, length(q - vec2(0.249, -0.118)) - 0.013);
}

float tray(vec3 p) {
    float d = sdRoundBox3(p - vec3(0.0, -0.43, 0.0), vec3(0.88, 0.075, 0.72), 0.06);
    return opSmoothSubtraction(d, sdRoundBox3(p - vec3(0.0, -0.29, 0.0), vec3(0.83, 0.15, 0.67), 0.04), 0.02);
}

vec3 besideCup(vec3 p) {
    // Two cups, mirrored about x = 0, handles outwards
    vec3 q = vec3(abs(p.x) - 0.34, p.y + 0.245, p.z - 0.36);
    return vec3(0.7 * q.x + 0.714 * q.z, q.y, 0.7 * q.z - 0.714 * q.x);
}

float sdf(vec3 p) {
    vec3 a = p - POT, b = besideCup(p);
    float d = min(tray(p), min(pot(a), lid(a)));
    return min(d, min(cup(b), min(tea(b), saucer(b))));
}

vec3 albedo(vec3 p, vec3 n) {
    vec3 a = p - POT, b = besideCup(p);
    float t = tray(p), c = min(cup(b), saucer(b)), brew = tea(b), body = min(pot(a), lid(a));
    float m = min(min(t, c), min(brew, body));
    if (m == t) return mix(vec3(0.3, 0.15, 0.06), vec3(0.38, 0.2, 0.08), 0.5 + 0.5 * sin(40.0 * p.z + 3.0 * sin(3.0 * p.x)));
    if (m == brew) return vec3(0.32, 0.1, 0.02);
    vec3 glaze = vec3(0.74, 0.72, 0.66), blue = vec3(0.04, 0.13, 0.36);
    if (m == c) {
        float r = length(b.xz);
        bool band = (r > 0.21 && r < 0.232) || (b.y > 0.02 && b.y < 0.034 && r > 0.1 && r < 0.19 && n.y < 0.9);
        return band ? blue : glaze;
    }
    // Bands at the shoulder and the foot, a knob and a ring of petals in blue
    float r = length(a.xz);
    if (a.y > 0.38) return blue;
    if (r < 0.42 && ((a.y > 0.17 && a.y < 0.19) || (a.y > -0.2 && a.y < -0.18) || a.y < -0.27)) return blue;
    if (r < 0.42 && r > 0.2) {
        float angle = atan(a.z, a.x) * 8.0 / 6.28318531, w = fract(angle) - 0.5;
        vec2 e = vec2(w * 0.29, a.y);
        if (abs(length(e) - 0.085) < 0.012 || length(e) < 0.03) return blue;
    }
    return glaze;
}
