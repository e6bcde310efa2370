const float A = 0.3, B = A * 2.0; const vec2 C = vec2(A, B).yx; const int N = 2 + 3; const float T[N] = float[N](1., 2., 3., 4., 5.);
float map(vec3 p) { return length(p.xy - C) - B + T[N - 1] * 0.01; }
