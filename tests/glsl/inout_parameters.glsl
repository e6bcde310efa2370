void fold(inout vec3 p, out float scale, in float k) { p = abs(p); if (p.x < p.y) p.xy = p.yx; p *= k; scale = k; k = 9.0; }
float map(vec3 p) { float s; fold(p, s, 1.5); fold(p, s, 1.2); return (length(p - 0.3) - 0.2) / s; }
