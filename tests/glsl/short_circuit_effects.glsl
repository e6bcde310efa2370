bool bump(inout float x) { x += 1.0; return x > 1.5; }
float map(vec3 p) { float x = p.x; bool r = p.y > 0.0 && bump(x); bool q = p.z > 0.0 || bump(x); return x + float(r) + float(q); }
