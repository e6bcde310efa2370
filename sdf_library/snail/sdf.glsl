// A snail on a stone: the shell is a tube whose axis is a logarithmic spiral, drawn out to a cone; the head looks to +x.
#include "lib/solids.glsl"
#include "lib/operators.glsl"

const float GROWTH = 0.165;               // of the logarithm of the radius, a radian
const float MOUTH = 0.36;                 // radius of the spiral at the shell's mouth
const float TUBE = 0.5;                   // radius of the tube, of the spiral's
const float LEAN = 0.62;                  // how far the axis of the cone rises, of the spiral's radius
const vec3 SHELL = vec3(-0.15, 0.06, -0.1);
const float GROUND = -0.5;

// A stroke whose radius runs from ra to rb.
float stroke(vec3 p, vec3 a, vec3 b, float ra, float rb) {
    vec3 axis = b - a;
    float t = clamp(dot(p - a, axis) / dot(axis, axis), 0.0, 1.0);
    return length(p - a - t * axis) - mix(ra, rb, t);
}

// In the shell's plane: the mouth lies at angle pi, angles grow towards it, over the back and the top.
vec3 coil(vec3 p) {
    vec3 q = p - SHELL;
    q.yz = mat2(0.97, -0.243, 0.243, 0.97) * q.yz;
    const vec2 e = vec2(-0.342, 0.94);    // against the mouth
    return vec3(dot(e, q.xy), e.y * q.x - e.x * q.y, q.z);
}

// Distance to the nearest turn, its spiral's radius, and the angle around the tube.
vec3 whorl(vec3 q) {
    float r = length(q.xy), radius = MOUTH * exp(GROWTH * (atan(q.y, q.x) - 3.14159265));
    vec3 nearest = vec3(1e3, 0.0, 0.0);
    for (int turn = 0; turn < 4; turn++) {
        vec2 across = vec2(r - radius, q.z - LEAN * (MOUTH - radius));
        float lines = 0.012 * radius * cos(150.0 * log(radius));
        float d = length(across) - TUBE * radius - lines;
        if (d < nearest.x) nearest = vec3(d, radius, atan(across.y, across.x));
        radius *= 0.35461;                // exp(-2 pi GROWTH)
    }
    return nearest;
}

float shell(vec3 p) {
    vec3 q = coil(p);
    // The last turn ends in a disc, thicker than the tube: beyond it the whorl knows nothing of the mouth
    float d = 0.92 * whorl(q).x;
    return opSmoothUnion(d, sdRoundDisc3((q + vec3(MOUTH, 0.0, 0.0)).xzy, 0.2, 0.03, 0.028), 0.02);
}

float flesh(vec3 p) {
    // The foot, flat below, with a wavy hem; neck and head
    vec3 w = vec3(p.x, (p.y - GROUND) * 1.25, p.z * (0.8 + 0.06 * cos(15.0 * p.x)));
    float foot = stroke(w, vec3(-0.84, 0.0, 0.0), vec3(-0.25, 0.03, 0.0), 0.015, 0.125);
    foot = opSmoothUnion(foot, stroke(w, vec3(-0.25, 0.03, 0.0), vec3(0.5, 0.03, 0.0), 0.125, 0.12), 0.05);
    foot = 0.8 * foot;
    float d = opSmoothUnion(foot, stroke(p, vec3(-0.1, -0.33, 0.0), vec3(0.4, -0.33, 0.0), 0.12, 0.115), 0.1);
    d = opSmoothUnion(d, stroke(p, vec3(0.36, -0.34, 0.0), vec3(0.62, -0.09, 0.0), 0.115, 0.085), 0.1);
    d = opSmoothUnion(d, stroke(p, vec3(0.62, -0.09, 0.0), vec3(0.72, -0.12, 0.0), 0.085, 0.066), 0.04);
    // Wrinkles
    d -= 0.0045 * cos(52.0 * p.x + 9.0 * p.y) * cos(46.0 * p.y + 14.0 * p.x) * cos(44.0 * p.z);
    // Long horns and short ones
    vec3 q = vec3(p.xy, abs(p.z));
    d = opSmoothUnion(d, stroke(q, vec3(0.63, -0.05, 0.035), vec3(0.76, 0.27, 0.14), 0.03, 0.018), 0.04);
    d = opSmoothUnion(d, stroke(q, vec3(0.72, -0.15, 0.035), vec3(0.83, -0.22, 0.07), 0.022, 0.015), 0.03);
    return max(d, GROUND - 0.01 - p.y);
}

float eyes(vec3 p) { return length(vec3(p.xy, abs(p.z)) - vec3(0.764, 0.283, 0.144)) - 0.033; }

float stone(vec3 p) {
    vec3 w = p - vec3(0.0, GROUND - 0.12, 0.0);
    float d = sdRoundDisc3(w.xzy, 0.9, 0.11, 0.09);
    return d - 0.012 * cos(5.0 * p.x + 2.0 * p.z) * cos(6.0 * p.z - p.x) * smoothstep(0.02, -0.1, w.y);
}

float pebbles(vec3 p) {
    float d = sdEllipsoid3(p - vec3(0.5, GROUND + 0.02, 0.42), vec3(0.13, 0.07, 0.1));
    d = min(d, sdEllipsoid3(p - vec3(0.3, GROUND + 0.01, 0.56), vec3(0.07, 0.045, 0.06)));
    return min(d, sdEllipsoid3(p - vec3(-0.55, GROUND + 0.02, -0.46), vec3(0.16, 0.09, 0.12)));
}

// A clover: three leaves on a bent stalk each.
float clover(vec3 p, vec3 foot, float size) {
    vec3 q = (p - foot) / size;
    float d = stroke(q, vec3(0.0), vec3(0.0, 0.8, 0.0), 0.035, 0.025);
    q -= vec3(0.0, 0.82, 0.0);
    q.xz = opPolar(q.xz, 3.0);
    float x = min(q.x, 0.65);             // bent no further than the leaf reaches
    q.y -= 0.35 * x * x;
    float leaf = sdRoundDisc3(vec3(q.x - 0.3, abs(q.z) - 0.11, q.y), 0.22, 0.03, 0.025);
    return 0.85 * size * min(d, leaf);
}

float plants(vec3 p) {
    float d = clover(p, vec3(-0.6, GROUND, 0.38), 0.26);
    d = min(d, clover(p, vec3(-0.38, GROUND, 0.58), 0.19));
    return min(d, clover(p, vec3(0.22, GROUND, -0.6), 0.24));
}

float sdf(vec3 p) {
    float d = min(shell(p), min(flesh(p), eyes(p)));
    return min(d, min(stone(p), min(pebbles(p), plants(p))));
}

vec3 albedo(vec3 p, vec3 n) {
    float body = flesh(p), house = shell(p), rest = min(stone(p), min(pebbles(p), plants(p)));
    if (eyes(p) < min(body, rest)) return vec3(0.03);
    if (house < min(body, rest)) {
        vec3 w = whorl(coil(p));
        float band = smoothstep(0.35, 0.5, w.z) * smoothstep(1.25, 1.1, w.z);
        band = max(band, smoothstep(-1.3, -1.15, w.z) * smoothstep(-0.5, -0.65, w.z));
        vec3 light = mix(vec3(0.62, 0.3, 0.1), vec3(0.82, 0.6, 0.3), smoothstep(0.04, 0.3, w.y));
        return mix(light, vec3(0.24, 0.08, 0.025), 0.85 * band);
    }
    if (body < rest) return mix(vec3(0.5, 0.43, 0.27), vec3(0.3, 0.26, 0.18), smoothstep(-0.4, -0.1, p.y) * smoothstep(0.3, 0.8, n.y));
    if (plants(p) <= rest) return vec3(0.1, 0.34, 0.06);
    if (pebbles(p) <= rest) return vec3(0.42, 0.4, 0.37);
    return mix(vec3(0.36, 0.35, 0.33), vec3(0.2, 0.3, 0.1), smoothstep(0.7, 0.95, n.y));
}

float exponent(vec3 p, vec3 n) {
    float wet = min(eyes(p), shell(p));
    return wet < min(flesh(p), min(stone(p), min(pebbles(p), plants(p)))) ? 64.0 : 12.0;
}
