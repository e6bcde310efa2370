// Sums over the discs that were taken out of a light, at many surface points: item k does lanes k*LANES …
// Twin of shaders/rendering/suns.glsl, with the same constants and the same steps; what they mean is told there.
// `rows`: point, normal, unit direction to the eye, exponent; `suns`: direction, angular radius, energy. `out`: the sums for a
// white diffuse surface, then for a white lobe.
// SUNS_OF_PLANES: of the planes of a picture, in fours, instead: `points`, and 1 where a ray hit, `normals`, `colours` with the exponent
// where SUNS_EXPONENT says that the scene has its own; the eye comes first in `camera`; `levels` are faint, fine and
// the lobe's exponent.
struct Suns : Simd {
    // Parts of a disc; share below which all is dark; depth of the look behind a hit; radius of the ring, of a part's cone; what is missing
    enum { PARTS = 6, BALLS = 4 };
    static CUDA_CALLABLE float dark() { return 0.08f; }
    static CUDA_CALLABLE float probe() { return 3.0f; }
    static CUDA_CALLABLE float aside() { return 0.667f; }
    static CUDA_CALLABLE float part() { return 0.3f; }
    static CUDA_CALLABLE float bias() { return 0.6f; }

    static CUDA_CALLABLE float narrow() { return 0.06f; }

    // `begin` and `end`: the part of the ray that is marched, and then that outside which nothing touches the cone of `tangent`
    static CUDA_CALLABLE F cone_free(const F* o, const F* d, F& begin, F& end, float tangent, float own, M first, const float* box,
                                     float most_near, float step, int steps, M live) {
        F enter, far;
        Tracer::clip(o[0], o[1], o[2], d[0], d[1], d[2], box, enter, far);
        far = min(far, end);
        const F zero = splat(0.0f), one = splat(1.0f), tiny = splat(1e-20f);
        F t = begin, free = one, near = splat(most_near), ball = zero, taken = zero, last = t;
        M alive = live & lt(t + near, far), met = none(), deep = none(), ended = none(), whole = ones();
        for (int i = 0; i < steps && any(alive); i++) {
            const F r = Scene::distance(o[0] + t * d[0], o[1] + t * d[1], o[2] + t * d[2], alive) * step;
            const M behind = alive & met;
            deep = deep | (behind & lt(r, -tangent * t));
            ended = ended | behind;
            alive = alive & ~behind;
            if (i == 0) near = sel(lt(zero, r), min(near, 0.5f * r), near);
            const F back = min(max((r * r - ball * ball + taken * taken) / (2.0f * max(taken, tiny)), zero), taken);
            const F nearest = sqrt(max(r * r - back * back, zero)), at = max(t - back, tiny), wide = own * at;
            const M apart = lt(ball, taken) & (lt(ball + r, taken) | lt(nearest, wide));
            free = sel(alive & ~apart, min(free, nearest / wide), free);
            const M touches = alive & lt(nearest, tangent * at), begins = touches & whole & ~apart;
            begin = sel(begins, max(t - taken + sqrt(max(ball * ball - tangent * tangent * at * at, zero)), begin), begin);
            whole = whole & ~begins;
            const M enough = begins & first;
            ended = ended | enough;
            alive = alive & ~enough;
            met = selm(alive, ~apart & (lt(r, near) | lt(free, splat(dark()))), met);
            last = sel(alive & (met | touches), t + max(r, zero) + tangent * t, last);
            const F slope = sel(lt(zero, taken), min(max((r - ball) / max(taken, tiny), -one), splat(0.8f)), splat(-0.5f));
            const F ahead = sel(lt(r, 2.0f * wide), r, min(1.9f * r / (1.0f - slope), max(r, far - near - t)));
            t = sel(alive, t + sel(apart, ball - taken, sel(met, probe() * tangent * t, ahead)), t);
            taken = sel(apart, ball, ahead);
            ball = sel(apart, ball, r);
            alive = alive & (met | lt(t, far));
        }
        const M stopped = met | alive | ended;
        end = sel(stopped, end, min(end, last));
        return sel(deep, -one, sel(stopped, zero, free));
    }

    // Mean of the clamped cosine over a disc whose middle is at the cosine c
    static CUDA_CALLABLE F disc_cosine(F c, float sine) {
        const float s = sine > 1e-6f ? sine : 1e-6f;
        const F x = min(max(c / s, splat(-1.0f)), splat(1.0f)), root = sqrt(1.0f - x * x);
        const F part = s * (x * (0.5f + (asin(x) + x * root) * 0.318309886f) + root * root * root * 0.212206591f);
        return sel(le(splat(s), c), c, sel(le(c, splat(-s)), splat(0.0f), part));
    }
};
{
    const int base = item * SDFPRT_LANES;
    F v[10], sum[6];
#if SUNS_OF_PLANES
    const float faint = levels.data[0], fine = levels.data[1];
    F met = Simd::splat(0.0f);
    for (int c = 0; c < 10; c++) v[c] = Simd::splat(c == 3 || c == 6 ? 1.0f : 0.0f);
    v[9] = Simd::splat(levels.data[2]);
    for (int k = 0; k < SDFPRT_LANES; k++) {
        const float *point = points.data + 4 * (base + k), *normal = normals.data + 4 * (base + k);
        if (!(point[3] > 0.5f)) continue;
        Simd::set(met, k, 1.0f);
        float away[3], size = 0.0f;
        for (int c = 0; c < 3; c++) away[c] = camera.data[c] - point[c], size += away[c] * away[c];
        size = sqrtf(size);
        for (int c = 0; c < 3; c++) {
            Simd::set(v[c], k, point[c]);
            Simd::set(v[3 + c], k, normal[c]);
            Simd::set(v[6 + c], k, away[c] / (size > 1e-12f ? size : 1e-12f));
        }
#if SUNS_EXPONENT
        Simd::set(v[9], k, colours.data[4 * (base + k) + 3]);
#endif
    }
    const M seen = Simd::lt(Simd::splat(0.5f), met);
    if (!Simd::any(seen)) return;
#else
    const M seen = Simd::ones();
    for (int c = 0; c < 10; c++) {
        v[c] = Simd::splat(0.0f);
        for (int k = 0; k < SDFPRT_LANES; k++) Simd::set(v[c], k, rows.data[10 * (base + k) + c]);
    }
#endif
    for (int c = 0; c < 6; c++) sum[c] = Simd::splat(0.0f);
    const F zero = Simd::splat(0.0f), one = Simd::splat(1.0f);
    const F *p = v, *n = v + 3, *e = v + 6, s = v[9];
    F o[3], m[3], radius[Suns::BALLS];
    float height[Suns::BALLS];
    const F facing = 2.0f * (n[0] * e[0] + n[1] * e[1] + n[2] * e[2]);
    for (int c = 0; c < 3; c++) o[c] = p[c] + lift * n[c], m[c] = facing * n[c] - e[c];
    bool looked = false;  // whether the balls are known
    for (int number = 0; number < count; number++) {
        const float* sun = suns.data + 7 * number;
        const float angle = sun[3], tangent = tanf(angle);
        const F up = Suns::disc_cosine(n[0] * sun[0] + n[1] * sun[1] + n[2] * sun[2], sinf(angle));
        M live = seen & Simd::lt(zero, up);
        if (!Simd::any(live)) continue;
        if (!looked)
            for (int k = 0; k < Suns::BALLS; k++) {
                height[k] = 2.0f * lift * (float)(1 << (2 * k));
                radius[k] = Scene::distance(o[0] + height[k] * n[0], o[1] + height[k] * n[1], o[2] + height[k] * n[2], Simd::ones()) * step;
            }
        looked = true;

        // A frame about the direction
        const float x = sun[0], y = sun[1], z = sun[2];
        float side[3];
        if (fabsf(x) < 0.7f) side[0] = 0.0f, side[1] = z, side[2] = -y;
        else side[0] = -z, side[1] = 0.0f, side[2] = x;
        const float length = sqrtf(side[0] * side[0] + side[1] * side[1] + side[2] * side[2]);
        for (int c = 0; c < 3; c++) side[c] /= length;
        const float other[3] = {y * side[2] - z * side[1], z * side[0] - x * side[2], x * side[1] - y * side[0]};

        const F wide = 1.0f / (1.0f + 0.25f * s * angle * angle);
        const F near_lobe = Simd::max(m[0] * x + m[1] * y + m[2] * z, Simd::splat(1e-20f));
        const F lobe = 0.5f * (s + 2.0f) * wide * Simd::exp2(s * wide * Simd::log2(near_lobe));
        const F worth = up * Simd::max(one, lobe) * (0.2126f * sun[4] + 0.7152f * sun[5] + 0.0722f * sun[6]);
        const M rough = angle < Suns::narrow() ? Simd::ones() : Simd::lt(worth, Simd::splat(fine)), little = Simd::lt(worth, Simd::splat(faint));

        F lit = zero, all = zero, from = zero, to = Simd::splat(1e30f), edge = zero;
        M single = Simd::none();  // one edge tells the share
        for (int part = -1; part <= Suns::PARTS && Simd::any(live); part++) {
            const float turn = 0.26f + 6.28318531f * (float)part / (float)Suns::PARTS, aside = part > 0 ? Suns::aside() * tangent : 0.0f;
            float w[3], size = 0.0f;
            for (int c = 0; c < 3; c++) w[c] = sun[c] + aside * (cosf(turn) * side[c] + sinf(turn) * other[c]), size += w[c] * w[c];
            F d[3];
            for (int c = 0; c < 3; c++) d[c] = Simd::splat(w[c] / sqrtf(size));
            const F cosine = n[0] * d[0] + n[1] * d[1] + n[2] * d[2];
            // A rough penumbra has no middle of its own
            const M mine = live & (part > 0 ? Simd::lt(zero, cosine) : part ? live : ~rough);
            if (!Simd::any(mine)) continue;
            F start = zero;
            for (int k = 0; k < Suns::BALLS; k++) {
                const F along = height[k] * cosine, inside = along * along - height[k] * height[k] + radius[k] * radius[k];
                const F leaves = along + Simd::sqrt(Simd::max(inside, zero));
                const M empty = Simd::lt(zero, radius[k]) & Simd::le(zero, inside) & Simd::le(2.0f * along - leaves, start);
                start = Simd::sel(empty, Simd::max(start, leaves), start);
            }
            F begin = Simd::max(start, from), end = to;
            const F free = Suns::cone_free(o, d, begin, end, tangent, part < 0 ? tangent : Suns::part() * tangent,
                                           part < 0 ? ~rough : Simd::none(), box, near, step, steps, mine);
            if (part < 1) from = Simd::sel(mine, begin, from), to = Simd::sel(mine, end, to);
            const F weight = Simd::max(cosine, zero);
            const M clear = part < 0 ? mine & Simd::le(one, free) : Simd::none();
            const M told = part < 0 ? mine & rough & Simd::lt(zero, free) & ~clear : Simd::none();
            single = single | told;
            edge = Simd::sel(told, free, edge);
            lit = Simd::sel(clear, one, lit);
            all = Simd::sel(clear, one, all);
            const M off = mine & (clear | told | Simd::lt(free, zero) | little);
            const M adds = mine & ~off & (part < 0 ? rough : Simd::ones());
            all = Simd::sel(adds, all + weight, all);
            lit = Simd::sel(adds, lit + weight * free, lit);
            live = live & ~off;
        }
        const F mean = lit / Simd::max(all, Simd::splat(1e-20f));
        const F share = Simd::sel(single, 0.5f + 0.318309886f * (Simd::asin(edge) + edge * Simd::sqrt(Simd::max(1.0f - edge * edge, zero))),
                                  mean + Suns::bias() * mean * (1.0f - mean));
        const F given = up * share * 0.318309886f;
        for (int c = 0; c < 3; c++) {
            sum[c] += given * sun[4 + c];
            sum[3 + c] += given * lobe * sun[4 + c];
        }
    }
    for (int k = 0; k < SDFPRT_LANES; k++)
        for (int c = 0; c < 6; c++)
#if SUNS_OF_PLANES
            (c < 3 ? sun_diffuse : sun_glossy).data[4 * (base + k) + c % 3] = Simd::lane(sum[c], k);
#else
            out.data[6 * (base + k) + c] = Simd::lane(sum[c], k);
#endif
}
