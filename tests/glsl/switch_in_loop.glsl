uint kind(vec3 p) { return uint(floor(p.y * 3.0 + 3.0)) % 4u; }
float map(vec3 p) {
    float d = 1e3;
    for (int i = 0; i < 4; i++) {
        vec3 q = p - vec3(0.3 * float(i) - 0.45, 0.0, 0.0);
        switch (kind(q)) {
            case 0u: { float r = 0.1; d = min(d, length(q) - r); } break;
            case 1u: if (q.x > 0.0) break; d = min(d, length(q.xz) - 0.05);
            case 2u:
                switch (i) { case 3: d += 0.01; break; default: d -= 0.001; }
                continue;
            default: d = min(d, max(abs(q.x), abs(q.z)) - 0.08);
        }
        d *= 0.99;
    }
    return d;
}
