// Second pass: network and lighting, on the samples that hit.
void network(vec3 p, vec3 n, out vec4 transfer[OUTPUTS]);
vec3 shade(vec3 n, vec3 o, vec4 transfer[OUTPUTS], vec3 base, float s);
uniform sampler2D surfacePoint;
uniform sampler2D surfaceDirection;
uniform sampler2D surfaceColour;
uniform vec3 eye;
uniform vec3 albedo;
uniform float exponent;
uniform bool hasAlbedo;
uniform bool hasExponent;
layout(location = 0) out vec4 radiance;

void main() {
    ivec2 at = ivec2(gl_FragCoord.xy);
    vec3 p = texelFetch(surfacePoint, at, 0).xyz, n = texelFetch(surfaceDirection, at, 0).xyz;
    vec4 colour = texelFetch(surfaceColour, at, 0);
    vec4 transfer[OUTPUTS];
    network(p, n, transfer);
    vec3 o = normalize(eye - p);
    radiance = vec4(shade(n, o, transfer, hasAlbedo ? colour.rgb : albedo, hasExponent ? colour.a : exponent), 1.0);
}
