float part(vec3 p) { if (p.y > 0.5) return 1.0; float d = length(p); if (d < 0.3) { if (p.x > 0.0) return 2.0; d *= 2.0; } else if (d > 0.9) return d; return -d; }
float map(vec3 p) { return part(p) + 0.5 * part(p.yzx); }
