float map(vec3 p) { float d = 0.0; for (int i = 0; i < 8; i++) { if (p.x * float(i) > 1.0) continue; if (i == 2) continue; d += float(i) * 0.1; } return d; }
