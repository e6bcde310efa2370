// An old touring car on a round stand; it looks along +x.
#include "lib/solids.glsl"
#include "lib/operators.glsl"

const float WHEEL = 0.185;      // radius
const vec3 HUB = vec3(0.5, -0.315, 0.31);

// A wheel about z at the origin: tyre, rim, hub and ten spokes.
float tyre(vec3 p) {
    return length(max(abs(vec2(length(p.xy) - WHEEL + 0.03, p.z)) - vec2(0.01, 0.014), 0.0)) - 0.02;
}
float rim(vec3 p) {
    float r = length(p.xy);
    float d = length(max(abs(vec2(r - 0.142, p.z)) - vec2(0.008, 0.022), 0.0)) - 0.006;
    d = min(d, sdRoundDisc3(p, 0.04, 0.04, 0.015));
    vec2 q = opPolar(p.xy, 10.0);
    return min(d, sdSegment3(vec3(q, p.z), vec3(0.03, 0.0, 0.012), vec3(0.14, 0.0, 0.0), 0.0085));
}

// Mudguard: a band over the wheel, a little more than half round.
float guard(vec3 p) {
    float r = length(p.xy), a = atan(p.x, p.y);
    float away = abs(a) - 1.75;
    float ring = abs(r - 0.235) - 0.01;
    float along = away > 0.0 ? r * sin(min(away, 1.5)) : -1.0;
    vec3 w = max(vec3(ring, along, abs(p.z) - 0.07), 0.0);
    return length(w) - 0.008;
}

float body(vec3 q) {
    // Cabin with recessed windows, roof, bonnet with louvres
    float d = sdRoundBox3(q - vec3(-0.24, -0.05, 0.0), vec3(0.35, 0.26, 0.235), 0.05);
    float panes = sdRoundBox3(q - vec3(-0.385, 0.075, 0.26), vec3(0.13, 0.085, 0.05), 0.02);
    panes = min(panes, sdRoundBox3(q - vec3(-0.075, 0.075, 0.26), vec3(0.13, 0.085, 0.05), 0.02));
    panes = min(panes, sdRoundBox3(q - vec3(0.135, 0.085, 0.0), vec3(0.05, 0.08, 0.19), 0.02));
    panes = min(panes, sdRoundBox3(q - vec3(-0.61, 0.09, 0.0), vec3(0.05, 0.06, 0.13), 0.02));
    d = max(d, -panes);
    // Door seams
    d = max(d, -sdBox3(q - vec3(-0.23, -0.08, 0.245), vec3(0.007, 0.2, 0.02)));
    d = min(d, sdRoundBox3(q - vec3(-0.24, 0.215, 0.0), vec3(0.385, 0.03, 0.26), 0.03));
    float bonnet = sdRoundBox3(q - vec3(0.36, -0.13, 0.0), vec3(0.27, 0.13, 0.165), 0.06);
    float x = q.x - 0.36 - 0.055 * clamp(round((q.x - 0.36) / 0.055), -3.0, 3.0);
    bonnet = min(bonnet, sdRoundBox3(vec3(x, q.y + 0.14, q.z - 0.165), vec3(0.014, 0.065, 0.012), 0.01));
    d = opSmoothUnion(d, bonnet, 0.03);
    // Waistline and sills
    d = min(d, sdRoundBox3(q - vec3(-0.24, -0.045, 0.0), vec3(0.36, 0.014, 0.248), 0.012));
    return min(d, sdRoundBox3(q - vec3(-0.02, -0.3, 0.0), vec3(0.64, 0.045, 0.15), 0.02));
}

float chrome(vec3 q) {
    // Radiator: frame, bars, cap
    vec3 g = q - vec3(0.64, -0.12, 0.0);
    float d = max(sdRoundBox3(g, vec3(0.03, 0.155, 0.16), 0.03), -sdBox3(g - vec3(0.03, 0.0, 0.0), vec3(0.022, 0.12, 0.125)));
    float z = g.z - 0.042 * clamp(round(g.z / 0.042), 0.0, 2.0);
    d = min(d, sdSegment3(vec3(g.x, g.y, z), vec3(0.014, -0.12, 0.0), vec3(0.014, 0.12, 0.0), 0.009));
    d = min(d, sdSegment3(g, vec3(0.0, 0.15, 0.0), vec3(0.0, 0.185, 0.0), 0.014));
    d = min(d, length(g - vec3(0.0, 0.2, 0.0)) - 0.024);
    // Head lamps on a bar
    vec3 l = q - vec3(0.63, -0.05, 0.235);
    float lamp = max(sdEllipsoid3(l, vec3(0.085, 0.072, 0.072)), l.x - 0.03);
    lamp = min(lamp, length(vec2(length(l.yz) - 0.064, l.x - 0.03)) - 0.01);
    d = min(d, lamp);
    d = min(d, sdSegment3(q, vec3(0.61, -0.11, 0.0), vec3(0.61, -0.11, 0.235), 0.012));
    // Bumpers and their arms
    vec3 b = vec3(abs(q.x) - 0.78, q.y + 0.3, q.z);
    d = min(d, sdRoundBox3(b, vec3(0.018, 0.03, 0.33), 0.016));
    d = min(d, sdSegment3(b, vec3(0.0, 0.0, 0.12), vec3(-0.2, 0.0, 0.12), 0.016));
    // Door handles
    d = min(d, sdSegment3(q, vec3(-0.19, -0.075, 0.255), vec3(-0.14, -0.075, 0.255), 0.011));
    return d;
}

float ground(vec3 p) { return sdRoundDisc3(vec3(p.x, p.z, p.y + 0.53), 0.97, 0.03, 0.02); }

// The parts' distances: x paint, y chrome and rims, z tyres, w mudguards and boards
vec4 parts(vec3 p) {
    vec3 q = vec3(p.x, p.y, abs(p.z));
    vec3 w = vec3(abs(q.x) - HUB.x, q.yz - HUB.yz);
    vec3 s = vec3(q.z, p.y + 0.08, p.x + 0.645);          // the spare wheel, flat against the back
    float boards = min(guard(w - vec3(0.0, 0.0, 0.015)), sdRoundBox3(q - vec3(0.0, -0.375, 0.325), vec3(0.29, 0.014, 0.07), 0.01));
    return vec4(body(q), min(min(chrome(q), rim(w)), rim(s)), min(tyre(w), tyre(s)), boards);
}

float sdf(vec3 p) {
    // Far from the car its box is bound enough; the cap keeps the field continuous where the parts take over
    float near = sdBox3(p - vec3(0.0, -0.12, 0.0), vec3(0.82, 0.39, 0.42)), cap = 0.15 + abs(near - 0.15);
    float floor = ground(p);
    if (near > 0.15) return min(floor, cap);
    vec4 d = parts(p);
    return min(min(floor, cap), min(min(d.x, d.y), min(d.z, d.w)));
}

vec3 albedo(vec3 p, vec3 n) {
    vec4 d = parts(p);
    float m = min(min(d.x, d.y), min(d.z, d.w));
    if (ground(p) < m) return vec3(0.42, 0.4, 0.37);
    if (m == d.y) return vec3(0.56, 0.57, 0.58);
    if (m == d.z) return vec3(0.06);
    if (m == d.w) return vec3(0.07, 0.08, 0.1);
    vec3 q = vec3(p.x, p.y, abs(p.z));
    bool glass = p.y > -0.005 && p.y < 0.165 && ((q.z < 0.226 && q.z > 0.205 && p.x < 0.06) || (p.x > 0.08 && p.x < 0.105 && q.z < 0.192) || (p.x < -0.555 && p.x > -0.58 && q.z < 0.132));
    if (glass) return vec3(0.1, 0.14, 0.17);
    if (p.y > 0.18) return vec3(0.55, 0.48, 0.36);
    return vec3(0.42, 0.05, 0.045);
}
