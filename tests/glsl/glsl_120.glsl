#version 120
#extension GL_EXT_gpu_shader4 : enable
varying vec2 uv;
attribute vec3 corner;
uniform vec2 u_resolution;
uniform sampler2D noise;
invariant varying vec4 tint;
float ball(vec3 p, float r) { return length(p) - r; }
float map(vec3 p) { return min(ball(p, 0.4), max(abs(p.y + 0.3) - 0.05, ball(p.xzy, 0.6))); }
void paint(float d) { gl_FragColor = vec4(d, u_resolution / 512.0, 1.0); }
void main(void) { paint(map(vec3(uv, 0.0)) + texture2D(noise, gl_FragCoord.xy).x); gl_FragColor.w = tint.x; }
