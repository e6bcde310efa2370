// A wooden sloop under main and jib on a round piece of sea; it sails along +x.
#include "lib/flat.glsl"
#include "lib/solids.glsl"
#include "lib/operators.glsl"

const float WATER = -0.62;
const vec3 DECK = vec3(0.0, -0.42, 0.0);

// bound: triangle a, b, c (anticlockwise) as three half planes
float triangle(vec2 p, vec2 a, vec2 b, vec2 c) {
    vec2 u = normalize(b - a), v = normalize(c - b), w = normalize(a - c);
    float d = dot(p - a, vec2(u.y, -u.x));
    d = max(d, dot(p - b, vec2(v.y, -v.x)));
    return max(d, dot(p - c, vec2(w.y, -w.x)));
}

float hull(vec3 q) {
    // A spindle cut along a sheer that rises to bow and stern, hollow above the deck
    vec2 s = vec2(length(vec2(q.z, 0.85 * q.y)), q.x);
    float sheer = 0.95 * (q.y - 0.16 * q.x * q.x);
    float d = max(sdVesica(s, 0.93, 0.7), sheer);
    float hold = max(sdVesica(s, 0.91, 0.71), -0.06 - sheer);
    return opSmoothSubtraction(d, hold, 0.01);
}

float trim(vec3 q) {
    // Rubbing strake along the side and the rudder
    vec2 s = vec2(length(vec2(q.z, 0.85 * q.y)), q.x);
    float sheer = 0.95 * (q.y - 0.16 * q.x * q.x);
    float d = length(vec2(sdVesica(s, 0.93, 0.7), sheer + 0.03)) - 0.013;
    d = min(d, sdRoundBox3(q - vec3(-0.59, -0.06, 0.0), vec3(0.035, 0.14, 0.012), 0.01));
    return min(d, sdSegment3(q, vec3(-0.6, 0.09, 0.0), vec3(-0.36, 0.06, 0.03), 0.012));
}

float cabin(vec3 q) {
    float d = sdRoundBox3(q - vec3(0.12, 0.0, 0.0), vec3(0.17, 0.07, 0.105), 0.025);
    float x = abs(q.x - 0.12) - 0.065;
    d = max(d, -(length(vec2(x, q.y - 0.02)) - 0.022 + max(0.09 - abs(q.z), 0.0)));
    return min(d, sdRoundBox3(q - vec3(0.08, 0.085, 0.0), vec3(0.06, 0.02, 0.055), 0.01));
}

float spars(vec3 q) {
    float d = sdSegment3(q, vec3(0.15, -0.05, 0.0), vec3(0.15, 1.3, 0.0), 0.016);
    d = min(d, sdSegment3(q, vec3(0.15, 0.16, 0.0), vec3(-0.5, 0.17, 0.12), 0.013));
    d = min(d, sdSegment3(q, vec3(0.52, 0.04, 0.0), vec3(0.78, 0.09, 0.0), 0.014));
    // Stays, and shrouds on both sides
    d = min(d, sdSegment3(q, vec3(0.77, 0.09, 0.0), vec3(0.15, 1.22, 0.0), 0.007));
    d = min(d, sdSegment3(vec3(q.xy, abs(q.z)), vec3(0.1, 0.0, 0.2), vec3(0.15, 0.95, 0.0), 0.007));
    return min(d, sdSegment3(q, vec3(-0.6, 0.06, 0.0), vec3(0.15, 1.27, 0.0), 0.007));
}

// Each sail is a piece of a shell that the wind fills towards +z: from mast to boom's end, and from stay to clew.
float mainSail(vec3 q) {
    float shell = abs(length(q.xz - vec2(-0.363, -0.873)) - 1.0) - 0.008;
    return max(shell, triangle(q.xy, vec2(-0.48, 0.2), vec2(0.125, 0.19), vec2(0.125, 1.2)) - 0.012);
}

float jib(vec3 q) {
    float aft = dot(q.xy - vec2(0.77, 0.09), vec2(-0.877, -0.481));
    float shell = abs(length(vec2(aft, q.z) - vec2(0.393, -0.579)) - 0.7) - 0.008;
    return max(shell, triangle(q.xy, vec2(0.22, 0.2), vec2(0.72, 0.15), vec2(0.2, 1.07)) - 0.012);
}

float flag(vec3 q) {
    vec3 f = q - vec3(0.05, 1.27, 0.018 * sin(30.0 * q.x));
    return sdRoundBox3(f, vec3(0.085, 0.04, 0.009), 0.008) * 0.85;
}

float sea(vec3 p) {
    float wave = 0.012 * sin(13.0 * p.x + 2.0 * sin(5.0 * p.z)) * sin(9.0 * p.z + 3.0 * p.x);
    return sdRoundDisc3(vec3(p.x, p.z, p.y - WATER + 0.06 - wave), 0.82, 0.06, 0.03);
}

float sdf(vec3 p) {
    vec3 q = p - DECK;
    float d = min(min(hull(q), trim(q)), min(cabin(q), spars(q)));
    d = min(d, min(min(mainSail(q), jib(q)), flag(q)));
    return min(d, sea(p));
}

vec3 albedo(vec3 p, vec3 n) {
    vec3 q = p - DECK;
    float h = hull(q), t = trim(q), c = cabin(q), s = spars(q), sail = min(mainSail(q), jib(q)), f = flag(q), w = sea(p);
    float m = min(min(min(h, t), min(c, s)), min(min(sail, f), w));
    if (m == w) return mix(vec3(0.03, 0.18, 0.26), vec3(0.55, 0.65, 0.67), 1.0 - smoothstep(0.0, 0.035, h));
    if (m == sail) return fract(q.y * 5.5) < 0.06 ? vec3(0.6, 0.52, 0.4) : vec3(0.8, 0.74, 0.62);
    if (m == f) return vec3(0.65, 0.08, 0.06);
    if (m == s) return vec3(0.42, 0.24, 0.1);
    if (m == t) return vec3(0.5, 0.3, 0.12);
    if (m == c) return n.y > 0.6 ? vec3(0.48, 0.3, 0.15) : (abs(q.z) < 0.103 && q.y > -0.01 && q.y < 0.05 && n.y < 0.9 && abs(abs(q.x - 0.12) - 0.065) < 0.024 ? vec3(0.05, 0.07, 0.1) : vec3(0.75, 0.73, 0.68));
    if (n.y > 0.7) return fract(q.z * 22.0) < 0.12 ? vec3(0.25, 0.13, 0.05) : vec3(0.5, 0.32, 0.16);
    return q.y < -0.12 ? vec3(0.45, 0.07, 0.05) : vec3(0.06, 0.14, 0.32);
}
