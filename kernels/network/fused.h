// The whole network for the 16 * ROW_TILES rows of packet `item`, on tensor cores: features, layers, transfer. Twin of
// `TransferNet.predict`, with weights and activations in halves. Nothing but rows and results leaves the registers: what a layer's
// sums are in is, packed, what the next layer's product takes in. A warp needs no other one.
//     1  rows: points, and whether any of them counts; normals
//     2  features, in the order that lets each lane work out its own ones: `SLOTS` half pairs a lane and row
//     3  layers, 16 neurons at a time: weights come in the order of the lanes, which network/fused.py gives them
//     4  scale * tanh, and the transfer of an open sky where the network holds what is missing from it
// Counts are constants: ROW_TILES; FEATURE_TILES, WIDTH_TILES, OUTPUT_TILES of 16 columns each; MIDDLE layers of the width between
// the first and the last, MIDDLE_UNROLL of them unrolled; POSITIONS and NORMALS octaves; OUTPUTS; RESIDUAL; the leaky ReLU's SLOPE.
// Arguments: weights; numbers: the centre and 1 / extent, biases, scale; points and normals, in rows of so many floats, a multiple
// of four; out; count of rows; masked: rows whose fourth number is not above 0.5 are left alone. Indices of all are below 2^31.
struct Fused : TensorCore {
    enum {
        SLOTS = 2 * FEATURE_TILES,
        OCTAVES = POSITIONS + NORMALS,
        MOST = FEATURE_TILES > WIDTH_TILES ? FEATURE_TILES : WIDTH_TILES,
        TILE = 128,   // words of 16 x 16 weights
        BIASES = 32,  // of 16 neurons, each twice: what the four lanes begin sums with
        ANCHOR = 4   // octaves from one sine that is looked up to the next; those between double the angle
    };
    struct Activations {
        Halves tiles[ROW_TILES][MOST];
    };

    // Turns that an octave makes of a point's and of a normal's component
    static inline CUDA_CALLABLE float turns(int octave, float point, float normal) {
        return octave < POSITIONS ? point * (0.5f * (1 << octave)) : normal * (0.5f * (1 << (octave - POSITIONS)));
    }

    // Lane 0, 1 or 2 of four has sine and cosine of its component, an octave a slot; lane 3 the six numbers themselves, and then
    // the octaves for which the others have no slots
    static inline CUDA_CALLABLE void encode(const float* v, int t, unsigned* slots) {
        const float point = choose(t, v[0], v[1], v[2]), normal = choose(t, v[3], v[4], v[5]);
        float s = 0.0f, c = 0.0f;
        UNROLL for (int slot = 0; slot < SLOTS; slot++) {
            const int octave = slot < POSITIONS ? slot : slot - POSITIONS, left = slot < 3 ? 0 : slot - 3;
            const int extra = SLOTS + left / 3, of = left % 3;
            const bool more = slot >= 3 && extra < OCTAVES;
            if (slot < OCTAVES && (more || octave % ANCHOR == 0)) {
                float turned = turns(slot, point, normal);
                if (more) turned = t == 3 ? turns(extra, v[of], v[3 + of]) : turned;
                const float angle = 6.28318530717958648f * (turned - nearest(turned));
                s = sine(angle), c = cosine(angle);
            } else {
                const float twice = 2.0f * s;
                s = twice * c, c = 1.0f - twice * (0.5f * twice);
            }
            slots[slot] = slot < OCTAVES ? pack(s, c) : 0u;
            if (slot < 3) slots[slot] = t == 3 ? pack(v[2 * slot], v[2 * slot + 1]) : slots[slot];
        }
    }

    // Sums of 16 neurons: two products beside each other a row tile, each from the bias on
    static inline CUDA_CALLABLE void sum(Sums (&sums)[ROW_TILES][2], const Activations& in, int tiles, const int* weights,
                                         const float* biases) {
        UNROLL for (int side = 0; side < 2; side++)
            for (int l = 0; l < HELD; l++) {
                float bias[4];
                load(biases + 8 * (lane(l) & 3) + 4 * side, bias);
                UNROLL for (int m = 0; m < ROW_TILES; m++)
                    UNROLL for (int i = 0; i < 4; i++) sums[m][side].at[l][i] = bias[i];
            }
        UNROLL for (int k = 0; k < tiles; k++) {
            Weights w;
            for (int l = 0; l < HELD; l++) load(weights + k * TILE + 4 * lane(l), w.at[l]);
            UNROLL for (int m = 0; m < ROW_TILES; m++) {
                multiply(sums[m][0], in.tiles[m][k], w, 0);
                multiply(sums[m][1], in.tiles[m][k], w, 1);
            }
        }
    }

    // A layer from `tiles` x 16 columns to the width
    static inline CUDA_CALLABLE void layer(const Activations& in, int tiles, const int* weights, const float* biases,
                                           Activations& out) {
        const unsigned slope = pack(SLOPE, SLOPE);
        UNROLL for (int block = 0; block < WIDTH_TILES; block++) {
            Sums sums[ROW_TILES][2];
            sum(sums, in, tiles, weights + block * tiles * TILE, biases + BIASES * block);
            UNROLL for (int m = 0; m < ROW_TILES; m++)
                for (int l = 0; l < HELD; l++)
                    UNROLL for (int i = 0; i < 4; i++) {
                        const float* pair = sums[m][i >> 1].at[l] + 2 * (i & 1);
                        out.tiles[m][block].at[l][i] = leaky(pack(pair[0], pair[1]), slope);
                    }
        }
    }

    // scale * tanh(x), to 1e-6 of scale
    static inline CUDA_CALLABLE float bounded(float x, float scale) {
        return scale - 2.0f * scale * inverse(1.0f + power_of_two(2.88539008177792681f * x));
    }

    // Coefficients 4t to 4t + 3 of the transfer of an open sky; twin of `open_sky` in sdfprt/network/mlp.py
    static inline CUDA_CALLABLE void add_sky(const float* n, int t, float* transfer) {
        const float x = n[0], y = n[1], z = n[2], a = 0.858085531f, b = 1.02332671f;
        transfer[0] += choose(t, 0.886226925f, a * x * y, t == 2 ? 0.5f * a * (x * x - y * y) : 0.0f);
        transfer[1] += choose(t, -b * y, -a * y * z, 0.0f);
        transfer[2] += choose(t, b * z, 0.247707956f * (3.0f * z * z - 1.0f), 0.0f);
        transfer[3] += choose(t, -b * x, -a * x * z, 0.0f);
    }

    // Of a lane in row tile m, its upper or its lower one
    static inline CUDA_CALLABLE int row_of(int item, int m, int lower, int l) {
        return item * 16 * ROW_TILES + 16 * m + 8 * lower + (lane(l) >> 2);
    }

    // Past the last row the last one
    static inline CUDA_CALLABLE int within(int row, int count) { return row < count ? row : count - 1; }
};

// Points, and a bit for each row that counts
float point[HELD][ROW_TILES][2][4];
unsigned counts[HELD];
UNROLL for (int l = 0; l < HELD; l++) {
    counts[l] = 0;
    UNROLL for (int m = 0; m < ROW_TILES; m++)
        UNROLL for (int r = 0; r < 2; r++) {
            const int row = Fused::row_of(item, m, r, l);
            Fused::load(points.data + Fused::within(row, count) * point_stride, point[l][m][r]);
            const bool hit = !masked | (point[l][m][r][3] > 0.5f);
            counts[l] |= (unsigned)((row < count) & hit) << (2 * m + r);
        }
}
if (Fused::any(counts)) {
    // Features
    Fused::Activations now, next;
    float place[4];
    Fused::load(numbers.data, place);
    UNROLL for (int l = 0; l < HELD; l++)
        UNROLL for (int m = 0; m < ROW_TILES; m++)
            UNROLL for (int r = 0; r < 2; r++) {
                const int row = Fused::row_of(item, m, r, l);
                float normal[4];
                Fused::load(normals.data + Fused::within(row, count) * normal_stride, normal);
                float six[6];
                UNROLL for (int i = 0; i < 3; i++) six[i] = (point[l][m][r][i] - place[i]) * place[3], six[3 + i] = normal[i];
                unsigned slots[Fused::SLOTS];
                Fused::encode(six, Fused::lane(l) & 3, slots);
                UNROLL for (int k = 0; k < FEATURE_TILES; k++) {
                    now.tiles[m][k].at[l][r] = slots[2 * k];
                    now.tiles[m][k].at[l][2 + r] = slots[2 * k + 1];
                }
            }

    // Layers
    const int* weights_here = Fused::anew(weights.data);
    const float* biases = Fused::anew(numbers.data + 4);
    Fused::layer(now, FEATURE_TILES, weights_here, biases, next);
    weights_here += FEATURE_TILES * WIDTH_TILES * Fused::TILE;
    biases += Fused::BIASES * WIDTH_TILES;
#if defined(__CUDA_ARCH__)
#pragma unroll(MIDDLE_UNROLL)
#endif
    for (int k = 0; k < MIDDLE; k++) {
        now = next;
        Fused::layer(now, WIDTH_TILES, weights_here, biases, next);
        weights_here += WIDTH_TILES * WIDTH_TILES * Fused::TILE;
        biases += Fused::BIASES * WIDTH_TILES;
    }

    // Transfer: a lane has four neighbouring outputs of a row
    UNROLL for (int block = 0; block < OUTPUT_TILES; block++) {
        Sums sums[ROW_TILES][2];
        Fused::sum(sums, next, WIDTH_TILES, weights_here + block * WIDTH_TILES * Fused::TILE, biases + Fused::BIASES * block);
        UNROLL for (int l = 0; l < HELD; l++) {
            const int t = Fused::lane(l) & 3, at = 16 * block + 4 * t;
            float scale[4];
            Fused::load(biases + Fused::BIASES * OUTPUT_TILES + at, scale);
            UNROLL for (int m = 0; m < ROW_TILES; m++)
                UNROLL for (int r = 0; r < 2; r++) {
                    const int row = Fused::row_of(item, m, r, l);
                    float transfer[4];
                    UNROLL for (int i = 0; i < 4; i++)
                        transfer[i] = Fused::bounded(sums[m][i >> 1].at[l][2 * r + (i & 1)], scale[i]);
                    if (RESIDUAL && block == 0) {
                        float normal[4];
                        Fused::load_again(normals.data + Fused::within(row, count) * normal_stride, normal);
                        Fused::add_sky(normal, t, transfer);
                    }
                    const bool counting = counts[l] >> (2 * m + r) & 1;
                    float* to = out.data + row * OUTPUTS + at;
                    if (OUTPUTS % 4 == 0) {
                        Fused::store(counting & (at < OUTPUTS), to, transfer);
                    } else {
                        UNROLL for (int i = 0; i < 4; i++) Fused::store(counting & (at + i < OUTPUTS), to + i, transfer[i]);
                    }
                }
        }
    }
}
