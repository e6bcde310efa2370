// Gradient of the squared error of a network, which counts linearly beyond `outlier`, over part `item` of a batch, for its matrices and biases; the forward pass in it is the
// twin of `forward` in sdfprt/network/mlp.py.
// TILE samples at a time pass through all layers and back, so that all stays in cache.
const int TILE = 64, MOST = 32;
const int* size = sizes.data;  // of the features, then the neurons of each layer
float* at = scratch.data + (long long)item * room;

// Padded: weights, their transposes, biases, and the gradients so far
float *w[MOST], *t[MOST], *b[MOST], *gw[MOST], *gb[MOST], *a[MOST + 1];
const float *weight = weights.data, *bias = biases.data;
int widest = Product::padded(size[0]);
for (int l = 0; l < layers; l++) {
    const int n = size[l], m = size[l + 1], count = Product::padded(n) * Product::padded(m);
    widest = widest > Product::padded(m) ? widest : Product::padded(m);
    w[l] = at;
    t[l] = w[l] + count;
    gw[l] = t[l] + count;
    b[l] = gw[l] + count;
    gb[l] = b[l] + Product::padded(m);
    at = gb[l] + Product::padded(m);
    Product::widen(weight, m, n, w[l], false);
    Product::widen(weight, m, n, t[l], true);
    Product::clear(b[l], Product::padded(m));
    for (int i = 0; i < m; i++) b[l][i] = bias[i];
    Product::clear(gw[l], count);
    Product::clear(gb[l], Product::padded(m));
    weight += m * n;
    bias += m;
}
for (int l = 0; l <= layers; l++, at += TILE * widest) a[l] = at;
float *back = at, *next = at + TILE * widest;

const int begin = (int)((long long)batch * item / parts), end = (int)((long long)batch * (item + 1) / parts);
for (int first = begin; first < end; first += TILE) {
    const int live = end - first < TILE ? end - first : TILE;
    const int inputs = size[0], outputs = size[layers], wide = Product::padded(inputs), last = Product::padded(outputs);
    Product::clear(a[0], TILE * wide);
    for (int r = 0; r < live; r++)
        for (int i = 0; i < inputs; i++) a[0][r * wide + i] = features.data[(long long)rows.data[first + r] * inputs + i];

    // Forward
    for (int l = 0; l < layers; l++) {
        const int n = Product::padded(size[l]), m = Product::padded(size[l + 1]);
        for (int r = 0; r < TILE; r++)
            for (int i = 0; i < m; i += SDFPRT_LANES) Simd::spill(a[l + 1] + r * m + i, Simd::fill(b[l] + i));
        Product::add(TILE, m, n, a[l], n, 1, t[l], m, a[l + 1], m);
        for (int i = 0; i < TILE * m; i += SDFPRT_LANES) {
            const F v = Simd::fill(a[l + 1] + i);
            Simd::spill(a[l + 1] + i, l + 1 < layers ? Simd::max(v, slope * v) : Simd::tanh(v));
        }
    }

    // Derivative of the error by what tanh was given, then back through the layers
    Product::clear(back, TILE * last);
    for (int r = 0; r < live; r++) {
        const float* want = targets.data + (long long)rows.data[first + r] * outputs;
        for (int i = 0; i < outputs; i++) {
            const float y = a[layers][r * last + i];
            const float error = y - want[i], held = error > outlier ? outlier : error < -outlier ? -outlier : error;
            back[r * last + i] = held * slopes.data[i] * (1.0f - y * y);
        }
    }
    for (int l = layers - 1; l >= 0; l--) {
        const int n = Product::padded(size[l]), m = Product::padded(size[l + 1]);
        for (int r = 0; r < TILE; r++)
            for (int i = 0; i < m; i += SDFPRT_LANES)
                Simd::spill(gb[l] + i, Simd::fill(gb[l] + i) + Simd::fill(back + r * m + i));
        Product::add(m, n, TILE, back, 1, m, a[l], n, gw[l], n);
        if (l == 0) break;
        Product::clear(next, TILE * n);
        Product::add(TILE, n, m, back, m, 1, w[l], n, next, n);
        for (int i = 0; i < TILE * n; i += SDFPRT_LANES) {
            const F v = Simd::fill(next + i);
            Simd::spill(next + i, Simd::sel(Simd::lt(Simd::splat(0.0f), Simd::fill(a[l] + i)), v, slope * v));
        }
        float* spare = back;
        back = next;
        next = spare;
    }
}

// Out, without the padding
float* out = gradients.data + (long long)item * total;
for (int l = 0; l < layers; l++)
    for (int r = 0; r < size[l + 1]; r++)
        for (int i = 0; i < size[l]; i++) *out++ = gw[l][r * Product::padded(size[l]) + i];
for (int l = 0; l < layers; l++)
    for (int r = 0; r < size[l + 1]; r++) *out++ = gb[l][r];
