// Carries, borrows and the high halves of products, of numbers and of vectors
float sdf(vec3 p) {
    uvec3 a = uvec3(abs(floor(p * 977.0))) * 40503u, b = ~uvec3(abs(floor(p.yzx * 31.0))) * 2654435761u, carry, high, low;
    ivec3 s = ivec3(floor(p * 90000.0)) * 60013, t = ivec3(floor(p.zxy * 70000.0)), above, below;
    uint one, two;
    vec3 sum = vec3(uaddCarry(a, b, carry) >> 9u) * 1e-7 + vec3(carry);
    float less = float(usubBorrow(a.x, b.x, one) >> 9u) * 1e-7 + float(one);
    umulExtended(a, b, high, low);
    imulExtended(s, t, above, below);
    umulExtended(a.y, b.z, one, two);
    vec3 product = vec3(high >> 9u) * 1e-7 + vec3(low >> 9u) * 2e-7 + vec3(above) * 1e-4 + vec3(below >> 9) * 1e-7;
    return length(p) - 0.5 + 0.01 * (dot(sum + product, vec3(1.0, 2.0, 3.0)) + less + float(one >> 9u) * 1e-7);
}
