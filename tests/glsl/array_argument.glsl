float total(float a[3], int n) { float s = 0.0; for (int i = 0; i < n; ++i) s += a[i]; return s; }
float map(vec3 p) { float a[3] = float[3](p.x, p.y, p.z); return total(a, 2) + total(a, 3); }
