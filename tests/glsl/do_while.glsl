float map(vec3 p) { float x = abs(p.x); int n = 0; do { x = x * 1.3 + 0.05; n++; if (n > 6) break; } while (x < 1.0); return x + float(n) * 0.1; }
