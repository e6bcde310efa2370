#define R iResolution
#define T (iTime*.5)
#define S(a,b,t) smoothstep(a,b,t)
#define rep(p,c) (mod(p+.5*c,c)-.5*c)
#define sabs(x) sqrt(x*x+.001)
float map(vec3 p, out int id)
{
    id=0; vec3 q=p; q.xz=rep(q.xz,vec2(.5)); float d=length(q)-.12,d2; 
    d2=max(abs(p.x)-.7,max(abs(p.y)-.05,abs(p.z)-.7)); if(d2<d) id=1,d=d2;
    switch(id){case 0: d+=.002*sin(40.*p.x);break; case 1: d-=.01; default: break;}
    return d;
}
float trace(vec3 o,vec3 r){ float t=0.; int id; for(int i=0;i<99;i++){ float d=map(o+r*t,id); if(abs(d)<.001||t>20.)break; t+=d;} return t; }
void mainImage(out vec4 o,vec2 u){ vec2 uv=(u-.5*R.xy)/R.y; o=vec4(trace(vec3(0,0,-3),vec3(uv,1)))*S(0.,1.,T)+texelFetch(iChannel0,ivec2(u),0)+textureLod(iChannel2,uv,0.); }
