// First pass: what each sample sees, and a list of the samples that hit for the second pass. Before it, with `coarse`, how far
// the cones about tiles of samples are free.
vec3 viewOrigin();
vec3 viewRay();
float footprint();
float march(vec3 o, vec3 d, float width, float begin, float cone);
vec3 surfaceNormal(vec3 p);
#ifdef HAS_ALBEDO
vec3 albedo(vec3 p, vec3 n);
#endif
#ifdef HAS_EXPONENT
float exponent(vec3 p, vec3 n);
#endif
uniform bool coarse;
uniform sampler2D freeCones;  // of the coarse pass
uniform int grain;            // samples a texel along a side
layout(early_fragment_tests) in;
layout(std430, binding = 0) buffer SeenSamples {
    uint seenCount;
    uint seen[];  // y << 16 | x
};
layout(location = 0) out vec4 surfacePoint;     // w: 1
layout(location = 1) out vec4 surfaceDirection; // the normal
layout(location = 2) out vec4 surfaceColour;    // albedo and exponent where the scene gives them

void main() {
    vec3 o = viewOrigin(), d = viewRay();
    float begin = coarse ? 0.0 : texelFetch(freeCones, ivec2(gl_FragCoord.xy) / grain, 0).x;
    float t = march(o, d, footprint(), begin, coarse ? 0.75 * footprint() : 0.0);
    if (coarse) {
        surfacePoint = vec4(t);  // the others are not there
        return;
    }
    if (t < 0.0) discard;
    vec3 p = o + d * t, n = surfaceNormal(p);
    seen[atomicAdd(seenCount, 1u)] = uint(gl_FragCoord.y) << 16 | uint(gl_FragCoord.x);
    surfacePoint = vec4(p, 1.0);
    surfaceDirection = vec4(n, 0.0);
    surfaceColour = vec4(0.0);
#ifdef HAS_ALBEDO
    surfaceColour.rgb = albedo(p, n);
#endif
#ifdef HAS_EXPONENT
    surfaceColour.a = exponent(p, n);
#endif
}
