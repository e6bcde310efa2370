// (u, v) of the unit direction d in a lat-long map, its first row at v = 0: +z at the centre, +x a quarter from the left edge, +y on
// top. The home of the convention is sdfprt/maths/sphere.py; twins: latlong_uv there, kernels/truth/sampling.h. A test holds them.
vec2 latlong(vec3 d) {
    return vec2(0.5 - atan(d.x, d.z) / 6.28318530717959, acos(clamp(d.y, -1.0, 1.0)) / 3.14159265358979);
}
