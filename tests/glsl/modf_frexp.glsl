float map(vec3 p) { float w; float f = modf(p.x * 5.0, w); int e; float m = frexp(p.y + 1.5, e); return f + w * .1 + m + float(e) + ldexp(p.z, 3); }
