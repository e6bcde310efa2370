vec2 map(vec3 p) { float a = length(p) - 0.4, b = p.y + 0.3; return a < b ? vec2(a, 1.0) : vec2(b, 2.0); }
