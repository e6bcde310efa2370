#define PHI (sqrt(5.)*0.5 + 0.5)
#define PI 3.14159265
#define saturate(x) clamp(x, 0, 1)
uniform float time;
const vec3 GDFVectors[7] = vec3[](normalize(vec3(1,0,0)),normalize(vec3(0,1,0)),normalize(vec3(0,0,1)),normalize(vec3(1,1,1)),normalize(vec3(-1,1,1)),normalize(vec3(1,-1,1)),normalize(vec3(1,1,-1)));
float fGDF(vec3 p, float r, int begin, int end) { float d = 0; for (int i = begin; i <= end; ++i) d = max(d, abs(dot(p, GDFVectors[i]))); return d - r; }
void pR(inout vec2 p, float a) { p = cos(a)*p + sin(a)*vec2(p.y, -p.x); }
float pMod1(inout float p, float size) { float halfsize = size*0.5; float c = floor((p + halfsize)/size); p = mod(p + halfsize, size) - halfsize; return c; }
float vmax(vec3 v){return max(max(v.x,v.y),v.z);}
float fBox(vec3 p, vec3 b){vec3 d=abs(p)-b;return length(max(d,vec3(0)))+vmax(min(d,vec3(0)));}
float fOpUnionStairs(float a,float b,float r,float n){float s=r/n;float u=b-r;return min(min(a,b),0.5*(u+a+abs((mod(u-a+s,2*s))-s)));}
float sceneSDF(vec3 samplePoint)
{
	vec3 p = samplePoint; float c = pMod1(p.x, .8); pR(p.yz, c*.3+time);
	float d = fGDF(p, .3, 3, 6);
	d = fOpUnionStairs(d, fBox(p, vec3(.5,.1,.1)), .1, 4.);
	d = max(d, fBox(samplePoint, vec3(.9)));
	uint h = uint(abs(c)); h = (h ^ 61u) ^ (h >> 16u); h *= 9u; d -= float(h & 15u)*.001;
	return d;
}
vec3 estimateNormal(vec3 p){return normalize(vec3(dFdx(sceneSDF(p)),dFdy(sceneSDF(p)),fwidth(p.x)));}
void mainImage(out vec4 fragColor, in vec2 fragCoord){ fragColor=vec4(estimateNormal(vec3(fragCoord,0)),saturate(1.)); if(fragColor.x<0.) discard; }
