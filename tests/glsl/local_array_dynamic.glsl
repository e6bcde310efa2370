float map(vec3 p) { float t[5]; for (int i = 0; i < 5; i++) t[i] = p.x * float(i); int k = int(p.y * 2.5 + 2.5); t[k] += 1.0; return t[(k + 1) % 5] + t[k]; }
