// names that C++ or simd.h own
#define F(x) ((x)*2.)
#define M 3
#define I vec3(1,0,0)
struct wp { float near, far; };
float template_(float class_) { return class_; }
float new1(float delete1){ return delete1; }
float lerp(float a, float b, float t) { return a + (b-a)*t; }
float saturate(float x) { return clamp(x, 0., 1.); }
float min3(float a, float b, float c) { return min(a, min(b, c)); }
float max3(vec3 v) { return max(v.x, max(v.y, v.z)); }
float splat(float x) { return x; }
float sel(bool M_, float a, float b) { return M_ ? a : b; }
float lane(float x, int k) { return x + float(k)*0.; }
float mask(float budget) { return budget; }
float evaluate(float g) { return g; }
float int32_t_(float x) { return x; }
vec3 float3(float x, float y, float z) { return vec3(x,y,z); }
float auto_(float live) { return live; }
float distance_(vec3 live) { return length(live); }
float Simd(vec3 p) { return length(p) - .3; }
float Scene(vec3 p) { return length(p - float3(.5,0.,0.)) - .2; }
struct Globals { float budget; vec3 entry; };
float register_ = 0.1;
float std(float x) { return x; }
float main_(float x) { return x; }
float printf(float x) { return x; }
float errno = .01, NULL_ = .02, NAN = .03, INFINITY = 1e9, M_E = 2.718, EOF = -1.;
float map(vec3 p) {
    float F_ = F(p.x), near = .1, far = 10., r0 = 0., t1 = 1., p1_0 = .2;
    wp w = wp(near, far);
    Globals gl = Globals(.1, p);
    float d = min3(Simd(p), Scene(p), max3(abs(p + I*.5) - .2));
    d = lerp(d, length(gl.entry) - .4, saturate(.2 + errno));
    for (int i = 0; i < M; i++) d = min(d, lane(length(p - vec3(0., .3*float(i), 0.)) - .1, i));
    return d + w.near * 0. + splat(0.) + sel(p.x > 0., 0., 0.0) + F_*0. + std(0.) + printf(0.)+ evaluate(0.) + mask(0.);
}
