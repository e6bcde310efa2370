float map(vec3 p) { int n = int(abs(p.x) * 6.0); float s = 0.0; for (int i = 0; i < n; i++) s += sin(float(i) + p.y); return s; }
