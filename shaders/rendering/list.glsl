// Lists the samples that a rasteriser has hit, for the second pass.
uniform sampler2D surfacePoint;
layout(std430, binding = 0) buffer SeenSamples {
    uint seenCount;
    uint seen[];  // y << 16 | x
};

void main() {
    if (texelFetch(surfacePoint, ivec2(gl_FragCoord.xy), 0).w > 0.5)
        seen[atomicAdd(seenCount, 1u)] = uint(gl_FragCoord.y) << 16 | uint(gl_FragCoord.x);
}
