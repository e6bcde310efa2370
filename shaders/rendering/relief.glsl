// The unit shading normal of a mesh on the side that is seen: a normal map's where the finish has one (glTF 2.0, Sec. 3.9.3).
in vec3 worldNormal;
in vec4 worldTangent;            // along u of the map; w: the side on which the bitangent lies
in vec2 reliefAt;
uniform bool relieved;           // by a normal map
uniform sampler2D normalMap;
uniform float normalScale;

vec3 shadingNormal() {
    vec3 n = normalize(worldNormal);
    if (relieved) {
        vec3 along = normalize(worldTangent.xyz - dot(worldTangent.xyz, n) * n);
        vec3 up = cross(n, along) * (worldTangent.w < 0.0 ? -1.0 : 1.0);
        vec3 found = 2.0 * textureLod(normalMap, vec2(reliefAt.x, 1.0 - reliefAt.y), 0.0).xyz - 1.0;
        n = normalize(normalScale * (found.x * along + found.y * up) + max(found.z, 0.02) * n);  // never away from its side
    }
    return gl_FrontFacing ? n : -n;
}
