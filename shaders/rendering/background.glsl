// The environment behind the scene, a lat-long map.
ivec2 gridPlace();
vec3 viewRay(vec2 at);
vec2 latlong(vec3 d);
uniform sampler2D environment;  // wraps in u
uniform mat3 toMap;             // world to map
layout(rgba32f, binding = 0) writeonly uniform image2D radiance;

void main() {
    ivec2 at = gridPlace();
    if (any(greaterThanEqual(at, imageSize(radiance)))) return;
    imageStore(radiance, at, vec4(textureLod(environment, latlong(toMap * viewRay(vec2(at) + 0.5)), 0.0).rgb, 0.0));
}
