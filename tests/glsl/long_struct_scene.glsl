// Long: forty parts, each a struct with a material, joined hard or softly
struct Hit { float d; vec3 col; float gloss; int id; };
float ball(vec3 p, float r) { return length(p) - r; }
float brick(vec3 p, vec3 b) { p = abs(p) - b; return length(max(p, 0.0)) + min(max(p.x, max(p.y, p.z)), 0.0); }
float hoop(vec3 p, float r, float w) { return length(vec2(length(p.xz) - r, p.y)) - w; }
float pole(vec3 p, vec3 to, float r) { return length(p - to * clamp(dot(p, to) / dot(to, to), 0.0, 1.0)) - r; }
mat2 turn(float a) { return mat2(cos(a), sin(a), -sin(a), cos(a)); }
Hit nearer(Hit a, Hit b) { if (b.d < a.d) return b; return a; }
Hit soft(Hit a, Hit b, float k) {
  float h = clamp(0.5 + 0.5 * (b.d - a.d) / k, 0.0, 1.0);
  Hit r = Hit(mix(b.d, a.d, h) - k * h * (1.0 - h), mix(b.col, a.col, h), mix(b.gloss, a.gloss, h), b.id);
  if (h > 0.5) r.id = a.id;
  return r;
}
Hit part0(vec3 p) {
  vec3 q = p - vec3(-0.10, 0.12, 0.85);
  Hit h = Hit(pole(q, vec3(-0.02, 0.14, -0.12), 0.05), vec3(0.48, 0.61, 0.19), 45.0, 0);
  q.xy *= turn(0.27);
  h = soft(h, Hit(ball(q, 0.14), vec3(0.40, 0.45, 0.74), 1.0, 100), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.15;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(ball(q, 0.17), vec3(0.06, 0.04, 0.88), 2.0, 200));
}
Hit part1(vec3 p) {
  vec3 q = p - vec3(0.20, 0.56, -0.35);
  Hit h = Hit(brick(q, vec3(0.13, 0.15, 0.12)), vec3(0.66, 0.46, 0.28), 99.0, 1);
  q.xy *= turn(2.12);
  h = soft(h, Hit(hoop(q, 0.18, 0.04), vec3(0.03, 0.56, 0.11), 1.0, 101), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.07;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(hoop(q, 0.14, 0.05), vec3(0.85, 0.00, 0.21), 2.0, 201));
}
Hit part2(vec3 p) {
  vec3 q = p - vec3(0.82, -0.06, 0.96);
  Hit h = Hit(pole(q, vec3(-0.03, 0.03, -0.12), 0.05), vec3(0.34, 0.31, 0.02), 41.0, 2);
  q.xy *= turn(0.40);
  h = soft(h, Hit(ball(q, 0.05), vec3(0.46, 0.49, 0.68), 1.0, 102), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.08;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(brick(q, vec3(0.20, 0.17, 0.11)), vec3(0.38, 0.39, 0.99), 2.0, 202));
}
Hit part3(vec3 p) {
  vec3 q = p - vec3(-1.00, 0.73, 0.95);
  Hit h = Hit(hoop(q, 0.20, 0.02), vec3(0.19, 1.00, 0.60), 58.0, 3);
  q.xy *= turn(2.97);
  h = soft(h, Hit(brick(q, vec3(0.12, 0.05, 0.14)), vec3(0.83, 0.39, 0.07), 1.0, 103), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.08;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(brick(q, vec3(0.05, 0.11, 0.14)), vec3(0.13, 0.59, 0.83), 2.0, 203));
}
Hit part4(vec3 p) {
  vec3 q = p - vec3(-0.73, -0.23, 0.25);
  Hit h = Hit(hoop(q, 0.19, 0.04), vec3(0.25, 0.19, 0.74), 93.0, 4);
  q.xy *= turn(2.06);
  h = soft(h, Hit(pole(q, vec3(0.15, 0.04, -0.03), 0.02), vec3(0.04, 0.96, 0.24), 1.0, 104), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.16;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(hoop(q, 0.14, 0.05), vec3(0.49, 0.52, 0.93), 2.0, 204));
}
Hit part5(vec3 p) {
  vec3 q = p - vec3(0.95, -0.75, -0.04);
  Hit h = Hit(ball(q, 0.09), vec3(0.92, 0.20, 0.02), 27.0, 5);
  q.yz *= turn(0.75);
  h = soft(h, Hit(ball(q, 0.08), vec3(0.37, 0.57, 0.13), 1.0, 105), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.10;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(pole(q, vec3(0.19, 0.06, 0.08), 0.04), vec3(0.14, 0.04, 0.02), 2.0, 205));
}
Hit part6(vec3 p) {
  vec3 q = p - vec3(0.82, 0.40, 0.93);
  Hit h = Hit(ball(q, 0.14), vec3(0.07, 0.07, 0.31), 14.0, 6);
  q.xy *= turn(0.23);
  h = soft(h, Hit(hoop(q, 0.17, 0.05), vec3(0.74, 0.70, 0.79), 1.0, 106), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.19;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(hoop(q, 0.11, 0.03), vec3(0.08, 0.86, 0.94), 2.0, 206));
}
Hit part7(vec3 p) {
  vec3 q = p - vec3(-0.94, -0.00, -0.97);
  Hit h = Hit(pole(q, vec3(-0.05, -0.20, -0.17), 0.02), vec3(0.12, 0.26, 0.42), 33.0, 7);
  q.zx *= turn(2.08);
  h = soft(h, Hit(pole(q, vec3(-0.02, 0.14, -0.17), 0.05), vec3(0.03, 0.60, 0.48), 1.0, 107), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.08;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(ball(q, 0.12), vec3(0.61, 0.92, 0.26), 2.0, 207));
}
Hit part8(vec3 p) {
  vec3 q = p - vec3(-0.98, -0.40, 0.36);
  Hit h = Hit(brick(q, vec3(0.13, 0.16, 0.10)), vec3(0.93, 0.50, 0.24), 41.0, 8);
  q.yz *= turn(0.60);
  h = soft(h, Hit(pole(q, vec3(0.12, 0.10, -0.12), 0.03), vec3(0.22, 0.92, 0.21), 1.0, 108), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.07;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(hoop(q, 0.18, 0.05), vec3(0.71, 0.95, 0.28), 2.0, 208));
}
Hit part9(vec3 p) {
  vec3 q = p - vec3(-0.66, -0.10, -0.45);
  Hit h = Hit(brick(q, vec3(0.17, 0.11, 0.13)), vec3(0.67, 0.72, 0.84), 62.0, 9);
  q.yz *= turn(0.22);
  h = soft(h, Hit(ball(q, 0.09), vec3(0.61, 0.68, 0.28), 1.0, 109), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.10;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(ball(q, 0.15), vec3(0.41, 0.19, 0.77), 2.0, 209));
}
Hit part10(vec3 p) {
  vec3 q = p - vec3(-0.47, 0.56, 0.59);
  Hit h = Hit(ball(q, 0.12), vec3(0.63, 0.66, 0.81), 95.0, 10);
  q.zx *= turn(0.59);
  h = soft(h, Hit(pole(q, vec3(-0.10, 0.09, 0.10), 0.04), vec3(0.04, 0.23, 0.78), 1.0, 110), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.13;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(brick(q, vec3(0.11, 0.17, 0.19)), vec3(0.09, 0.93, 0.72), 2.0, 210));
}
Hit part11(vec3 p) {
  vec3 q = p - vec3(-0.74, -0.09, 0.25);
  Hit h = Hit(ball(q, 0.11), vec3(0.57, 0.88, 0.80), 94.0, 11);
  q.yz *= turn(0.98);
  h = soft(h, Hit(brick(q, vec3(0.06, 0.18, 0.17)), vec3(0.92, 0.12, 0.24), 1.0, 111), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.11;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(ball(q, 0.20), vec3(0.54, 0.79, 0.32), 2.0, 211));
}
Hit part12(vec3 p) {
  vec3 q = p - vec3(0.82, 0.71, -0.30);
  Hit h = Hit(ball(q, 0.06), vec3(0.34, 0.42, 0.28), 91.0, 12);
  q.xy *= turn(2.43);
  h = soft(h, Hit(ball(q, 0.11), vec3(0.04, 0.53, 0.69), 1.0, 112), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.19;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(pole(q, vec3(-0.14, 0.01, 0.09), 0.05), vec3(0.69, 0.95, 0.49), 2.0, 212));
}
Hit part13(vec3 p) {
  vec3 q = p - vec3(0.90, -0.83, -0.56);
  Hit h = Hit(hoop(q, 0.18, 0.04), vec3(0.16, 0.51, 0.91), 26.0, 13);
  q.zx *= turn(1.14);
  h = soft(h, Hit(brick(q, vec3(0.10, 0.07, 0.13)), vec3(0.27, 0.50, 0.41), 1.0, 113), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.07;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(ball(q, 0.14), vec3(0.03, 0.97, 0.52), 2.0, 213));
}
Hit part14(vec3 p) {
  vec3 q = p - vec3(-0.20, 0.60, 0.13);
  Hit h = Hit(pole(q, vec3(-0.16, -0.13, 0.17), 0.04), vec3(0.92, 0.80, 0.40), 25.0, 14);
  q.yz *= turn(0.38);
  h = soft(h, Hit(pole(q, vec3(0.16, 0.17, 0.17), 0.04), vec3(0.11, 0.42, 0.03), 1.0, 114), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.09;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(ball(q, 0.06), vec3(0.16, 0.01, 0.28), 2.0, 214));
}
Hit part15(vec3 p) {
  vec3 q = p - vec3(0.45, -0.51, -0.00);
  Hit h = Hit(pole(q, vec3(0.09, -0.15, 0.00), 0.03), vec3(0.20, 0.53, 0.44), 38.0, 15);
  q.yz *= turn(2.48);
  h = soft(h, Hit(brick(q, vec3(0.13, 0.18, 0.13)), vec3(0.22, 0.22, 0.54), 1.0, 115), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.14;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(brick(q, vec3(0.08, 0.16, 0.17)), vec3(0.90, 0.32, 0.31), 2.0, 215));
}
Hit part16(vec3 p) {
  vec3 q = p - vec3(0.85, -0.56, 1.00);
  Hit h = Hit(ball(q, 0.07), vec3(0.24, 0.73, 0.26), 11.0, 16);
  q.yz *= turn(1.63);
  h = soft(h, Hit(brick(q, vec3(0.08, 0.14, 0.17)), vec3(0.10, 0.57, 0.36), 1.0, 116), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.17;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(hoop(q, 0.11, 0.04), vec3(0.76, 0.50, 0.69), 2.0, 216));
}
Hit part17(vec3 p) {
  vec3 q = p - vec3(-0.62, -0.86, -0.79);
  Hit h = Hit(ball(q, 0.16), vec3(0.61, 0.91, 0.48), 20.0, 17);
  q.xy *= turn(0.61);
  h = soft(h, Hit(brick(q, vec3(0.20, 0.19, 0.06)), vec3(0.06, 0.95, 0.46), 1.0, 117), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.16;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(hoop(q, 0.14, 0.03), vec3(0.35, 0.21, 0.37), 2.0, 217));
}
Hit part18(vec3 p) {
  vec3 q = p - vec3(0.27, -0.92, -0.60);
  Hit h = Hit(pole(q, vec3(-0.02, 0.10, -0.04), 0.03), vec3(0.17, 0.51, 0.02), 89.0, 18);
  q.zx *= turn(2.63);
  h = soft(h, Hit(pole(q, vec3(0.03, -0.12, 0.03), 0.03), vec3(0.76, 0.28, 0.12), 1.0, 118), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.16;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(brick(q, vec3(0.17, 0.11, 0.18)), vec3(0.88, 0.69, 0.77), 2.0, 218));
}
Hit part19(vec3 p) {
  vec3 q = p - vec3(0.53, -0.19, 0.45);
  Hit h = Hit(ball(q, 0.17), vec3(0.30, 0.10, 0.89), 98.0, 19);
  q.zx *= turn(0.15);
  h = soft(h, Hit(hoop(q, 0.19, 0.04), vec3(0.34, 0.66, 0.57), 1.0, 119), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.13;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(pole(q, vec3(0.01, -0.00, -0.11), 0.02), vec3(0.40, 0.57, 0.11), 2.0, 219));
}
Hit part20(vec3 p) {
  vec3 q = p - vec3(-0.78, -0.53, -0.11);
  Hit h = Hit(ball(q, 0.16), vec3(0.65, 0.01, 0.26), 28.0, 20);
  q.yz *= turn(1.65);
  h = soft(h, Hit(pole(q, vec3(0.19, 0.03, 0.20), 0.05), vec3(0.81, 0.08, 0.60), 1.0, 120), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.16;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(ball(q, 0.11), vec3(0.94, 0.39, 0.97), 2.0, 220));
}
Hit part21(vec3 p) {
  vec3 q = p - vec3(0.71, 0.08, 0.19);
  Hit h = Hit(pole(q, vec3(0.18, -0.03, 0.01), 0.04), vec3(0.37, 0.29, 0.66), 56.0, 21);
  q.yz *= turn(1.99);
  h = soft(h, Hit(hoop(q, 0.10, 0.04), vec3(0.59, 0.63, 0.41), 1.0, 121), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.15;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(ball(q, 0.18), vec3(0.75, 0.05, 0.99), 2.0, 221));
}
Hit part22(vec3 p) {
  vec3 q = p - vec3(0.89, -0.85, 0.81);
  Hit h = Hit(pole(q, vec3(0.09, -0.10, 0.10), 0.02), vec3(0.10, 0.81, 0.91), 15.0, 22);
  q.xy *= turn(1.81);
  h = soft(h, Hit(ball(q, 0.06), vec3(0.42, 0.12, 0.86), 1.0, 122), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.10;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(brick(q, vec3(0.07, 0.12, 0.15)), vec3(0.46, 0.26, 0.58), 2.0, 222));
}
Hit part23(vec3 p) {
  vec3 q = p - vec3(-0.16, 0.56, 0.06);
  Hit h = Hit(brick(q, vec3(0.19, 0.16, 0.09)), vec3(0.11, 0.89, 0.78), 62.0, 23);
  q.yz *= turn(0.82);
  h = soft(h, Hit(brick(q, vec3(0.14, 0.16, 0.08)), vec3(0.25, 0.98, 0.92), 1.0, 123), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.18;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(ball(q, 0.14), vec3(0.01, 0.26, 0.03), 2.0, 223));
}
Hit part24(vec3 p) {
  vec3 q = p - vec3(-0.92, -0.55, -0.44);
  Hit h = Hit(ball(q, 0.19), vec3(0.16, 0.23, 0.98), 48.0, 24);
  q.yz *= turn(0.63);
  h = soft(h, Hit(hoop(q, 0.15, 0.02), vec3(0.87, 0.80, 0.45), 1.0, 124), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.17;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(brick(q, vec3(0.12, 0.16, 0.11)), vec3(0.15, 0.15, 0.84), 2.0, 224));
}
Hit part25(vec3 p) {
  vec3 q = p - vec3(0.19, -0.42, 0.52);
  Hit h = Hit(brick(q, vec3(0.11, 0.11, 0.06)), vec3(0.88, 0.08, 0.08), 56.0, 25);
  q.yz *= turn(2.45);
  h = soft(h, Hit(pole(q, vec3(-0.08, 0.11, -0.17), 0.03), vec3(0.66, 0.08, 0.30), 1.0, 125), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.16;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(hoop(q, 0.13, 0.02), vec3(0.36, 0.73, 0.37), 2.0, 225));
}
Hit part26(vec3 p) {
  vec3 q = p - vec3(-0.77, 0.42, 0.14);
  Hit h = Hit(hoop(q, 0.14, 0.04), vec3(0.30, 0.32, 0.40), 93.0, 26);
  q.zx *= turn(0.74);
  h = soft(h, Hit(hoop(q, 0.18, 0.02), vec3(0.68, 0.58, 0.80), 1.0, 126), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.16;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(hoop(q, 0.18, 0.04), vec3(0.84, 0.56, 0.18), 2.0, 226));
}
Hit part27(vec3 p) {
  vec3 q = p - vec3(0.52, 0.76, -0.44);
  Hit h = Hit(ball(q, 0.08), vec3(0.06, 0.16, 0.30), 3.0, 27);
  q.yz *= turn(0.19);
  h = soft(h, Hit(hoop(q, 0.18, 0.02), vec3(0.08, 0.74, 0.90), 1.0, 127), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.06;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(brick(q, vec3(0.06, 0.17, 0.11)), vec3(0.71, 0.49, 0.91), 2.0, 227));
}
Hit part28(vec3 p) {
  vec3 q = p - vec3(-0.32, -0.08, -0.30);
  Hit h = Hit(hoop(q, 0.17, 0.03), vec3(0.54, 0.72, 0.71), 91.0, 28);
  q.yz *= turn(2.27);
  h = soft(h, Hit(hoop(q, 0.19, 0.04), vec3(0.83, 0.89, 0.96), 1.0, 128), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.15;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(hoop(q, 0.17, 0.04), vec3(0.42, 0.42, 0.15), 2.0, 228));
}
Hit part29(vec3 p) {
  vec3 q = p - vec3(0.48, 0.98, -0.25);
  Hit h = Hit(brick(q, vec3(0.10, 0.11, 0.13)), vec3(0.27, 0.89, 0.47), 73.0, 29);
  q.yz *= turn(1.94);
  h = soft(h, Hit(brick(q, vec3(0.19, 0.16, 0.05)), vec3(0.48, 0.80, 0.31), 1.0, 129), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.08;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(hoop(q, 0.12, 0.03), vec3(0.72, 0.59, 0.22), 2.0, 229));
}
Hit part30(vec3 p) {
  vec3 q = p - vec3(-0.63, -0.44, -0.65);
  Hit h = Hit(hoop(q, 0.16, 0.05), vec3(0.55, 0.85, 0.48), 40.0, 30);
  q.yz *= turn(1.98);
  h = soft(h, Hit(ball(q, 0.12), vec3(0.22, 0.05, 0.95), 1.0, 130), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.17;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(pole(q, vec3(0.19, 0.12, 0.11), 0.05), vec3(0.06, 0.92, 0.89), 2.0, 230));
}
Hit part31(vec3 p) {
  vec3 q = p - vec3(0.75, 0.81, -0.10);
  Hit h = Hit(brick(q, vec3(0.16, 0.14, 0.07)), vec3(0.16, 0.32, 0.26), 86.0, 31);
  q.zx *= turn(0.39);
  h = soft(h, Hit(hoop(q, 0.15, 0.02), vec3(0.57, 0.18, 0.20), 1.0, 131), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.19;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(brick(q, vec3(0.17, 0.06, 0.09)), vec3(0.72, 0.10, 0.48), 2.0, 231));
}
Hit part32(vec3 p) {
  vec3 q = p - vec3(-0.06, 0.91, 0.17);
  Hit h = Hit(hoop(q, 0.10, 0.03), vec3(0.19, 0.68, 0.78), 44.0, 32);
  q.xy *= turn(1.63);
  h = soft(h, Hit(pole(q, vec3(-0.14, 0.13, -0.08), 0.03), vec3(0.08, 0.31, 0.47), 1.0, 132), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.16;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(hoop(q, 0.11, 0.02), vec3(0.67, 0.68, 0.75), 2.0, 232));
}
Hit part33(vec3 p) {
  vec3 q = p - vec3(0.57, -0.76, -0.11);
  Hit h = Hit(pole(q, vec3(0.08, -0.01, -0.08), 0.02), vec3(0.77, 0.86, 0.84), 71.0, 33);
  q.zx *= turn(0.46);
  h = soft(h, Hit(pole(q, vec3(0.17, 0.10, 0.18), 0.05), vec3(0.56, 0.09, 0.19), 1.0, 133), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.11;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(ball(q, 0.10), vec3(0.95, 0.56, 0.72), 2.0, 233));
}
Hit part34(vec3 p) {
  vec3 q = p - vec3(-0.34, 0.65, -0.82);
  Hit h = Hit(brick(q, vec3(0.14, 0.07, 0.14)), vec3(0.18, 0.19, 0.04), 46.0, 34);
  q.zx *= turn(0.27);
  h = soft(h, Hit(brick(q, vec3(0.05, 0.20, 0.12)), vec3(0.77, 0.34, 0.82), 1.0, 134), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.19;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(brick(q, vec3(0.15, 0.17, 0.17)), vec3(0.39, 0.33, 0.41), 2.0, 234));
}
Hit part35(vec3 p) {
  vec3 q = p - vec3(-0.97, -0.20, 0.40);
  Hit h = Hit(brick(q, vec3(0.15, 0.14, 0.05)), vec3(0.33, 0.34, 0.65), 11.0, 35);
  q.yz *= turn(0.61);
  h = soft(h, Hit(hoop(q, 0.18, 0.04), vec3(0.61, 0.16, 0.77), 1.0, 135), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.19;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(brick(q, vec3(0.10, 0.13, 0.07)), vec3(0.71, 0.99, 0.52), 2.0, 235));
}
Hit part36(vec3 p) {
  vec3 q = p - vec3(0.43, 0.67, -0.61);
  Hit h = Hit(ball(q, 0.14), vec3(0.20, 0.08, 0.24), 57.0, 36);
  q.zx *= turn(1.00);
  h = soft(h, Hit(ball(q, 0.19), vec3(0.36, 0.46, 0.12), 1.0, 136), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.20;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(brick(q, vec3(0.09, 0.14, 0.13)), vec3(0.06, 0.92, 0.17), 2.0, 236));
}
Hit part37(vec3 p) {
  vec3 q = p - vec3(0.49, 0.79, -0.33);
  Hit h = Hit(brick(q, vec3(0.07, 0.17, 0.09)), vec3(0.90, 0.24, 0.57), 82.0, 37);
  q.xy *= turn(1.79);
  h = soft(h, Hit(ball(q, 0.12), vec3(0.40, 0.78, 0.93), 1.0, 137), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.20;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(brick(q, vec3(0.10, 0.15, 0.16)), vec3(0.38, 0.59, 0.80), 2.0, 237));
}
Hit part38(vec3 p) {
  vec3 q = p - vec3(-0.97, -0.60, -0.06);
  Hit h = Hit(brick(q, vec3(0.13, 0.07, 0.11)), vec3(0.34, 0.13, 0.24), 92.0, 38);
  q.xy *= turn(1.93);
  h = soft(h, Hit(ball(q, 0.16), vec3(0.79, 0.40, 0.50), 1.0, 138), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.07;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(hoop(q, 0.14, 0.04), vec3(0.69, 0.76, 0.75), 2.0, 238));
}
Hit part39(vec3 p) {
  vec3 q = p - vec3(-0.03, 0.99, 0.68);
  Hit h = Hit(pole(q, vec3(0.13, -0.15, -0.15), 0.06), vec3(0.33, 0.52, 0.42), 3.0, 39);
  q.xy *= turn(0.89);
  h = soft(h, Hit(pole(q, vec3(0.09, 0.04, 0.10), 0.03), vec3(0.59, 0.07, 0.12), 1.0, 139), 0.05);
  for (int i = 0; i < 3; ++i) {
    q = abs(q) - 0.12;
    q.xz *= turn(0.3 * float(i));
  }
  return nearer(h, Hit(pole(q, vec3(0.19, -0.01, -0.16), 0.06), vec3(0.54, 0.66, 0.94), 2.0, 239));
}
Hit map(in vec3 p) {
  Hit h = Hit(p.y + 0.9, vec3(0.2), 1.0, -1);
  h = soft(h, part0(p), 0.04);
  h = soft(h, part1(p), 0.04);
  h = soft(h, part2(p), 0.04);
  h = soft(h, part3(p), 0.04);
  h = nearer(h, part4(p));
  h = soft(h, part5(p), 0.04);
  h = soft(h, part6(p), 0.04);
  h = nearer(h, part7(p));
  h = soft(h, part8(p), 0.04);
  h = nearer(h, part9(p));
  h = nearer(h, part10(p));
  h = nearer(h, part11(p));
  h = soft(h, part12(p), 0.04);
  h = nearer(h, part13(p));
  h = soft(h, part14(p), 0.04);
  h = soft(h, part15(p), 0.04);
  h = nearer(h, part16(p));
  h = nearer(h, part17(p));
  h = soft(h, part18(p), 0.04);
  h = nearer(h, part19(p));
  h = nearer(h, part20(p));
  h = nearer(h, part21(p));
  h = nearer(h, part22(p));
  h = soft(h, part23(p), 0.04);
  h = nearer(h, part24(p));
  h = soft(h, part25(p), 0.04);
  h = nearer(h, part26(p));
  h = nearer(h, part27(p));
  h = nearer(h, part28(p));
  h = nearer(h, part29(p));
  h = nearer(h, part30(p));
  h = nearer(h, part31(p));
  h = soft(h, part32(p), 0.04);
  h = soft(h, part33(p), 0.04);
  h = soft(h, part34(p), 0.04);
  h = nearer(h, part35(p));
  h = soft(h, part36(p), 0.04);
  h = soft(h, part37(p), 0.04);
  h = nearer(h, part38(p));
  h = nearer(h, part39(p));
  return h;
}
