// Second pass: network and lighting of the samples that hit, POINTS of them an invocation and SAMPLES a group.
void network(vec3 p[POINTS], vec3 n[POINTS], out vec4 transfer[POINTS * NETWORK_OUTPUTS]);
vec3 shade(vec3 n, vec3 o, vec4 transfer[OUTPUTS], vec3 base, float s);
vec3 sunShade(vec3 base, vec3 diffuse, vec3 glossy);
#if TRANSFERS > 1
vec3 recoloured(vec3 base);
vec3 bouncedLight(int b, vec4 more[OUTPUTS]);
vec3 bouncedShade(vec3 n, vec3 o, vec4 transfer[OUTPUTS], vec3 arriving, vec3 base, float s);
#endif
layout(local_size_x = GROUP) in;
layout(std430, binding = 0) readonly buffer SeenSamples {
    uint seenCount;
    uint seen[];  // y << 16 | x
};
layout(rgba32f, binding = 0) writeonly uniform image2D radiance;
uniform sampler2D surfacePoint;
uniform sampler2D surfaceDirection;
uniform sampler2D surfaceColour;
uniform vec3 eye;
uniform vec3 albedo;
uniform float exponent;
uniform bool hasAlbedo;
uniform bool hasExponent;
uniform bool sunlit;           // whether discs of the light go by rays
uniform sampler2D sunDiffuse;  // their sums, of the sunlight pass
uniform sampler2D sunGlossy;
#if TRANSFERS > 1
uniform int keepLoops;         // 1, see network.glsl
#endif

// Number of this group's first sample: groups stand in rows, since a driver takes 65,535 along a side.
uint firstSample() {
    return (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * SAMPLES;
}

// Where sample k of this invocation lies; the last ones repeat themselves where the hits end.
ivec2 place(int k) {
    uint hit = seen[min(firstSample() + gl_LocalInvocationID.x * POINTS + uint(k), seenCount - 1u)];
    return ivec2(hit & 0xffffu, hit >> 16);
}

void main() {
    if (firstSample() >= seenCount) return;  // all of a group or none: they may work together
    int points = POINTS * int(min(seenCount, 1u));  // POINTS, but the compiler cannot know: the loops stay loops
    vec3 p[POINTS], n[POINTS];
    for (int k = 0; k < points; k++) {
        p[k] = texelFetch(surfacePoint, place(k), 0).xyz;
        n[k] = texelFetch(surfaceDirection, place(k), 0).xyz;
    }
    vec4 all[POINTS * NETWORK_OUTPUTS];
    network(p, n, all);
    if (gl_LocalInvocationID.x * POINTS >= SAMPLES) return;
    for (int k = 0; k < points; k++) {
        vec4 transfer[OUTPUTS];
        for (int i = 0; i < OUTPUTS; i++) transfer[i] = all[k * NETWORK_OUTPUTS + i];
        vec4 colour = texelFetch(surfaceColour, place(k), 0);
        vec3 o = normalize(eye - p[k]);
        vec3 base = hasAlbedo ? colour.rgb : albedo;
        float s = hasExponent ? colour.a : exponent;
#if TRANSFERS > 1
        base = recoloured(base);
        vec3 arriving = vec3(0.0);
        for (int b = 1; b < TRANSFERS * keepLoops; b++) {
            vec4 more[OUTPUTS];
            for (int i = 0; i < OUTPUTS; i++) more[i] = all[(k * TRANSFERS + b) * OUTPUTS + i];
            arriving += bouncedLight(b - 1, more);
        }
        vec3 light = shade(n[k], o, transfer, base, s) + bouncedShade(n[k], o, transfer, arriving, base, s);
#else
        vec3 light = shade(n[k], o, transfer, base, s);
#endif
        if (sunlit) light += sunShade(base, texelFetch(sunDiffuse, place(k), 0).rgb, texelFetch(sunGlossy, place(k), 0).rgb);
        float dark = texelFetch(surfaceDirection, place(k), 0).w;  // the inside of a closed mesh
        imageStore(radiance, place(k), vec4(light * (1.0 - dark), 1.0));
    }
}
