// Operators that the other files leave out, on all kinds; vectors indexed by variables, read and written
float sdf(vec3 p) {
    int i = int(floor(p.x * 7.0)), j = 3 - i;
    uint n = uint(abs(i)), m = 5u;
    bool near = p.x < -0.5 || p.y >= 0.25 || j >= 4, order = n < m || n <= uint(abs(j)), odd = n % 2u != m / 2u;
    mat3 turn = 0.5 * mat3(0.8, 0.6, 0.0, -0.6, 0.8, 0.0, 0.0, 0.0, 1.0) * 2.0;
    vec3 q = turn * p;
    int axis = clamp(i + 3, 0, 2);
    q[axis] = -q[axis] + float(-i) * 0.01;
    ivec3 k = -ivec3(floor(p * 5.0));
    float most = max(q[0], max(q[1], q[(axis + 1) % 3]));
    bvec3 above = greaterThanEqual(k, ivec3(1)), below = lessThan(uvec3(abs(k)), uvec3(n));
    float extra = (near ? 0.01 : 0.0) + (order ? 0.02 : 0.0) + (odd != near ? 0.04 : 0.0) + (any(above) ^^ all(below) ? 0.08 : 0.0);
    return most - 0.5 + extra + (q.x != q.y ? 0.0 : 0.1);
}
