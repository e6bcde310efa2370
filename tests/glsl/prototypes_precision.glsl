precision mediump float;
precision highp int;
#line 100
lowp float half_way(mediump float a, highp float b);
highp vec2 fold(in lowp vec2 q);
layout(location = 0) out mediump vec4 shown;
smooth in highp vec3 seen;
float map(in highp vec3 p) { return half_way(length(fold(p.xy)) - 0.3, length(p) - 0.5); }
highp vec2 fold(in lowp vec2 q) { return abs(q) - vec2(0.2, 0.1); }
lowp float half_way(mediump float a, highp float b) { return (a + b) * 0.5; }
void main() { shown = vec4(map(seen)); }
