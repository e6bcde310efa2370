float map(vec3 p) { vec3 t[4] = vec3[4](p, p.zyx, -p, p * 2.0); int k = int(clamp(p.x * 2.0 + 2.0, 0.0, 3.0)); t[k].y = 3.0; return dot(t[3 - k], vec3(1, 2, 3)) + t[k][k % 3]; }
