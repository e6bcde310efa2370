const vec3 centres[] = vec3[](vec3(0.3, 0.0, 0.1), vec3(-0.4, 0.2, 0.0), vec3(0.0, -0.3, 0.2));
float radii[centres.length()] = float[centres.length()](0.2, 0.15, 0.3);
float nearest(const in vec3 p, in float r[3]) {
    float d = 1e3;
    for (int i = 0; i < centres.length(); ++i) d = min(d, length(p - centres[i]) - r[i]);
    return d + 0.01 * float(r.length());
}
float map(vec3 p) { float kept[3] = radii; kept[1] += 0.1 * p.x; return nearest(p, kept); }
