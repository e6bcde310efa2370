// From the world to the picture, by the pinhole of camera.glsl: the picture's first row is the framebuffer's first row.
uniform vec3 eye;
uniform mat3 axes;       // columns: right * half width, up * half height, forward
uniform vec4 viewport;   // xy: first sample of this tile, zw: samples of the whole picture
uniform vec2 tile;       // samples of this tile
uniform vec2 clip;       // nearest and farthest depth

vec4 toPicture(vec3 place) {
    vec3 d = place - eye;
    float w = dot(d, axes[2]);
    vec2 across = vec2(dot(d, axes[0]) / dot(axes[0], axes[0]), -dot(d, axes[1]) / dot(axes[1], axes[1]));
    // From -w … w over the whole picture to -w … w over the tile
    vec2 share = viewport.zw / tile, first = 2.0 * viewport.xy / tile;
    float depth = (w * (clip.y + clip.x) - 2.0 * clip.x * clip.y) / (clip.y - clip.x);
    return vec4(across * share + w * (share - first - 1.0), depth, w);
}

// Unit direction from a place to the eye.
vec3 toViewer(vec3 place) {
    return normalize(eye - place);
}
