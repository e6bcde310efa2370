int   matId, objId = 0; float minDist; vec3 gPos, gCol; bool hit; mat2 gRot; uvec3 seed;
#define res(d, id) if ((d) < minDist) { minDist = (d); matId = id; }
void Push(float d, int id, vec3 c) { if (d < minDist) { minDist = d; matId = id; gCol = c; } objId++; }
float rnd() { seed = seed * 747796405u + 2891336453u; seed.x ^= seed.y >> 13u; return float(seed.x) / 4294967295.; }
float GetDist(vec3 p) {
  minDist = 1e9; matId = -1; objId = 0; seed = uvec3(1u,2u,3u); gRot = mat2(cos(.5), sin(.5), -sin(.5), cos(.5));
  gPos = p; gPos.xy *= gRot;
  Push(length(gPos) - .3, 1, vec3(1,0,0));
  for (int i = 0; i < 5; i++) { vec3 c = vec3(rnd(), rnd(), rnd()) * 1.6 - .8; Push(length(p - c) - .1 - .02*float(objId), objId, c); }
  res(p.y + .8, 7) res(length(p.xz) - .05, 8)
  hit = minDist < .001;
  if (matId == 7) minDist += .01*sin(p.x*20.)*sin(p.z*20.);
  return minDist;
}
