// Transfer at a surface point: positional encoding by angle doubling, then the MLP with leaky ReLU (learnt transfer, Sec. 3.2).
// Counts are in fours: INPUTS, WIDTH, OUTPUTS; LAYERS linear layers. Weights are data: 4x4 blocks, row of blocks after row.
mat4 weightBlock(int at);
vec4 biasQuad(int at);
uniform vec3 networkCenter;
uniform float networkExtent;
uniform vec4 networkScale[OUTPUTS];
uniform int once;  // 1: loops whose length the compiler cannot know stay loops, and compile in seconds

void putFeature(inout float f[4 * INPUTS], inout int at, vec3 v) {
    f[at] = v.x;
    f[at + 1] = v.y;
    f[at + 2] = v.z;
    at += 3;
}

// sin and cos of pi v, 2 pi v, 4 pi v … by the formulas of the double angle.
void putOctaves(inout float f[4 * INPUTS], inout int at, vec3 v, int octaves) {
    vec3 s = sin(3.14159265358979 * v), c = cos(3.14159265358979 * v);
    for (int k = 0; k < octaves; k++) {
        putFeature(f, at, s);
        putFeature(f, at, c);
        vec3 twice = 2.0 * s * c;
        c = 1.0 - 2.0 * s * s;
        s = twice;
    }
}

// T_i at p with unit normal n, in fours.
void network(vec3 p, vec3 n, out vec4 transfer[OUTPUTS]) {
    // Features, zero-padded
    float f[4 * INPUTS];
    for (int i = 4 * INPUTS - 3; i < 4 * INPUTS; i++) f[i] = 0.0;
    int at = 0;
    vec3 x = (p - networkCenter) / networkExtent;
    putFeature(f, at, x);
    putFeature(f, at, n);
    putOctaves(f, at, x, POSITION_FREQUENCIES);
    putOctaves(f, at, n, NORMAL_FREQUENCIES);
    vec4 a[INPUTS > WIDTH ? INPUTS : WIDTH], b[WIDTH > OUTPUTS ? WIDTH : OUTPUTS];
    for (int i = 0; i < INPUTS; i++) a[i] = vec4(f[4 * i], f[4 * i + 1], f[4 * i + 2], f[4 * i + 3]);

    // Layers: b = W a + bias, back into a
    int block = 0, bias = 0, columns = INPUTS * once;
    for (int layer = 0; layer < LAYERS * once; layer++) {
        int rows = layer == LAYERS - 1 ? OUTPUTS : WIDTH;
        for (int row = 0; row < rows; row++) {
            vec4 sum = biasQuad(bias + row);
            for (int column = 0; column < columns; column++) sum += weightBlock(block + column) * a[column];
            block += columns;
            b[row] = sum;
        }
        bias += rows;
        columns = WIDTH * once;
        for (int row = 0; row < WIDTH; row++) a[row] = max(b[row], 0.01 * b[row]);
    }
    for (int row = 0; row < OUTPUTS; row++) transfer[row] = networkScale[row] * tanh(b[row]);
}
