// A striped lighthouse on a rock in the sea, with a gallery, a lantern and the keeper's cottage.
#include "lib/solids.glsl"
#include "lib/operators.glsl"

const vec3 TOWER = vec3(-0.08, 0.0, -0.08);
const vec3 COTTAGE = vec3(0.27, -0.585, 0.05);

// bound: body of revolution between heights y0 and y1, radius r0 below and r1 above; q is radius and height
float taper(vec2 q, float y0, float y1, float r0, float r1) {
    vec2 n = normalize(vec2(y1 - y0, r0 - r1));
    return max(dot(q - vec2(r0, y0), n), max(y0 - q.y, q.y - y1));
}

float rock(vec3 p) {
    float d = sdRoundBox3(p - vec3(-0.08, -0.78, -0.06), vec3(0.34, 0.11, 0.3), 0.09);
    d = opSmoothUnion(d, sdRoundBox3(p - vec3(0.2, -0.79, 0.03), vec3(0.32, 0.125, 0.25), 0.1), 0.08);
    d = opSmoothUnion(d, length(p - vec3(-0.3, -0.86, 0.18)) - 0.16, 0.06);
    d = opSmoothUnion(d, length(p - vec3(0.3, -0.9, 0.33)) - 0.13, 0.06);
    d = opSmoothUnion(d, length(p - vec3(0.06, -0.92, 0.38)) - 0.12, 0.05);
    // Rough flanks, flat on top
    float rough = sin(17.0 * p.x + 3.0 * p.y) * sin(19.0 * p.z - 5.0 * p.y) * sin(15.0 * p.y);
    return max(d - 0.012 * rough * (1.0 - smoothstep(-0.74, -0.66, p.y)), -0.915 - p.y);
}

float sea(vec3 p) {
    float wave = 0.008 * sin(16.0 * p.x + 2.0 * sin(7.0 * p.z)) * sin(11.0 * p.z + 4.0 * p.x);
    return sdRoundDisc3(vec3(p.x, p.z, p.y + 0.875 - wave), 0.7, 0.045, 0.02);
}

float tower(vec3 p, vec2 q) {
    float d = taper(q, -0.7, 0.42, 0.2, 0.115);
    // Windows in a row up the front, the door below them
    float y = p.y - clamp(round((p.y + 0.04) / 0.26), -1.0, 1.0) * 0.26 + 0.04;
    d = max(d, -sdRoundBox3(vec3(p.x, y, p.z - 0.17), vec3(0.028, 0.045, 0.055), 0.012));
    return max(d, -sdRoundBox3(p - vec3(0.0, -0.58, 0.2), vec3(0.05, 0.09, 0.04), 0.02));
}

float stone(vec3 p, vec2 q) {
    // Corbel, gallery and plinth
    float d = min(taper(q, 0.36, 0.43, 0.12, 0.185), taper(q, 0.43, 0.46, 0.205, 0.205));
    return min(d, taper(q, -0.7, -0.63, 0.24, 0.225));
}

float iron(vec3 p, vec2 q) {
    // Railing, window bars of the lantern, roof with ball and rod
    float d = length(q - vec2(0.185, 0.555)) - 0.011;
    vec3 r = vec3(opPolar(p.xz, 12.0), p.y);
    d = min(d, sdSegment3(r, vec3(0.185, 0.0, 0.45), vec3(0.185, 0.0, 0.555), 0.009));
    vec3 b = vec3(opPolar(p.xz, 8.0), p.y);
    d = min(d, sdSegment3(b, vec3(0.092, 0.0, 0.46), vec3(0.092, 0.0, 0.66), 0.009));
    d = min(d, taper(q, 0.46, 0.49, 0.105, 0.105));
    d = min(d, taper(q, 0.645, 0.67, 0.125, 0.125));
    d = min(d, taper(q, 0.67, 0.77, 0.12, 0.025));
    d = min(d, length(p - vec3(0.0, 0.785, 0.0)) - 0.034);
    return min(d, sdSegment3(p, vec3(0.0, 0.79, 0.0), vec3(0.0, 0.88, 0.0), 0.009));
}

float cottage(vec3 p) {
    float d = sdBox3(p, vec3(0.16, 0.085, 0.115));
    d = min(d, max(sdBox3(p - vec3(0.0, 0.1, 0.0), vec3(0.155, 0.1, 0.115)), 0.7071 * (abs(p.z) + p.y - 0.195)));
    // Recessed windows beside the door
    d = max(d, -sdBox3(vec3(abs(p.x) - 0.095, p.y - 0.005, p.z - 0.12), vec3(0.028, 0.032, 0.02)));
    d = max(d, -sdBox3(p - vec3(0.0, -0.02, 0.12), vec3(0.028, 0.065, 0.018)));
    return d;
}

float roof(vec3 p) {
    vec2 s = vec2(abs(p.z), p.y - 0.2);
    vec2 along = vec2(dot(s, vec2(0.7071, -0.7071)), dot(s, vec2(0.7071)));
    float d = sdBox3(vec3(p.x, along.x - 0.095, along.y), vec3(0.18, 0.105, 0.014));
    d = min(d, sdBox3(p - vec3(-0.1, 0.2, 0.03), vec3(0.026, 0.07, 0.026)));
    return d;
}

float sdf(vec3 p) {
    vec3 t = p - TOWER, c = p - COTTAGE;
    vec2 q = vec2(length(t.xz), t.y);
    float d = min(rock(p), sea(p));
    // The tower's hull is bound enough from afar; the cap keeps the field continuous where the parts take over
    float near = taper(q, -0.7, 0.91, 0.24, 0.24), cap = 0.1 + abs(near - 0.1);
    d = min(d, cap);
    if (near < 0.1) d = min(d, min(tower(t, q), min(min(stone(t, q), iron(t, q)), taper(q, 0.47, 0.66, 0.08, 0.08))));
    near = sdBox3(c - vec3(0.0, 0.09, 0.0), vec3(0.2, 0.2, 0.2)), cap = 0.1 + abs(near - 0.1);
    d = min(d, cap);
    if (near < 0.1) d = min(d, min(cottage(c), roof(c)));
    return d;
}

vec3 albedo(vec3 p, vec3 n) {
    vec3 t = p - TOWER, c = p - COTTAGE;
    vec2 q = vec2(length(t.xz), t.y);
    float a = tower(t, q), b = stone(t, q), i = iron(t, q), lamp = taper(q, 0.47, 0.66, 0.08, 0.08), h = cottage(c), r = roof(c), k = rock(p), s = sea(p);
    float m = min(min(min(a, b), min(i, lamp)), min(min(h, r), min(k, s)));
    if (m == lamp) return vec3(0.85, 0.7, 0.3);
    if (m == i) return vec3(0.3, 0.04, 0.04);
    if (m == b) return vec3(0.45, 0.44, 0.42);
    if (m == a) {
        bool hole = t.z > 0.0 && abs(t.x) < 0.06 && taper(q, -0.7, 0.42, 0.2, 0.115) < -0.004;
        if (hole) return t.y < -0.45 ? vec3(0.16, 0.08, 0.04) : vec3(0.05, 0.07, 0.1);
        return fract((t.y + 0.7) / 0.32) < 0.5 ? vec3(0.8, 0.78, 0.74) : vec3(0.6, 0.06, 0.05);
    }
    if (m == r) return vec3(0.38, 0.14, 0.09);
    if (m == h) {
        if (c.z > 0.09 && c.z < 0.113 && c.y < 0.05) return abs(c.x) < 0.04 ? vec3(0.12, 0.22, 0.16) : vec3(0.06, 0.08, 0.1);
        return vec3(0.78, 0.75, 0.68);
    }
    if (m == k) return mix(vec3(0.26, 0.23, 0.2), vec3(0.2, 0.3, 0.1), smoothstep(0.75, 0.95, n.y) * smoothstep(-0.8, -0.68, p.y));
    return mix(vec3(0.04, 0.16, 0.24), vec3(0.5, 0.6, 0.62), 1.0 - smoothstep(0.0, 0.05, k));
}
