float prim(int kind, vec3 p, vec4 a) {
  switch (kind) {
    case 0: return length(p) - a.x;
    case 1: { vec3 q = abs(p) - a.xyz; return length(max(q, 0.)) + min(max(q.x, max(q.y, q.z)), 0.); }
    case 2: p = p.xzy;
    case 3: vec2 t = vec2(length(p.xz) - a.x, p.y); return length(t) - a.y;
    default: break;
  }
  return p.y + a.w;
}
struct Prim { int kind; vec3 pos; vec4 arg; uint flags; };
const Prim PRIMS[5] = Prim[5](
  Prim(0, vec3(0, 0, 0), vec4(.3), 1u), Prim(1, vec3(.5, 0, 0), vec4(.2, .1, .3, 0), 2u),
  Prim(2, vec3(-.5, .2, 0), vec4(.25, .06, 0, 0), 1u|4u), Prim(3, vec3(0, .5, 0), vec4(.3, .05, 0, 0), 3u), Prim(9, vec3(0), vec4(0, 0, 0, .7), 0u));
float smin(float a, float b, float k) { float h = max(k - abs(a - b), 0.) / k; return min(a, b) - h*h*k*.25; }
float map(vec3 p) {
  float d = 1e5;
  for (int i = 0; i < PRIMS.length(); ++i) {
    Prim q = PRIMS[i];
    float e = prim(q.kind, p - q.pos, q.arg);
    bool smooth_ = (q.flags & 1u) != 0u, carve = bool(q.flags & 2u) && !bool(bitfieldExtract(q.flags, 0, 1));
    if (carve) d = max(d, -e); else d = smooth_ ? smin(d, e, .1) : min(d, e);
    if ((q.flags >> 2 & 1u) == 1u) continue;
    d += .0001 * float(findMSB(q.flags + 1u));
  }
  return d;
}
