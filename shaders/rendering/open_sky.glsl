// Transfer with nothing in the way of the sky, four coefficients of it: the clamped cosine about n, up to degree 2, since degree 3 has
// none (Ramamoorthi and Hanrahan 2001). Twin of `open_sky` in sdfprt/network/mlp.py.
vec4 openSky(vec3 n, int row) {
    if (row == 0) return vec4(0.886226925, 1.02332671 * vec3(-n.y, n.z, -n.x));
    if (row == 1) return vec4(0.858085531 * vec2(n.x, -n.z) * n.y, 0.247707956 * (3.0 * n.z * n.z - 1.0), -0.858085531 * n.x * n.z);
    return row == 2 ? vec4(0.429042765 * (n.x * n.x - n.y * n.y), 0.0, 0.0, 0.0) : vec4(0.0);
}
