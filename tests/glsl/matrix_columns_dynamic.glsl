mat3 turned(float a) { mat3 m = mat3(1.0); m[0].xz = vec2(cos(a), sin(a)); m[2].xz = vec2(-sin(a), cos(a)); return m; }
float map(vec3 p) {
    mat3 m = turned(0.4);
    int at = p.x > 0.0 ? 1 : 2;
    m[at] *= 1.2;
    m[at][(at + 1) % 3] += 0.1;
    vec3 q = p * m;
    for (int i = 0; i < 3; i++) q[i] = abs(q[i]) - 0.2 - 0.05 * m[i][i];
    mat4 wide = mat4(m);
    q += (wide * vec4(0.0, 0.0, 0.0, 1.0)).xyz + mat3(wide)[0] * 0.0;
    m /= 2.0; m -= mat3(0.1); m = -m;
    return length(max(q, 0.0)) + min(max(q.x, max(q.y, q.z)), 0.0) + 0.01 * determinant(m);
}
