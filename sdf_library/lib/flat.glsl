// Flat shapes in the x, y plane: distances to strokes, sectors and lenses. Point first, sizes after.

// exact: stroke from a to b with round ends of radius r
float sdSegment2(vec2 p, vec2 a, vec2 b, float r) {
    vec2 q = p - a, edge = b - a;
    return length(q - edge * clamp(dot(q, edge) / dot(edge, edge), 0.0, 1.0)) - r;
}

// exact: sector of radius r about +y; c is sine and cosine of half its opening
float sdPie(vec2 p, vec2 c, float r) {
    p.x = abs(p.x);
    float disc = length(p) - r;
    float edge = length(p - c * clamp(dot(p, c), 0.0, r));
    return max(disc, edge * sign(c.y * p.x - c.x * p.y));
}

// exact: stroke of half width w along a circle of radius r; c is sine and cosine of half its opening about +y
float sdArc(vec2 p, vec2 c, float r, float w) {
    p.x = abs(p.x);
    bool beyond = c.y * p.x > c.x * p.y;
    return (beyond ? length(p - c * r) : abs(length(p) - r)) - w;
}

// exact: what two discs of radius r have in common, their centres at x = -d and d
float sdVesica(vec2 p, float r, float d) {
    p = abs(p);
    float tip = sqrt(r * r - d * d);
    bool corner = (p.y - tip) * d > p.x * tip;
    return corner ? length(p - vec2(0.0, tip)) : length(p + vec2(d, 0.0)) - r;
}

// exact: the part of a disc of radius r above y = h
float sdCutDisk(vec2 p, float r, float h) {
    float w = sqrt(r * r - h * h), rim = length(p) - r;
    p.x = abs(p.x);
    if (p.y < h && p.x < w) return h - p.y;
    if (p.y >= h && rim < 0.0) return max(rim, h - p.y);
    return p.y * w < h * p.x ? length(p - vec2(w, h)) : rim;
}

// bound: ellipse with half axes r; exact along the shorter one
float sdEllipse2(vec2 p, vec2 r) {
    return (length(p / r) - 1.0) * min(r.x, r.y);
}
