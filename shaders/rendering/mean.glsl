// The mean of each pixel's samples: only it is read back. Rows are summed first, so that many samples lose no digits.
uniform sampler2D samplesOfTile;
uniform int across;  // samples of a pixel along a side
layout(location = 0) out vec4 mean;

void main() {
    ivec2 first = ivec2(gl_FragCoord.xy) * across;
    vec4 sum = vec4(0.0);
    for (int y = 0; y < across; y++) {
        vec4 row = vec4(0.0);
        for (int x = 0; x < across; x++) row += texelFetch(samplesOfTile, first + ivec2(x, y), 0);
        sum += row;
    }
    mean = sum / float(across * across);
}
