// Matrix `item` brought near to U V^T of its singular value decomposition (Muon, Jordan et al. 2024).
const float* from = matrices.data;
float* to = results.data;
for (int l = 0; l < item; l++) {
    from += sizes.data[l] * sizes.data[l + 1];
    to += sizes.data[l] * sizes.data[l + 1];
}
const int m = sizes.data[item + 1], n = sizes.data[item];
const bool tall = m > n;  // then its transpose is worked on
const int p = Product::padded(tall ? n : m), q = Product::padded(tall ? m : n);
float* x = scratch.data + (long long)item * room;
float *turned = x + p * q, *next = turned + p * q, *gram = next + p * q, *mixed = gram + p * p;
float norm = 0.0f;
for (int i = 0; i < m * n; i++) norm += from[i] * from[i];
norm = sqrtf(norm) + 1e-12f;
Product::widen(from, m, n, x, tall);
for (int i = 0; i < p * q; i += SDFPRT_LANES) Simd::spill(x + i, Simd::fill(x + i) / norm);
for (int turn = 0; turn < 5; turn++) {
    for (int r = 0; r < p; r++)
        for (int c = 0; c < q; c++) turned[c * p + r] = x[r * q + c];
    Product::clear(gram, p * p);
    Product::add(p, p, q, x, q, 1, turned, p, gram, p, true);
    Product::mirror(gram, p);
    Product::clear(mixed, p * p);
    Product::add(p, p, p, gram, p, 1, gram, p, mixed, p, true);
    Product::mirror(mixed, p);
    for (int i = 0; i < p * p; i += SDFPRT_LANES)
        Simd::spill(mixed + i, -4.7750f * Simd::fill(gram + i) + 2.0315f * Simd::fill(mixed + i));
    for (int i = 0; i < p * q; i += SDFPRT_LANES) Simd::spill(next + i, 3.4445f * Simd::fill(x + i));
    Product::add(p, q, p, mixed, p, 1, x, q, next, q);
    float* spare = x;
    x = next;
    next = spare;
}
for (int r = 0; r < m; r++)
    for (int c = 0; c < n; c++) to[r * n + c] = x[tall ? c * q + r : r * q + c];
