const vec3 A = vec3(1, 2, 3), B = A.zyx * 2., C[2] = vec3[2](A, B);
const mat3 M = mat3(A, B, C[0]) * mat3(2.);
const float D = dot(A, B) / length(C[1]), E = sin(D) + M[1][2];
const int N = int(D) + 2, K = N > 3 ? 7 : 9; const bool Q = N > 1 && K == 7; const uint U = 0xFFu ^ uint(N);
vec3 g = A * E; float h = g.x + D; mat2 r = mat2(cos(h), sin(h), -sin(h), cos(h));
float map(vec3 p) { float a[K]; for (int i = 0; i < K; i++) a[i] = float(i) / float(K); p.xy *= r; return length(p) - .3 - a[N % K] * .1 - (Q ? .05 : .0) - float(U & 3u) * .001; }
