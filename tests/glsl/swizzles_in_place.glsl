float map(vec3 p) {
  vec4 q = p.xyzx; q.wzyx = q; q.xz += q.wy; q.rgb.rg.x *= 2.; q.stpq.s -= .1;
  vec3 w = q.www; w.zx = w.xz * mat2(1, .5, -.5, 1); w.yx++; --w.z;
  (w.xy) *= .5; ivec3 i = ivec3(w * 10.); i.xy <<= 1; i.zx ^= ivec2(3, 5); i.y %= 7; i %= 11;
  mat3 m = mat3(w, q.xyz, p); m[1].xz = vec2(1, 2); m[2][1] += m[0][i.x & 1]; m[0] *= 2.; m *= .5; p *= m; p = m * p; m *= m; mat2 k = mat2(m); k++; -k;
  vec2 v = vec2(1) * k / 2.; bvec2 bb = bvec2(v); bb.x = !bb.y; float z = float(bb.x) + float(any(bb));
  return length(p) * .1 - .3 + z * .01 + float(i.x + i.y * i.z) * 1e-3 + length(v) * 1e-2;
}
