float map(vec3 p) { float d = 0.0; for (int i = 0; i < 20; i++) { d += 0.07; if (d > abs(p.x)) break; d += p.y * 0.01; } return d; }
