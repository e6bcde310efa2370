float map(vec3 p) { float z = p.x > 0.0 ? 0.0 : 1.0; float a = 1.0 / z; return (isinf(a) ? 1.0 : a) + (isnan(p.y) ? 5.0 : 0.25); }
