float smin(float a, float b, float k) { float h = max(k - abs(a - b), 0.0) / k; return min(a, b) - h * h * k * 0.25; }
float map(vec3 p) { vec3 q = p; q.x = mod(q.x + .25, .5) - .25; float d = 1e3; for (float a = 0.; a < 6.; a += 1.) { float c = cos(a), s = sin(a); d = smin(d, length(vec3(c * q.x + s * q.z, q.y, c * q.z - s * q.x) - vec3(.2, 0, 0)) - .06, .1); } return d; }
