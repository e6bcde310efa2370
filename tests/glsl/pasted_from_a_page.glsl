float map(vec3 p) { float d = 1.; for (int i = 0; i &lt; 3; i++) d = min(d, length(p) - .5); return d; }
