uint hash(uint x) { x ^= x >> 16u; x *= 0x7feb352du; x ^= x >> 15u; x *= 0x846ca68bu; x ^= x >> 16u; return x; }
float map(vec3 p) { uvec3 q = uvec3(ivec3(floor(p * 8.0)) + 100); uint h = hash(q.x + hash(q.y + hash(q.z))); return float(h) / 4294967296.0 + float(h % 7u) + float(h / 1000003u) * 1e-4; }
