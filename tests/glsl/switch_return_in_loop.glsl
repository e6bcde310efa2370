float f(int i, vec3 p) { switch (i % 3) { case 0: return p.x; case 1: p.y *= 2.0; break; case 2: return p.z; } return p.y; }
float map(vec3 p) { float s = 0.0; for (int i = 0; i < 6; i++) { s += f(i + int(p.x > 0.3), p); } return s; }
