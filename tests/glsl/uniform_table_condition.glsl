const uint T[4] = uint[](1u, 7u, 2u, 9u);
float sdf(vec3 p) { float d = p.x; vec3 c = vec3(1.0, 2.0, 3.0); for (int i = 0; i < 4; i++) { if (T[i] > 3u) d = 0.5; else d += 0.1; if ((c * c).y > 5.0) d = p.y; } return d; }
