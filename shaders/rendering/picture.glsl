// One pass for browsers: trace, network, light and what is behind; then exposure, tone curve and sRGB as sdfprt/imaging/tone.py has them.
vec3 viewOrigin();
vec3 viewRay(vec2 at);
float footprint();
float march(vec3 o, vec3 d, float width, float begin, float cone);
vec3 surfaceNormal(vec3 p);
void network(vec3 p[POINTS], vec3 n[POINTS], out vec4 transfer[POINTS * NETWORK_OUTPUTS]);
vec3 shade(vec3 n, vec3 o, vec4 transfer[OUTPUTS], vec3 base, float s);
vec3 sunShade(vec3 base, vec3 diffuse, vec3 glossy);
#if TRANSFERS > 1
vec3 recoloured(vec3 base);
vec3 bouncedLight(int b, vec4 more[OUTPUTS]);
vec3 bouncedShade(vec3 n, vec3 o, vec4 transfer[OUTPUTS], vec3 arriving, vec3 base, float s);
#endif
void sunlight(vec3 p, vec3 n, vec3 o, float s, out vec3 diffuse, out vec3 glossy);
#ifdef HAS_ALBEDO
vec3 albedo(vec3 p, vec3 n);
#endif
#ifdef HAS_EXPONENT
float exponent(vec3 p, vec3 n);
#endif
#ifdef ENVIRONMENT_MAP
vec2 latlong(vec3 d);
uniform sampler2D environment;  // wraps in u
uniform mat3 toMap;             // world to map
#else
void weightedBasis(vec3 d, float weights[RESULT_BANDS], out float y[4 * RESULTS]);
uniform vec3 skyCoefficients[LIGHT_COUNT];
#endif
vec4 viewport;                  // camera.glsl's: not a uniform here but the canvas in samples
uniform vec3 baseColour;
uniform float baseExponent;
uniform float exposure;
uniform bool background;
uniform int samples;            // n x n in each pixel
uniform int sunCount;           // discs of the light that go by rays
uniform int keepLoops;          // 1, see network.glsl

// There is no coarse pass here.
float sunReach(int k) {
    return 1e30;
}

float sunNearby(int k, float worth) {
    return -1.0;
}

// The light from direction d, or black.
vec3 behind(vec3 d) {
    if (!background) return vec3(0.0);
#ifdef ENVIRONMENT_MAP
    return textureLod(environment, latlong(toMap * d), 0.0).rgb;
#else
    float ones[RESULT_BANDS], y[4 * RESULTS];
    for (int l = 0; l < RESULT_BANDS; l++) ones[l] = 1.0;
    weightedBasis(d, ones, y);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < LIGHT_COUNT; i++) sum += skyCoefficients[i] * y[i];
    return max(sum, vec3(0.0));
#endif
}

// Radiance along the ray through `place`, in samples.
vec3 seenRadiance(vec2 place) {
    vec3 o = viewOrigin(), d = viewRay(place);
    float t = march(o, d, footprint(), 0.0, 0.0);
    if (t < 0.0) return behind(d);
    vec3 p[POINTS], n[POINTS];
    p[0] = o + d * t;
    n[0] = surfaceNormal(p[0]);
    vec3 colour = baseColour;
    float s = baseExponent;
#ifdef HAS_ALBEDO
    colour = albedo(p[0], n[0]);
#endif
#ifdef HAS_EXPONENT
    s = exponent(p[0], n[0]);
#endif
    vec4 all[NETWORK_OUTPUTS], transfer[OUTPUTS];
    network(p, n, all);
    for (int i = 0; i < OUTPUTS; i++) transfer[i] = all[i];
#if TRANSFERS > 1
    colour = recoloured(colour);
    vec3 arriving = vec3(0.0);
    for (int b = 1; b < TRANSFERS * keepLoops; b++) {
        vec4 more[OUTPUTS];
        for (int i = 0; i < OUTPUTS; i++) more[i] = all[b * OUTPUTS + i];
        arriving += bouncedLight(b - 1, more);
    }
    vec3 light = shade(n[0], -d, transfer, colour, s) + bouncedShade(n[0], -d, transfer, arriving, colour, s);
#else
    vec3 light = shade(n[0], -d, transfer, colour, s);
#endif
    if (sunCount > 0) {
        vec3 diffuse, glossy;
        sunlight(p[0], n[0], -d, s, diffuse, glossy);
        light += sunShade(colour, diffuse, glossy);
    }
    return light;
}

// Linear to 0.6, then a shoulder that reaches 1 at infinity; sRGB.
vec3 encoded(vec3 radiance) {
    vec3 x = max(radiance, vec3(0.0)) * exposure, over = max(x - 0.6, vec3(0.0));
    x = min(x, vec3(0.6)) + 0.4 * over / (over + 0.4);
    return mix(12.92 * x, 1.055 * pow(max(x, vec3(1e-12)), vec3(1.0 / 2.4)) - 0.055, step(vec3(0.0031308), x));
}

// The pixel whose centre is `at`, of a picture of `size` pixels.
vec3 pixel(vec2 at, vec2 size) {
    viewport = vec4(vec2(0.0), size * float(samples));
    vec3 sum = vec3(0.0);
    for (int k = 0; k < samples * samples * keepLoops; k++)
        sum += seenRadiance(floor(at) * float(samples) + vec2(float(k % samples), float(k / samples)) + 0.5);
    return encoded(sum / float(samples * samples));
}
