vec2 map(vec3 p, float time);
#define FOLD(p) p=abs(p);if(p.x<p.y)p.xy=p.yx;if(p.y<p.z)p.yz=p.zy;
vec4 orb; // trap
vec2 map(vec3 p, float time){ vec3 w=p; float s=1.0; orb=vec4(1000.0);
 for(int i=0;i<9;i++){ FOLD(w) w=w*2.-vec3(1.,1.,1.)*vec3(1,1,step(.5,w.z)); s*=2.; orb=min(orb,vec4(abs(w),dot(w,w))); }
 return vec2(length(w-clamp(w,-1.,1.))/s-.002*sin(time),orb.w); }
float map_d(vec3 p){return map(p,iTime).x;}
mat3 setCamera(in vec3 ro,in vec3 ta,float cr){vec3 cw=normalize(ta-ro);vec3 cp=vec3(sin(cr),cos(cr),0.);vec3 cu=normalize(cross(cw,cp));return mat3(cu,cross(cu,cw),cw);}
void mainVR(out vec4 c,in vec2 f,in vec3 o,in vec3 d){c=vec4(map(o,iTime),0,1);}
void mainImage(out vec4 fragColor,in vec2 fragCoord){vec4 acc=vec4(0);for(int m=0;m<2;m++){acc+=vec4(map(vec3(fragCoord,m),iTimeDelta),iDate.w,iFrameRate);}fragColor=acc/iChannelResolution[0].x+texture2D(iChannel3,fragCoord);}
