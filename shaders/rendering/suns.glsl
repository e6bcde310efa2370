// The discs that were taken out of the light: each by rays through the field, with the penumbra of its size.
// Twin: kernels/sdf/suns.h, with the same constants.
float sdfprt_distance(vec3 p);
vec2 clipToBounds(vec3 o, vec3 d, float cone);
uniform float stepFactor;
uniform float shadowDistance;  // what counts as met, scene units
uniform float shadowLift;      // how far off the surface rays begin
uniform int marchSteps;
uniform int keepLoops;         // 1, see network.glsl
uniform int sunCount;
uniform vec4 sunDirection[MOST_SUNS];  // unit direction in the world; angular radius, negative for a disc that goes in parts
uniform vec3 sunEnergy[MOST_SUNS];     // radiance times solid angle

const float SUN_ONE = 0.6;       // radius of the cone of a disc that does not, of its own: a cone sees an edge from outside only
const float SUN_DARK = 0.02;     // share of the cone's radius below which nothing comes through
const int SUN_PARTS = 7;         // of a disc: the middle and a ring of six, each of a third of its radius
const float SUN_PROBE = 3.0;     // how deep behind a hit the solid is looked at, in radii of the cone there

// How free the cone about a ray is, of its radius: 1 where nothing touches it, 0 where the ray itself is stopped, -1 where the solid
// there is deeper than the cone is wide. `tangent`: its radius at distance 1; nothing lies before `begin`.
float coneFree(vec3 o, vec3 d, float begin, float tangent) {
    float far = clipToBounds(o, d, 0.0).y, t = begin, free = 1.0, near = shadowDistance;
    float ball = 0.0, taken = 0.0;  // of the evaluation before: radius, and the step after it
    bool alive = t + near < far, met = false, deep = false;
    for (int i = 0; i < marchSteps && alive; i++) {
        float r = sdfprt_distance(o + d * t) * stepFactor;
        if (met) {
            deep = r < -tangent * t;
            break;
        }
        if (i == 0 && r > 0.0) near = min(near, 0.5 * r);  // in a crease a ray begins nearer than that
        // Nearest to the ray between the last two balls: where their spheres meet (Aaltonen 2018)
        float back = clamp((r * r - ball * ball + taken * taken) / (2.0 * max(taken, 1e-20)), 0.0, taken);
        float nearest = sqrt(max(r * r - back * back, 0.0)), wide = tangent * max(t - back, 1e-20);
        // Where the balls do not touch, or not enough to say that the cone is free: back to the end of the first
        bool apart = taken > ball && (ball + r < taken || nearest < wide);
        if (!apart) free = min(free, nearest / wide);
        met = !apart && (r < near || free < SUN_DARK);
        // Else as far as the next ball will touch this one if the slope stays (Balint and Valasek 2018), but ball by ball where the
        // cone is touched, so that the nearest place is found
        float slope = taken > 0.0 ? clamp((r - ball) / taken, -1.0, 0.8) : -0.5;
        float ahead = r < 2.0 * wide ? r : min(1.9 * r / (1.0 - slope), max(r, far - near - t));
        t += apart ? ball - taken : met ? SUN_PROBE * tangent * t : ahead;
        taken = apart ? ball : ahead;
        ball = apart ? ball : r;
        alive = met || t < far;
    }
    return deep ? -1.0 : met || alive ? 0.0 : free;  // what is still under way after so many steps grazes a surface
}

// Mean of the clamped cosine over a disc whose middle is at the cosine c, `sine` of its radius.
float discCosine(float c, float sine) {
    float x = c / max(sine, 1e-6);
    if (x >= 1.0) return c;
    if (x <= -1.0) return 0.0;
    float root = sqrt(1.0 - x * x);
    return sine * (x * (0.5 + (asin(x) + x * root) / 3.14159265358979) + root * root * root * 0.212206590789194);
}

// Sums over the discs for a white diffuse surface and for a white lobe of exponent s, at p with normal n, seen along -o.
void sunlight(vec3 p, vec3 n, vec3 o, float s, out vec3 diffuse, out vec3 glossy) {
    diffuse = glossy = vec3(0.0);
    vec3 begin = p + shadowLift * n, mirrored = reflect(-o, n);

    // Empty balls above the point: rays start where they leave the last of those that follow each other
    vec4 height = 2.0 * shadowLift * vec4(1.0, 4.0, 16.0, 64.0), radius = vec4(0.0);
    for (int k = 0; k < 4 * keepLoops; k++) radius[k] = sdfprt_distance(begin + height[k] * n) * stepFactor;

    for (int k = 0; k < sunCount; k++) {
        vec3 w = sunDirection[k].xyz;
        bool whole = sunDirection[k].w > 0.0;
        float angle = abs(sunDirection[k].w), up = discCosine(dot(n, w), sin(angle));
        if (up <= 0.0) continue;

        // The cone of the whole disc; where something touches it, its parts, if it has any
        float tangent = tan(angle), lit = 0.0, all = 0.0;
        vec3 side = normalize(abs(w.x) < 0.7 ? cross(w, vec3(1.0, 0.0, 0.0)) : cross(w, vec3(0.0, 1.0, 0.0)));
        for (int part = 0; part < SUN_PARTS * keepLoops; part++) {
            float turn = 0.26 + 6.28318530717959 * float(part) / float(SUN_PARTS - 1), aside = part == 0 ? 0.0 : 0.666667 * tangent;
            vec3 d = normalize(w + aside * (cos(turn) * side + sin(turn) * cross(w, side)));
            float cosine = dot(n, d);
            if (cosine <= 0.0) continue;
            vec4 along = height * cosine, inside = along * along - height * height + radius * radius;
            vec4 leaves = along + sqrt(max(inside, vec4(0.0))), enters = 2.0 * along - leaves;
            float start = 0.0;
            for (int ball = 0; ball < 4; ball++)
                if (radius[ball] > 0.0 && inside[ball] >= 0.0 && enters[ball] <= start) start = max(start, leaves[ball]);
            float free = coneFree(begin, d, start, part > 0 ? tangent / 3.0 : whole ? SUN_ONE * tangent : tangent);
            all += cosine;
            bool done = part == 0 && (free >= 1.0 || free < 0.0 || whole);
            lit += cosine * max(part == 0 && !done ? min(3.0 * free, 1.0) : free, 0.0);
            if (done) break;
        }
        if (lit <= 0.0) continue;
        float given = up * lit / all, wide = 1.0 / (1.0 + 0.25 * s * angle * angle);
        diffuse += given * 0.318309886183791 * sunEnergy[k];
        // The lobe as wide as it and the disc are together
        float m = max(dot(mirrored, w), 1e-20);
        glossy += given * (s + 2.0) * 0.159154943091895 * wide * pow(m, s * wide) * sunEnergy[k];
    }
}
