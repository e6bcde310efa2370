float sdf(vec3 p) { float d = 0.0, t = 1.0; int n = 0; for (int i = 0; i < 8; i++) { if (sin(p.x * float(i) * 3.0 + p.y) > 0.1) { t *= 1.1; n++; if (n > 2) d += t + 0.1 * float(n); } } return d; }
