// Matrix products of tensor cores, m16n8k16 with halves in and float sums, and what a kernel around them asks of its 32 lanes.
// Lane l of a warp holds parts of each matrix, g = l / 4 and t = l % 4 (PTX ISA, "Matrix fragments for mma.m16n8k16"), a pair of
// halves in a word:
//     A, 16 x 16   word i: row g + 8 (i % 2), columns 2t + 8 (i / 2) and the next
//     B, 16 x 8    word i: rows 2t + 8 i and the next, column g
//     D, 16 x 8    float i: row g + 8 (i / 2), column 2t + i % 2
// On CUDA a thread is a lane and has its own parts only. On the CPU one text runs all lanes, and the product is worked out from
// their parts, so that a test there holds every index. This text stands inside the body of a function.
#if defined(__CUDA_ARCH__)
enum { HELD = 1 };  // lanes that one thread holds
#define UNROLL _Pragma("unroll")
#else
enum { HELD = 32 };
#define UNROLL
#endif
struct Halves {  // A
    unsigned at[HELD][4];
};
struct Weights {  // two B, beside each other
    unsigned at[HELD][4];
};
struct Sums {  // D
    float at[HELD][4];
};
struct TensorCore {
#if defined(__CUDA_ARCH__)
    static inline CUDA_CALLABLE int lane(int) { return threadIdx.x & 31; }

    // Whether a bit is set in any lane
    static inline CUDA_CALLABLE bool any(const unsigned (&bits)[HELD]) { return __any_sync(0xffffffffu, bits[0]); }

    // D += A B, of the left (0) or the right (1) B; by all lanes together, hence volatile, lest the compiler moves it into a branch
    static inline CUDA_CALLABLE void multiply(Sums& d, const Halves& a, const Weights& b, int side) {
        const unsigned* x = a.at[0];
        const unsigned* y = b.at[0] + 2 * side;
        float* s = d.at[0];
        float r0, r1, r2, r3;
        asm volatile(
            "mma.sync.aligned.m16n8k16.row.col.f32.f16.f16.f32 {%0, %1, %2, %3}, {%4, %5, %6, %7}, {%8, %9}, {%10, %11, %12, %13};"
            : "=f"(r0), "=f"(r1), "=f"(r2), "=f"(r3)
            : "r"(x[0]), "r"(x[1]), "r"(x[2]), "r"(x[3]), "r"(y[0]), "r"(y[1]), "f"(s[0]), "f"(s[1]), "f"(s[2]), "f"(s[3]));
        s[0] = r0, s[1] = r1, s[2] = r2, s[3] = r3;
    }

    // Two numbers as halves, the first one in the lower bits
    static inline CUDA_CALLABLE unsigned pack(float low, float high) {
        unsigned both;
        asm("cvt.rn.f16x2.f32 %0, %1, %2;" : "=r"(both) : "f"(high), "f"(low));
        return both;
    }

    // Four words, or floats, at a multiple of 16 bytes that nothing writes meanwhile. Volatile, lest the compiler loads all weights
    // once, ahead of the loop over rows, for which there are no registers.
    static inline CUDA_CALLABLE void load(const int* from, unsigned* to) {
        asm volatile("ld.global.nc.v4.u32 {%0, %1, %2, %3}, [%4];"
                     : "=r"(to[0]), "=r"(to[1]), "=r"(to[2]), "=r"(to[3])
                     : "l"(from));
    }
    static inline CUDA_CALLABLE void load(const float* from, float* to) {
        asm volatile("ld.global.nc.v4.f32 {%0, %1, %2, %3}, [%4];"
                     : "=f"(to[0]), "=f"(to[1]), "=f"(to[2]), "=f"(to[3])
                     : "l"(from));
    }
    // What has been loaded before: by another instruction, lest the compiler keeps it from the first time, for which there are no
    // registers either
    static inline CUDA_CALLABLE void load_again(const float* from, float* to) {
        asm volatile("ld.global.v4.f32 {%0, %1, %2, %3}, [%4];"
                     : "=f"(to[0]), "=f"(to[1]), "=f"(to[2]), "=f"(to[3])
                     : "l"(from));
    }

    // The same address, of which the compiler does not know that it was the same a packet ago: it would keep many sums with it
    static inline CUDA_CALLABLE const int* anew(const int* p) {
        asm volatile("mov.u64 %0, %0;" : "+l"(p));
        return p;
    }
    static inline CUDA_CALLABLE const float* anew(const float* p) {
        asm volatile("mov.u64 %0, %0;" : "+l"(p));
        return p;
    }

    // One float, or four at a multiple of 16 bytes, where `so`; without a branch, for which what is stored would have to wait
    static inline CUDA_CALLABLE void store(bool so, float* to, float value) {
        asm volatile("{ .reg .pred p; setp.ne.s32 p, %0, 0; @p st.global.f32 [%1], %2; }"
                     :
                     : "r"((int)so), "l"(to), "f"(value)
                     : "memory");
    }
    static inline CUDA_CALLABLE void store(bool so, float* to, const float* from) {
        asm volatile("{ .reg .pred p; setp.ne.s32 p, %0, 0; @p st.global.v4.f32 [%1], {%2, %3, %4, %5}; }"
                     :
                     : "r"((int)so), "l"(to), "f"(from[0]), "f"(from[1]), "f"(from[2]), "f"(from[3])
                     : "memory");
    }

    // The larger of x and slope x, of two halves
    static inline CUDA_CALLABLE unsigned leaky(unsigned x, unsigned slope) {
        unsigned less, larger;
        asm("mul.rn.f16x2 %0, %1, %2;" : "=r"(less) : "r"(x), "r"(slope));
        asm("max.f16x2 %0, %1, %2;" : "=r"(larger) : "r"(x), "r"(less));
        return larger;
    }

    // One of three by a lane's number, without a branch
    static inline CUDA_CALLABLE float choose(int which, float first, float second, float third) {
        float late, chosen;
        asm("{ .reg .pred p; setp.eq.s32 p, %1, 1; selp.f32 %0, %2, %3, p; }" : "=f"(late) : "r"(which), "f"(second), "f"(third));
        asm("{ .reg .pred p; setp.eq.s32 p, %1, 0; selp.f32 %0, %2, %3, p; }" : "=f"(chosen) : "r"(which), "f"(first), "f"(late));
        return chosen;
    }

    // Of the hardware: sine and cosine of -pi to pi to 2^-21, the others to 2^-22 of their value
    static inline CUDA_CALLABLE float sine(float x) { return __sinf(x); }
    static inline CUDA_CALLABLE float cosine(float x) { return __cosf(x); }
    static inline CUDA_CALLABLE float power_of_two(float x) {
        float y;
        asm("ex2.approx.ftz.f32 %0, %1;" : "=f"(y) : "f"(x));
        return y;
    }
    static inline CUDA_CALLABLE float inverse(float x) {
        float y;
        asm("rcp.approx.ftz.f32 %0, %1;" : "=f"(y) : "f"(x));
        return y;
    }
    static inline CUDA_CALLABLE float nearest(float x) { return rintf(x); }
#else
    static inline int lane(int held) { return held; }

    static inline bool any(const unsigned (&bits)[HELD]) {
        unsigned all = 0;
        for (int l = 0; l < HELD; l++) all |= bits[l];
        return all != 0;
    }

    static inline void multiply(Sums& d, const Halves& a, const Weights& b, int side) {
        float left[16][16], right[16][8];
        for (int l = 0; l < HELD; l++) {
            const int g = l / 4, t = l % 4;
            for (int i = 0; i < 4; i++)
                for (int e = 0; e < 2; e++) left[g + 8 * (i % 2)][2 * t + 8 * (i / 2) + e] = unpack(a.at[l][i] >> 16 * e);
            for (int i = 0; i < 2; i++)
                for (int e = 0; e < 2; e++) right[2 * t + 8 * i + e][g] = unpack(b.at[l][2 * side + i] >> 16 * e);
        }
        for (int l = 0; l < HELD; l++)
            for (int i = 0; i < 4; i++)
                for (int k = 0; k < 16; k++) d.at[l][i] += left[l / 4 + 8 * (i / 2)][k] * right[k][2 * (l % 4) + i % 2];
    }

    static inline unsigned pack(float low, float high) { return half(low) | half(high) << 16; }

    // To the nearest half, of two as near to the even one
    static inline unsigned half(float x) {
        const unsigned bits = __builtin_bit_cast(unsigned, x), sign = bits >> 16 & 0x8000u, size = bits & 0x7fffffffu;
        if (size > 0x7f800000u) return sign | 0x7e00u;   // NaN
        if (size >= 0x477ff000u) return sign | 0x7c00u;  // 65520 and more are infinite
        if (size < 0x38800000u)                          // below 2^-14 steps are 2^-24, as a float's above 0.5
            return sign | (__builtin_bit_cast(unsigned, __builtin_bit_cast(float, size) + 0.5f) - 0x3f000000u);
        return sign | (size - 0x38000000u + 0xfffu + (size >> 13 & 1u)) >> 13;
    }
    static inline float unpack(unsigned word) {
        const unsigned size = word & 0x7fffu;
        const float x = __builtin_bit_cast(float, size << 13) * 0x1p112f;
        const float value = size < 0x7c00u ? x : size == 0x7c00u ? __builtin_inff() : __builtin_nanf("");
        return word & 0x8000u ? -value : value;
    }
    static inline void load(const int* from, unsigned* to) {
        for (int i = 0; i < 4; i++) to[i] = from[i];
    }
    static inline void load(const float* from, float* to) {
        for (int i = 0; i < 4; i++) to[i] = from[i];
    }
    static inline void load_again(const float* from, float* to) { load(from, to); }
    static inline const int* anew(const int* p) { return p; }
    static inline const float* anew(const float* p) { return p; }
    static inline void store(bool so, float* to, float value) {
        if (so) *to = value;
    }
    static inline void store(bool so, float* to, const float* from) {
        for (int i = 0; i < 4; i++) store(so, to + i, from[i]);
    }
    static inline unsigned leaky(unsigned x, unsigned slope) {
        unsigned both = 0;
        for (int e = 0; e < 2; e++) {
            const float value = unpack(x >> 16 * e), less = unpack(half(value * unpack(slope >> 16 * e)));
            both |= half(value > less ? value : less) << 16 * e;
        }
        return both;
    }
    static inline float choose(int which, float first, float second, float third) {
        return which == 0 ? first : which == 1 ? second : third;
    }
    static inline float sine(float x) { return wp::sin(x); }
    static inline float cosine(float x) { return wp::cos(x); }
    static inline float power_of_two(float x) { return wp::pow(2.0f, x); }
    static inline float inverse(float x) { return 1.0f / x; }
    static inline float nearest(float x) { return __builtin_rintf(x); }
#endif
};
