// First pass: what each sample sees, and a list of the samples that hit for the second pass. Before it, with `coarse`, how far
// the cones about tiles of samples are free.
ivec2 gridPlace();
vec3 viewOrigin();
vec3 viewRay(vec2 at);
float footprint();
float march(vec3 o, vec3 d, float width, float begin, float cone);
vec3 surfaceNormal(vec3 p);
void listHit(bool hit, ivec2 at);
#ifdef HAS_ALBEDO
vec3 albedo(vec3 p, vec3 n);
#endif
#ifdef HAS_EXPONENT
float exponent(vec3 p, vec3 n);
#endif
uniform bool coarse;
uniform int grain;  // samples along a side that a cone holds
layout(rgba32f, binding = 0) writeonly uniform image2D surfacePoint;      // w: 1 where a sample hit, 0 elsewhere
layout(rgba32f, binding = 1) writeonly uniform image2D surfaceDirection;  // the normal; only where a sample hit, as the colour
layout(rgba32f, binding = 2) writeonly uniform image2D surfaceColour;     // albedo and exponent where the scene gives them
layout(r32f, binding = 3) uniform image2D freeCones;                      // -1 where nothing is met
layout(rgba32f, binding = 4) writeonly uniform image2D missed;            // the radiance: 0 where no sample hit

void main() {
    ivec2 at = gridPlace();
    bool inside = all(lessThan(at, coarse ? imageSize(freeCones) : imageSize(surfacePoint)));
    float begin = !inside ? -1.0 : coarse ? 0.0 : imageLoad(freeCones, at / grain).x, t = -1.0;
    vec3 o = viewOrigin(), d = viewRay(vec2(at) + 0.5);
    if (begin >= 0.0) t = march(o, d, footprint(), begin, coarse ? 0.75 * footprint() : 0.0);
    if (coarse) {
        if (inside) imageStore(freeCones, at, vec4(t));
        return;
    }
    bool hit = t >= 0.0;
    if (hit) {
        vec3 p = o + d * t, n = surfaceNormal(p);
        vec4 colour = vec4(0.0);
#ifdef HAS_ALBEDO
        colour.rgb = albedo(p, n);
#endif
#ifdef HAS_EXPONENT
        colour.a = exponent(p, n);
#endif
        imageStore(surfacePoint, at, vec4(p, 1.0));
        imageStore(surfaceDirection, at, vec4(n, 0.0));
        imageStore(surfaceColour, at, colour);
    } else if (inside) {
        imageStore(surfacePoint, at, vec4(0.0));
        imageStore(missed, at, vec4(0.0));
    }
    listHit(hit, at);
}
