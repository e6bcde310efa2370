// A desk lamp beside a stack of books and a mug, on a round table top.
float box(vec3 p, vec3 b, float r) { vec3 q = abs(p) - b + r; return length(max(q, 0.0)) + min(max(q.x, max(q.y, q.z)), 0.0) - r; }
float rod(vec3 p, vec3 a, vec3 b, float r) { vec3 d = b - a; return length(p - a - d * clamp(dot(p - a, d) / dot(d, d), 0.0, 1.0)) - r; }
float disc(vec3 p, float r, float h, float e) { vec2 q = vec2(length(p.xz) - r, abs(p.y) - h) + e; return length(max(q, 0.0)) + min(max(q.x, q.y), 0.0) - e; }
mat2 turn(float a) { float c = cos(a), s = sin(a); return mat2(c, s, -s, c); }
float shade(vec3 p) {
    p.xy = turn(0.9) * p.xy;
    float r = 0.1 - 0.45 * p.y;
    float shell = abs(length(p.xz) - r) * 0.9 - 0.008;
    return max(shell, abs(p.y) - 0.13);
}
float lamp(vec3 p) {
    float d = disc(p - vec3(-0.45, -0.57, -0.2), 0.2, 0.025, 0.02);
    d = min(d, rod(p, vec3(-0.45, -0.57, -0.2), vec3(-0.65, 0.05, -0.2), 0.018));
    d = min(d, rod(p, vec3(-0.65, 0.05, -0.2), vec3(-0.15, 0.45, -0.1), 0.018));
    d = min(d, length(p - vec3(-0.65, 0.05, -0.2)) - 0.035);
    return min(d, min(shade(p - vec3(-0.08, 0.4, -0.09)), length(p - vec3(-0.1, 0.38, -0.09)) - 0.06));
}
float books(vec3 p) {
    float d = 1e3;
    for (int i = 0; i < 4; i++) {
        vec3 q = p - vec3(0.3, -0.55 + 0.085 * float(i), -0.15);
        q.xz = turn(0.25 * sin(2.3 * float(i))) * q.xz;
        float cover = max(box(q, vec3(0.27 - 0.02 * float(i), 0.04, 0.19), 0.008), -box(q - vec3(0.03, 0.0, 0.0), vec3(0.27, 0.03, 0.3), 0.004));
        float pages = box(q - vec3(-0.005, 0.0, 0.0), vec3(0.25 - 0.02 * float(i), 0.031, 0.175), 0.004);
        d = min(d, min(cover, pages));
    }
    return d;
}
float mug(vec3 p) {
    vec3 q = p - vec3(-0.02, -0.5, 0.4);
    float d = max(disc(q, 0.11, 0.11, 0.01), -disc(q - vec3(0.0, 0.03, 0.0), 0.092, 0.11, 0.005));
    vec2 t = vec2(length(q.xy - vec2(0.13, 0.0)) - 0.06, q.z);
    return min(d, max(length(t) - 0.016, 0.1 - length(q.xz)));
}
float sdf(vec3 p) { return min(min(disc(p - vec3(0.0, -0.62, 0.0), 0.85, 0.03, 0.02), lamp(p)), min(books(p), mug(p))); }
