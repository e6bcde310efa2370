#version 330 core
layout(std140) uniform Params { vec4 a; float radius; vec3 center; };
layout(std140, binding = 1) uniform Other { mat4 view; float blend; } other;
layout (location = 0) out vec4 FragColor;
layout(location=1) out vec4 Extra;
in VS_OUT { vec3 pos; vec2 uv; } fs_in;
flat in int id;
uniform float uRadius = 0.4;
float map(vec3 p) { return length(p) - uRadius - radius - other.blend; }
void main() { FragColor = vec4(map(fs_in.pos)); }
