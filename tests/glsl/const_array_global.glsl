const vec3 K[3] = vec3[](vec3(.1, .2, .3), vec3(-.1, .2, .3), vec3(.1, -.2, .3));
float map(vec3 p) { float d = 1e9; for (int i = 0; i < 3; i++) d = min(d, length(p - K[i]) - 0.1); return d + K[p.x > 0.0 ? 1 : 2].y; }
