float map(vec3 p) {
  float d = 1e3; int n = 0;
  for (int i = 0; i < 8; i++) {
    if (i == 2) continue;
    for (int j = 0; ; j++) {
      if (j >= i) break; if (((i ^ j) & 1) == 0) continue;
      int k = 0; while (true) { k++; if (k > 3 || float(k) > p.x * 4.) break; d = min(d, length(p - .2 * vec3(i - 4, j - 2, k - 2)) - .07); if (d < -.05) return d; }
      n += k;
      switch (n % 4) { case 1: continue; case 2: d += .001; break; default: if (p.z > .9) return .5; }
    }
  }
  return d + float(n) * 1e-4;
}
