void push(inout float d, float x) { if (x > 0.0) d += x; else { d -= 0.5 * x; return; } d *= 1.1; }
float map(vec3 p) { float d = 0.2; if (p.y > 0.1) push(d, p.x); else push(d, p.z); return d; }
