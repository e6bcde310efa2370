// The network of network.glsl for GPUs: a work group takes BLOCK points through the layers together, each a product of matrices in
// blocks. Activations lie in shared memory, a row a feature, four points a quad; an invocation computes 8 neurons of 8 points in
// registers, so that two quads of weights and two of activations serve 64 multiplications.
vec4 openSky(vec3 n, int row);
layout(std430, binding = 1) readonly buffer BlockWeights {
    vec4 blockWeights[];  // layer after layer, four neurons a quad: the biases, then a row for each of the layer's inputs
};
uniform vec3 networkCenter;
uniform float networkExtent;
uniform vec4 networkScale[NETWORK_OUTPUTS];
uniform float networkOpen;
uniform int keepLoops;  // 1, see network.glsl
const int POINT_QUADS = BLOCK / 4, POINT_TILES = BLOCK / 8, NEURON_TILES = BLOCK_WIDTH / 2;
const int ROUNDS = (POINT_QUADS * NETWORK_OUTPUTS + GROUP - 1) / GROUP;  // quads of outputs that an invocation computes
shared vec4 activations[BLOCK_ROWS * POINT_QUADS];

void writeFeatures(int row, int point, vec3 v) {
    for (int i = 0; i < 3; i++) activations[(row + i) * POINT_QUADS + (point >> 2)][point & 3] = v[i];
}

// sin and cos of pi v, 2 pi v, 4 pi v …
void writeOctaves(int row, int point, vec3 v, int octaves) {
    vec3 s = sin(3.14159265358979 * v), c = cos(3.14159265358979 * v);
    for (int octave = 0; octave < octaves * keepLoops; octave++) {
        writeFeatures(row + 6 * octave, point, s);
        writeFeatures(row + 6 * octave + 3, point, c);
        vec3 twice = 2.0 * s * c;
        c = 1.0 - 2.0 * s * s;
        s = twice;
    }
}

// A hidden layer, in place: 8 neurons of 8 points, two quads of each.
void hiddenLayer(int weights, int inputs) {
    // A warp of 32 invocations takes 8 tiles of points by 4 of neurons where there are as many
    int me = int(gl_LocalInvocationID.x), warp = me >> 5;
    const int across = max(POINT_TILES / 8, 1);
    bool square = POINT_TILES >= 8 && NEURON_TILES % 4 == 0;
    int point = square ? (me & 7) + 8 * (warp % across) : me % POINT_TILES;
    int neuron = square ? ((me >> 3) & 3) + 4 * (warp / across) : me / POINT_TILES;
    vec4 sum[16];
    for (int i = 0; i < 16; i++) sum[i] = vec4(blockWeights[weights + neuron + (i / 8) * NEURON_TILES][i / 2 % 4]);
    int w = weights + BLOCK_WIDTH + neuron, a = point;
    for (int k = 0; k < inputs; k++, w += BLOCK_WIDTH, a += POINT_QUADS) {
        vec4 low = blockWeights[w], high = blockWeights[w + NEURON_TILES];
        vec4 near = activations[a], far = activations[a + POINT_TILES];
        for (int i = 0; i < 4; i++) {
            sum[2 * i] += low[i] * near;
            sum[2 * i + 1] += low[i] * far;
            sum[2 * i + 8] += high[i] * near;
            sum[2 * i + 9] += high[i] * far;
        }
    }
    barrier();
    for (int i = 0; i < 16; i++) {
        int row = 4 * (neuron + (i / 8) * NEURON_TILES) + i / 2 % 4;
        activations[row * POINT_QUADS + point + (i % 2) * POINT_TILES] = max(sum[i], 0.01 * sum[i]);
    }
    barrier();
}

// The last layer without its tanh, in place: four outputs of four points a round.
void lastLayer(int weights, int inputs) {
    vec4 sum[4 * ROUNDS];
    for (int i = 0; i < ROUNDS; i++) {
        int tile = int(gl_LocalInvocationID.x) + i * GROUP, a = tile % POINT_QUADS, w = weights + min(tile / POINT_QUADS, NETWORK_OUTPUTS - 1);
        for (int c = 0; c < 4; c++) sum[4 * i + c] = vec4(blockWeights[w][c]);
        for (int k = 0; k < inputs; k++) {
            w += NETWORK_OUTPUTS;
            vec4 weight = blockWeights[w], activation = activations[a + k * POINT_QUADS];
            for (int c = 0; c < 4; c++) sum[4 * i + c] += weight[c] * activation;
        }
    }
    barrier();
    for (int i = 0; i < ROUNDS; i++) {
        int tile = int(gl_LocalInvocationID.x) + i * GROUP;
        if (tile < POINT_QUADS * NETWORK_OUTPUTS)
            for (int c = 0; c < 4; c++) activations[(4 * (tile / POINT_QUADS) + c) * POINT_QUADS + tile % POINT_QUADS] = sum[4 * i + c];
    }
    barrier();
}

// T_i at POINTS points of each invocation, as of network.glsl; all invocations of a group have to come here.
void network(vec3 p[POINTS], vec3 n[POINTS], out vec4 transfer[POINTS * NETWORK_OUTPUTS]) {
    int mine = int(gl_LocalInvocationID.x) * POINTS;
    if (mine < BLOCK)
        for (int k = 0; k < POINTS; k++) {
            vec3 x = (p[k] - networkCenter) / networkExtent;
            writeFeatures(0, mine + k, x);
            writeFeatures(3, mine + k, n[k]);
            writeOctaves(6, mine + k, x, POSITION_OCTAVES);
            writeOctaves(6 + 6 * POSITION_OCTAVES, mine + k, n[k], NORMAL_OCTAVES);
        }
    barrier();
    int weights = 0, inputs = FEATURES;
    for (int layer = 0; layer < (LAYERS - 1) * keepLoops; layer++) {
        hiddenLayer(weights, inputs);
        weights += (1 + inputs) * BLOCK_WIDTH;
        inputs = 4 * BLOCK_WIDTH;
    }
    lastLayer(weights, inputs);
    for (int k = 0; k < POINTS; k++)
        for (int row = 0; row < NETWORK_OUTPUTS; row++) {
            vec4 value;
            int at = min(mine + k, BLOCK - 1);
            for (int i = 0; i < 4; i++) value[i] = activations[(4 * row + i) * POINT_QUADS + (at >> 2)][at & 3];
            transfer[k * NETWORK_OUTPUTS + row] = networkScale[row] * tanh(value) + networkOpen * openSky(n[k], row);
        }
}
