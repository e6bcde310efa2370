// How far cones about tiles of GRAIN x GRAIN samples are free, -1 where to the end: item k does lanes k*LANES …, tiles row by row.
// `camera`: eye, and the axes of the image plane as far as its edges; `next` becomes 0, for seen.h. Twin: the coarse pass of shaders/rendering/surface.glsl.
{
    const int across = (width + GRAIN - 1) / GRAIN, base = item * SDFPRT_LANES;
    const float* axes = camera.data + 3;
    if (item == 0) next.data[0] = 0;
    F d[3];
    for (int axis = 0; axis < 3; axis++) d[axis] = Simd::splat(1.0f);
    for (int k = 0; k < SDFPRT_LANES; k++) {
        const int x = (base + k) % across, y = (base + k) / across;
        const float u = ((float)x + 0.5f) * (float)(2 * GRAIN) / (float)width - 1.0f;
        const float v = 1.0f - ((float)y + 0.5f) * (float)(2 * GRAIN) / (float)height;
        for (int axis = 0; axis < 3; axis++) Simd::set(d[axis], k, u * axes[axis] + v * axes[3 + axis] + axes[6 + axis]);
    }
    const F size = Simd::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
    for (int axis = 0; axis < 3; axis++) d[axis] = d[axis] / size;

    // Beyond the corners of the tile; the bounds are grown by as much as the cone is wide where it leaves them
    const float sample = 2.0f * sqrtf(axes[3] * axes[3] + axes[4] * axes[4] + axes[5] * axes[5]) / (float)height;
    const float cone = 0.75f * (float)GRAIN * sample;
    float to_middle = 0.0f, diagonal = 0.0f, grown[6];
    for (int axis = 0; axis < 3; axis++) {
        const float away = camera.data[axis] - 0.5f * (box.data[axis] + box.data[3 + axis]), side = box.data[3 + axis] - box.data[axis];
        to_middle += away * away, diagonal += side * side;
    }
    const float wide = cone * (sqrtf(to_middle) + sqrtf(diagonal));
    for (int axis = 0; axis < 3; axis++) grown[axis] = box.data[axis] - wide, grown[3 + axis] = box.data[3 + axis] + wide;
    const F ox = Simd::splat(camera.data[0]), oy = Simd::splat(camera.data[1]), oz = Simd::splat(camera.data[2]);
    F enter, leave;
    Tracer::clip(ox, oy, oz, d[0], d[1], d[2], grown, enter, leave);
    const F free = Tracer::free_cone(ox, oy, oz, d[0], d[1], d[2], Simd::max(enter, Simd::splat(0.0f)), leave, cone, step, steps);
    for (int k = 0; k < SDFPRT_LANES; k++) cones.data[base + k] = Simd::lane(free, k);
}
