float map(vec3 p) { float x = abs(p.x) + 0.1; int n = 0; while (x < 1.0) { x *= 1.5; n++; } return x + float(n); }
