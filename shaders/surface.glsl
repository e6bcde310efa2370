// First pass: what each sample sees, and a list of the samples that hit for the second pass.
vec3 viewOrigin();
vec3 viewRay();
float footprint();
float march(vec3 o, vec3 d, float width);
vec3 surfaceNormal(vec3 p);
#ifdef HAS_ALBEDO
vec3 albedo(vec3 p, vec3 n);
#endif
#ifdef HAS_EXPONENT
float exponent(vec3 p, vec3 n);
#endif
layout(std430, binding = 0) buffer SeenSamples {
    uint seenCount;
    uint seen[];  // y << 16 | x
};
layout(location = 0) out vec4 surfacePoint;     // w: 1
layout(location = 1) out vec4 surfaceDirection; // the normal
layout(location = 2) out vec4 surfaceColour;    // albedo and exponent where the scene gives them

void main() {
    vec3 o = viewOrigin(), d = viewRay();
    float t = march(o, d, footprint());
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
