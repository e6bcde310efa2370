// Closes, by depth, the samples of the tiles whose cones met nothing: the pass that follows never runs there.
uniform sampler2D freeCones;  // of the coarse pass, -1 where nothing was met
uniform int grain;            // samples a texel along a side

void main() {
    if (texelFetch(freeCones, ivec2(gl_FragCoord.xy) / grain, 0).x >= 0.0) discard;
}
