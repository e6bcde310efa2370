#define PI 3.14159265
#define SQ(x) ((x) * (x))
#define rot(a) mat2(cos(a), sin(a), -sin(a), cos(a))
#ifdef PI
#define R 0.4
#else
#error no
#endif
#if R_UNSET + 1 > 1
#error no
#endif
float map(vec3 p) { p.xz *= rot(PI / 5.0); return sqrt(SQ(p.x) + SQ(p.y) + SQ(p.z)) - R; }
