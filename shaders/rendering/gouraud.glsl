// Vertex storage: what the vertices have gathered, interpolated (Gouraud 1971); albedo, with its picture, a sample.
vec3 sunShade(vec3 base, vec3 diffuse, vec3 glossy);
#if (LOBES & 4) != 0
vec3 reflection(vec3 n, vec3 o);
in vec3 toEye;
in vec3 normalHere;
#endif
in vec3 diffuseLightHere;
in vec3 glossyLightHere;
in vec2 pictureAt;
in vec3 vertexPaint;
uniform vec3 finishAlbedo;
uniform bool painted;            // by a picture
uniform sampler2D picture;       // linear when read
uniform bool otherSide;          // of a triangle with two sides; a closed body seen from inside is dark
uniform bool twoSided;
uniform bool sunlit;             // whether discs of the light go by rays
uniform sampler2D sunDiffuse;    // their sums, of a pass before this
uniform sampler2D sunGlossy;
layout(location = 0) out vec4 radiance;

void main() {
    if (twoSided && gl_FrontFacing == otherSide) discard;
    vec3 colour = finishAlbedo * vertexPaint;
    if (painted) colour *= textureLod(picture, vec2(pictureAt.x, 1.0 - pictureAt.y), 0.0).rgb;
    bool dark = !twoSided && !gl_FrontFacing;
    vec3 light = colour * diffuseLightHere + glossyLightHere;
    ivec2 at = ivec2(gl_FragCoord.xy);
    if (sunlit) light += sunShade(colour, texelFetch(sunDiffuse, at, 0).rgb, texelFetch(sunGlossy, at, 0).rgb);
#if (LOBES & 4) != 0
    light += reflection(normalize(normalHere), normalize(toEye));
#endif
    radiance = vec4(dark ? vec3(0.0) : light, 1.0);
}
