// The pass between surface and network where discs were taken out of the light: their sums at each sample that hit.
void sunlight(vec3 p, vec3 n, vec3 o, float s, out vec3 diffuse, out vec3 glossy);
uniform sampler2D surfacePoint;
uniform sampler2D surfaceDirection;
uniform sampler2D surfaceColour;
uniform vec3 eye;
uniform float lobeExponent;  // of the material, where the scene's file gives none
uniform bool hasExponent;
layout(location = 0) out vec4 sunDiffuse;
layout(location = 1) out vec4 sunGlossy;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec4 seen = texelFetch(surfacePoint, at, 0);
    if (seen.w < 0.5) discard;
    float s = hasExponent ? texelFetch(surfaceColour, at, 0).a : lobeExponent;
    vec3 diffuse, glossy;
    sunlight(seen.xyz, texelFetch(surfaceDirection, at, 0).xyz, normalize(eye - seen.xyz), s, diffuse, glossy);
    sunDiffuse = vec4(diffuse, 1.0);
    sunGlossy = vec4(glossy, 1.0);
}
