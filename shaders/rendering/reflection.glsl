// Reflection mapping (Blinn and Newell 1976): the light from the mirrored view, whatever stands in its way. Twin: `reflection` of
// sdfprt/material/shading.py.
vec2 latlong(vec3 d);
uniform vec3 specular;
#if (LOBES & 4) != 0
uniform sampler2D environment;  // the whole light, wraps in u
uniform mat3 toMap;             // world to map

// What is seen along o, the unit direction to the eye, in a mirror with the unit normal n.
vec3 reflection(vec3 n, vec3 o) {
    return specular * textureLod(environment, latlong(toMap * reflect(-o, n)), 0.0).rgb;
}
#endif
