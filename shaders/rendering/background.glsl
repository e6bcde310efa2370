// The environment behind the scene: lat-long, +z at the centre, +x a quarter from the left edge, +y on top.
vec3 viewRay();
uniform sampler2D environment;  // wraps in u
uniform mat3 toMap;             // world to map
layout(location = 0) out vec4 radiance;

void main() {
    vec3 d = toMap * viewRay();
    vec2 at = vec2(0.5 - atan(d.x, d.z) / 6.28318530717959, acos(clamp(d.y, -1.0, 1.0)) / 3.14159265358979);
    radiance = vec4(textureLod(environment, at, 0.0).rgb, 0.0);
}
