// no well-known name at all: only march loop tells
float sdSphere(vec3 p, float r) { return length(p) - r; }
float theWholeThing(vec3 q) { return min(sdSphere(q, .4), q.y + .4); }
float castRay(vec3 ro, vec3 rd) { float t = 0.; for (int i = 0; i < 100; i++) { float h = theWholeThing(ro + rd * t); if (h < .001) break; t += h; } return t; }
vec3 getNormal(vec3 p) { vec2 e = vec2(.001, 0); return normalize(vec3(theWholeThing(p + e.xyy) - theWholeThing(p - e.xyy), theWholeThing(p + e.yxy) - theWholeThing(p - e.yxy), theWholeThing(p + e.yyx) - theWholeThing(p - e.yyx))); }
void mainImage(out vec4 c, in vec2 f) { c = vec4(castRay(vec3(0,0,3), normalize(vec3(f, -1.)))); }
