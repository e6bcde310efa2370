// Transfer at a surface point: positional encoding, then the MLP with leaky ReLU (learnt transfer, Sec. 3.2).
// Counts are in fours: INPUTS, WIDTH, OUTPUTS; LAYERS linear layers.
// Weights come from a texture: compiled in two seconds at any width where constants took half a minute, and any network of
// the same size runs without compiling again.
uniform sampler2D networkWeights;  // 4x4 blocks, row of blocks after row, layer after layer; then the biases
uniform vec3 networkCenter;
uniform float networkExtent;
uniform vec4 networkScale[OUTPUTS];
uniform int once;  // 1: loops whose length the compiler cannot know stay loops, and compile in seconds

// Columns of a block, and a bias, in rows of 1024 texels.
vec4 weightTexel(int at) {
    return texelFetch(networkWeights, ivec2(at & 1023, at >> 10), 0);
}

mat4 weightBlock(int at) {
    return mat4(weightTexel(4 * at), weightTexel(4 * at + 1), weightTexel(4 * at + 2), weightTexel(4 * at + 3));
}

// T_i at p with unit normal n, in fours.
void network(vec3 p, vec3 n, out vec4 transfer[OUTPUTS]) {
    // Features: x, n, then three quads an octave; sin and cos of pi v, 2 pi v, 4 pi v … by the formulas of the double angle
    vec4 a[INPUTS > WIDTH ? INPUTS : WIDTH], b[WIDTH > OUTPUTS ? WIDTH : OUTPUTS];
    vec3 x = (p - networkCenter) / networkExtent;
    a[0] = vec4(x, n.x);
    a[1] = vec4(n.yz, 0.0, 0.0);
    vec3 sx = sin(3.14159265358979 * x), cx = cos(3.14159265358979 * x);
    vec3 sn = sin(3.14159265358979 * n), cn = cos(3.14159265358979 * n);
    for (int at = 2; at < INPUTS * once; at += 3) {
        a[at] = vec4(sx, cx.x);
        a[at + 1] = vec4(cx.yz, sn.xy);
        a[at + 2] = vec4(sn.z, cn);
        vec3 twice = 2.0 * sx * cx;
        cx = 1.0 - 2.0 * sx * sx;
        sx = twice;
        twice = 2.0 * sn * cn;
        cn = 1.0 - 2.0 * sn * sn;
        sn = twice;
    }

    // Layers: b = W a + bias, back into a
    int block = 0, bias = 4 * BLOCKS, columns = INPUTS * once;
    for (int layer = 0; layer < LAYERS * once; layer++) {
        int rows = layer == LAYERS - 1 ? OUTPUTS : WIDTH;
        for (int row = 0; row < rows; row++) {
            vec4 sum = weightTexel(bias + row);
            for (int column = 0; column < columns; column++) sum += weightBlock(block + column) * a[column];
            block += columns;
            b[row] = sum;
        }
        bias += rows;
        columns = WIDTH * once;
        for (int row = 0; row < WIDTH * once; row++) a[row] = max(b[row], 0.01 * b[row]);
    }
    for (int row = 0; row < OUTPUTS; row++) transfer[row] = networkScale[row] * tanh(b[row]);
}
