// step, smoothstep, mix and comparisons of what is no number; zero vectors made unit ones; divisions by zero
float map(vec3 p) {
    float none = sqrt(-1.0 - abs(p.x)), far = 1.0 / floor(0.25 * abs(p.y));
    vec3 unit = normalize(floor(0.25 * abs(p)));
    float d = step(none, p.x) + 2.0 * step(p.y, none) + smoothstep(-0.5, 0.5, none) + smoothstep(none, 1.5, p.z);
    d += mix(p.x, none, 0.0) + mix(far, p.y, 1.0) + mix(vec3(none), p, vec3(1.0)).y + mix(unit, p, 1.0).z;
    d += (none < 0.0 ? 1.0 : 2.0) + (none >= 0.0 ? 4.0 : 8.0) + (none == none ? 16.0 : 32.0) + (far > 1e30 ? 64.0 : 128.0);
    d += (p.y / floor(0.25 * p.z) < 0.0 ? 0.5 : 0.25) + min(1.0, far) + max(-far, -2.0) + clamp(unit.x, 0.5, 0.75);
    return d + (acos(1.5 + p.x * p.x) < 9.0 ? 1.0 : 2.0) + (asin(-1.5 - p.x * p.x) > -9.0 ? 4.0 : 8.0);
}
