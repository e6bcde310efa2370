struct V { vec3 p; float r[3]; mat2 m; };
void mod_(inout V v[2], int i, out float s) { v[i].r[i + 1] *= 2.; v[1 - i].p.xz *= v[i].m; s = v[i].r[0] + v[1].r[2]; }
V[2] make(vec3 p) { V a; a.p = p; a.r = float[](.1, .2, .3); a.m = mat2(.8, .6, -.6, .8); return V[2](a, V(p.zxy, float[3](.3, .2, .1), a.m * a.m)); }
float map(vec3 p) { V v[2] = make(p); float s, t; mod_(v, p.x > 0. ? 1 : 0, s); mod_(v, 0, t); return min(length(v[0].p), length(v[1].p)) - v[int(p.y > 0.)].r[1] - s * .1 + t * .05; }
