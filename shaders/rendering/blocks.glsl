// The network of network.glsl for GPUs: a work group takes BLOCK points through the layers together. Activations lie in shared memory as
// pairs of halves, a row for each two neurons and a column a point. In a hidden layer 32 invocations, a warp, take 16 neurons and each
// of them LANE_POINTS points: weights are the same for the whole warp, and four of them serve as many points. Sums are pairs too, of even
// and of odd inputs, in half precision where the driver has it (HALVES), else in single. Everything that is indexed is indexed by
// constants, by way of macros: what is not lies in slow memory.
vec4 openSky(vec3 n, int row);
#ifdef WEIGHTS_UNIFORM
layout(std140, binding = 1) uniform NetworkWeights {
    uvec4 rows[LAYER_SIZE];  // of one layer, four neurons a word: (bias, 0), then a pair of inputs a row
} networkLayers[LAYERS];
#define WEIGHTS(layer, at) networkLayers[layer].rows[at]
#else
layout(std430, binding = 1) readonly buffer NetworkWeights {
    uvec4 layerRows[];
};
#define WEIGHTS(layer, at) layerRows[(layer) * LAYER_SIZE + (at)]
#endif
#ifdef HALVES
#define PAIR f16vec2
#define HALF float16_t
#define UNPACK(word) unpackFloat2x16(word)
#define PACK(pair) packFloat2x16(pair)
#else
#define PAIR vec2
#define HALF float
#define UNPACK(word) unpackHalf2x16(word)
#define PACK(pair) packHalf2x16(pair)
#endif
uniform vec3 networkCenter;
uniform float networkExtent;
uniform vec4 networkScale[NETWORK_OUTPUTS];
uniform float networkOpen;
uniform int keepLoops;  // 1, see network.glsl
shared uint activations[PAIR_ROWS * BLOCK];

// Rows `row` to `row` + 2 of a point.
void writeFeatures(int row, int point, vec3 u, vec3 v) {
    activations[row * BLOCK + point] = packHalf2x16(u.xy);
    activations[(row + 1) * BLOCK + point] = packHalf2x16(vec2(u.z, v.x));
    activations[(row + 2) * BLOCK + point] = packHalf2x16(v.yz);
}

// sin and cos of pi v, 2 pi v, 4 pi v …
void writeOctaves(int row, int point, vec3 v, int octaves) {
    vec3 s = sin(3.14159265358979 * v), c = cos(3.14159265358979 * v);
    for (int octave = 0; octave < octaves * keepLoops; octave++) {
        writeFeatures(row + 3 * octave, point, s, c);
        vec3 twice = 2.0 * s * c;
        c = 1.0 - 2.0 * s * s;
        s = twice;
    }
}

// DO(neuron, component of a word of weights), of the four neurons of a word
#define FOUR(DO, first) DO(first, x) DO(first + 1, y) DO(first + 2, z) DO(first + 3, w)
// The same of the sixteen neurons whose words lie from `at` on
#define QUARTER(DO, layer, k) word = WEIGHTS(layer, at + k); FOUR(DO, 4 * k)
#define SIXTEEN(DO, layer) QUARTER(DO, layer, 0) QUARTER(DO, layer, 1) QUARTER(DO, layer, 2) QUARTER(DO, layer, 3)
#define SUMS(i, point) sum[LANE_POINTS * (i) + point]
#if LANE_POINTS == 4
#define EACH_POINT(DO, i) DO(i, 0) DO(i, 1) DO(i, 2) DO(i, 3)
#elif LANE_POINTS == 2
#define EACH_POINT(DO, i) DO(i, 0) DO(i, 1)
#else
#define EACH_POINT(DO, i) DO(i, 0)
#endif
#define BEGIN(i, point) SUMS(i, point) = weight;
#define BEGIN_NEURON(i, c) { PAIR weight = UNPACK(word.c); EACH_POINT(BEGIN, i) }
#define ADD(i, point) SUMS(i, point) = fma(weight, given[point], SUMS(i, point));
#define ADD_NEURON(i, c) { PAIR weight = UNPACK(word.c); EACH_POINT(ADD, i) }
#define READ_POINT(i, point) given[point] = UNPACK(activations[column + 32 * point]);
#define WRITE(i, point) { \
    PAIR pair = PAIR(SUMS(2 * (i), point).x + SUMS(2 * (i), point).y, SUMS(2 * (i) + 1, point).x + SUMS(2 * (i) + 1, point).y); \
    activations[(8 * warp + i) * BLOCK + lane + 32 * point] = PACK(max(pair, HALF(0.01) * pair)); }
#define WRITE_PAIR(i) EACH_POINT(WRITE, i)

// A hidden layer, in place.
void hiddenLayer(int layer, int pairs) {
    int lane = int(gl_LocalInvocationID.x) & 31, warp = int(gl_LocalInvocationID.x) >> 5, at = 4 * warp, column = lane;
    PAIR sum[16 * LANE_POINTS];
    uvec4 word;
    SIXTEEN(BEGIN_NEURON, layer)
    for (int k = 0; k < pairs * keepLoops; k++) {
        PAIR given[LANE_POINTS];
        EACH_POINT(READ_POINT, 0)
        at += 4 * WARPS;
        column += BLOCK;
        SIXTEEN(ADD_NEURON, layer)
    }
    barrier();
    WRITE_PAIR(0) WRITE_PAIR(1) WRITE_PAIR(2) WRITE_PAIR(3) WRITE_PAIR(4) WRITE_PAIR(5) WRITE_PAIR(6) WRITE_PAIR(7)
    barrier();
}

#define BEGIN_OUTPUT(i, c) sum[i] = UNPACK(word.c);
#define ADD_OUTPUT(i, c) sum[i] = fma(UNPACK(word.c), value, sum[i]);
#define OUTPUT(i) vec4(sum[i].x, sum[i + 1].x, sum[i + 2].x, sum[i + 3].x) + vec4(sum[i].y, sum[i + 1].y, sum[i + 2].y, sum[i + 3].y)
const int OUTPUT_WORDS = (NETWORK_OUTPUTS + 3) / 4 * 4;

// Sixteen outputs of a point from `first` on, four a vector.
void lastLayer(int point, int first, int pairs, out vec4 result[4]) {
    int at = first;
    PAIR sum[16];
    uvec4 word;
    SIXTEEN(BEGIN_OUTPUT, LAYERS - 1)
    for (int k = 0; k < pairs * keepLoops; k++) {
        PAIR value = UNPACK(activations[k * BLOCK + point]);
        at += OUTPUT_WORDS;
        SIXTEEN(ADD_OUTPUT, LAYERS - 1)
    }
    result = vec4[4](OUTPUT(0), OUTPUT(4), OUTPUT(8), OUTPUT(12));
}

// A layer's number is a constant, which is a tenth faster than a loop
#define HIDDEN(i) if (i < LAYERS - 1) { hiddenLayer(min(i, LAYERS - 1), pairs); pairs = 8 * WARPS; }

// T_i at POINTS points of each invocation, as of network.glsl; all invocations of a group have to come here.
void network(vec3 p[POINTS], vec3 n[POINTS], out vec4 transfer[POINTS * NETWORK_OUTPUTS]) {
    int mine = int(gl_LocalInvocationID.x) * POINTS, pairs = 3 * (1 + POSITION_OCTAVES + NORMAL_OCTAVES);
    if (mine < BLOCK)
        for (int k = 0; k < POINTS; k++) {
            vec3 x = (p[k] - networkCenter) / networkExtent;
            writeFeatures(0, mine + k, x, n[k]);
            writeOctaves(3, mine + k, x, POSITION_OCTAVES);
            writeOctaves(3 + 3 * POSITION_OCTAVES, mine + k, n[k], NORMAL_OCTAVES);
        }
    barrier();
    HIDDEN(0) HIDDEN(1) HIDDEN(2) HIDDEN(3) HIDDEN(4) HIDDEN(5) HIDDEN(6) HIDDEN(7) HIDDEN(8) HIDDEN(9)
    if (mine >= BLOCK) return;
    for (int k = 0; k < POINTS; k++)
        for (int first = 0; first < OUTPUT_WORDS; first += 4) {
            vec4 result[4];
            lastLayer(mine + k, first, pairs, result);
            for (int i = 0; i < 4; i++)
                if (first + i < NETWORK_OUTPUTS)
                    transfer[k * NETWORK_OUTPUTS + first + i] =
                        networkScale[first + i] * tanh(result[i]) + networkOpen * openSky(n[k], first + i);
        }
}
