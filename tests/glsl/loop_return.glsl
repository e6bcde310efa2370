float find(vec3 p) { for (int i = 0; i < 10; i++) { p *= 1.3; if (p.x > 0.7) return float(i); if (p.y > 0.9) return -float(i); } return 0.5; }
float map(vec3 p) { return find(p) * 0.1 + find(p.zxy); }
