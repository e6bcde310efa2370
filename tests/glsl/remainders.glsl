float map(vec3 p) {
 vec3 w = p*3.; ivec3 i = ivec3(w * 10.); i.xy <<= 1; i.zx ^= ivec2(3, 5); i.y %= 7; i %= 11;
  return float(i.x)+3.*float(i.y)+float(i.z)*5.; }
