#define real float
#define vec3f vec3
#define float3 vec3
#define float2 vec2
#define lerp mix
#define frac fract
#define fmod(a,b) ((a)-(b)*trunc((a)/(b)))
#define mul(a,b) ((b)*(a))
#define saturate(x) clamp(x, 0.0, 1.0)
#define static
#define inline
real map(float3 p) { p.xz = mul(mat2(.8,.6,-.6,.8), p.xz); return lerp(length(p) - .5, p.y, saturate(.1)) + frac(.5) * 0. + fmod(p.x, .3) * .01; }
