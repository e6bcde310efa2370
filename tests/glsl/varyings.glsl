#version 120
varying highp vec3 v_normal, v_pos;
varying vec2 uv[2];
attribute vec4 color;
invariant gl_Position;
invariant varying vec3 q3;
centroid varying vec2 cc;
uniform vec3 lights[4]; uniform float k; uniform sampler2D t0, t1; uniform samplerCube env; uniform sampler3D vol;
uniform struct Cam { vec3 pos; float fov; } cam;
uniform mat3 basis; uniform bool flag; uniform ivec2 cells;
float map(vec3 p) { float d = length(p) - .5 + k; for (int i = 0; i < 4; i++) d = min(d, length(p - lights[i]) - .3); if (flag) d += cam.fov; d += float(cells.x) + v_pos.x * 0. + uv[0].x; return d + length(basis * p) * .01; }
void main() { gl_FragColor = texture2D(t0, uv[0]) + textureCube(env, v_normal); gl_FragData[1] = vec4(1); if (k > 1.) discard; }
