// Light that has bounced off other surfaces: each transfer of bounces times all of the light, times the colour that it bounced off.
// Twin: sdfprt/material/shading.py.
void weightedBasis(vec3 d, float weights[RESULT_BANDS], out float y[4 * RESULTS]);
void lobeFactors(float s, out float g[RESULT_BANDS]);
#if TRANSFERS > 1
uniform vec3 specular;
uniform vec3 bounceColours[TRANSFERS - 1];
uniform vec4 wholeLight[3 * OUTPUTS];  // L / pi with the light's discs, channel after channel
uniform int partCount;                 // of the table of colours; 0 where the surface has one colour
uniform vec3 partsBefore[8];           // the table of the bake
uniform vec3 partsNow[8];

// The surface's own colour after its table has changed: part and share as material/colours.py has them.
vec3 recoloured(vec3 base) {
    if (partCount == 0) return base;
    vec3 own = partsBefore[0], now = partsNow[0];
    for (int q = 1; q < partCount; q++)
        if (dot(base - partsBefore[q], base - partsBefore[q]) < dot(base - own, base - own)) {
            own = partsBefore[q];
            now = partsNow[q];
        }
    float square = dot(own, own), share = square > 0.0 ? dot(base, own) / square : 1.0;
    return max(base + share * (now - own), vec3(0.0));
}

// What transfer number b of bounces brings to a white diffuse surface.
vec3 bouncedLight(int b, vec4 more[OUTPUTS]) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < OUTPUTS; i++)
        sum += vec3(dot(more[i], wholeLight[i]), dot(more[i], wholeLight[OUTPUTS + i]), dot(more[i], wholeLight[2 * OUTPUTS + i]));
    return bounceColours[b] * sum;
}

// What of it goes along o. The glossy lobe sees it come evenly from where direct transfer is not open.
vec3 bouncedShade(vec3 n, vec3 o, vec4 transfer[OUTPUTS], vec3 arriving, vec3 base, float s) {
    arriving = max(arriving, vec3(0.0));
    vec3 sum = vec3(0.0);
#if (LOBES & 1) != 0
    sum += base * arriving;
#endif
#if (LOBES & 2) != 0
    float g[RESULT_BANDS], lobe[4 * RESULTS], open[4 * RESULTS];
    lobeFactors(s, g);
    weightedBasis(reflect(-o, n), g, lobe);
    // Transfer under an open sky: the clamped cosine (Ramamoorthi and Hanrahan 2001)
    for (int l = 0; l < RESULT_BANDS; l++) g[l] = l == 0 ? 3.14159265358979 : l == 1 ? 2.0943951023932 : 0.0;
    for (int l = 2; l < RESULT_BANDS; l += 2) g[l] = l == 2 ? 0.785398163397448 : -g[l - 2] * float(l - 3) / float(l + 2);
    weightedBasis(n, g, open);
    float met = 0.0;
    for (int i = 0; i < 4 * min(OUTPUTS, RESULTS); i++) met += lobe[i] * (open[i] - transfer[i / 4][i % 4]);
    float closed = max(1.0 - transfer[0].x / 0.886226925452758, 0.02);
    sum += specular * arriving * clamp(met, 0.0, 1.0) / closed;
#endif
    return sum;
}
#endif
