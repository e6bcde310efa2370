// The environment behind the scene, a lat-long map.
vec3 viewRay();
vec2 latlong(vec3 d);
uniform sampler2D environment;  // wraps in u
uniform mat3 toMap;             // world to map
layout(location = 0) out vec4 radiance;

void main() {
    radiance = vec4(textureLod(environment, latlong(toMap * viewRay()), 0.0).rgb, 0.0);
}
