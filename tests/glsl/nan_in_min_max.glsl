// A wheel whose bulge is a root, of a negative number beyond the tread: min and max then give the other operand
float wheel(vec3 p, float r) {
    float bulge = sqrt(r * r - p.z * p.z), hub = length(p.xy);
    float d = max(length(vec2(hub - 0.5, p.z)) - 0.2, abs(p.z) - 0.5);
    d = min(d, max(d, -bulge));
    d = max(min(bulge + 9.0, d), d);
    vec3 both = max(vec3(bulge, d, bulge), vec3(d, bulge - 9.0, d - 1.0));
    return min(max(-bulge, d), both.y) + clamp(bulge, 0.125, 0.25) + 0.125 * clamp(p.x, -bulge, bulge) + min(both.z, 4.0);
}
float map(vec3 p) { return wheel(p, 0.4) + 0.5 * wheel(p.zxy, 0.3); }
