// Operators on distances and domains. Distances first, widths after.

// bound: union rounded over a width k
float opSmoothUnion(float a, float b, float k) {
    float h = max(k - abs(a - b), 0.0) / k;
    return min(a, b) - 0.25 * k * h * h;
}

// bound: intersection rounded over a width k
float opSmoothIntersection(float a, float b, float k) { return -opSmoothUnion(-a, -b, k); }

// bound: a without b, the edge rounded over a width k
float opSmoothSubtraction(float a, float b, float k) { return -opSmoothUnion(-a, b, k); }

// exact: prism over a flat shape with distance d, from -h to h along z
float opExtrude(float d, float z, float h) {
    vec2 w = vec2(d, abs(z) - h);
    return min(max(w.x, w.y), 0.0) + length(max(w, 0.0));
}

// Fold the plane into one of n equal sectors about the origin, its middle along +x.
vec2 opPolar(vec2 p, float n) {
    float sector = 6.28318531 / n;
    float a = sector * round(atan(p.y, p.x) / sector), c = cos(a), s = sin(a);
    return vec2(c * p.x + s * p.y, c * p.y - s * p.x);
}
