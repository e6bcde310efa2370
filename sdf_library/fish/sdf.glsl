// A fish above a sea bed with pebbles and weed, held by a glass rod; it swims along +x.
#include "lib/solids.glsl"
#include "lib/operators.glsl"

float limb(vec3 p, vec3 a, vec3 b, float ra, float rb) {
    vec3 axis = b - a;
    float t = clamp(dot(p - a, axis) / dot(axis, axis), 0.0, 1.0);
    return length(p - a - t * axis) - mix(ra, rb, t);
}

// A fin: a fan of rays from `root`, between angles a and b in the x, y plane, thin along z, its skin between the rays.
float fin(vec3 p, vec2 root, float a, float b, float reach, float rays, float thick) {
    vec2 q = p.xy - root;
    float r = length(q), angle = atan(q.y, q.x), middle = 0.5 * (a + b), spread = 0.5 * (b - a);
    float off = mod(angle - middle + 3.14159265, 6.28318531) - 3.14159265;
    float within = clamp(off / spread, -1.0, 1.0);
    float ripple = cos(within * 3.14159265 * rays) * smoothstep(0.05, 0.6 * reach, r);
    float edge = r - reach * (0.96 + 0.03 * ripple - 0.22 * within * within);
    float side = (abs(off) - spread) * max(r, 0.02);
    float skin = abs(p.z) - thick * (0.75 + 0.3 * ripple) * (1.25 - 0.5 * clamp(r / reach, 0.0, 1.0));
    vec3 w = max(vec3(edge, side, skin), 0.0);
    return (length(w) + min(max(edge, max(side, skin)), 0.0) - 0.008) * 0.75;
}

const vec3 EYE = vec3(0.42, 0.19, 0.105);

float bodyShape(vec3 p) {
    // Deep in front, slender at the root of the tail
    float d = sdEllipsoid3(p - vec3(0.12, 0.1, 0.0), vec3(0.47, 0.26, 0.15));
    d = opSmoothUnion(d, sdEllipsoid3(p - vec3(0.4, 0.1, 0.0), vec3(0.2, 0.155, 0.115)), 0.1);
    return opSmoothUnion(d, limb(p, vec3(-0.2, 0.11, 0.0), vec3(-0.55, 0.13, 0.0), 0.12, 0.05), 0.16);
}

// Scales: rows of shallow bumps over the flank
float scales(vec3 p) {
    float fade = smoothstep(0.3, 0.2, p.x) * smoothstep(-0.5, -0.4, p.x);
    return 0.005 * fade * (0.5 + 0.5 * cos(46.0 * p.x) * cos(46.0 * (p.y - 0.1)));
}

float bodyOnly(vec3 p) {
    vec3 q = vec3(p.xy, abs(p.z));
    float d = bodyShape(p) - scales(p);
    // Gill cover: a raised rim along the flank
    vec2 g = p.xy - vec2(0.5, 0.1);
    float rim = length(vec2(length(g) - 0.225, bodyShape(p))) - 0.014;
    d = opSmoothUnion(d, max(rim, 0.5 * (g.x + 0.08)), 0.025);
    // Mouth: a slit between full lips
    d = opSmoothUnion(d, length(vec2(length(p.yz - vec2(0.07, 0.0)) - 0.04, p.x - 0.575)) - 0.026, 0.03);
    d = opSmoothSubtraction(d, sdEllipsoid3(p - vec3(0.62, 0.07, 0.0), vec3(0.07, 0.022, 0.038)), 0.01);
    // Eye socket
    d = opSmoothUnion(d, length(q - EYE + vec3(0.0, 0.0, 0.012)) - 0.062, 0.02);
    return opSmoothSubtraction(d, length(q - EYE - vec3(0.0, 0.0, 0.035)) - 0.05, 0.01);
}

float fins(vec3 p) {
    vec3 q = vec3(p.xy, abs(p.z));
    float d = fin(p, vec2(-0.5, 0.13), 2.45, 3.84, 0.4, 5.0, 0.02);        // tail
    d = min(d, fin(p, vec2(0.1, 0.1), 0.95, 2.3, 0.46, 6.0, 0.018));        // back
    d = min(d, fin(p, vec2(-0.1, 0.12), 3.75, 4.7, 0.34, 4.0, 0.017));      // belly, behind
    // Pectoral fins stand off the flank
    vec3 f = q - vec3(0.24, 0.04, 0.13);
    f.xz = mat2(0.82, -0.57, 0.57, 0.82) * f.xz;
    return min(d, fin(f, vec2(0.02, 0.0), 2.7, 4.1, 0.24, 4.0, 0.014));
}

float eyeball(vec3 p) { return length(vec3(p.xy, abs(p.z)) - EYE) - 0.05; }

float bed(vec3 p) {
    float d = sdRoundDisc3(vec3(p.x, p.z, p.y + 0.53), 0.85, 0.035, 0.03);
    return opSmoothUnion(d, sdEllipsoid3(p - vec3(-0.1, -0.52, -0.1), vec3(0.6, 0.06, 0.5)), 0.06);
}

float pebbles(vec3 p) {
    float d = 1e3;
    for (int i = 0; i < 7; i++) {
        float a = 0.9 * float(i) + 0.3, r = 0.42 + 0.05 * float(i % 4), s = 0.055 + 0.022 * float(i % 3);
        d = min(d, sdEllipsoid3(p - vec3(r * cos(a) + 0.05, -0.475, r * sin(a)), vec3(1.25, 0.7, 1.0) * s));
    }
    return d;
}

float weed(vec3 p) {
    float d = 1e3;
    for (int i = 0; i < 4; i++) {
        float k = float(i);
        vec3 root = vec3(-0.5 + 0.09 * k, -0.49, -0.35 + 0.12 * sin(2.5 * k));
        float top = 0.32 + 0.1 * sin(1.7 * k + 1.0);
        vec3 middle = root + vec3(0.05 * cos(3.0 * k), 0.5 * top, 0.0), tip = root + vec3(-0.03, top, 0.04 * cos(2.0 * k));
        d = min(d, opSmoothUnion(limb(p, root, middle, 0.024, 0.02), limb(p, middle, tip, 0.02, 0.011), 0.02));
    }
    return d;
}

float rod(vec3 p) { return limb(p, vec3(0.08, -0.5, 0.0), vec3(0.08, -0.1, 0.0), 0.022, 0.016); }

float sdf(vec3 p) {
    float d = min(min(bed(p), pebbles(p)), min(weed(p), rod(p)));
    float near = sdBox3(p - vec3(-0.13, 0.14, 0.0), vec3(0.8, 0.46, 0.34));
    if (near > 0.2) return min(d, near + 0.02);
    return min(d, min(opSmoothUnion(bodyOnly(p), fins(p), 0.03), eyeball(p)));
}

vec3 albedo(vec3 p, vec3 n) {
    float b = bodyOnly(p), f = fins(p), e = eyeball(p), g = bed(p), s = pebbles(p), w = weed(p), r = rod(p);
    float d = min(min(min(b, f), min(e, g)), min(s, min(w, r)));
    if (d == g) return vec3(0.52, 0.45, 0.33);
    if (d == s) return mix(vec3(0.3, 0.28, 0.27), vec3(0.5, 0.42, 0.36), fract(7.0 * p.x * p.z));
    if (d == w) return vec3(0.1, 0.28, 0.1);
    if (d == r) return vec3(0.5);
    if (d == e) {
        float a = length(p.xy - EYE.xy);
        return a < 0.026 ? vec3(0.015) : vec3(0.65, 0.5, 0.12);
    }
    if (d == f) return vec3(0.62, 0.2, 0.05);
    // Orange with two white bands, pale belly
    vec3 c = mix(vec3(0.68, 0.5, 0.36), vec3(0.66, 0.2, 0.03), smoothstep(-0.1, 0.1, p.y));
    float band = min(abs(p.x - 0.2) - 0.045, abs(p.x + 0.22) - 0.04);
    return band < 0.0 ? vec3(0.72, 0.7, 0.66) : band < 0.018 ? vec3(0.06) : c;
}
