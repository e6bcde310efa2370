// Vertex storage: light times transfer at each vertex of one side of a mesh, diffuse without albedo, and glossy.
vec4 toPicture(vec3 place);
vec3 toViewer(vec3 place);
vec3 diffuseLobe(vec4 transfer[OUTPUTS]);
vec3 glossyLobe(vec3 n, vec3 o, vec4 transfer[OUTPUTS], float s);
in vec3 place;
in vec3 direction;
in vec2 coordinates;
in vec3 paint;
in int otherRow;                // of the side that faces the other way, -1 for none
layout(std430, binding = 1) readonly buffer TransferTable {
    vec4 rows[];                // OUTPUTS a channel
};
uniform int channels;           // 1, or 3 with interreflections
uniform bool otherSide;
uniform float finishExponent;
uniform vec3 eye;
#if (LOBES & 4) != 0
out vec3 toEye;                 // for reflection mapping
out vec3 normalHere;
#endif
out vec3 diffuseLightHere;
out vec3 glossyLightHere;
out vec2 pictureAt;
out vec3 vertexPaint;
invariant gl_Position;          // as in the depth pass

void main() {
    gl_Position = toPicture(place);
    pictureAt = coordinates;
    vertexPaint = paint;
    int row = otherSide ? max(otherRow, 0) : gl_VertexID;
    diffuseLightHere = glossyLightHere = vec3(0.0);
    vec3 n = otherSide ? -direction : direction, o = toViewer(place);
#if (LOBES & 4) != 0
    toEye = eye - place;
    normalHere = n;
#endif
    for (int c = 0; c < channels; c++) {
        vec4 transfer[OUTPUTS];
        for (int i = 0; i < OUTPUTS; i++) transfer[i] = rows[(row * channels + c) * OUTPUTS + i];
        vec3 diffuse = vec3(0.0), shine = vec3(0.0);
#if (LOBES & 1) != 0
        diffuse = diffuseLobe(transfer);
#endif
#if (LOBES & 2) != 0
        shine = glossyLobe(n, o, transfer, finishExponent);
#endif
        if (channels == 1) {
            diffuseLightHere = diffuse;
            glossyLightHere = shine;
        } else {
            diffuseLightHere[c] = diffuse[c];
            glossyLightHere[c] = shine[c];
        }
    }
    diffuseLightHere = max(diffuseLightHere, vec3(0.0));
    glossyLightHere = max(glossyLightHere, vec3(0.0));
}
