uniform sampler2D iChannel1;
float map(vec3 p) { return length(p) - 0.5 - 0.1 * sin(iTime + p.x); }
vec3 shade(vec2 uv) { return texture(iChannel0, uv).xyz + fwidth(uv.x) + texelFetch(iChannel1, ivec2(0), 0).x; }
void mainImage(out vec4 c, in vec2 f) { vec2 uv = f / iResolution.xy; c = vec4(shade(uv) + iMouse.x + iChannelResolution[0].x, 1.0); }
