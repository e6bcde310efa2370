// What a sample sees of a mesh, in the three textures that trace.glsl's pass fills: place, shading normal on the side that is
// seen, albedo and exponent. A closed body seen from inside is dark: w of the direction.
vec3 shadingNormal();
in vec3 worldPoint;
in vec2 pictureAt;
in vec3 vertexPaint;
uniform vec3 finishAlbedo;
uniform float finishExponent;
uniform bool painted;            // by a picture
uniform sampler2D picture;       // linear when read
uniform bool twoSided;
layout(location = 0) out vec4 surfacePoint;
layout(location = 1) out vec4 surfaceDirection;
layout(location = 2) out vec4 surfaceColour;

void main() {
    surfacePoint = vec4(worldPoint, 1.0);
    surfaceDirection = vec4(shadingNormal(), gl_FrontFacing || twoSided ? 0.0 : 1.0);
    vec3 colour = finishAlbedo * vertexPaint;
    if (painted) colour *= textureLod(picture, vec2(pictureAt.x, 1.0 - pictureAt.y), 0.0).rgb;
    surfaceColour = vec4(colour, finishExponent);
}
