// A boulder covered with five octaves of value noise, of the hash by a sine: the last bit of the sine is multiplied by 43,758.
float hash(vec3 p) { return fract(sin(dot(p, vec3(127.1, 311.7, 74.7))) * 43758.5453); }
float noise(vec3 x) {
    vec3 i = floor(x), f = smoothstep(0.0, 1.0, fract(x));
    vec2 e = vec2(0.0, 1.0);
    return mix(mix(mix(hash(i), hash(i + e.yxx), f.x), mix(hash(i + e.xyx), hash(i + e.yyx), f.x), f.y),
               mix(mix(hash(i + e.xxy), hash(i + e.yxy), f.x), mix(hash(i + e.xyy), hash(i + e.yyy), f.x), f.y), f.z);
}
float layers(vec3 p) {
    float sum = 0.0, size = 0.5;
    for (int i = 0; i < 5; i++) {
        sum += size * noise(p);
        p = 2.03 * p.yzx + 3.7;
        size *= 0.45;
    }
    return sum;
}
float sdf(vec3 p) {
    float stone = length(p * vec3(1.0, 1.25, 1.1)) - 0.62;
    float ground = p.y + 0.55 - 0.04 * layers(6.0 * p);
    return 0.33 * max(min(stone - 0.3 * (layers(2.7 * p) - 0.4), ground), max(max(abs(p.x), abs(p.z)) - 0.95, -0.75 - p.y));
}
