// A ball carved into a gyroid, a smaller golden ball inside, on a turned foot.
#include "lib/operators.glsl"
#include "lib/solids.glsl"

float lattice(vec3 p) {
    vec3 q = 9.0 * (p - vec3(0.0, 0.12, 0.0));
    float field = dot(sin(q), cos(q.yzx));
    float wall = (abs(field) - 0.42) / 16.0;                 // the gradient of the field stays under 16
    float r = length(p - vec3(0.0, 0.12, 0.0));
    return opSmoothIntersection(wall, max(r - 0.72, 0.5 - r), 0.02);
}
float core(vec3 p) { return length(p - vec3(0.0, 0.12, 0.0)) - 0.36; }
float foot(vec3 p) {
    vec3 q = vec3(p.x, p.z, p.y);
    float d = sdRoundDisc3(q + vec3(0.0, 0.0, 0.82), 0.5, 0.05, 0.03);
    d = opSmoothUnion(d, sdRoundDisc3(q + vec3(0.0, 0.0, 0.72), 0.26, 0.08, 0.03), 0.08);
    return max(d, 0.735 - length(p - vec3(0.0, 0.12, 0.0)));
}

float sdf(vec3 p) { return min(min(lattice(p), core(p)), foot(p)); }

vec3 albedo(vec3 p, vec3 n) {
    float l = lattice(p), c = core(p), f = foot(p);
    if (f < min(l, c)) return vec3(0.14, 0.12, 0.11);
    if (c < l) return vec3(0.7, 0.42, 0.08);
    vec3 q = 9.0 * (p - vec3(0.0, 0.12, 0.0));
    return dot(sin(q), cos(q.yzx)) > 0.0 ? vec3(0.12, 0.36, 0.5) : vec3(0.66, 0.66, 0.62);
}
