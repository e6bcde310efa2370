// A trefoil: a band of turning square section, wound twice around a torus; it stands on a plinth.
#include "lib/solids.glsl"
#include "lib/operators.glsl"

// bound: a rounded square of half size 0.08 at (0.19, 0), turned by the sine and cosine in t
float section(vec2 q, vec2 t) {
    q.x -= 0.19;
    q = abs(vec2(t.y * q.x + t.x * q.y, t.y * q.y - t.x * q.x)) - 0.055;
    return length(max(q, 0.0)) + min(max(q.x, q.y), 0.0) - 0.025;
}

float band(vec3 p) {
    // Two places where the band crosses the half plane of this point, half a turn apart; both turn with the angle
    float a = atan(p.y, p.x), c = cos(1.5 * a), s = sin(1.5 * a);
    vec2 q = vec2(length(p.xy) - 0.46, p.z), turn = vec2(-sin(0.75 * a), cos(0.75 * a));
    q = vec2(c * q.x + s * q.y, c * q.y - s * q.x);
    // Where the band turns about the axis faster than it goes forward, the field is steeper
    float slope = (1.5 * min(length(q), 0.35) + 0.1) / max(length(p.xy), 0.1);
    return min(section(q, turn), section(-q, turn)) * inversesqrt(1.0 + slope * slope);
}
float plinth(vec3 p) {
    float d = sdRoundBox3(p - vec3(0.0, -0.92, 0.0), vec3(0.55, 0.06, 0.4), 0.015);
    return min(d, sdRoundBox3(p - vec3(0.0, -0.78, 0.0), vec3(0.36, 0.09, 0.26), 0.015));
}

float sdf(vec3 p) { return min(band(p - vec3(0.0, 0.02, 0.0)), plinth(p)); }

vec3 albedo(vec3 p, vec3 n) {
    if (plinth(p) < band(p - vec3(0.0, 0.02, 0.0))) return vec3(0.3, 0.29, 0.28);
    float a = atan(p.y - 0.02, p.x);
    return 0.5 * (vec3(0.5, 0.42, 0.32) + vec3(0.5, 0.35, 0.3) * cos(a + vec3(0.3, 1.6, 2.9))) + 0.12;
}
