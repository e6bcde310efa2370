// The sum of the material's lobes from transfer: diffuse by one vector a channel; glossy by maps in which light and lobe are exact
// (EXACT_LIGHT), or with the light fixed (TPFL) by one matrix a channel, or by the whole triple product (TP), whose non-zero
// tau_ijk are data. Twin: sdfprt/material/shading.py.
void weightedBasis(vec3 d, float weights[RESULT_BANDS], out float y[4 * RESULTS]);
#if (LOBES & 4) != 0
vec3 reflection(vec3 n, vec3 o);
#endif
uniform vec3 specular;
uniform vec4 diffuseLight[3 * OUTPUTS];              // L / pi, channel after channel
#ifdef EXACT_LIGHT
uniform sampler2DArray glossMaps;                    // F_j in fours, channel after channel, level after level; lat-long
uniform sampler2D openLight;                         // what bands beyond those of transfer give under an open sky, over pi
uniform mat3 toLight;                                // world to the frame of the maps
uniform mat4 turnTransfer[OUTPUTS * OUTPUTS];        // the same for coefficients, 4x4 blocks row after row
uniform int glossLevels;                             // 1: that of the material; more: exponents 1, 2, 4 ...
#elif defined(TAU_COUNT)
uniform vec3 lightCoefficients[LIGHT_COUNT];
#elif !defined(CONSTANT_LIGHT)
layout(std140) uniform GlossyLight {                 // M_ki = sum_j tau_ijk L_j in 4x4 blocks, channel after channel
    mat4 glossyLight[3 * RESULTS * OUTPUTS];
};
#endif

// g_l = sqrt(4 pi/(2l+1)) f_l of (s+2)/(2 pi) cos^s.
void lobeFactors(float s, out float g[RESULT_BANDS]) {
    g[0] = (s + 2.0) / (s + 1.0);
    for (int l = 1; l < RESULT_BANDS; l++) g[l] = l == 1 ? 1.0 : g[l - 2] * (s - float(l) + 2.0) / (s + float(l) + 1.0);
}

#ifdef EXACT_LIGHT
vec2 latlong(vec3 d);

// sum_j T_j F_j(R) of the lobe about the world direction r, with exponent s.
vec3 exactGloss(vec4 transfer[OUTPUTS], vec3 r, float s) {
    vec2 at = latlong(toLight * r);
    // Between two levels such that the lobe's variance, 1 / s, is right
    float e = clamp(s, 1.0, exp2(float(glossLevels - 1)));
    float low = clamp(floor(log2(e)), 0.0, max(float(glossLevels - 2), 0.0));
    float share = glossLevels > 1 ? 2.0 - 2.0 * exp2(low) / e : 0.0;
    vec3 sum = vec3(0.0);
    for (int row = 0; row < OUTPUTS; row++) {
        vec4 t = vec4(0.0);
        for (int column = 0; column < OUTPUTS; column++) t += turnTransfer[row * OUTPUTS + column] * transfer[column];
        for (int channel = 0; channel < 3; channel++) {
            float layer = (low * 3.0 + float(channel)) * float(OUTPUTS) + float(row);
            vec4 f = textureLod(glossMaps, vec3(at, layer), 0.0);
            if (share > 0.0) f = mix(f, textureLod(glossMaps, vec3(at, layer + 3.0 * float(OUTPUTS)), 0.0), share);
            sum[channel] += dot(t, f);
        }
    }
    return sum;
}
#else
// sum_k y_k H_k, H the product of light and transfer.
vec3 glossy(vec4 transfer[OUTPUTS], float y[4 * RESULTS]) {
    vec3 sum = vec3(0.0);
#ifdef TAU_COUNT
    float t[4 * OUTPUTS];
    for (int i = 0; i < 4 * OUTPUTS; i++) t[i] = transfer[i / 4][i % 4];
    for (int at = 0; at < TAU_COUNT; at++) {
        int ijk = tauIndex[at];
        sum += tauValue[at] * t[ijk & 255] * y[ijk >> 16] * lightCoefficients[ijk >> 8 & 255];
    }
#else
    for (int k = 0; k < RESULTS; k++) {
        vec4 red = vec4(0.0), green = vec4(0.0), blue = vec4(0.0);
        for (int i = 0; i < OUTPUTS; i++) {
            red += glossyLight[k * OUTPUTS + i] * transfer[i];
            green += glossyLight[(RESULTS + k) * OUTPUTS + i] * transfer[i];
            blue += glossyLight[(2 * RESULTS + k) * OUTPUTS + i] * transfer[i];
        }
        vec4 basis = vec4(y[4 * k], y[4 * k + 1], y[4 * k + 2], y[4 * k + 3]);
        sum += vec3(dot(basis, red), dot(basis, green), dot(basis, blue));
    }
#endif
    return sum;
}
#endif

// What the diffuse lobe sends everywhere, without its albedo.
vec3 diffuseLobe(vec4 transfer[OUTPUTS]) {
    vec3 light = vec3(0.0);
    for (int i = 0; i < OUTPUTS; i++)
        light += vec3(dot(transfer[i], diffuseLight[i]), dot(transfer[i], diffuseLight[OUTPUTS + i]),
                      dot(transfer[i], diffuseLight[2 * OUTPUTS + i]));
    return light;
}

// What the Phong lobe with exponent s sends along o, its colour included.
vec3 glossyLobe(vec3 n, vec3 o, vec4 transfer[OUTPUTS], float s) {
#ifdef EXACT_LIGHT
    return specular * exactGloss(transfer, reflect(-o, n), s);
#else
    float g[RESULT_BANDS], y[4 * RESULTS];
    lobeFactors(s, g);
    weightedBasis(reflect(-o, n), g, y);
    return specular * glossy(transfer, y);
#endif
}

// Radiance along o, the unit direction to the eye, with albedo `base` and exponent s.
vec3 shade(vec3 n, vec3 o, vec4 transfer[OUTPUTS], vec3 base, float s) {
    vec3 sum = vec3(0.0);
#if (LOBES & 1) != 0
    sum += base * diffuseLobe(transfer);
#ifdef EXACT_LIGHT
    sum += base * clamp(transfer[0].x / 0.886226925452758, 0.0, 1.0) * textureLod(openLight, latlong(toLight * n), 0.0).rgb;
#endif
#endif
#if (LOBES & 2) != 0
    sum += glossyLobe(n, o, transfer, s);
#endif
    sum = mix(sum, vec3(0.0), lessThan(sum, vec3(0.0)));  // cut-off series dip below zero; NaN stays to be reported
#if (LOBES & 4) != 0
    sum += reflection(n, o);
#endif
    return sum;
}

// The same of the light's discs, from their sums for a white diffuse surface and a white lobe.
vec3 sunShade(vec3 base, vec3 diffuse, vec3 glossy) {
    vec3 sum = vec3(0.0);
#if (LOBES & 1) != 0
    sum += base * diffuse;
#endif
#if (LOBES & 2) != 0
    sum += specular * glossy;
#endif
    return sum;
}
