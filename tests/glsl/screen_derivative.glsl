float map(vec3 p) { float w = fwidth(p.x); return length(p) - .5 + 0. * w; }
