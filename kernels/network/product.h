// Matrix products for the fit of a network, and rows and columns padded to whole packets with zeros.
struct Product : Simd {
    static inline CUDA_CALLABLE int padded(int n) { return (n + 15) & ~15; }

    // C += A B for multiples of 4 rows and of the lanes columns; A(r, k) = a[r * a_row + k * a_inner], B and C by rows.
    // `upper` leaves out blocks of C that lie below its diagonal.
    static inline CUDA_CALLABLE void add(int rows, int columns, int inner, const float* a, int a_row, int a_inner, const float* b,
                                         int b_row, float* c, int c_row, bool upper = false) {
        for (int at = 0; at < columns; at += SDFPRT_LANES) {
            const int end = upper && at + SDFPRT_LANES < rows ? at + SDFPRT_LANES : rows;
            for (int r = 0; r < end; r += 4) {
                const float* x = a + r * a_row;
                float* out = c + r * c_row + at;
                F s0 = fill(out), s1 = fill(out + c_row), s2 = fill(out + 2 * c_row), s3 = fill(out + 3 * c_row);
#pragma unroll 4
                for (int k = 0; k < inner; k++) {
                    const F v = fill(b + k * b_row + at);
                    const float* y = x + k * a_inner;
                    s0 += splat(y[0]) * v;
                    s1 += splat(y[a_row]) * v;
                    s2 += splat(y[2 * a_row]) * v;
                    s3 += splat(y[3 * a_row]) * v;
                }
                spill(out, s0);
                spill(out + c_row, s1);
                spill(out + 2 * c_row, s2);
                spill(out + 3 * c_row, s3);
            }
        }
    }

    // What lies below the diagonal of a symmetric n x n matrix, from above it
    static inline CUDA_CALLABLE void mirror(float* v, int n) {
        for (int r = 1; r < n; r++)
            for (int c = 0; c < r; c++) v[r * n + c] = v[c * n + r];
    }

    static inline CUDA_CALLABLE void clear(float* v, int count) {
        for (int i = 0; i < count; i += SDFPRT_LANES) spill(v + i, splat(0.0f));
    }

    // A matrix of rows x columns as one of padded(rows) x padded(columns), or its transpose so
    static inline CUDA_CALLABLE void widen(const float* from, int rows, int columns, float* to, bool turned) {
        const int row = padded(turned ? rows : columns);
        clear(to, padded(rows) * padded(columns));
        for (int r = 0; r < rows; r++)
            for (int c = 0; c < columns; c++) to[turned ? c * row + r : r * row + c] = from[r * columns + c];
    }
};
