// Texture storage: transfer of the side that is seen from its texture, light times transfer in each fragment.
vec3 shade(vec3 n, vec3 o, vec4 transfer[OUTPUTS], vec3 base, float s);
void lobeFactors(float s, out float g[RESULT_BANDS]);
void weightedBasis(vec3 d, float weights[RESULT_BANDS], out float y[4 * RESULTS]);
vec3 shadingNormal();
vec3 sunShade(vec3 base, vec3 diffuse, vec3 glossy);
in vec3 worldPoint;
in vec2 pictureAt;
in vec3 vertexPaint;
in vec2 transferAt;
flat in ivec2 layersHere;
uniform vec3 eye;
uniform vec3 finishAlbedo;
uniform float finishExponent;
uniform bool painted;            // by a picture
uniform sampler2D picture;       // linear when read
uniform bool twoSided;
uniform sampler2DArray transferTextures;  // OUTPUTS layers of four coefficients each
uniform bool sunlit;             // whether discs of the light go by rays
uniform sampler2D sunDiffuse;    // their sums, of a pass before this
uniform sampler2D sunGlossy;
uniform vec3 lobeColour;         // of the glossy lobe
uniform bool bounced;            // whether 3 * OUTPUTS layers of what other surfaces send follow those of transfer
uniform float sentScale;         // their unit
layout(location = 0) out vec4 radiance;

// What other surfaces send, G in SH, times the material: albedo/pi G_0 / y_0, and sum_i g_l G_i y_i(R).
vec3 indirect(int first, float level, vec3 n, vec3 o, vec3 base) {
    vec3 sum = vec3(0.0);
    float y[4 * RESULTS];
#if (LOBES & 2) != 0
    float g[RESULT_BANDS];
    lobeFactors(finishExponent, g);
    weightedBasis(reflect(-o, n), g, y);
#endif
    for (int c = 0; c < 3; c++)
        for (int i = 0; i < OUTPUTS; i++) {
            vec4 sent = textureLod(transferTextures, vec3(transferAt, float(first + c * OUTPUTS + i)), level);
#if (LOBES & 1) != 0
            if (i == 0) sum[c] += base[c] * 1.12837916709551 * sent.x;  // 1 / (pi y_0)
#endif
#if (LOBES & 2) != 0
            if (i < RESULTS) sum[c] += lobeColour[c] * dot(sent, vec4(y[4 * i], y[4 * i + 1], y[4 * i + 2], y[4 * i + 3]));
#endif
        }
    return max(sentScale * sum, vec3(0.0));
}

void main() {
    // The level by the shorter axis of the sample's footprint and a half of it, so that what a bilinear read spans is one sample: rims
    // of a few texels would blur away. By derivatives, so before any branch
    vec2 side = vec2(textureSize(transferTextures, 0).xy), across = dFdx(transferAt) * side, down = dFdy(transferAt) * side;
    float level = max(0.0, 0.5 * log2(min(dot(across, across), dot(down, down))) - 1.0);
    int first = (gl_FrontFacing ? layersHere.x : layersHere.y) * OUTPUTS * (bounced ? 4 : 1);
    radiance = vec4(0.0, 0.0, 0.0, 1.0);
    if (!gl_FrontFacing && !twoSided) return;  // a closed body seen from inside is dark
    vec4 transfer[OUTPUTS];
    for (int i = 0; i < OUTPUTS; i++) transfer[i] = textureLod(transferTextures, vec3(transferAt, float(first + i)), level);
    vec3 colour = finishAlbedo * vertexPaint;
    if (painted) colour *= textureLod(picture, vec2(pictureAt.x, 1.0 - pictureAt.y), 0.0).rgb;
    vec3 n = shadingNormal(), o = normalize(eye - worldPoint);
    radiance.rgb = shade(n, o, transfer, colour, finishExponent);
    if (bounced) radiance.rgb += indirect(first + OUTPUTS, level, n, o, colour);
    ivec2 at = ivec2(gl_FragCoord.xy);
    if (sunlit) radiance.rgb += sunShade(colour, texelFetch(sunDiffuse, at, 0).rgb, texelFetch(sunGlossy, at, 0).rgb);
}
