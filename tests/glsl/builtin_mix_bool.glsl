float map(vec3 p) { vec3 a = mix(p, p.zxy, greaterThan(p, vec3(0.0))); return a.x + 2.0 * a.y + 3.0 * a.z + mix(1.0, 2.0, p.x > 0.1); }
