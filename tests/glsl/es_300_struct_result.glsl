#version 300 es
precision highp float; precision highp int;
out vec4 outColor; in vec2 vUv;
uniform vec3 uCam; uniform mat4 uView; uniform float uBeat; uniform samplerCube env;
struct Material { vec3 color; float rough; };
struct Hit { float d; int id; Material m; };
Hit mk(float d,int id){ Hit h; h.d=d; h.id=id; h.m=Material(vec3(.5),.2); return h; }
Hit un(Hit a,Hit b){ if(a.d<b.d) return a; return b; }
float blobs[4];
vec3 centers[3] = vec3[3](vec3(0.,.2,0.),vec3(.4,-.1,.1),vec3(-.4,.1,-.2));
float kifs(vec3 p, float s){ float k=1.; for(int i=0;i<6;++i){ p=abs(p)-vec3(.4,.3,.2)*.8; if(p.x<p.y)p.xy=p.yx; if(p.x<p.z)p.xz=p.zx; float c=cos(.7),n=sin(.7); p.xy=mat2(c,n,-n,c)*p.xy; p*=s; k*=s;} return (length(p)-.6)/k; }
Hit map(vec3 p, float t){
  Hit h=mk(1e10,0);
  for(int i=0;i<3;i++){ blobs[i]=length(p-centers[i])-.15-.02*sin(t); h=un(h,mk(blobs[i],i+1)); }
  h=un(h,mk(kifs(p,1.4)+uBeat,9));
  return h;
}
vec3 normal(vec3 p){vec2 e=vec2(.001,0);return normalize(vec3(map(p+e.xyy,0.).d,map(p+e.yxy,0.).d,map(p+e.yyx,0.).d)-map(p,0.).d);}
void main(){ vec3 ro=(uView*vec4(uCam,1.)).xyz; outColor=vec4(normal(ro)*vUv.x+texture(env,ro).rgb,1.); }
