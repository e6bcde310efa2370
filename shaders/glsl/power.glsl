// x to the power y. Where y is whole, the product that drivers make of pow(x, 2.0) and a few more, of negative x as well: GLSL
// leaves that open, and each driver folds other exponents. Twins: `pow` of
// kernels/core/simd.h and `power` of sdfprt/glsl/operations.py.
float sdfprt_pow(float x, float y) {
    if (y != floor(y)) return pow(x, y);
    if (abs(y) > 63.0) {
        float size = pow(abs(x), y);
        return x < 0.0 && fract(0.5 * y) != 0.0 ? -size : size;
    }
    int n = int(abs(y));
    float square = x, product = (n & 1) != 0 ? x : 1.0;
    square *= square;
    if ((n & 2) != 0) product *= square;
    square *= square;
    if ((n & 4) != 0) product *= square;
    square *= square;
    if ((n & 8) != 0) product *= square;
    square *= square;
    if ((n & 16) != 0) product *= square;
    square *= square;
    if ((n & 32) != 0) product *= square;
    return y < 0.0 ? 1.0 / product : product;
}
vec2 sdfprt_pow(vec2 x, vec2 y) { return vec2(sdfprt_pow(x.x, y.x), sdfprt_pow(x.y, y.y)); }
vec3 sdfprt_pow(vec3 x, vec3 y) { return vec3(sdfprt_pow(x.x, y.x), sdfprt_pow(x.y, y.y), sdfprt_pow(x.z, y.z)); }
vec4 sdfprt_pow(vec4 x, vec4 y) { return vec4(sdfprt_pow(x.xy, y.xy), sdfprt_pow(x.zw, y.zw)); }
