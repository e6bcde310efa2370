// A coral of hash noise: branches whose skin the hash makes rough. The hash multiplies numbers of thousands, so that one rounding
// more or less is another field: what rays meet must be what the surface is.
float hash(vec3 p) { p = fract(p * 0.1031); p += dot(p, p.yzx + 33.33); return fract((p.x + p.y) * p.z); }
float noise(vec3 x) {
    vec3 i = floor(x), f = fract(x);
    f = f * f * (3.0 - 2.0 * f);
    vec2 e = vec2(0.0, 1.0);
    vec4 low = vec4(hash(i), hash(i + e.yxx), hash(i + e.xyx), hash(i + e.yyx));
    vec4 high = vec4(hash(i + e.xxy), hash(i + e.yxy), hash(i + e.xyy), hash(i + e.yyy));
    vec4 along = mix(low, high, f.z);
    return mix(mix(along.x, along.y, f.x), mix(along.z, along.w, f.x), f.y);
}
float branch(vec3 p, float height, float radius) {
    p.y -= clamp(p.y, 0.0, height);
    return length(p) - radius;
}
float sdf(vec3 p) {
    vec3 q = p + vec3(0.0, 0.75, 0.0);
    float d = max(length(q * vec3(0.8, 2.5, 0.8)) - 0.45, -q.y) / 2.5, radius = 0.13, height = 0.5;
    for (int i = 0; i < 4; i++) {
        d = min(d, branch(q, height, radius));
        q.y -= 0.8 * height;
        q.xz = abs(q.xz) - 0.04;
        q.xy = mat2(0.84, 0.54, -0.54, 0.84) * q.xy;
        q.zy = mat2(0.91, 0.41, -0.41, 0.91) * q.zy;
        radius *= 0.72;
        height *= 0.78;
    }
    return 0.28 * (d - 0.035 * noise(17.0 * p) - 0.015 * noise(41.0 * p + 9.0));
}
