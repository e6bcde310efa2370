float g = 0.5; vec3 q; int n = 3;
void bend(vec3 p) { q = p.zxy * g; n++; g += 0.25; }
float map(vec3 p) { bend(p); if (p.x > 0.0) bend(q); return length(q) - g * 0.1 + float(n); }
