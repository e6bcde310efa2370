float a[4], b; vec3 c[2] , d = vec3(1, 2, 3), e /* a comment, with commas; */; int n
 = 3, m; mat2[2] q;
highp vec2 w;
float f(float x) { return x; }
float map(vec3 p) { m += n; b += .1; c[1] += p; e += d; w += p.xy; a[n] += .2; return length(p) - .5 + b + c[0].x + c[1].y * .01 + e.x * .01 + float(m) * .01 + q[1][0][1] + w.x * .1 + a[2] + a[3]; }
