int cnt = 0; float inc(float x) { cnt++; return x + float(cnt); }
float map(vec3 p) { cnt = 0; float a = inc(1.) * inc(2.) - inc(3.), b; b = a, a = b * 2., p.x += .01; bool t = p.x > 0. && inc(0.) > 2., u = p.y > 0. || inc(1.) > 3.; int i = 0, j = i++ + ++i; i += i++ * 2; return length(p) - .4 + .001 * (a + b + float(cnt) + float(i + j)) + (t ? .01 : 0.) + (u ? .02 : 0.); }
