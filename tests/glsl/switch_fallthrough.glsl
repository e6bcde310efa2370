float map(vec3 p) { float d = 0.0; switch (int(p.z * 3.0)) { case 0: d += 1.0; break; case 1: d += 2.0; default: d += 3.0; if (p.x > 0.0) break; d *= 2.0; case -2: d += 0.25; } return d; }
