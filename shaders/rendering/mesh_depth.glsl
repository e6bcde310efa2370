// The early depth pass: nothing but depths, and with MASKED none where the finish has a hole.
#ifdef MASKED
in vec2 pictureAt;
uniform sampler2D cover;  // negative in a hole

void main() {
    if (textureLod(cover, vec2(pictureAt.x, 1.0 - pictureAt.y), 0.0).r < 0.0) discard;
}
#else
void main() {
}
#endif
