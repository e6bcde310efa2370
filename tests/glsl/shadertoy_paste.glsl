// A picture's worth of code around a map: the rest is ignored
mat2 rot(float a) { float c = cos(a), s = sin(a); return mat2(c, -s, s, c); }
float map(in vec3 p) { p.xz *= rot(iTime * 0.3 + 0.4); vec3 q = abs(p) - vec3(.4, .2, .3); return length(max(q, 0.)) + min(max(q.x, max(q.y, q.z)), 0.) - .05; }
vec3 normal(vec3 p) { vec2 e = vec2(1e-3, 0); return normalize(vec3(map(p + e.xyy), map(p + e.yxy), map(p + e.yyx)) - map(p)); }
void mainImage(out vec4 fragColor, in vec2 fragCoord) {
    vec2 uv = (2.0 * fragCoord - iResolution.xy) / iResolution.y; vec3 o = vec3(0, 0, 2), d = normalize(vec3(uv + iMouse.xy * .001, -1.5)); float t = 0.;
    for (int i = 0; i < 60; i++) { float h = map(o + t * d); if (h < 1e-3 || t > 9.) break; t += h; }
    fragColor = vec4(t < 9. ? normal(o + t * d) * .5 + .5 : vec3(0), 1);
}
