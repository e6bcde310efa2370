float map(vec3 p) { vec3 a = abs(p) + 0.05; return pow(a.x, 2.3) + exp(p.x) + log(a.y) + exp2(p.y) + log2(a.z) + sqrt(a.x) + inversesqrt(a.y) + pow(vec2(a.xy), vec2(1.5, 0.5)).y; }
