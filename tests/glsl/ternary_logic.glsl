float map(vec3 p) { bool a = p.x > 0.0, b = p.y > 0.0 && p.z < 0.4 || p.x < -0.5; bool c = a ^^ b; return (a ? 1.0 : b ? 2.0 : 3.0) + (c ? 0.1 : 0.2) + (!a && c ? 4.0 : 0.0) + float(a == b); }
