// The sum of the material's lobes from transfer, one sample: what shading.shade does with arrays. Twins: sdfprt/material/shading.py,
// shaders/rendering/shade.glsl with bounced.glsl and reflection.glsl.
// LOBES: 1 diffuse, 2 Phong, 4 reflection mapping. What a light, a material and colours give lies in `numbers`, from the places AT_…
// on; rows of coefficients take whole fours there. Loops over coefficients are unrolled on CUDA, so that these stay in registers.
#if defined(__CUDA_ARCH__)
#define UNROLL _Pragma("unroll")
#else
#define UNROLL
#endif
struct alignas(16) Four {
    float x, y, z, w;
};
struct Shade {
    enum {
        K = BANDS * BANDS,
        QUADS = (K + 3) / 4,
        PADDED = 4 * QUADS,
        MOST = BANDS > RESULT_BANDS ? BANDS : RESULT_BANDS,  // bands of a basis
    };
    static CUDA_CALLABLE float open() { return 0.886226925452758f; }  // T_0 under an open sky
    static CUDA_CALLABLE float closed() { return 0.02f; }             // of the directions, at least, that bounced light comes from
    static CUDA_CALLABLE float cut(float x, float low, float high) { return x < low ? low : high < x ? high : x; }  // NaN stays
    static CUDA_CALLABLE float dot(const float* a, const float* b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
    static CUDA_CALLABLE void normalize(float* v) {
        const float size = sqrtf(dot(v, v)), over = 1.0f / (size > 1e-12f ? size : 1e-12f);
        for (int c = 0; c < 3; c++) v[c] *= over;
    }
    // From the world into the frame of a map whose rotation is given, row by row
    static CUDA_CALLABLE void turned(const float* d, const float* rotation, float* out) {
        for (int c = 0; c < 3; c++) out[c] = d[0] * rotation[c] + d[1] * rotation[3 + c] + d[2] * rotation[6 + c];
    }
    // sum_i t_i row_i of a row in `numbers`
    static CUDA_CALLABLE float product(const float* t, const float* row) {
        const Four* four = (const Four*)row;
        float sum = 0.0f;
        UNROLL for (int q = 0; q < QUADS; q++) {
            const Four v = four[q];
            sum += t[4 * q] * v.x + t[4 * q + 1] * v.y + t[4 * q + 2] * v.z + t[4 * q + 3] * v.w;
        }
        return sum;
    }

    // Where a direction lies in a lat-long map: four texels and their weights
    struct Place {
        int texel[4];
        float weight[4];
    };
    static CUDA_CALLABLE void latlong(const float* d, int rows, int columns, Place& at) {
        const float x = (0.5f - atan2f(d[0], d[2]) * 0.159154943091895f) * (float)columns - 0.5f;
        const float y = cut(acosf(cut(d[1], -1.0f, 1.0f)) * 0.318309886183791f * (float)rows - 0.5f, 0.0f, (float)(rows - 1));
        const float x0 = floorf(x), y0 = floorf(y), fx = x - x0, fy = y - y0;
        // By no number the first texel, and no number is its weight
        const int left = x0 >= 0.0f && x0 < (float)columns ? (int)x0 : x0 < 0.0f ? columns - 1 : 0;
        const int top = y0 > 0.0f ? (int)y0 : 0, right = left + 1 < columns ? left + 1 : 0, below = top + 1 < rows ? top + 1 : top;
        at.texel[0] = top * columns + left, at.weight[0] = (1.0f - fx) * (1.0f - fy);
        at.texel[1] = top * columns + right, at.weight[1] = fx * (1.0f - fy);
        at.texel[2] = below * columns + left, at.weight[2] = (1.0f - fx) * fy;
        at.texel[3] = below * columns + right, at.weight[3] = fx * fy;
    }
    // Radiance of a map of three channels
    static CUDA_CALLABLE void look(const float* map, int rows, int columns, const float* d, float* out) {
        Place at;
        latlong(d, rows, columns, at);
        out[0] = out[1] = out[2] = 0.0f;
        for (int k = 0; k < 4; k++)
            for (int c = 0; c < 3; c++) out[c] += at.weight[k] * map[3 * (size_t)at.texel[k] + c];
    }

    // g_l = sqrt(4 pi/(2l+1)) f_l of (s+2)/(2 pi) cos^s
    static CUDA_CALLABLE void lobe_factors(float s, float* g) {
        UNROLL for (int l = 0; l < MOST; l++)
            g[l] = l == 0 ? (s + 2.0f) / (s + 1.0f) : l == 1 ? 1.0f : g[l - 2] * (s - (float)l + 2.0f) / (s + (float)l + 1.0f);
    }
    // Basis functions at the unit direction d: the recurrence in l of each order m (maths/sh.py)
    static CUDA_CALLABLE void basis(const float* d, float* y) {
        float re = 1.0f, im = 0.0f, diagonal = 1.0f, first = 1.0f;
        UNROLL for (int m = 0; m < MOST; m++) {
            // P_l^m without its sin^m; ratio: (l-m)! / (l+m)!
            float before = 0.0f, here = diagonal, ratio = first;
            UNROLL for (int l = m; l < MOST; l++) {
                const float value = sqrtf((float)(2 * l + 1) * 0.0795774715459477f * ratio) * here;
                const int at = l * (l + 1);
                if (m == 0) y[at] = value;
                else y[at + m] = 1.4142135623731f * value * re, y[at - m] = 1.4142135623731f * value * im;
                const float next = ((float)(2 * l + 1) * d[2] * here - (float)(l + m) * before) / (float)(l - m + 1);
                before = here;
                here = next;
                ratio *= (float)(l - m + 1) / (float)(l + m + 1);
            }
            const float other = re * d[0] - im * d[1];
            im = re * d[1] + im * d[0];
            re = other;
            diagonal *= -(float)(2 * m + 1);
            first /= (float)((2 * m + 1) * (2 * m + 2));
        }
    }

#if EXACT && (LOBES & 2)
    // sum_j T_j F_j(R) of the lobe about the world direction r with exponent s; maps: levels, rows, columns, channels, coefficients
    static CUDA_CALLABLE void exact_gloss(const float* t, const float* r, float s, const float* numbers, const float* maps, int rows,
                                          float* out) {
        float own[PADDED], d[3];
        UNROLL for (int i = K; i < PADDED; i++) own[i] = 0.0f;
        UNROLL for (int l = 0; l < BANDS; l++)  // bands do not mix
            UNROLL for (int j = l * l; j < (l + 1) * (l + 1); j++) {
                own[j] = 0.0f;
                UNROLL for (int i = l * l; i < (l + 1) * (l + 1); i++) own[j] += t[i] * numbers[AT_TURN + i * K + j];
            }
        turned(r, numbers + AT_LIGHT_FRAME, d);
        const int columns = 2 * rows;
        Place at;
        latlong(d, rows, columns, at);
        // Between two levels such that the lobe's variance, 1 / s, is right
        const float e = cut(s, 1.0f, (float)(1 << (GLOSS_LEVELS - 1))), whole = floorf(log2f(e));
        const float low = cut(whole, 0.0f, (float)(GLOSS_LEVELS > 2 ? GLOSS_LEVELS - 2 : 0));
        const float share = GLOSS_LEVELS > 1 ? 2.0f - 2.0f * exp2f(low) / e : 0.0f;
        const int level = GLOSS_LEVELS > 1 && low > 0.0f ? (int)low : 0;
        out[0] = out[1] = out[2] = 0.0f;
        for (int k = 0; k < (GLOSS_LEVELS > 1 ? 8 : 4); k++) {
            const size_t texel = (size_t)(level + k / 4) * rows * columns + at.texel[k % 4];
            const float weight = at.weight[k % 4] * (k / 4 ? share : 1.0f - share);
            UNROLL for (int c = 0; c < 3; c++) out[c] += weight * product(own, maps + (3 * texel + c) * PADDED);
        }
    }
#endif

    // One transfer of a row of them
    static CUDA_CALLABLE void load(const float* row, float* t) {
#if BANDS % 2 == 0  // whole fours
        UNROLL for (int q = 0; q < QUADS; q++) {
            const Four v = ((const Four*)row)[q];
            t[4 * q] = v.x, t[4 * q + 1] = v.y, t[4 * q + 2] = v.z, t[4 * q + 3] = v.w;
        }
#else
        UNROLL for (int i = 0; i < PADDED; i++) t[i] = i < K ? row[i] : 0.0f;
#endif
    }

    // Radiance along o from the surface with normal n and a row of transfer, of which those of bounces follow the direct one. `base`
    // is the surface's albedo, s its exponent. `sums`: over the light's discs, for a white diffuse surface and a white lobe.
    static CUDA_CALLABLE void shade(const float* row, const float* n, const float* o, float* base, float s, const float* sums,
                                    const float* numbers, const float* gloss, int gloss_rows, const float* opening, int open_rows,
                                    const float* environment, int environment_rows, int environment_columns, float* out) {
        float t[PADDED], total[3] = {}, direct[3] = {}, mirrored[3], found[3];
        load(row, t);
        const float facing = 2.0f * dot(n, o);
        for (int c = 0; c < 3; c++) mirrored[c] = facing * n[c] - o[c];
        const float over = 1.0f / sqrtf(dot(mirrored, mirrored));
        for (int c = 0; c < 3; c++) mirrored[c] *= over;
        const float* specular = numbers + AT_SPECULAR;

#if TRANSFERS > 1
        // What bounces bring, and the surface's own colour after its table has changed (material/colours.py)
        float arriving[3] = {};
        for (int b = 1; b < TRANSFERS; b++) {
            float more[PADDED];
            load(row + b * K, more);
            for (int c = 0; c < 3; c++)
                arriving[c] += numbers[AT_BOUNCES + 3 * (b - 1) + c] * product(more, numbers + AT_WHOLE_LIGHT + c * PADDED);
        }
        for (int c = 0; c < 3; c++) arriving[c] = arriving[c] < 0.0f ? 0.0f : arriving[c];
#if PARTS > 0
        int part = 0;
        float least = 0.0f;
        for (int q = 0; q < PARTS; q++) {
            float apart = 0.0f;
            for (int c = 0; c < 3; c++) {
                const float away = base[c] - numbers[AT_PARTS + 6 * q + c];
                apart += away * away;
            }
            if (q == 0 || apart < least) part = q, least = apart;
        }
        const float* own = numbers + AT_PARTS + 6 * part;  // before; after it, now
        const float square = dot(own, own), share = square > 0.0f ? dot(base, own) / square : 1.0f;
        for (int c = 0; c < 3; c++) {
            const float now = base[c] + share * (own[3 + c] - own[c]);
            base[c] = now < 0.0f ? 0.0f : now;
        }
#endif
#endif

#if LOBES & 1
        for (int c = 0; c < 3; c++) total[c] += base[c] * product(t, numbers + AT_DIFFUSE + c * PADDED);
#if EXACT
        float ahead[3];
        turned(n, numbers + AT_LIGHT_FRAME, ahead);
        look(opening, open_rows, 2 * open_rows, ahead, found);
        for (int c = 0; c < 3; c++) total[c] += base[c] * cut(t[0] / open(), 0.0f, 1.0f) * found[c];
#endif
#if TRANSFERS > 1
        for (int c = 0; c < 3; c++) direct[c] += base[c] * arriving[c];
#endif
#endif

#if LOBES & 2
#if EXACT
        exact_gloss(t, mirrored, s, numbers, gloss, gloss_rows, found);
        for (int c = 0; c < 3; c++) total[c] += specular[c] * found[c];
#endif
#if !EXACT || TRANSFERS > 1
        float g[MOST], y[MOST * MOST];
        lobe_factors(s, g);
        basis(mirrored, y);
        UNROLL for (int l = 0; l < MOST; l++)
            UNROLL for (int k = l * l; k < (l + 1) * (l + 1); k++) y[k] *= g[l];
#endif
#if !EXACT
        // H_k = sum_i M_ki T_i, the light fixed in M
        float sum[3] = {};
#if RESULT_BANDS * RESULT_BANDS * BANDS * BANDS <= 1024
        UNROLL
#endif
        for (int k = 0; k < RESULT_BANDS * RESULT_BANDS; k++)
            UNROLL for (int c = 0; c < 3; c++) sum[c] += y[k] * product(t, numbers + AT_GLOSSY + (3 * k + c) * PADDED);
        for (int c = 0; c < 3; c++) total[c] += specular[c] * sum[c];
#endif
#if TRANSFERS > 1
        // The lobe sees bounced light come evenly from where direct transfer is not open
        float ahead_of[MOST * MOST], met = 0.0f;
        basis(n, ahead_of);
        UNROLL for (int l = 0; l < BANDS; l++)
            UNROLL for (int i = l * l; i < (l + 1) * (l + 1); i++) met += y[i] * (ahead_of[i] * numbers[AT_COSINE + l] - t[i]);
        const float hidden = 1.0f - t[0] / open(), shut = cut(met, 0.0f, 1.0f) / (hidden < closed() ? closed() : hidden);
        for (int c = 0; c < 3; c++) direct[c] += specular[c] * arriving[c] * shut;
#endif
#endif

#if LOBES & 4
        float seen[3];
        turned(mirrored, numbers + AT_ENVIRONMENT_FRAME, seen);
        look(environment, environment_rows, environment_columns, seen, found);
        for (int c = 0; c < 3; c++) direct[c] += specular[c] * found[c];
#endif

        for (int c = 0; c < 3; c++) {
            out[c] = (total[c] < 0.0f ? 0.0f : total[c]) + direct[c];  // cut-off series dip below zero; NaN stays to be reported
#if SUNLIT && (LOBES & 1)
            out[c] += base[c] * sums[c];
#endif
#if SUNLIT && (LOBES & 2)
            out[c] += specular[c] * sums[3 + c];
#endif
        }
    }
};
