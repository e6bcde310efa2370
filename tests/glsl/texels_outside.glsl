// texelFetch beyond the picture gives nothing
float map(vec3 p) { return length(p) - 0.5 - 0.01 * texelFetch(iChannel0, ivec2(p.xy * 300.0), 0).x; }
