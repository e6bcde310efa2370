// Transfer at a surface point: positional encoding, then the MLP with leaky ReLU (learnt transfer, Sec. 3.2). Twin of `forward` in
// sdfprt/network/mlp.py, which numpy and torch run.
// Counts are in fours: INPUTS, WIDTH, NETWORK_OUTPUTS, each transfer's OUTPUTS after the other's; LAYERS linear layers.
// Weights come from a texture: compiled in two seconds at any width where constants took half a minute, and any network of
// the same size runs without compiling again.
vec4 openSky(vec3 n, int row);
#ifndef PACKED_WEIGHTS
uniform sampler2D networkWeights;  // 4x4 blocks, row of blocks after row, layer after layer; then the biases
#endif
uniform vec3 networkCenter;
uniform float networkExtent;
uniform vec4 networkScale[NETWORK_OUTPUTS];
uniform float networkOpen;  // 1: what the layers give is added to the transfer of an open sky, 0: it is transfer
uniform int keepLoops;  // 1: loops whose length the compiler cannot know stay loops, and compile in seconds
#if CELLS > 1
int networkStart;  // first texel of the network that is asked: cells.glsl chooses
#else
const int networkStart = 0;
#endif

// Columns of a block, and a bias, in rows of 1024 texels.
vec4 weightTexel(int at) {
#ifdef PACKED_WEIGHTS  // halves in an array, two texels an element, where there are no textures
    uvec4 both = packedWeights[at >> 1];
    return (at & 1) == 0 ? vec4(unpackHalf2x16(both.x), unpackHalf2x16(both.y)) : vec4(unpackHalf2x16(both.z), unpackHalf2x16(both.w));
#else
    return texelFetch(networkWeights, ivec2(at & 1023, at >> 10), 0);
#endif
}

mat4 weightBlock(int at) {
    at = networkStart + 4 * at;
    return mat4(weightTexel(at), weightTexel(at + 1), weightTexel(at + 2), weightTexel(at + 3));
}

// Centre and extent of the box that the features are relative to, and what the rows of outputs are multiplied with: uniforms, or of
// each network in cells the last of its texels.
vec4 networkBox() {
#if CELLS > 1
    return weightTexel(networkStart + STRIDE - NETWORK_OUTPUTS - 1);
#else
    return vec4(networkCenter, networkExtent);
#endif
}

vec4 networkScales(int row) {
#if CELLS > 1
    return weightTexel(networkStart + STRIDE - NETWORK_OUTPUTS + row);
#else
    return networkScale[row];
#endif
}

// T_i at POINTS points p with unit normals n, in fours, point after point; a weight is fetched once for all of them.
#if CELLS > 1
void cellNetwork(vec3 p[POINTS], vec3 n[POINTS], out vec4 transfer[POINTS * NETWORK_OUTPUTS])
#else
void network(vec3 p[POINTS], vec3 n[POINTS], out vec4 transfer[POINTS * NETWORK_OUTPUTS])
#endif
{
    // Features: x, n, then sin and cos of pi v, 2 pi v, 4 pi v … by the formulas of the double angle, first of x, then of n;
    // two octaves fill three quads
    vec4 a[POINTS * (INPUTS > WIDTH ? INPUTS : WIDTH)], b[POINTS * (WIDTH > NETWORK_OUTPUTS ? WIDTH : NETWORK_OUTPUTS)];
    vec4 box = networkBox();
    for (int k = 0; k < POINTS * keepLoops; k++) {
        vec3 x = (p[k] - box.xyz) / box.w;
        a[k] = vec4(x, n[k].x);
        a[POINTS + k] = vec4(n[k].yz, 0.0, 0.0);
        vec3 s = sin(3.14159265358979 * x), c = cos(3.14159265358979 * x);
        vec4 middle = vec4(0.0);
        int at = 2 * POINTS + k;
        for (int octave = 0; octave < (POSITION_OCTAVES + NORMAL_OCTAVES) * keepLoops; octave++) {
            if (octave == POSITION_OCTAVES) {
                s = sin(3.14159265358979 * n[k]);
                c = cos(3.14159265358979 * n[k]);
            }
            bool first = octave % 2 == 0;
            middle = first ? vec4(c.yz, 0.0, 0.0) : vec4(middle.xy, s.xy);
            a[at + (first ? 0 : 2 * POINTS)] = first ? vec4(s, c.x) : vec4(s.z, c);
            a[at + POINTS] = middle;
            if (first) a[at + 2 * POINTS] = vec4(0.0); else at += 3 * POINTS;
            vec3 twice = 2.0 * s * c;
            c = 1.0 - 2.0 * s * s;
            s = twice;
        }
    }

    // Layers: b = W a + bias, back into a
    int block = 0, bias = 4 * BLOCKS, columns = INPUTS * keepLoops;
    for (int layer = 0; layer < LAYERS * keepLoops; layer++) {
        int rows = layer == LAYERS - 1 ? NETWORK_OUTPUTS : WIDTH;
        for (int row = 0; row < rows; row++) {
            vec4 sum[POINTS];
            vec4 start = weightTexel(networkStart + bias + row);
            for (int k = 0; k < POINTS; k++) sum[k] = start;
            for (int column = 0; column < columns; column++) {
                mat4 weights = weightBlock(block + column);
                for (int k = 0; k < POINTS; k++) sum[k] += weights * a[POINTS * column + k];
            }
            block += columns;
            for (int k = 0; k < POINTS; k++) b[POINTS * row + k] = sum[k];
        }
        bias += rows;
        columns = WIDTH * keepLoops;
        for (int i = 0; i < POINTS * WIDTH * keepLoops; i++) a[i] = max(b[i], 0.01 * b[i]);
    }
    for (int row = 0; row < NETWORK_OUTPUTS; row++)
        for (int k = 0; k < POINTS; k++)
            transfer[k * NETWORK_OUTPUTS + row] = networkScales(row) * tanh(b[POINTS * row + k]) + networkOpen * openSky(n[k], row);
}
