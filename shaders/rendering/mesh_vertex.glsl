// A mesh's vertex: to the picture by the pinhole of camera.glsl, whose first row is the framebuffer's first row.
in vec3 place;
in vec3 direction;
in vec2 coordinates;
in vec3 paint;
uniform vec3 eye;
uniform mat3 axes;       // columns: right * half width, up * half height, forward
uniform vec4 viewport;   // xy: first sample of this tile, zw: samples of the whole picture
uniform vec2 tile;       // samples of this tile
uniform vec2 clip;       // nearest and farthest depth
out vec3 worldPoint;
out vec3 worldNormal;
out vec2 pictureAt;
out vec3 vertexPaint;
invariant gl_Position;   // the depth pass and the one after it see the same depths

void main() {
    vec3 d = place - eye;
    float w = dot(d, axes[2]);
    vec2 across = vec2(dot(d, axes[0]) / dot(axes[0], axes[0]), -dot(d, axes[1]) / dot(axes[1], axes[1]));
    // From -w … w over the whole picture to -w … w over the tile
    vec2 share = viewport.zw / tile, first = 2.0 * viewport.xy / tile;
    float depth = (w * (clip.y + clip.x) - 2.0 * clip.x * clip.y) / (clip.y - clip.x);
    gl_Position = vec4(across * share + w * (share - first - 1.0), depth, w);
    worldPoint = place;
    worldNormal = direction;
    pictureAt = coordinates;
    vertexPaint = paint;
}
