// Texture storage: a mesh's vertex as mesh_vertex.glsl has it, with its place in the transfer textures.
vec4 toPicture(vec3 place);
in vec3 place;
in vec3 direction;
in vec2 coordinates;
in vec3 paint;
in vec4 tangent;
in vec2 reliefCoordinates;
in vec2 transferCoordinates;
in ivec2 transferLayers;        // of its front and of its back
out vec3 worldPoint;
out vec3 worldNormal;
out vec2 pictureAt;
out vec3 vertexPaint;
out vec4 worldTangent;
out vec2 reliefAt;
out vec2 transferAt;
flat out ivec2 layersHere;
invariant gl_Position;          // as in the depth pass

void main() {
    gl_Position = toPicture(place);
    worldPoint = place;
    worldNormal = direction;
    pictureAt = coordinates;
    vertexPaint = paint;
    worldTangent = tangent;
    reliefAt = reliefCoordinates;
    transferAt = transferCoordinates;
    layersHere = transferLayers;
}
