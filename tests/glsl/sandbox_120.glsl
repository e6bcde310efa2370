// GLSL 1.20 sandbox
#ifdef GL_ES
precision mediump float;
#endif
uniform float time; uniform vec2 mouse; uniform vec2 resolution;
uniform sampler2D backbuffer;
varying vec2 surfacePosition;
const int ITER=8;
const float PI=3.14159;
float DE(vec3 z0) {
	vec3 z=z0; float dr=1.0; float r=0.0;
	for(int i=0;i<ITER;i++){ r=length(z); if(r>2.0) break;
		float theta=acos(z.z/r), phi=atan(z.y,z.x); dr=pow(r,7.0)*8.0*dr+1.0;
		float zr=pow(r,8.0); theta*=8.0; phi*=8.0;
		z=zr*vec3(sin(theta)*cos(phi),sin(phi)*sin(theta),cos(theta)); z+=z0; }
	return 0.5*log(r)*r/dr;
}
float ao(vec3 p, vec3 n){float s=0.;for(float i=1.;i<5.;i++)s+=(i*.1-DE(p+n*i*.1))/exp2(i);return 1.-s;}
void main( void ) {
	vec2 pos = ( gl_FragCoord.xy / resolution.xy ) + mouse / 4.0;
	vec3 c = texture2D(backbuffer, pos).rgb; float d=0.; vec3 ro=vec3(0,0,-3);
	for(int i=0;i<50;i++) d+=DE(ro+d*vec3(pos,1.));
	gl_FragColor = vec4(vec3(d)*c, 1.0 );
}
