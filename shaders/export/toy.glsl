// Shadertoy's entry: the mouse turns the camera about what it looks at.
vec3 pixel(vec2 at, vec2 size);
vec3 eye;   // camera.glsl's
mat3 axes;
uniform vec3 iResolution;
uniform vec4 iMouse;
uniform vec3 firstEye;
uniform vec3 target;
uniform vec3 upward;
uniform float halfHeight;  // of the image plane at distance 1

void mainImage(out vec4 colour, in vec2 at) {
    vec3 offset = firstEye - target;
    eye = firstEye;
    if (iMouse.x > 0.0 || iMouse.y > 0.0) {
        vec2 turn = iMouse.xy / iResolution.xy - 0.5;
        float radius = length(offset), around = atan(offset.x, offset.z) - 6.2831853 * turn.x;
        float rise = clamp(asin(offset.y / radius) + 3.1415927 * turn.y, -1.5, 1.5);
        eye = target + radius * vec3(sin(around) * cos(rise), sin(rise), cos(around) * cos(rise));
    }
    vec3 forward = normalize(target - eye), right = normalize(cross(forward, upward));
    float aspect = iResolution.x / iResolution.y;
    axes = mat3(right * halfHeight * aspect, cross(forward, right) * halfHeight, forward);
    colour = vec4(pixel(at, iResolution.xy), 1.0);
}
