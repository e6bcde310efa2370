// xyz = colour, w = distance
vec4 opU(vec4 a, vec4 b){ return a.w<b.w?a:b; }
float sdCapsule(vec3 p,vec3 a,vec3 b,float r){vec3 pa=p-a,ba=b-a;float h=clamp(dot(pa,ba)/dot(ba,ba),0.,1.);return length(pa-ba*h)-r;}
vec4 map(vec3 p){ vec4 r=vec4(.2,.3,.1,p.y+.9); r=opU(r,vec4(1,0,0,sdCapsule(p,vec3(-.5,0,0),vec3(.5,.2,.1),.15))); 
 float an=6.2831/7.,a=mod(atan(p.z,p.x)+an*.5,an)-an*.5; vec3 q=vec3(length(p.xz)*cos(a)-.6,p.y+.3,length(p.xz)*sin(a)); return opU(r,vec4(0,1,0,length(q)-.13)); }
vec4 march(vec3 o,vec3 d){float t=0.;vec4 h;for(int i=0;i<80;i++){h=map(o+d*t);if(h.w<.001)break;t+=h.w;}return vec4(h.rgb,t);}
float shadow(vec3 o,vec3 l){float t=.01;for(int i=0;i<20;i++){float h=map(o+l*t).w;if(h<.001)return 0.;t+=h;}return 1.;}
void mainImage(out vec4 c,in vec2 f){ c=march(vec3(0,1,-3),vec3(f/iResolution.xy,1)); }
