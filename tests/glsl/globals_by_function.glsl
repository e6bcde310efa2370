float scaled(float x) { return x * 0.5; }
vec3 middle = vec3(0.1, scaled(0.2), -0.1), last;
float size = scaled(0.8), calls = 0.0;
bool near_by = true;
mat2 turn = mat2(0.8, 0.6, -0.6, 0.8);
float ball(vec3 p) { calls += 1.0; last = p; return length(p - middle) - size; }
float map(vec3 p) {
    p.xy *= turn;
    float a = ball(p), b = near_by ? ball(p.yzx * 1.1) : 3.0;
    near_by = a < 0.0;
    return min(a, b) + 0.01 * calls + 0.01 * last.x + (near_by ? 0.0 : 0.02);
}
