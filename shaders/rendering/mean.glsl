// The mean of each pixel's samples: only it is read back. Rows are summed first, so that many samples lose no digits.
ivec2 gridPlace();
uniform sampler2D samplesOfTile;
uniform int across;  // samples of a pixel along a side
layout(rgba32f, binding = 0) writeonly uniform image2D mean;

void main() {
    ivec2 at = gridPlace();
    if (any(greaterThanEqual(at, imageSize(mean)))) return;
    vec4 sum = vec4(0.0);
    for (int y = 0; y < across; y++) {
        vec4 row = vec4(0.0);
        for (int x = 0; x < across; x++) row += texelFetch(samplesOfTile, at * across + ivec2(x, y), 0);
        sum += row;
    }
    imageStore(mean, at, sum / float(across * across));
}
