// A pagoda of three storeys with upswept roofs, on a stone terrace with a stair and two lanterns.
#include "lib/solids.glsl"
#include "lib/operators.glsl"

// bound: four-sided roof whose eaves have half width w at height 0, swept up towards the corners; apex at height h
float roof(vec3 p, float w, float h) {
    vec2 a = abs(p.xz);
    float far = max(a.x, a.y), side = min(a.x, a.y);
    // Height of the tiles: steep at the top, flat at the eaves, lifted at the corners
    float u = clamp(far / w, 0.0, 1.0), corner = side / w;
    float top = h * (1.0 - u) * (1.0 - 0.55 * u) + 0.3 * w * u * u * corner * corner * corner * corner;
    // Tiles: ribs that run down each face
    top += 0.006 * cos(6.28318531 * side / 0.05);
    float d = abs(p.y - top) - 0.02;
    d = max(0.62 * d, far - w);
    return min(d, length(vec3(a - vec2(w - 0.015), p.y - 0.3 * w + 0.005)) - 0.026);
}

vec3 storey(vec3 p, out float w) {
    // The nearest of three storeys, each smaller than the one below; its local point and half width
    float i = clamp(round((p.y + 0.52) / 0.42), 0.0, 2.0);
    w = 0.36 - 0.075 * i;
    return p - vec3(0.0, -0.52 + 0.42 * i, 0.0);
}

float room(vec3 q, float w) {
    float d = sdBox3(q, vec3(w - 0.05, 0.15, w - 0.05));
    // Doors and windows let into each side
    vec2 a = abs(q.xz);
    vec2 s = a.x > a.y ? vec2(a.y, a.x) : a;
    float hole = sdBox3(vec3(s.x, q.y + 0.02, s.y - w + 0.05), vec3(0.06, 0.1, 0.022));
    hole = min(hole, sdBox3(vec3(s.x - 0.62 * w, q.y - 0.01, s.y - w + 0.05), vec3(0.04, 0.055, 0.022)));
    return max(d, -hole);
}

float timber(vec3 q, float w) {
    // Columns at the corners and beside the door, beams, a rail around the floor
    vec2 a = abs(q.xz);
    vec2 s = a.x > a.y ? vec2(a.y, a.x) : a;
    float d = max(length(a - vec2(w - 0.035)) - 0.026, abs(q.y) - 0.16);
    d = min(d, max(length(s - vec2(0.1, w - 0.035)) - 0.018, abs(q.y) - 0.16));
    d = min(d, sdBox3(vec3(s.x, q.y - 0.115, s.y - w + 0.035), vec3(w, 0.016, 0.022)));
    d = min(d, sdBox3(vec3(s.x, q.y + 0.155, s.y - 0.5 * w), vec3(w + 0.03, 0.018, 0.5 * w + 0.03)));
    return d;
}

float roofs(vec3 p) {
    float d = roof(p - vec3(0.0, -0.38, 0.0), 0.56, 0.19);
    d = min(d, roof(p - vec3(0.0, 0.04, 0.0), 0.47, 0.17));
    return min(d, roof(p - vec3(0.0, 0.46, 0.0), 0.4, 0.25));
}

float finial(vec3 p) {
    vec3 f = p - vec3(0.0, 0.72, 0.0);
    float d = sdSegment3(f, vec3(0.0, -0.05, 0.0), vec3(0.0, 0.2, 0.0), 0.014);
    float y = f.y - clamp(round((f.y - 0.02) / 0.05), 0.0, 2.0) * 0.05 - 0.02;
    d = min(d, length(vec2(length(f.xz) - 0.03, y)) - 0.014);
    return min(d, length(f - vec3(0.0, 0.19, 0.0)) - 0.03);
}

float stone(vec3 p) {
    float d = sdRoundBox3(p - vec3(0.0, -0.84, 0.0), vec3(0.8, 0.06, 0.8), 0.02);
    d = min(d, sdRoundBox3(p - vec3(0.0, -0.74, 0.0), vec3(0.5, 0.06, 0.5), 0.012));
    for (int i = 0; i < 3; i++) d = min(d, sdBox3(p - vec3(0.0, -0.78, 0.5), vec3(0.12, 0.065 - 0.03 * float(i), 0.04 + 0.045 * float(i))));
    // Lanterns on both sides of the stair
    vec3 l = vec3(abs(p.x) - 0.32, p.y + 0.78, p.z - 0.65);
    d = min(d, max(length(l.xz) - 0.028, abs(l.y - 0.07) - 0.09));
    d = min(d, sdBox3(l - vec3(0.0, 0.155, 0.0), vec3(0.058, 0.012, 0.058)));
    d = min(d, max(max(abs(l.x), abs(l.z)) * 0.7071 + (l.y - 0.31) * 0.7071, 0.235 - l.y));
    return d;
}

float flames(vec3 p) {
    vec3 l = vec3(abs(p.x) - 0.32, p.y + 0.78, p.z - 0.65);
    return sdBox3(l - vec3(0.0, 0.2, 0.0), vec3(0.036, 0.04, 0.036));
}

float sdf(vec3 p) {
    float w;
    vec3 q = storey(p, w);
    float d = min(stone(p), flames(p));
    // The storeys lie in this box; the cap keeps the field continuous where the parts take over
    float near = sdBox3(p - vec3(0.0, 0.13, 0.0), vec3(0.59, 0.83, 0.59)), cap = 0.1 + abs(near - 0.1);
    if (near > 0.1) return min(d, cap);
    d = min(min(d, cap), min(room(q, w), timber(q, w)));
    return min(d, min(roofs(p), finial(p)));
}

vec3 albedo(vec3 p, vec3 n) {
    float w;
    vec3 q = storey(p, w);
    float s = stone(p), l = flames(p), r = room(q, w), t = timber(q, w), f = roofs(p), g = finial(p);
    float m = min(min(min(s, l), min(r, t)), min(f, g));
    if (m == s) return p.y > -0.77 ? vec3(0.48, 0.46, 0.42) : (n.y > 0.7 ? vec3(0.22, 0.3, 0.12) : vec3(0.3, 0.27, 0.24));
    if (m == l) return vec3(0.8, 0.6, 0.25);
    if (m == g) return vec3(0.65, 0.48, 0.15);
    if (m == t) return vec3(0.5, 0.09, 0.05);
    if (m == f) return vec3(0.1, 0.26, 0.24);
    return max(abs(q.x), abs(q.z)) < w - 0.055 ? vec3(0.16, 0.09, 0.05) : vec3(0.74, 0.68, 0.56);
}
