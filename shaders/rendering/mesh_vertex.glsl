// A mesh's vertex, with what mesh_surface.glsl interpolates, and with TEXTURED what textured.glsl does.
vec4 toPicture(vec3 place);
in vec3 place;
in vec3 direction;
in vec2 coordinates;
in vec3 paint;
in vec4 tangent;
in vec2 reliefCoordinates;
#ifdef TEXTURED
in vec2 transferCoordinates;  // of the vertex in the transfer textures
in ivec2 transferLayers;      // of its front and of its back
out vec2 transferAt;
flat out ivec2 layersHere;
#endif
out vec3 worldPoint;
out vec3 worldNormal;
out vec2 pictureAt;
out vec3 vertexPaint;
out vec4 worldTangent;
out vec2 reliefAt;
invariant gl_Position;  // the depth pass and the one after it see the same depths

void main() {
    gl_Position = toPicture(place);
    worldPoint = place;
    worldNormal = direction;
    pictureAt = coordinates;
    vertexPaint = paint;
    worldTangent = tangent;
    reliefAt = reliefCoordinates;
#ifdef TEXTURED
    transferAt = transferCoordinates;
    layersHere = transferLayers;
#endif
}
