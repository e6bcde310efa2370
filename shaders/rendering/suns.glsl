// The discs that were taken out of the light: each by a cone through the field, and where that is touched by narrow cones to its parts.
// Twin: kernels/sdf/suns.h, with the same constants.
float sdfprt_distance(vec3 p);
vec2 clipToBounds(vec3 o, vec3 d, float grown);
float sunReach(int k);                 // how far from a surface something may touch the cone to disc k; -1 where it is known to be dark
float sunNearby(int k, float worth);   // share of disc k that points nearby see, or -1 where they do not tell or it is worth more
uniform float stepFactor;
uniform float shadowDistance;  // what counts as met, scene units
uniform float shadowLift;      // how far off the surface rays begin
uniform int marchSteps;
uniform int keepLoops;         // 1, see network.glsl
uniform int sunCount;
uniform vec4 sunDirection[MOST_SUNS];  // unit direction in the world, angular radius
uniform vec3 sunEnergy[MOST_SUNS];     // radiance times solid angle
uniform vec2 sunRough;                 // what a disc gives an open surface: its penumbra is faint below x, fine above y

const float SUN_DARK = 0.08;    // share of the cone's radius below which nothing comes through
const float SUN_PROBE = 3.0;    // how deep behind a hit the solid is looked at, in radii of the cone there
const int SUN_PARTS = 6;        // of a disc whose cone is touched, in a ring about the middle
const float SUN_ASIDE = 0.667;  // radius of the ring, of the disc
const float SUN_PART = 0.3;     // radius of the cone to a part, of the disc: its penumbra is so wide that the parts leave no steps
// A cone sees an edge from outside only, so the mean e over the parts is that of an edge half a part's radius too far in: e + 0.6 e (1 - e)
// is the share of a disc that is as much further out (against 256 thin rays on four scenes, discs of 0.1 radians: 39 to 52 dB for 31 to 43)
const float SUN_BIAS = 0.6;
const float SUN_NARROW = 0.06;  // radius of a disc, radians, below which a rough penumbra is good enough, however bright it is

// Marches the ray from touched.x to touched.y, about which lies a cone to the whole disc with the radius `tangent` at distance 1.
// How free a cone of the radius `own` is: 1 where nothing touches it, 0 where the ray itself is stopped, -1 where the solid there is
// deeper than the whole cone is wide. `first`: 0 at once where something touches it.
// `touched` becomes the part of the ray outside which nothing touches the whole cone.
float coneFree(vec3 o, vec3 d, inout vec2 touched, float tangent, float own, bool first) {
    float far = min(clipToBounds(o, d, 0.0).y, touched.y), t = touched.x, free = 1.0, near = shadowDistance, last = t;
    float ball = 0.0, taken = 0.0;  // of the evaluation before: radius, and the step after it
    bool alive = t + near < far, met = false, deep = false, whole = true;
    for (int i = 0; i < marchSteps && alive; i++) {
        float r = sdfprt_distance(o + d * t) * stepFactor;
        if (met) {
            deep = r < -tangent * t;
            break;
        }
        if (i == 0 && r > 0.0) near = min(near, 0.5 * r);  // in a crease a ray begins nearer than that
        // Nearest to the ray between the last two balls: where their spheres meet (Aaltonen 2018)
        float back = clamp((r * r - ball * ball + taken * taken) / (2.0 * max(taken, 1e-20)), 0.0, taken);
        float nearest = sqrt(max(r * r - back * back, 0.0)), at = max(t - back, 1e-20), wide = own * at;
        // Where the balls do not touch, or not enough to say that the cone is free: back to the end of the first
        bool apart = taken > ball && (ball + r < taken || nearest < wide);
        if (!apart) free = min(free, nearest / wide);
        if (whole && !apart && nearest < tangent * at) {
            whole = false;
            touched.x = max(t - taken + sqrt(max(ball * ball - tangent * tangent * at * at, 0.0)), touched.x);
            if (first) return 0.0;
        }
        met = !apart && (r < near || free < SUN_DARK);
        if (met || nearest < tangent * at) last = t + max(r, 0.0) + tangent * t;
        // Else as far as the next ball will touch this one if the slope stays (Balint and Valasek 2018), but ball by ball where the
        // cone is touched, so that the nearest place is found
        float slope = taken > 0.0 ? clamp((r - ball) / taken, -1.0, 0.8) : -0.5;
        float ahead = r < 2.0 * wide ? r : min(1.9 * r / (1.0 - slope), max(r, far - near - t));
        t += apart ? ball - taken : met ? SUN_PROBE * tangent * t : ahead;
        taken = apart ? ball : ahead;
        ball = apart ? ball : r;
        alive = met || t < far;
    }
    if (!met && !alive) touched.y = min(touched.y, last);
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

// Share of a disc that is seen from `begin`, just above a point with normal n. Balls of `radius` about the places at `height` above the
// point are empty: rays start where they leave the last of those that follow each other. Where the disc gives little (`rough`) and the
// ray to its middle is free, the edge that is nearest to that is taken for the only one; where it gives less (`faint`), all is dark else.
float sunShare(vec3 begin, vec3 n, vec4 height, vec4 radius, vec3 w, float tangent, float reach, bool rough, bool faint) {
    float lit = 0.0, all = 0.0;
    vec3 side = normalize(abs(w.x) < 0.7 ? cross(w, vec3(1.0, 0.0, 0.0)) : cross(w, vec3(0.0, 1.0, 0.0)));
    vec2 touched = vec2(0.0, reach);
    // The cone of the whole disc; where something touches it, its parts
    for (int part = -1; part <= SUN_PARTS * keepLoops; part++) {
        float turn = 0.26 + 6.28318530717959 * float(part) / float(SUN_PARTS), aside = part < 1 ? 0.0 : SUN_ASIDE * tangent;
        vec3 d = normalize(w + aside * (cos(turn) * side + sin(turn) * cross(w, side)));
        float cosine = dot(n, d);
        if (part > 0 && cosine <= 0.0) continue;
        vec4 along = height * cosine, inside = along * along - height * height + radius * radius;
        vec4 leaves = along + sqrt(max(inside, vec4(0.0))), enters = 2.0 * along - leaves;
        float start = 0.0;
        for (int ball = 0; ball < 4; ball++)
            if (radius[ball] > 0.0 && inside[ball] >= 0.0 && enters[ball] <= start) start = max(start, leaves[ball]);
        vec2 range = vec2(max(start, touched.x), touched.y);
        float free = coneFree(begin, d, range, tangent, part < 0 ? tangent : SUN_PART * tangent, part < 0 && !rough);
        if (part < 1) touched = range;
        if (part < 0 && free >= 1.0) return 1.0;
        if (part < 0 && free > 0.0) return 0.5 + (asin(free) + free * sqrt(1.0 - free * free)) / 3.14159265358979;
        if (free < 0.0 || faint) break;
        if (part >= 0 || rough) {
            all += max(cosine, 0.0);
            lit += max(cosine, 0.0) * free;
        }
        if (part < 0 && rough) part = 0;
    }
    float share = lit / max(all, 1e-20);
    return share + SUN_BIAS * share * (1.0 - share);
}

// Sums over the discs `first` to `last` for a white diffuse surface and for a white lobe of exponent s, at p with normal n, seen along
// -o; `shares` of the first four that are seen, -1 below the horizon. At a corner, for others, no disc is worth a fine penumbra.
void sunsBetween(int first, int last, bool corner, vec3 p, vec3 n, vec3 o, float s, out vec3 diffuse, out vec3 glossy, out vec4 shares) {
    diffuse = glossy = vec3(0.0);
    shares = vec4(-1.0);
    vec3 begin = p + shadowLift * n, mirrored = reflect(-o, n);
    vec4 height = 2.0 * shadowLift * vec4(1.0, 4.0, 16.0, 64.0), radius = vec4(0.0);
    int balls = 4 * keepLoops;
    for (int k = first; k < last; k++) {
        vec3 w = sunDirection[k].xyz;
        float angle = sunDirection[k].w, up = discCosine(dot(n, w), sin(angle)), reach = sunReach(k);
        if (up <= 0.0) continue;
        // The lobe as wide as it and the disc are together
        float wide = 1.0 / (1.0 + 0.25 * s * angle * angle);
        float lobe = 0.5 * (s + 2.0) * wide * pow(max(dot(mirrored, w), 1e-20), s * wide);
        float worth = up * max(1.0, lobe) * dot(sunEnergy[k], vec3(0.2126, 0.7152, 0.0722));
        bool rough = corner || angle < SUN_NARROW || worth < sunRough.y;
        float share = reach < 0.0 ? 0.0 : reach == 0.0 ? 1.0 : sunNearby(k, worth);
        if (share < 0.0) {
            for (int ball = 0; ball < balls; ball++) radius[ball] = sdfprt_distance(begin + height[ball] * n) * stepFactor;
            balls = 0;
            share = sunShare(begin, n, height, radius, w, tan(angle), reach, rough, worth < sunRough.x);
        }
        vec3 given = up * share * 0.318309886183791 * sunEnergy[k];
        diffuse += given;
        glossy += given * lobe;
        if (k < first + 4) shares[k - first] = share;
    }
}

// The sums over all discs.
void sunlight(vec3 p, vec3 n, vec3 o, float s, out vec3 diffuse, out vec3 glossy) {
    vec4 shares;
    sunsBetween(0, sunCount, false, p, n, o, s, diffuse, glossy, shares);
}
