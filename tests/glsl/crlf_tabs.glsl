float GetDist(vec3 p) {
	vec4 s = vec4(0, 0.2, 0, .5);
	#define BIG(a) \
		max(a, .1)
	float d = BIG(length(p-s.xyz)-s.w); // é
	return min(d-.1, p.y+.7);
}
