// Value types and elementary functions, generic in SDFPRT_LANES: 8 or 16 on the CPU (clang vector types), 1 on CUDA.
// F float, I int, U unsigned, M mask (-1 or 0 a lane). Polynomials are our own minimax fits; errors about 1e-7 relative.
// This text stands inside the body of a Warp native function, so everything is a local struct.
using namespace wp;
#if defined(__CUDA_ARCH__)
#undef SDFPRT_LANES
#define SDFPRT_LANES 1
#endif
#if SDFPRT_LANES == 1
typedef float F;
typedef int I;
typedef unsigned U;
typedef int M;
#else
typedef float F __attribute__((ext_vector_type(SDFPRT_LANES)));
typedef int I __attribute__((ext_vector_type(SDFPRT_LANES)));
typedef unsigned U __attribute__((ext_vector_type(SDFPRT_LANES)));
typedef int M __attribute__((ext_vector_type(SDFPRT_LANES)));
typedef bool B __attribute__((ext_vector_type(SDFPRT_LANES)));
typedef long long Pair __attribute__((ext_vector_type(SDFPRT_LANES)));  // of words
#if SDFPRT_LANES == 8
typedef unsigned char Bits;
#else
typedef unsigned short Bits;
#endif
#endif
#if SDFPRT_LANES == 8
struct Packing {
    unsigned long long row[256];  // a byte a lane
    constexpr Packing() : row() {
        for (int bits = 0; bits < 256; bits++)
            for (int k = 0, n = 0; k < 8; k++)
                if (bits >> k & 1) row[bits] |= (unsigned long long)k << 8 * n++;
    }
};
static constexpr Packing PACKING;
#endif
struct Simd {
#if SDFPRT_LANES == 1
    static inline CUDA_CALLABLE float lane(F v, int) { return v; }
    static inline CUDA_CALLABLE int lane(I v, int) { return v; }
    static inline CUDA_CALLABLE void set(F& v, int, float x) { v = x; }
    static inline CUDA_CALLABLE void set(I& v, int, int x) { v = x; }
    static inline CUDA_CALLABLE void set(U& v, int, unsigned x) { v = x; }
    static inline CUDA_CALLABLE I lanes() { return 0; }
    static inline CUDA_CALLABLE bool any(M m) { return m != 0; }
    static inline CUDA_CALLABLE unsigned bits(M m) { return m & 1; }  // a bit a lane
    static inline CUDA_CALLABLE int lowest(unsigned) { return 0; }    // number of the lowest bit that is set
    static inline CUDA_CALLABLE int ones_of(unsigned b) { return (int)b; }
    static inline CUDA_CALLABLE F sel(M m, F a, F b) { return m ? a : b; }
    static inline CUDA_CALLABLE I sel(M m, I a, I b) { return m ? a : b; }
    static inline CUDA_CALLABLE U sel(M m, U a, U b) { return m ? a : b; }
    static inline CUDA_CALLABLE M lt(F a, F b) { return -(a < b); }
    static inline CUDA_CALLABLE M le(F a, F b) { return -(a <= b); }
    static inline CUDA_CALLABLE M eq(F a, F b) { return -(a == b); }
    static inline CUDA_CALLABLE M ne(F a, F b) { return -(a != b); }
    static inline CUDA_CALLABLE M lt(I a, I b) { return -(a < b); }
    static inline CUDA_CALLABLE M le(I a, I b) { return -(a <= b); }
    static inline CUDA_CALLABLE M eq(I a, I b) { return -(a == b); }
    static inline CUDA_CALLABLE M lt(U a, U b) { return -(a < b); }
    static inline CUDA_CALLABLE M le(U a, U b) { return -(a <= b); }
#if defined(__CUDA_ARCH__)
    static inline CUDA_CALLABLE F as_F(I a) { return __int_as_float(a); }
    static inline CUDA_CALLABLE I as_I(F a) { return __float_as_int(a); }
#else
    static inline F as_F(I a) { return __builtin_bit_cast(F, a); }
    static inline I as_I(F a) { return __builtin_bit_cast(I, a); }
#endif
    static inline CUDA_CALLABLE U as_U(I a) { return (U)a; }
    static inline CUDA_CALLABLE I as_I(U a) { return (I)a; }
    static inline CUDA_CALLABLE F to_F(I a) { return (F)a; }
    static inline CUDA_CALLABLE F to_F(U a) { return (F)a; }
    static inline CUDA_CALLABLE I to_I(F a) { return (I)a; }
    static inline CUDA_CALLABLE F abs(F a) { return fabsf(a); }
    static inline CUDA_CALLABLE F floor(F a) { return floorf(a); }
    static inline CUDA_CALLABLE F ceil(F a) { return ceilf(a); }
    static inline CUDA_CALLABLE F trunc(F a) { return truncf(a); }
    static inline CUDA_CALLABLE F round_even(F a) { return rintf(a); }
    static inline CUDA_CALLABLE F min(F a, F b) { return a < b ? a : b; }
    static inline CUDA_CALLABLE F max(F a, F b) { return a > b ? a : b; }
#else
    static inline float lane(F v, int i) { return v[i]; }
    static inline int lane(I v, int i) { return v[i]; }
    static inline void set(F& v, int i, float x) { v[i] = x; }
    static inline void set(I& v, int i, int x) { v[i] = x; }
    static inline void set(U& v, int i, unsigned x) { v[i] = x; }
    static inline I lanes() {
        I r = splat(0);
        for (int k = 0; k < SDFPRT_LANES; k++) r[k] = k;
        return r;
    }
    static inline bool any(M m) { return bits(m) != 0; }
    static inline unsigned bits(M m) { return __builtin_bit_cast(Bits, __builtin_convertvector(m, B)); }
    static inline int lowest(unsigned bits) { return __builtin_ctz(bits); }
    static inline int ones_of(unsigned bits) { return __builtin_popcount(bits); }
    static inline F sel(M m, F a, F b) { return m ? a : b; }
    static inline I sel(M m, I a, I b) { return m ? a : b; }
    static inline U sel(M m, U a, U b) { return m ? a : b; }
    static inline M lt(F a, F b) { return a < b; }
    static inline M le(F a, F b) { return a <= b; }
    static inline M eq(F a, F b) { return a == b; }
    static inline M ne(F a, F b) { return a != b; }
    static inline M lt(I a, I b) { return a < b; }
    static inline M le(I a, I b) { return a <= b; }
    static inline M eq(I a, I b) { return a == b; }
    static inline M lt(U a, U b) { return a < b; }
    static inline M le(U a, U b) { return a <= b; }
    static inline F as_F(I a) { return __builtin_bit_cast(F, a); }
    static inline I as_I(F a) { return __builtin_bit_cast(I, a); }
    static inline U as_U(I a) { return __builtin_bit_cast(U, a); }
    static inline I as_I(U a) { return __builtin_bit_cast(I, a); }
    static inline F to_F(I a) { return __builtin_convertvector(a, F); }
    static inline F to_F(U a) { return __builtin_convertvector(a, F); }
    static inline I to_I(F a) { return __builtin_convertvector(a, I); }
    static inline F abs(F a) { return __builtin_elementwise_abs(a); }
    static inline F floor(F a) { return __builtin_elementwise_floor(a); }
    static inline F ceil(F a) { return __builtin_elementwise_ceil(a); }
    static inline F trunc(F a) { return __builtin_elementwise_trunc(a); }
    static inline F round_even(F a) { return __builtin_elementwise_roundeven(a); }
    static inline F min(F a, F b) { return a < b ? a : b; }  // one instruction; a NaN in a gives b
    static inline F max(F a, F b) { return a > b ? a : b; }
#endif

    // Products and sums. The compiler never rounds the two together by itself (kernels.py): in a field that would be another field
    // in each kernel. GLSL's fma rounds twice, as OpenGL's CPU driver does, on CUDA too: a field is the same to the bit there.
    static inline CUDA_CALLABLE F fma(F a, F b, F c) { return a * b + c; }
    // Of our own sums: rounded once where the processor can do that
#if defined(__CUDA_ARCH__)
    static inline CUDA_CALLABLE F mad(F a, F b, F c) { return fmaf(a, b, c); }
#else
    static inline F mad(F a, F b, F c) {
#if defined(__FMA__) || defined(__aarch64__)
        return __builtin_elementwise_fma(a, b, c);
#else
        return a * b + c;
#endif
    }
#endif
    // Roots, rounded as IEEE 754 asks for. CUDA's compiler has the same steps from the same seed, but calls a slow function for zero,
    // which the distance to a box is the root of everywhere inside, and the warp waits for it.
#if SDFPRT_LANES == 1
    // The seed is 1 / sqrt of the scaled number to some units in the last place
    static inline CUDA_CALLABLE float scaled(F a) { return a < 7.8886091e-31f ? a * 1.2676506e30f : a; }  // by 2^100 below 2^-100
    static inline CUDA_CALLABLE F root(F a, F seed) {
        const F x = scaled(a), r = x * seed, w = mad(mad(-r, r, x), 0.5f * seed, r);
        return a == 0.0f || a > 3.4028234e38f ? a : a < 7.8886091e-31f ? w * 8.8817842e-16f : w;
    }
#endif
    // Quotients of a field, likewise: a divisor is most often a constant, whose reciprocal the compiler knows then, and needs no check.
    // To the bit where the divisor is within 1e-12 to 1e12 and the quotient within 1e-18 to 1e18, or is 0; beyond, the quotient is
    // right to two units in the last place. A macro, since this compiler puts functions with a division into calls of their own.
#define QUOTIENT_FIRST(a, b) ((a) * (1.0f / (b)))
#define QUOTIENT_SECOND(a, b) mad(mad(-(b), QUOTIENT_FIRST(a, b), a), 1.0f / (b), QUOTIENT_FIRST(a, b))
#define QUOTIENT_THIRD(a, b) mad(mad(-(b), QUOTIENT_SECOND(a, b), a), 1.0f / (b), QUOTIENT_SECOND(a, b))
#define QUOTIENT_OF_ONE(a, b) \
    (!((fabsf(b) >= 1e-12f) & (fabsf(b) <= 1e12f)) \
         ? plain_quotient(a, b) \
         : sel(-((fabsf(QUOTIENT_FIRST(a, b)) >= 1e-18f) & (fabsf(QUOTIENT_FIRST(a, b)) <= 1e18f)), QUOTIENT_THIRD(a, b), \
               QUOTIENT_FIRST(a, b)))
#if SDFPRT_LANES == 1
    static __attribute__((noinline)) CUDA_CALLABLE F plain_quotient(F a, F b) { return a / b; }
#endif
#if defined(__CUDA_ARCH__)
#define QUOTIENT(a, b) QUOTIENT_OF_ONE(a, b)
#else
#define QUOTIENT(a, b) ((a) / (b))
#endif
#if defined(__CUDA_ARCH__)
    static inline CUDA_CALLABLE F sqrt(F a) {
        float seed;
        asm("rsqrt.approx.ftz.f32 %0, %1;" : "=f"(seed) : "f"(scaled(a)));
        return root(a, seed);
    }
#elif SDFPRT_LANES == 1
    static inline F sqrt(F a) { return sqrtf(a); }
#else
    static inline F sqrt(F a) { return __builtin_elementwise_sqrt(a); }
#endif
    static inline CUDA_CALLABLE F splat(float x) { return (F)x; }
    static inline CUDA_CALLABLE I splat(int x) { return (I)x; }
    static inline CUDA_CALLABLE U splat(unsigned x) { return (U)x; }
    static inline CUDA_CALLABLE M mask(bool b) { return (M)(b ? -1 : 0); }
    static inline CUDA_CALLABLE M selm(M m, M a, M b) { return (m & a) | (~m & b); }
    static inline CUDA_CALLABLE M ones() { return (M)(-1); }
    static inline CUDA_CALLABLE M none() { return (M)(0); }

    // Lanes through memory: where single ones are read or written in a loop, much quicker than lane() and set()
#if SDFPRT_LANES == 1
    static inline CUDA_CALLABLE F fill(const float* v) { return *v; }
    static inline CUDA_CALLABLE I fill(const int* v) { return *v; }
    static inline CUDA_CALLABLE void spill(float* v, F x) { *v = x; }
    static inline CUDA_CALLABLE void spill(int* v, I x) { *v = x; }
#else
    static inline F fill(const float* v) {
        F r = splat(0.0f);
        __builtin_memcpy(&r, v, sizeof(F));
        return r;
    }
    static inline I fill(const int* v) {
        I r = splat(0);
        __builtin_memcpy(&r, v, sizeof(I));
        return r;
    }
    static inline void spill(float* v, F x) { __builtin_memcpy(v, &x, sizeof(F)); }
    static inline void spill(int* v, I x) { __builtin_memcpy(v, &x, sizeof(I)); }
#endif

    // Of all lanes
    static inline CUDA_CALLABLE float total(F v) {
        float each[SDFPRT_LANES], r = 0.0f;
        spill(each, v);
        for (int k = 0; k < SDFPRT_LANES; k++) r += each[k];
        return r;
    }
    static inline CUDA_CALLABLE float smallest(F v) {
        float each[SDFPRT_LANES];
        spill(each, v);
        float r = each[0];
        for (int k = 1; k < SDFPRT_LANES; k++) r = each[k] < r ? each[k] : r;
        return r;
    }

    // Arrays indexed by a value that differs between lanes; indices out of range are clamped
    static inline CUDA_CALLABLE I clamp_index(I i, int n) {
        i = sel(lt(i, splat(0)), splat(0), i);
        return sel(lt(splat(n - 1), i), splat(n - 1), i);
    }
#if SDFPRT_LANES > 1  // with one lane, I is int
#if SDFPRT_LANES != 1
    static inline CUDA_CALLABLE int clamp_index(int i, int n) { return i < 0 ? 0 : (i >= n ? n - 1 : i); }
#endif
#endif
    static inline CUDA_CALLABLE F gather(const float* table, I i) {
        int at[SDFPRT_LANES];
        float r[SDFPRT_LANES];
        spill(at, i);
        for (int k = 0; k < SDFPRT_LANES; k++) r[k] = table[at[k]];
        return fill(r);
    }
    static inline CUDA_CALLABLE I gather(const int* table, I i) {
        int at[SDFPRT_LANES], r[SDFPRT_LANES];
        spill(at, i);
        for (int k = 0; k < SDFPRT_LANES; k++) r[k] = table[at[k]];
        return fill(r);
    }
    // The pair of words at each place
#if SDFPRT_LANES == 1
    static inline CUDA_CALLABLE void gather_pairs(const int* table, I i, I& a, I& b) {
        a = table[2 * i];
        b = table[2 * i + 1];
    }
#else
    static inline void gather_pairs(const int* table, I i, I& a, I& b) {
        unsigned at[SDFPRT_LANES];  // no index is negative
        __builtin_memcpy(at, &i, sizeof(I));
        Pair row = (Pair)0;
        for (int k = 0; k < SDFPRT_LANES; k++) __builtin_memcpy((int*)&row + 2 * k, table + 2ull * at[k], 8);
        a = __builtin_convertvector(row, I);
        b = __builtin_convertvector(row >> 32, I);
    }
#endif

    // The order that moves lanes whose bits are set to the front, and lanes in an order
#if SDFPRT_LANES == 1
    static inline CUDA_CALLABLE I packing(unsigned) { return 0; }
    static inline CUDA_CALLABLE F permute(F v, I) { return v; }
    static inline CUDA_CALLABLE I permute(I v, I) { return v; }
#else
    static inline I packing(unsigned bits) {
#if SDFPRT_LANES == 8
        typedef unsigned char Row __attribute__((ext_vector_type(8)));
        return __builtin_convertvector(__builtin_bit_cast(Row, PACKING.row[bits]), I);
#else
        int order[SDFPRT_LANES] = {}, n = 0;
        for (int k = 0; k < SDFPRT_LANES; k++) {
            order[n] = k;
            n += bits >> k & 1;
        }
        return fill(order);
#endif
    }
    static inline F permute(F v, I order) {
#if SDFPRT_LANES == 8 && defined(__AVX2__)
        typedef float Floats __attribute__((vector_size(32)));
        typedef int Wholes __attribute__((vector_size(32)));
        return (F)__builtin_ia32_permvarsf256((Floats)v, (Wholes)order);
#else
        float from[SDFPRT_LANES];
        spill(from, v);
        return gather(from, order);
#endif
    }
    static inline I permute(I v, I order) { return as_I(permute(as_F(v), order)); }
#endif

    // Element i of `count`, `stride` apart: those that some lane asks for
#if SDFPRT_LANES == 1
    static inline CUDA_CALLABLE F pick(const F* v, I i, int, int stride) { return v[i * stride]; }
    static inline CUDA_CALLABLE I pick(const I* v, I i, int, int stride) { return v[i * stride]; }
    static inline CUDA_CALLABLE void put(F* v, I i, int, int stride, F x, M m) { if (m) v[i * stride] = x; }
    static inline CUDA_CALLABLE void put(I* v, I i, int, int stride, I x, M m) { if (m) v[i * stride] = x; }
#else
    static inline F pick(const F* v, I i, int count, int stride) {
        F r = v[0];
        for (int k = 1; k < count; k++) r = sel(eq(i, splat(k)), v[k * stride], r);
        return r;
    }
    static inline I pick(const I* v, I i, int count, int stride) {
        I r = v[0];
        for (int k = 1; k < count; k++) r = sel(eq(i, splat(k)), v[k * stride], r);
        return r;
    }
    static inline void put(F* v, I i, int count, int stride, F x, M m) {
        for (int k = 0; k < count; k++) v[k * stride] = sel(m & eq(i, splat(k)), x, v[k * stride]);
    }
    static inline void put(I* v, I i, int count, int stride, I x, M m) {
        for (int k = 0; k < count; k++) v[k * stride] = sel(m & eq(i, splat(k)), x, v[k * stride]);
    }
#endif

    // Integers: division by zero gives what Mesa gives, shifts use the low five bits, as drivers do
    static inline CUDA_CALLABLE I idiv(I a, I b) {
        I r = splat(0);
        for (int k = 0; k < SDFPRT_LANES; k++) {
            int x = lane(a, k), y = lane(b, k);
            set(r, k, y == 0 ? 0 : (y == -1 ? (int)(0u - (unsigned)x) : x / y));
        }
        return r;
    }
    static inline CUDA_CALLABLE U udiv(U a, U b) {
        U r = splat(0u);
        I x = as_I(a), y = as_I(b);
        for (int k = 0; k < SDFPRT_LANES; k++) {
            unsigned d = (unsigned)lane(y, k);
            set(r, k, d == 0u ? 0xffffffffu : (unsigned)lane(x, k) / d);
        }
        return r;
    }
    static inline CUDA_CALLABLE I irem(I a, I b) { return a - idiv(a, b) * b; }
    static inline CUDA_CALLABLE U urem(U a, U b) {
        return sel(eq(as_I(b), splat(0)), splat(0xffffffffu), a - udiv(a, b) * b);
    }
    static inline CUDA_CALLABLE I imod(I a, I b) { return as_I(urem(as_U(a), as_U(b))); }  // GLSL leaves negatives open; as Mesa
    static inline CUDA_CALLABLE I imin(I a, I b) { return sel(lt(a, b), a, b); }
    static inline CUDA_CALLABLE I imax(I a, I b) { return sel(lt(a, b), b, a); }
    static inline CUDA_CALLABLE U umin(U a, U b) { return sel(lt(a, b), a, b); }
    static inline CUDA_CALLABLE U umax(U a, U b) { return sel(lt(a, b), b, a); }
    static inline CUDA_CALLABLE I bit_count(U a) {
        a = a - ((a >> 1) & 0x55555555u);
        a = (a & 0x33333333u) + ((a >> 2) & 0x33333333u);
        return as_I((((a + (a >> 4)) & 0x0f0f0f0fu) * 0x01010101u) >> 24);
    }
    static inline CUDA_CALLABLE U bit_reverse(U a) {
        a = ((a >> 1) & 0x55555555u) | ((a & 0x55555555u) << 1);
        a = ((a >> 2) & 0x33333333u) | ((a & 0x33333333u) << 2);
        a = ((a >> 4) & 0x0f0f0f0fu) | ((a & 0x0f0f0f0fu) << 4);
        a = ((a >> 8) & 0x00ff00ffu) | ((a & 0x00ff00ffu) << 8);
        return (a >> 16) | (a << 16);
    }
    static inline CUDA_CALLABLE I find_lsb(U a) {
        I low = as_I(a) & -as_I(a);
        return sel(eq(low, splat(0)), splat(-1), bit_count(as_U(low) - 1u));
    }
    static inline CUDA_CALLABLE I find_umsb(U a) {
        a |= a >> 1;
        a |= a >> 2;
        a |= a >> 4;
        a |= a >> 8;
        a |= a >> 16;
        return bit_count(a) - 1;
    }
    static inline CUDA_CALLABLE I find_smsb(I a) { return find_umsb(as_U(a ^ (a >> 31))); }
    static inline CUDA_CALLABLE U low_bits(I n) {
        return sel(lt(n, splat(32)), (splat(1u) << as_U(n & 31)) - 1u, splat(0xffffffffu));
    }
    static inline CUDA_CALLABLE U bit_extract(U a, I at, I n) { return (a >> as_U(at & 31)) & low_bits(n); }
    static inline CUDA_CALLABLE I bit_extract(I a, I at, I n) {
        I up = 32 - at - n;
        I r = (a << (up & 31)) >> ((32 - n) & 31);
        return sel(eq(n, splat(0)), splat(0), r);
    }
    static inline CUDA_CALLABLE U bit_insert(U base, U x, I at, I n) {
        U m = low_bits(n) << as_U(at & 31);
        return (base & ~m) | ((x << as_U(at & 31)) & m);
    }

    // Floats
    static inline CUDA_CALLABLE I to_I_safe(F a) {
        a = sel(eq(a, a), a, splat(0.0f));
        return to_I(min(max(a, splat(-2147483648.0f)), splat(2147483520.0f)));
    }
    static inline CUDA_CALLABLE U to_U_safe(F a) {
        a = sel(eq(a, a), a, splat(0.0f));
        M big = le(splat(2147483648.0f), a);
        F low = sel(big, a - 2147483648.0f, a);
        U r = as_U(to_I(min(max(low, splat(-2147483648.0f)), splat(2147483520.0f))));
        return sel(big, r ^ 0x80000000u, r);
    }
    static inline CUDA_CALLABLE F clamp(F a, F lo, F hi) { return min(max(a, lo), hi); }
    // GLSL's min, max and clamp: of a number and a NaN the number, as GPUs give it (IEEE 754-2019, minimumNumber). `min` and `max`
    // above are quicker, for our own values; they take away a NaN that comes first, and no other.
    static inline CUDA_CALLABLE F min_number(F a, F b) { return sel(is_nan(b), a, min(a, b)); }
    static inline CUDA_CALLABLE F max_number(F a, F b) { return sel(is_nan(b), a, max(a, b)); }
    static inline CUDA_CALLABLE F fract(F a) { return a - floor(a); }
    static inline CUDA_CALLABLE F mod(F a, F b) { return a - b * floor(a / b); }
    static inline CUDA_CALLABLE F rem(F a, F b) { return a - b * trunc(a / b); }
    static inline CUDA_CALLABLE F sign(F a) {
        return sel(lt(splat(0.0f), a), splat(1.0f), sel(lt(a, splat(0.0f)), splat(-1.0f), splat(0.0f)));
    }
    static inline CUDA_CALLABLE F copy_sign(F size, F s) {
        return as_F((as_I(size) & 0x7fffffff) | (as_I(s) & (int)0x80000000));
    }
    static inline CUDA_CALLABLE F round_away(F a) { return copy_sign(floor(abs(a) + 0.5f), a); }
    static inline CUDA_CALLABLE F rsqrt(F a) { return 1.0f / sqrt(a); }
    static inline CUDA_CALLABLE F mix(F a, F b, F t) { return fma(t, b - a, a); }
    static inline CUDA_CALLABLE F step(F edge, F x) { return sel(le(edge, x), splat(1.0f), splat(0.0f)); }  // 0 by a NaN
    static inline CUDA_CALLABLE F smoothstep(F a, F b, F x) {
        F t = clamp((x - a) / (b - a), splat(0.0f), splat(1.0f));
        return t * (t * (3.0f - 2.0f * t));
    }
    static inline CUDA_CALLABLE M is_nan(F a) { return ne(a, a); }
    static inline CUDA_CALLABLE M is_inf(F a) { return eq(abs(a), as_F(splat(0x7f800000))); }

    // 2^a: whole part into the exponent, the rest by a polynomial on [-1/2, 1/2]
    static inline CUDA_CALLABLE F exp2(F a) {
        F x = min(max(a, splat(-126.0f)), splat(127.99f));
        F whole = round_even(x);
        F t = x - whole;
        F r = splat(1.53458075e-4f);
        r = fma(r, t, splat(1.33999312e-3f));
        r = fma(r, t, splat(9.61848897e-3f));
        r = fma(r, t, splat(5.55032878e-2f));
        r = fma(r, t, splat(2.40226469e-1f));
        r = fma(r, t, splat(6.93147206e-1f));
        r = fma(r, t, splat(1.0f));
        F y = as_F(as_I(r) + (to_I(whole) << 23));
        y = sel(lt(a, splat(-126.0f)), splat(0.0f), y);
        y = sel(le(splat(128.0f), a), as_F(splat(0x7f800000)), y);
        return sel(is_nan(a), a, y);
    }
    static inline CUDA_CALLABLE F log2(F a) {
        M tiny = lt(a, splat(1.17549435e-38f));
        F x = sel(tiny, a * 8388608.0f, a);
        I bits = as_I(x);
        // Mantissa into [sqrt(1/2), sqrt(2))
        I exponent = (bits - 0x3f3504f3) >> 23;
        F m = as_F(bits - (exponent << 23));
        F t = m - 1.0f;
        F r = splat(0.12926264f);
        r = fma(r, t, splat(-0.20893306f));
        r = fma(r, t, splat(0.21521252f));
        r = fma(r, t, splat(-0.2386758f));
        r = fma(r, t, splat(0.28793908f));
        r = fma(r, t, splat(-0.36071626f));
        r = fma(r, t, splat(0.48091028f));
        r = fma(r, t, splat(-0.7213472f));
        r = fma(r, t, splat(1.442695f));
        F y = fma(r, t, to_F(exponent) - sel(tiny, splat(23.0f), splat(0.0f)));
        y = sel(eq(a, splat(0.0f)), as_F(splat((int)0xff800000)), y);
        y = sel(lt(a, splat(0.0f)), as_F(splat(0x7fc00000)), y);
        y = sel(eq(a, as_F(splat(0x7f800000))), a, y);
        return sel(is_nan(a), a, y);
    }
    static inline CUDA_CALLABLE F exp(F a) { return exp2(a * 1.44269504f); }
    static inline CUDA_CALLABLE F log(F a) { return log2(a) * 0.693147181f; }
    // Of a negative number: what a product would give where the exponent is whole, else no number. Twin: shaders/glsl/power.glsl
    static inline CUDA_CALLABLE F pow(F a, F b) {
        F y = exp2(b * log2(abs(a)));
        const M negative = lt(a, splat(0.0f)), whole = eq(b, round_even(b)), even = eq(0.5f * b, round_even(0.5f * b));
        y = sel(negative & ~even, -y, y);
        y = sel(negative & ~whole, as_F(splat(0x7fc00000)), y);
        return sel(eq(b, splat(0.0f)), splat(1.0f), y);
    }

    // Sine and cosine: quarter turns off in three parts, then polynomials on [-pi/4, pi/4]
    static inline CUDA_CALLABLE void sincos(F a, F& s, F& c) {
        F q = round_even(a * 0.636619772f);
        F x = fma(q, splat(-1.5703125f), a);
        x = fma(q, splat(-4.83751297e-4f), x);
        x = fma(q, splat(-7.54978995e-8f), x);
        F z = x * x;
        F ps = splat(2.71735323e-6f);
        ps = fma(ps, z, splat(-1.98392031e-4f));
        ps = fma(ps, z, splat(8.33332879e-3f));
        ps = fma(ps, z, splat(-1.66666666e-1f));
        ps = fma(ps * z, x, x);
        F pc = splat(-2.72102371e-7f);
        pc = fma(pc, z, splat(2.479952e-5f));
        pc = fma(pc, z, splat(-1.38888838e-3f));
        pc = fma(pc, z, splat(4.16666666e-2f));
        pc = fma(pc * z, z, fma(z, splat(-0.5f), splat(1.0f)));
        I turn = to_I_safe(q);
        M odd = eq(turn & 1, splat(1));
        F rs = sel(odd, pc, ps), rc = sel(odd, ps, pc);
        s = as_F(as_I(rs) ^ ((turn & 2) << 30));
        c = as_F(as_I(rc) ^ (((turn + 1) & 2) << 30));
    }
    static inline CUDA_CALLABLE F sin(F a) {
        F s, c;
        sincos(a, s, c);
        return s;
    }
    static inline CUDA_CALLABLE F cos(F a) {
        F s, c;
        sincos(a, s, c);
        return c;
    }
    static inline CUDA_CALLABLE F tan(F a) {
        F s, c;
        sincos(a, s, c);
        return s / c;
    }
    // Arc tangent of y / x, both positive: reduced to [0, tan(pi/8)]
    static inline CUDA_CALLABLE F atan_ratio(F y, F x) {
        F low = min(x, y), high = max(x, y);
        M steep = le(high * 0.414213562f, low) & lt(splat(0.0f), high);
        F t = sel(steep, low - high, low) / sel(steep, low + high, high);
        t = sel(is_nan(t), splat(0.0f), t);  // both zero, or both infinite
        F z = t * t;
        F r = splat(-0.06040183f);
        r = fma(r, z, splat(0.10575792f));
        r = fma(r, z, splat(-0.1424043f));
        r = fma(r, z, splat(0.19998238f));
        r = fma(r, z, splat(-0.33333308f));
        r = fma(r * z, t, t) + sel(steep, splat(0.785398163f), splat(0.0f));
        return sel(is_nan(x), splat(0.0f), sel(lt(x, y), 1.57079633f - r, r));  // by a NaN 0, as Mesa
    }
    static inline CUDA_CALLABLE F atan(F a) {
        F r = atan_ratio(min(splat(1e30f), abs(a)), splat(1.0f));
        return copy_sign(r, a);
    }
    static inline CUDA_CALLABLE F atan2(F y, F x) {
        F r = atan_ratio(abs(y), abs(x));
        r = sel(lt(as_I(x), splat(0)), 3.14159265f - r, r);
        return copy_sign(r, y);
    }
    static inline CUDA_CALLABLE F asin(F a) {
        F x = abs(a);
        M large = lt(splat(0.5f), x);
        F z = sel(large, 0.5f * (1.0f - x), x * x);
        F t = sel(large, sqrt(z), x);  // no number beyond 1, as Mesa
        F r = splat(0.03756519f);
        r = fma(r, z, splat(0.01440261f));
        r = fma(r, z, splat(0.03181761f));
        r = fma(r, z, splat(0.04451572f));
        r = fma(r, z, splat(0.07500511f));
        r = fma(r, z, splat(0.1666666f));
        r = fma(r * z, t, t);
        r = sel(large, 1.57079633f - 2.0f * r, r);
        return copy_sign(r, a);
    }
    static inline CUDA_CALLABLE F acos(F a) {
        F x = abs(a);
        // Near 1 through the half angle, so that nothing cancels
        F r = 2.0f * asin(sqrt(0.5f * (1.0f - x)));
        r = sel(lt(splat(0.5f), x), r, 1.57079633f - asin(x));
        return sel(lt(a, splat(0.0f)), 3.14159265f - r, r);
    }
    static inline CUDA_CALLABLE F sinh(F a) {
        F x = abs(a), e = exp(x), z = a * a;
        F small = x * (1.0f + z * (0.166666667f + z * (8.33333333e-3f + z * 1.98412698e-4f)));
        return copy_sign(sel(lt(x, splat(1.0f)), small, 0.5f * (e - 1.0f / e)), a);
    }
    static inline CUDA_CALLABLE F cosh(F a) {
        F e = exp(abs(a));
        return 0.5f * (e + 1.0f / e);
    }
    static inline CUDA_CALLABLE F tanh(F a) {
        F x = min(abs(a), splat(20.0f));
        F small = sinh(x) / cosh(x);
        F e = exp(2.0f * x);
        return copy_sign(sel(lt(x, splat(1.0f)), small, 1.0f - 2.0f / (e + 1.0f)), a);
    }
    static inline CUDA_CALLABLE F asinh(F a) {
        F x = abs(a);
        return copy_sign(log(x + sqrt(x * x + 1.0f)), a);
    }
    static inline CUDA_CALLABLE F acosh(F a) { return log(a + sqrt(a * a - 1.0f)); }
    static inline CUDA_CALLABLE F atanh(F a) { return 0.5f * log((1.0f + a) / (1.0f - a)); }
    static inline CUDA_CALLABLE F ldexp(F a, I e) { return a * exp2(to_F(e)); }
    static inline CUDA_CALLABLE I exponent_of(F a) {
        return sel(eq(a, splat(0.0f)), splat(0), ((as_I(a) >> 23) & 255) - 126);
    }
    static inline CUDA_CALLABLE F mantissa_of(F a) {
        return sel(eq(a, splat(0.0f)), a, as_F((as_I(a) & (int)0x807fffff) | 0x3f000000));
    }
};
