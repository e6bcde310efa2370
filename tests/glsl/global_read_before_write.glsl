vec3 acc; float hit;
float map(vec3 p) { acc += p; hit += length(acc); return hit - 0.5; }
