// Chess on four by four squares: a white king and pawn against a black rook, bishop and pawn.
#include "lib/solids.glsl"
#include "lib/operators.glsl"

const float BOARD = -0.5;      // height of the squares
const float SQUARE = 0.36;

// bound: cone's trunk between heights y0 and y1, radius r0 below and r1 above; q is radius and height
float taper(vec2 q, float y0, float y1, float r0, float r1) {
    vec2 n = normalize(vec2(y1 - y0, r0 - r1));
    return max(dot(q - vec2(r0, y0), n), max(y0 - q.y, q.y - y1));
}

// A flat ring or disc with a round edge
float collar(vec2 q, float y, float r, float t) { return length(vec2(max(q.x - r, 0.0), q.y - y)) - t; }

// What all the pieces stand on, and their stem up to height h
float foot(vec2 q, float h, float r) {
    float d = min(collar(q, 0.035, r - 0.035, 0.035), collar(q, 0.085, 0.76 * r, 0.02));
    return opSmoothUnion(d, taper(q, 0.08, h, 0.62 * r, 0.36 * r), 0.05);
}

float pawn(vec3 p) {
    vec2 q = vec2(length(p.xz), p.y);
    float d = min(foot(q, 0.3, 0.13), collar(q, 0.3, 0.055, 0.02));
    return min(d, length(q - vec2(0.0, 0.375)) - 0.078);
}

float rook(vec3 p) {
    vec2 q = vec2(length(p.xz), p.y);
    float d = min(foot(q, 0.4, 0.15), collar(q, 0.39, 0.075, 0.022));
    // A turret with a hollow and six battlements
    float turret = max(taper(q, 0.41, 0.55, 0.095, 0.112), -taper(q, 0.49, 0.6, 0.07, 0.07));
    vec2 s = opPolar(p.xz, 6.0);
    turret = max(turret, -sdBox3(vec3(s.x - 0.1, p.y - 0.55, s.y), vec3(0.05, 0.04, 0.019)));
    return min(d, turret);
}

float bishop(vec3 p) {
    vec2 q = vec2(length(p.xz), p.y);
    float d = min(foot(q, 0.46, 0.145), min(collar(q, 0.45, 0.06, 0.02), collar(q, 0.41, 0.045, 0.018)));
    float mitre = sdEllipsoid3(p - vec3(0.0, 0.56, 0.0), vec3(0.082, 0.125, 0.082));
    // A slanted slit
    vec3 c = p - vec3(0.045, 0.62, 0.0);
    mitre = max(mitre, -sdBox3(vec3(0.8 * c.x + 0.6 * c.y, 0.8 * c.y - 0.6 * c.x, c.z), vec3(0.012, 0.075, 0.15)));
    return min(d, min(mitre, length(q - vec2(0.0, 0.7)) - 0.028));
}

float king(vec3 p) {
    vec2 q = vec2(length(p.xz), p.y);
    float d = min(foot(q, 0.62, 0.17), min(collar(q, 0.56, 0.085, 0.02), collar(q, 0.61, 0.065, 0.02)));
    d = min(d, taper(q, 0.61, 0.79, 0.07, 0.115));
    d = min(d, collar(q, 0.795, 0.1, 0.022));
    d = opSmoothUnion(d, sdEllipsoid3(p - vec3(0.0, 0.8, 0.0), vec3(0.09, 0.06, 0.09)), 0.01);
    // The cross
    vec3 c = p - vec3(0.0, 0.94, 0.0);
    d = min(d, sdRoundBox3(c, vec3(0.021, 0.085, 0.021), 0.008));
    return min(d, sdRoundBox3(c - vec3(0.0, 0.02, 0.0), vec3(0.062, 0.021, 0.021), 0.008));
}

vec3 at(vec3 p, float column, float row) { return p - vec3(SQUARE * (column - 1.5), BOARD, SQUARE * (row - 1.5)); }

float white(vec3 p) { return min(king(at(p, 1.0, 1.0)), pawn(at(p, 0.0, 3.0))); }

float black(vec3 p) { return min(rook(at(p, 3.0, 1.0)), min(bishop(at(p, 2.0, 0.0)), pawn(at(p, 2.0, 3.0)))); }

float board(vec3 p) {
    float d = sdRoundBox3(p - vec3(0.0, BOARD - 0.065, 0.0), vec3(0.79, 0.065, 0.79), 0.02);
    // A groove around the squares
    vec2 a = abs(p.xz);
    float groove = length(vec2(max(a.x, a.y) - 0.738, p.y - BOARD)) - 0.012;
    return max(d, -groove);
}

float sdf(vec3 p) {
    // The pieces lie in this box; the cap keeps the field continuous where they take over
    float near = sdBox3(p - vec3(0.0, 0.03, 0.0), vec3(0.74, 0.56, 0.72)), cap = 0.1 + abs(near - 0.1);
    float d = board(p);
    if (near > 0.1) return min(d, cap);
    return min(min(d, cap), min(white(p), black(p)));
}

vec3 albedo(vec3 p, vec3 n) {
    float w = white(p), b = black(p), g = board(p);
    if (w < min(b, g)) return vec3(0.74, 0.62, 0.42);
    if (b < g) return vec3(0.09, 0.05, 0.035);
    vec2 a = abs(p.xz);
    if (max(a.x, a.y) > 0.72 || n.y < 0.7) return vec3(0.22, 0.09, 0.04);
    vec2 c = floor(p.xz / SQUARE);
    return mod(c.x + c.y, 2.0) < 0.5 ? vec3(0.62, 0.48, 0.3) : vec3(0.25, 0.12, 0.06);
}
