// A wind-up tin robot on a round stand; it faces +z.
#include "lib/solids.glsl"
#include "lib/operators.glsl"

// A ribbed hose from a to b: a stroke whose radius swells and shrinks along it.
float hose(vec3 p, vec3 a, vec3 b, float r, float ribs) {
    vec3 axis = b - a;
    float t = clamp(dot(p - a, axis) / dot(axis, axis), 0.0, 1.0);
    return 0.65 * (length(p - a - t * axis) - r - 0.007 * cos(6.28318531 * ribs * t));
}

float plates(vec3 p, vec3 q) {
    // Chest with a panel let in, pelvis, head, feet
    float d = sdRoundBox3(p - vec3(0.0, 0.03, 0.0), vec3(0.27, 0.25, 0.19), 0.05);
    d = max(d, -sdRoundBox3(p - vec3(0.0, 0.05, 0.2), vec3(0.19, 0.16, 0.03), 0.02));
    d = min(d, sdRoundBox3(p - vec3(0.0, -0.28, 0.0), vec3(0.2, 0.065, 0.14), 0.03));
    float head = sdRoundBox3(p - vec3(0.0, 0.5, 0.0), vec3(0.21, 0.155, 0.165), 0.05);
    head = max(head, -sdRoundBox3(p - vec3(0.0, 0.4, 0.17), vec3(0.125, 0.034, 0.035), 0.015));
    d = min(d, head);
    return min(d, sdRoundBox3(q - vec3(0.14, -0.75, 0.05), vec3(0.105, 0.075, 0.17), 0.05));
}

float steel(vec3 p, vec3 q) {
    // Neck, shoulders, arms, legs
    float d = hose(p, vec3(0.0, 0.26, 0.0), vec3(0.0, 0.37, 0.0), 0.075, 3.0);
    d = min(d, length(q - vec3(0.29, 0.17, 0.0)) - 0.08);
    d = min(d, hose(q, vec3(0.31, 0.15, 0.0), vec3(0.46, -0.06, 0.02), 0.046, 7.0));
    d = min(d, length(q - vec3(0.465, -0.07, 0.02)) - 0.058);
    d = min(d, hose(q, vec3(0.46, -0.08, 0.03), vec3(0.45, -0.26, 0.17), 0.046, 6.0));
    d = min(d, hose(q, vec3(0.13, -0.33, 0.0), vec3(0.14, -0.7, 0.0), 0.062, 9.0));
    // Claws: half a ring, opening forwards and down
    vec3 h = q - vec3(0.445, -0.35, 0.24);
    float claw = sdCappedTorus3(vec3(h.x, dot(h.yz, vec2(0.79, -0.61)), dot(h.yz, vec2(0.61, 0.79))), vec2(0.64, -0.77), 0.075, 0.026);
    d = min(d, claw);
    d = min(d, sdSegment3(q, vec3(0.45, -0.26, 0.17), vec3(0.447, -0.29, 0.19), 0.05));
    // Ears and aerial, teeth of the grille
    d = min(d, sdRoundDisc3((q - vec3(0.22, 0.5, 0.0)).zyx, 0.065, 0.035, 0.015));
    d = min(d, sdSegment3(p, vec3(0.0, 0.64, 0.0), vec3(0.0, 0.8, 0.0), 0.013));
    float x = p.x - clamp(round(p.x / 0.05), -2.0, 2.0) * 0.05;
    d = min(d, sdSegment3(vec3(x, p.y, p.z), vec3(0.0, 0.375, 0.15), vec3(0.0, 0.425, 0.15), 0.011));
    // The key: a shaft with two rings
    d = min(d, sdSegment3(p, vec3(0.0, 0.05, -0.18), vec3(0.0, 0.05, -0.34), 0.024));
    vec3 k = vec3(q.x - 0.085, p.y - 0.05, p.z + 0.37);
    return min(d, length(vec2(length(k.xy) - 0.065, k.z)) - 0.024);
}

float lamps(vec3 p, vec3 q) {
    // Eyes, aerial's ball, three buttons
    float d = sdEllipsoid3(q - vec3(0.09, 0.545, 0.16), vec3(0.055, 0.055, 0.035));
    d = min(d, length(p - vec3(0.0, 0.82, 0.0)) - 0.045);
    float x = p.x - clamp(round(p.x / 0.1), -1.0, 1.0) * 0.1;
    return min(d, sdEllipsoid3(vec3(x, p.y + 0.06, p.z - 0.17), vec3(0.03, 0.03, 0.025)));
}

float dial(vec3 p) {
    vec3 g = p - vec3(0.0, 0.1, 0.17);
    return min(length(vec2(length(g.xy) - 0.085, g.z)) - 0.016, sdRoundDisc3(g, 0.085, 0.008, 0.004));
}

float rims(vec3 q) { return length(vec2(length(q.xy - vec2(0.09, 0.545)) - 0.06, q.z - 0.165)) - 0.015; }

float ground(vec3 p) { return sdRoundDisc3(vec3(p.x, p.z, p.y + 0.86), 0.66, 0.04, 0.025); }

float sdf(vec3 p) {
    vec3 q = vec3(abs(p.x), p.y, p.z);
    // Far from the robot its box is bound enough; the cap keeps the field continuous where the parts take over
    float near = sdBox3(p - vec3(0.0, 0.02, -0.07), vec3(0.56, 0.88, 0.42)), cap = 0.1 + abs(near - 0.1);
    float floor = ground(p);
    if (near > 0.1) return min(floor, cap);
    float d = min(min(plates(p, q), steel(p, q)), min(lamps(p, q), min(dial(p), rims(q))));
    return min(d, min(floor, cap));
}

vec3 albedo(vec3 p, vec3 n) {
    vec3 q = vec3(abs(p.x), p.y, p.z);
    float a = plates(p, q), s = steel(p, q), l = lamps(p, q), d = dial(p), r = rims(q), g = ground(p);
    float m = min(min(min(a, s), min(l, d)), min(r, g));
    if (m == g) return vec3(0.42, 0.4, 0.37);
    if (m == s || m == r) return vec3(0.5, 0.5, 0.52);
    if (m == l) {
        if (p.y > 0.7) return vec3(0.7, 0.08, 0.05);
        if (p.y > 0.4) return length(q.xy - vec2(0.09, 0.545)) < 0.022 ? vec3(0.03) : vec3(0.8, 0.72, 0.35);
        return p.x < -0.05 ? vec3(0.65, 0.08, 0.05) : (p.x < 0.05 ? vec3(0.75, 0.5, 0.08) : vec3(0.1, 0.45, 0.15));
    }
    if (m == d) {
        vec2 v = p.xy - vec2(0.0, 0.1);
        if (length(v) > 0.071) return vec3(0.5, 0.42, 0.25);
        if (abs(dot(v, vec2(0.8, 0.6))) < 0.007 && dot(v, vec2(-0.6, 0.8)) > -0.01) return vec3(0.6, 0.05, 0.04);
        float tick = abs(fract(atan(v.y, v.x) * 12.0 / 6.28318531) - 0.5);
        return length(v) > 0.05 && tick > 0.4 ? vec3(0.05) : vec3(0.8, 0.78, 0.7);
    }
    // Paint: teal chest and head, warm panel, red feet and pelvis
    if (p.y < -0.55 || (p.y < -0.2 && p.y > -0.36)) return vec3(0.5, 0.09, 0.05);
    if (p.z > 0.16 && p.z < 0.185 && abs(p.x) < 0.185 && p.y < 0.21) return vec3(0.65, 0.52, 0.3);
    if (p.y > 0.36 && p.y < 0.44 && p.z < 0.15 && p.z > 0.12 && q.x < 0.12) return vec3(0.04);
    return vec3(0.08, 0.32, 0.36);
}
