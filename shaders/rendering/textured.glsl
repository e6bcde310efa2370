// Texture storage: transfer of the side that is seen from its texture, light times transfer in each fragment.
vec3 shade(vec3 n, vec3 o, vec4 transfer[OUTPUTS], vec3 base, float s);
vec3 sunShade(vec3 base, vec3 diffuse, vec3 glossy);
in vec3 worldPoint;
in vec3 worldNormal;
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
layout(location = 0) out vec4 radiance;

void main() {
    vec2 level = textureQueryLod(transferTextures, transferAt);  // by derivatives, so before any branch
    int first = (gl_FrontFacing ? layersHere.x : layersHere.y) * OUTPUTS;
    radiance = vec4(0.0, 0.0, 0.0, 1.0);
    if (!gl_FrontFacing && !twoSided) return;  // a closed body seen from inside is dark
    vec4 transfer[OUTPUTS];
    for (int i = 0; i < OUTPUTS; i++) transfer[i] = textureLod(transferTextures, vec3(transferAt, float(first + i)), level.x);
    vec3 colour = finishAlbedo * vertexPaint;
    if (painted) colour *= textureLod(picture, vec2(pictureAt.x, 1.0 - pictureAt.y), 0.0).rgb;
    vec3 n = normalize(gl_FrontFacing ? worldNormal : -worldNormal);
    radiance.rgb = shade(n, normalize(eye - worldPoint), transfer, colour, finishExponent);
    ivec2 at = ivec2(gl_FragCoord.xy);
    if (sunlit) radiance.rgb += sunShade(colour, texelFetch(sunDiffuse, at, 0).rgb, texelFetch(sunGlossy, at, 0).rgb);
}
