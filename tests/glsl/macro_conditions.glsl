#define LEVEL 2
#define HALF 0.5
#undef HALF
#ifndef HALF
#define HALF 0.25
#endif
#define JOIN(a, b) a##b
#define BLEND(a, b, k) \
    mix(a, b, \
        clamp(0.5 + 0.5 * ((a) - (b)) / (k), 0.0, 1.0))
#define EACH(i, n) for (int i = 0; i < n; i++)
float JOIN(ba, ll)(vec3 p) { return length(p) - HALF; }
float map(vec3 p) {
    float d = ball(p);
#if LEVEL == 1
    d += 1.0;
#elif LEVEL == 2 && defined(HALF) && !defined(NOTHING)
    EACH(i, LEVEL) d = BLEND(d, ball(p - 0.3 * vec3(float(i), 1.0, -0.5)), 0.1);
#else
    d = unknown;
#endif
    return d + 0.001 * float(__LINE__ % 7);
}
