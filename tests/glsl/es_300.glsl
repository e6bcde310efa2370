#version 300 es
precision highp float;
out vec4 fragColor;
uniform float iTime;
float map(vec3 p) { return length(p) - 0.3 - 0.1 * sin(iTime); }
void main() { fragColor = vec4(map(vec3(gl_FragCoord.xy, 0.0))); }
