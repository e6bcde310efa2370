float sdf(vec3 p) { float d = p.x; vec2 c = vec2(0.0, 1.0); for (int i = 0; i < 4; i++) { c = c * 1.3 + vec2(0.1, 0.2); if ((c + c).y > 3.0) d = p.y; d *= 1.1; } return d; }
