// A round temple: fluted columns on steps carry a ring and a ribbed dome over a small altar.
#include "lib/solids.glsl"
#include "lib/operators.glsl"

// exact: ring or disc about y, its section a box of half sizes b around radius r and height h
float ring(vec3 p, float r, float h, vec2 b, float e) {
    vec2 q = abs(vec2(length(p.xz) - r, p.y - h)) - b + e;
    return min(max(q.x, q.y), 0.0) + length(max(q, 0.0)) - e;
}

float steps(vec3 p) {
    float d = ring(p, 0.0, -0.71, vec2(0.86, 0.04), 0.01);
    d = min(d, ring(p, 0.0, -0.64, vec2(0.78, 0.04), 0.01));
    return min(d, ring(p, 0.0, -0.57, vec2(0.7, 0.04), 0.01));
}

float columns(vec3 p) {
    vec2 around = opPolar(p.xz, 10.0) - vec2(0.56, 0.0);
    vec3 q = vec3(around.x, p.y, around.y);
    // Base and capital: a cushion and a slab each
    vec3 mirrored = vec3(q.x, abs(q.y + 0.12), q.z);
    float d = sdRoundBox3(mirrored - vec3(0.0, 0.4, 0.0), vec3(0.088, 0.022, 0.088), 0.006);
    d = min(d, ring(mirrored, 0.045, 0.362, vec2(0.03, 0.02), 0.018));
    if (length(around) > 0.25) return min(d, length(around) - 0.1);
    // Shaft: slender towards the top, with flutes
    vec2 flute = opPolar(around, 10.0) - vec2(0.068 - 0.012 * (q.y + 0.5), 0.0);
    float shaft = length(around) - 0.064 + 0.012 * (q.y + 0.5);
    shaft = max(opSmoothSubtraction(shaft, length(flute) - 0.015, 0.008), mirrored.y - 0.37);
    return min(d, shaft);
}

float roof(vec3 p) {
    float d = ring(p, 0.56, 0.35, vec2(0.1, 0.05), 0.01);
    d = min(d, ring(p, 0.57, 0.425, vec2(0.15, 0.024), 0.012));
    // Small blocks under the cornice
    vec2 t = opPolar(p.xz, 40.0) - vec2(0.675, 0.0);
    d = min(d, sdRoundBox3(vec3(t.x, p.y - 0.385, t.y), vec3(0.03, 0.022, 0.024), 0.005));
    // Dome, hollow, with ribs and a lantern
    vec3 c = p - vec3(0.0, 0.32, 0.0);
    float dome = max(abs(length(c) - 0.57) - 0.03, 0.1 - c.y);
    vec2 rib = opPolar(p.xz, 20.0);
    dome = opSmoothUnion(dome, max(length(vec2(length(vec2(rib.x, c.y)) - 0.6, rib.y)) - 0.016, 0.12 - c.y), 0.015);
    d = min(d, max(dome, 0.09 - length(p.xz)));
    d = min(d, ring(p, 0.1, 0.915, vec2(0.025, 0.03), 0.012));
    return d;
}

float altar(vec3 p) {
    float d = sdRoundBox3(p - vec3(0.0, -0.37, 0.0), vec3(0.1, 0.15, 0.1), 0.015);
    d = min(d, sdRoundBox3(p - vec3(0.0, -0.21, 0.0), vec3(0.14, 0.025, 0.14), 0.012));
    return min(d, length(p - vec3(0.0, -0.07, 0.0)) - 0.12);
}

float sdf(vec3 p) { return min(min(steps(p), columns(p)), min(roof(p), altar(p))); }

vec3 albedo(vec3 p, vec3 n) {
    if (length(p - vec3(0.0, -0.07, 0.0)) < 0.125) return vec3(0.65, 0.42, 0.1);
    if (p.y > 0.45) return mix(vec3(0.24, 0.42, 0.37), vec3(0.32, 0.5, 0.42), 0.5 + 0.5 * n.y);
    return p.y < -0.52 ? vec3(0.55, 0.5, 0.43) : vec3(0.68, 0.64, 0.55);
}
