// The last bit of a sum, a mix or a step counts where a hash enlarges it
float scatter(vec3 p) { p = fract(p * vec3(0.137, 0.119, 0.151)); p += dot(p, p.zxy + 21.7); return fract((p.x + p.y) * p.z); }
float map(vec3 p) {
  vec3 cell = floor(p * 20.0);
  float a = scatter(cell), b = fract(1e3 * length(p)), c = fract(1e3 * mix(p.x, p.y, p.z)), d = fract(1e3 * (p * mat3(p, p.yzx, p.zxy)).y);
  return length(p) - 0.5 + 0.1 * a + 0.01 * (b + c + d);
}
