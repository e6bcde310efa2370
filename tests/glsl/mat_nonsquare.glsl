float map(vec3 p) { mat2x3 m = mat2x3(p, p.yzx); mat3x2 t = transpose(m); vec3 a = m * p.xy; vec2 b = p * m; mat2 s = t * m; return a.x + a.z + b.y + s[1][0] + m[1].z; }
