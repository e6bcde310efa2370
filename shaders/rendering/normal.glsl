// Unit normal: differences at the corners of a tetrahedron, four taps; the loop keeps the distance from being inlined four times.
float sdfprt_distance(vec3 p);
uniform float normalStep;  // half width of the taps, scene units
uniform int keepLoops;     // 1, see network.glsl

vec3 surfaceNormal(vec3 p) {
    vec3 sum = vec3(0.0);
    for (int i = 0; i < 4 * keepLoops; i++) {
        vec3 corner = 1.0 - 2.0 * vec3((i + 1) / 2 % 2, i / 2, i % 2);
        sum += corner * sdfprt_distance(p + corner * normalStep);
    }
    float size = length(sum);
    return size > 0.0 ? sum / size : vec3(0.0, 1.0, 0.0);
}
