float size(float x) { return abs(x); }
float size(vec2 v) { return length(v); }
float size(vec3 v) { return length(v) * 0.5; }
float map(vec3 p) { return size(p.x) + size(p.xy) + size(p) - 1.0; }
