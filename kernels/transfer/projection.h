// The directions of a point's rays and their projection onto SH, the same for every kind of scene: cosine-weighted, an R2 sequence
// shifted by a hash of the point's number and the seed. SDFPRT_SHARE are the rays that a fan holds at most.
#ifndef SDFPRT_SHARE
#define SDFPRT_SHARE 1
#endif

// Unit directions in which a point looks, and 1 where the ray is free, 0 where it meets something or is none
struct Fan {
    float *x, *y, *z, *free;
};

struct Directions : Simd {
    float nx, ny, nz, px, py, pz, qx, qy, qz;  // the normal, and the frame about it
    float shift;                               // of u
    const float* order;                        // u, cos(2 pi v), sin(2 pi v), `all` of each
    int all;

    inline CUDA_CALLABLE Directions(const float* normal, int number, int seed, const float* sequence, int rays) {
        nx = normal[0], ny = normal[1], nz = normal[2];
        all = (rays + 7) / 8 * 8;

        // Frame about the normal (Duff et al. 2017)
        const float sign = nz >= 0.0f ? 1.0f : -1.0f;
        const float a = -1.0f / (sign + nz), b = nx * ny * a;
        const float tx = 1.0f + sign * nx * nx * a, ty = sign * b, tz = -sign * nx;
        const float bx = b, by = sign + ny * ny * a, bz = -ny;

        // A shift of the directions that depends on the point's number and the seed alone
        unsigned s = ((unsigned)number * 2654435761u) ^ ((unsigned)seed * 2246822519u);
        s ^= s >> 16; s *= 0x7feb352du; s ^= s >> 15; s *= 0x846ca68bu; s ^= s >> 16;
        shift = (float)(s & 0xffffu) / 65536.0f;

        // The shift of v turns the frame
        const float turn = 6.28318531f * (float)(s >> 16) / 65536.0f, cs = cosf(turn), sn = sinf(turn);
        px = cs * tx + sn * bx, py = cs * ty + sn * by, pz = cs * tz + sn * bz;
        qx = cs * bx - sn * tx, qy = cs * by - sn * ty, qz = cs * bz - sn * tz;
        const int SHIFTS = 16;  // orders of a point's rays, for as many parts of the shift of u
        order = sequence + (int)(shift * (float)SHIFTS) * 3 * all;
    }

    // The packet whose first direction is number `at`; the cosine to the normal, and which lanes hold a direction
    inline CUDA_CALLABLE F packet(int at, F& x, F& y, F& z, M& used) const {
        const F number = fill(order + at), u = fract(number + shift);
        used = le(splat(0.0f), number);
        const F c = sqrt(max(1.0f - u, splat(1e-9f))), r = sqrt(u);
        const F lx = r * fill(order + all + at), ly = r * fill(order + 2 * all + at);
        x = mad(c, splat(nx), mad(ly, splat(qx), lx * px));
        y = mad(c, splat(ny), mad(ly, splat(qy), lx * py));
        z = mad(c, splat(nz), mad(ly, splat(qz), lx * pz));
        return c;
    }
};

struct Projection : Simd {
    float re[SDFPRT_SHARE], im[SDFPRT_SHARE];  // (x + i y)^m of each direction of a point, 0 where a ray is not free

    // Adds the basis at `count` directions of a fan, a multiple of the lanes, to `total`
    inline CUDA_CALLABLE void add(const Fan& fan, int count, int bands, const float* recurrence, F* total) {
        for (int at = 0; at < count; at += SDFPRT_LANES) {
            spill(re + at, fill(fan.free + at));
            spill(im + at, splat(0.0f));
        }
        if (SDFPRT_LANES > 1 && bands == 4) {  // known beforehand: sums stay in registers
            order(fan, count, 0, 4, recurrence, total);
            order(fan, count, 1, 4, recurrence, total);
            order(fan, count, 2, 4, recurrence, total);
            order(fan, count, 3, 4, recurrence, total);
        } else {
            for (int m = 0; m < bands; m++) order(fan, count, m, bands, recurrence, total);
        }
    }

    // The functions of order m and -m, by the recurrence in l whose constants are from sdfprt/transfer/projection.py
    __attribute__((always_inline)) inline CUDA_CALLABLE void order(const Fan& fan, int count, int m, int bands,
                                                                   const float* recurrence, F* total) {
        F even[8], odd[8];
        for (int l = m; l < bands; l++) even[l] = odd[l] = splat(0.0f);
        for (int at = 0; at < count; at += SDFPRT_LANES) {
            const F x = fill(fan.x + at), y = fill(fan.y + at), z = fill(fan.z + at);
            const F a = fill(re + at), b = fill(im + at);
            F before = splat(0.0f), here = splat(recurrence[3 * (m * bands + m)]);
            for (int l = m; l < bands; l++) {
                const float* constants = recurrence + 3 * (m * bands + l);
                even[l] = mad(here, a, even[l]);
                odd[l] = mad(here, b, odd[l]);
                const F next = mad(constants[1] * z, here, -constants[2] * before);
                before = here;
                here = next;
            }
            spill(re + at, mad(a, x, -b * y));
            spill(im + at, mad(a, y, b * x));
        }
        for (int l = m; l < bands; l++) {
            total[l * (l + 1) + m] += even[l];
            if (m > 0) total[l * (l + 1) - m] += odd[l];
        }
    }
};
