float map(vec3 p) { vec4 v = vec4(p, 1.0); v.wx = v.yz; v.rgb += v.bgr * 0.5; vec2 s = v.st; s.yx *= 2.0; v.zw = s; p.xy = p.yx; return v.x + v.y * 2.0 + v.z * 3.0 + v.w * 4.0 + p.x; }
