// Solids that no flat shape makes by extrusion or revolution. Point first, sizes after.

// exact: cuboid of half sizes b
float sdBox3(vec3 p, vec3 b) {
    vec3 q = abs(p) - b;
    return length(max(q, 0.0)) + min(max(q.x, max(q.y, q.z)), 0.0);
}

// exact outside, bound inside: the twelve edges of a cuboid of half sizes b, as square bars of width t
float sdBoxFrame3(vec3 p, vec3 b, float t) {
    // Three bars, one along each axis, in the corner that the point is nearest to
    vec3 middle = b - 0.5 * t, q = abs(p), bar = vec3(0.5 * t);
    float x = sdBox3(vec3(q.x, q.yz - middle.yz), vec3(b.x, bar.yz));
    float y = sdBox3(vec3(q.y, q.xz - middle.xz), vec3(b.y, bar.xz));
    float z = sdBox3(vec3(q.z, q.xy - middle.xy), vec3(b.z, bar.xy));
    return min(x, min(y, z));
}

// exact: stroke from a to b with round ends of radius r
float sdSegment3(vec3 p, vec3 a, vec3 b, float r) {
    vec3 q = p - a, edge = b - a;
    return length(q - edge * clamp(dot(q, edge) / dot(edge, edge), 0.0, 1.0)) - r;
}

// exact: arc of a torus in the x, y plane, tube radius t; c is sine and cosine of half its opening about +y
float sdCappedTorus3(vec3 p, vec2 c, float r, float t) {
    p.x = abs(p.x);
    bool beyond = c.y * p.x > c.x * p.y;
    float along = beyond ? dot(p.xy, c) : length(p.xy);
    return sqrt(max(dot(p, p) + r * r - 2.0 * r * along, 0.0)) - t;
}

// exact: hull of a ball of radius a at the origin and one of radius b at height h along y
float sdRoundCone3(vec3 p, float a, float b, float h) {
    vec2 q = vec2(length(p.xz), p.y);
    float s = (a - b) / h, c = sqrt(1.0 - s * s);
    float along = c * q.y - s * q.x;
    if (along < 0.0) return length(q) - a;
    if (along > c * h) return length(q - vec2(0.0, h)) - b;
    return c * q.x + s * q.y - a;
}

// bound: ellipsoid with half axes r; exact along the shortest one
float sdEllipsoidBound(vec3 p, vec3 r) {
    return (length(p / r) - 1.0) * min(r.x, min(r.y, r.z));
}

// exact: box of half sizes b over all, its edges rounded by r
float sdRoundBox3(vec3 p, vec3 b, float r) { return sdBox3(p, b - r) - r; }

// exact: cylinder along z of radius r and half length h, edges rounded by e
float sdRoundDisc3(vec3 p, float r, float h, float e) {
    vec2 q = vec2(length(p.xy) - r + e, abs(p.z) - h + e);
    return min(max(q.x, q.y), 0.0) + length(max(q, 0.0)) - e;
}

// bound: ellipsoid with half axes r, close to exact near the surface; overestimates a little inside
float sdEllipsoid3(vec3 p, vec3 r) {
    float k = length(p / r), g = length(p / (r * r));
    return max(k * (k - 1.0) / max(g, 1e-5), -min(r.x, min(r.y, r.z)));
}
