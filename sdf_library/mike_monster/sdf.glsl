// A round monster with one eye, small horns, a grin, long arms, clawed feet and a tail with a club.
#include "lib/solids.glsl"
#include "lib/operators.glsl"

const vec3 EYE = vec3(0.0, 0.16, 0.3);

float limb(vec3 p, vec3 a, vec3 b, float ra, float rb) {
    vec3 axis = b - a;
    float t = clamp(dot(p - a, axis) / dot(axis, axis), 0.0, 1.0);
    return length(p - a - t * axis) - mix(ra, rb, t);
}

float skin(vec3 p) {
    vec3 q = vec3(abs(p.x), p.y, p.z);
    // Body, a little wider below
    float d = opSmoothUnion(length(p - vec3(0.0, 0.1, 0.0)) - 0.4, length(p - vec3(0.0, -0.04, 0.0)) - 0.39, 0.1);
    // Lids: a bulge around the eye
    float lid = max(length(p - EYE) - 0.2, -(length(p - EYE - vec3(0.0, -0.015, 0.1)) - 0.19));
    d = opSmoothUnion(d, lid, 0.04);
    d = opSmoothSubtraction(d, length(p - EYE) - 0.168, 0.02);
    // The grin: a curved groove, wide and open
    vec3 m = p - vec3(0.0, -0.03, 0.36);
    float grin = length(vec2(length(m.xy - vec2(0.0, 0.2)) - 0.29, m.z)) - 0.075;
    grin = max(grin, m.y + 0.035 + 0.25 * m.x * m.x);
    d = opSmoothSubtraction(d, grin, 0.02);
    // Arms: shoulder, elbow, hand with three fingers and a thumb
    vec3 shoulder = vec3(0.37, 0.06, 0.0), elbow = vec3(0.57, -0.14, 0.06), hand = vec3(0.55, -0.34, 0.2);
    float arm = opSmoothUnion(limb(q, shoulder, elbow, 0.05, 0.042), limb(q, elbow, hand, 0.042, 0.036), 0.03);
    arm = opSmoothUnion(arm, length(q - hand) - 0.06, 0.03);
    for (int i = 0; i < 3; i++) {
        float s = float(i) - 1.0;
        vec3 knuckle = hand + vec3(0.035 * s, -0.05, 0.03), tip = hand + vec3(0.055 * s, -0.115, 0.055);
        arm = opSmoothUnion(arm, limb(q, knuckle, tip, 0.024, 0.019), 0.015);
    }
    arm = opSmoothUnion(arm, limb(q, hand, hand + vec3(-0.085, -0.03, 0.02), 0.028, 0.02), 0.02);
    d = opSmoothUnion(d, arm, 0.06);
    // Legs and broad feet
    float leg = limb(q, vec3(0.17, -0.35, 0.0), vec3(0.2, -0.72, 0.0), 0.075, 0.055);
    leg = opSmoothUnion(leg, sdEllipsoid3(q - vec3(0.22, -0.78, 0.08), vec3(0.1, 0.06, 0.16)), 0.06);
    for (int i = 0; i < 3; i++) {
        float s = float(i) - 1.0;
        leg = opSmoothUnion(leg, length(q - vec3(0.22 + 0.062 * s, -0.79, 0.22 - 0.02 * abs(s))) - 0.045, 0.02);
    }
    d = opSmoothUnion(d, leg, 0.07);
    // Tail, its club turned up
    float tail = opSmoothUnion(limb(p, vec3(0.0, -0.26, -0.3), vec3(0.0, -0.42, -0.5), 0.07, 0.045), limb(p, vec3(0.0, -0.42, -0.5), vec3(0.0, -0.3, -0.62), 0.045, 0.035), 0.04);
    return opSmoothUnion(d, opSmoothUnion(tail, length(p - vec3(0.0, -0.25, -0.64)) - 0.07, 0.03), 0.06);
}

// Spots on the back and the sides, as cones from the middle of the body
float spots(vec3 p) {
    vec3 v = normalize(vec3(abs(p.x), p.y, p.z));
    float d = acos(dot(v, normalize(vec3(0.25, 0.75, -0.6)))) - 0.2;
    d = min(d, acos(dot(v, normalize(vec3(0.55, 0.35, -0.75)))) - 0.15);
    d = min(d, acos(dot(v, normalize(vec3(0.2, 0.15, -1.0)))) - 0.13);
    d = min(d, acos(dot(v, normalize(vec3(0.75, 0.7, 0.05)))) - 0.13);
    return min(d, acos(dot(v, normalize(vec3(0.9, 0.3, -0.35)))) - 0.11);
}

float horns(vec3 p) {
    vec3 q = vec3(abs(p.x), p.y, p.z);
    float d = limb(q, vec3(0.2, 0.42, 0.0), vec3(0.275, 0.54, 0.0), 0.07, 0.042);
    return opSmoothUnion(d, limb(q, vec3(0.275, 0.54, 0.0), vec3(0.29, 0.63, 0.03), 0.04, 0.014), 0.03);
}

float claws(vec3 p) {
    vec3 q = vec3(abs(p.x), p.y, p.z);
    float d = 1e3;
    for (int i = 0; i < 3; i++) {
        float s = float(i) - 1.0;
        vec3 toe = vec3(0.22 + 0.062 * s, -0.79, 0.255 - 0.02 * abs(s));
        d = min(d, limb(q, toe, toe + vec3(0.012 * s, -0.018, 0.045), 0.024, 0.012));
    }
    return d;
}

float teeth(vec3 p) {
    // A row along the lower lip, bent with the grin
    vec3 q = vec3(abs(p.x), p.y, p.z);
    float d = 1e3;
    for (int i = 0; i < 4; i++) {
        float a = 0.17 + 0.24 * float(i);
        vec3 root = vec3(0.29 * sin(a), 0.17 - 0.3 * cos(a) - 0.035, 0.375 - 0.13 * a * a);
        d = min(d, limb(q, root, root + vec3(-0.004, 0.045, 0.012), 0.024, 0.011));
    }
    return d;
}

float eye(vec3 p) {
    float d = length(p - EYE) - 0.165;
    return min(d, sdEllipsoid3(p - EYE - vec3(0.0, 0.0, 0.125), vec3(0.085, 0.085, 0.055)));
}

float ground(vec3 p) { return sdRoundDisc3(vec3(p.x, p.z, p.y + 0.87), 0.75, 0.03, 0.02); }

float sdf(vec3 p) {
    // Far from the monster its box is bound enough; the cap keeps the field continuous where the parts take over
    float near = sdBox3(p - vec3(0.0, -0.1, -0.12), vec3(0.68, 0.78, 0.62)), cap = 0.1 + abs(near - 0.1);
    float floor = ground(p);
    if (near > 0.1) return min(floor, cap);
    float d = min(min(skin(p), horns(p)), min(eye(p), min(teeth(p), claws(p))));
    return min(d, min(floor, cap));
}

vec3 albedo(vec3 p, vec3 n) {
    float s = skin(p), bone = min(min(horns(p), teeth(p)), claws(p)), e = eye(p), g = ground(p);
    if (g < min(min(s, bone), e)) return vec3(0.43, 0.4, 0.38);
    if (bone < min(s, e)) return vec3(0.62, 0.56, 0.42);
    if (e < s) {
        vec3 v = normalize(p - EYE);
        float a = length(v.xy);
        if (v.z > 0.0 && a < 0.24) return vec3(0.02);
        if (v.z > 0.0 && a < 0.5) return mix(vec3(0.6, 0.3, 0.04), vec3(0.75, 0.5, 0.08), step(0.36, a));
        return vec3(0.75, 0.74, 0.7);
    }
    vec3 m = p - vec3(0.0, -0.03, 0.36);
    if (abs(length(m.xy - vec2(0.0, 0.2)) - 0.29) < 0.07 && m.y < -0.03 && p.z > 0.15 && length(p - vec3(0.0, 0.03, 0.0)) < 0.405)
        return vec3(0.25, 0.04, 0.05);
    // Violet, pale below the grin, spotted behind
    vec3 coat = mix(vec3(0.2, 0.09, 0.38), vec3(0.34, 0.16, 0.52), smoothstep(-0.4, 0.4, p.y));
    float belly = length(p.xy - vec2(0.0, -0.36)) - 0.2 + 0.4 * max(0.2 - p.z, 0.0);
    if (p.z > 0.0 && p.y > -0.45) coat = mix(vec3(0.52, 0.36, 0.5), coat, smoothstep(-0.02, 0.02, belly));
    if (abs(p.x) < 0.45 && p.y > -0.4) coat = mix(vec3(0.1, 0.3, 0.36), coat, smoothstep(-0.01, 0.01, spots(p - vec3(0.0, 0.05, 0.0))));
    return coat;
}
