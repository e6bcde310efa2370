float map(vec3 p) { float a = pi * 0.1 + saturate(p.x) + frac(p.y) * 0.2 + lerp(0.1, 0.2, p.z); return sqrt(lengthSquared(p)) - a; }
