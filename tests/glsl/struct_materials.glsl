struct Material { vec3 albedo; float metallic, roughness; int type; };
struct Surface { Material mat; float dist; vec3 nor; };
struct Ray { vec3 o, d; };
Material M_RED = Material(vec3(1,0,0), .1, .2, 1);
const Material M_BLUE = Material(vec3(0,0,1), .1, .2, 2);
Surface minS(Surface a, Surface b) { if (a.dist < b.dist) return a; return b; }
Surface smoothS(Surface a, Surface b, float k) { float h = clamp(.5 + .5*(b.dist - a.dist)/k, 0., 1.); Surface r; r.mat.albedo = mix(b.mat.albedo, a.mat.albedo, h); r.mat.metallic = mix(b.mat.metallic, a.mat.metallic, h); r.mat.roughness = .5; r.mat.type = h > .5 ? a.mat.type : b.mat.type; r.dist = mix(b.dist, a.dist, h) - k*h*(1.-h); r.nor = vec3(0); return r; }
Surface map(vec3 p) {
  Surface a = Surface(M_RED, length(p) - .4, vec3(0)), b;
  b.mat = M_BLUE; b.dist = length(p - vec3(.4, .1, 0)) - .3;
  Surface arr[2] = Surface[2](a, b);
  arr[1].dist -= .05; arr[0].mat.albedo.gb = vec2(.3, arr[1].mat.albedo.r);
  return minS(smoothS(arr[0], arr[1], .2), Surface(Material(vec3(.5), 0., 1., 0), p.y + .5, vec3(0,1,0)));
}
float march(Ray r) { float t = 0.; for (int i = 0; i < 100; i++) { Surface s = map(r.o + r.d*t); t += s.dist; } return t; }
