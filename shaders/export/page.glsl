// The page's entry.
vec3 pixel(vec2 at, vec2 size);
uniform vec2 canvas;  // pixels
out vec4 colour;

void main() {
    colour = vec4(pixel(gl_FragCoord.xy, canvas), 1.0);
}
