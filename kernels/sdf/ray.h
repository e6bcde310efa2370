// Stands before what has a packet of rays an item: item k has rays k*LANES …, their origins, directions and the part within the bounds.
const int base = item * SDFPRT_LANES;
F o[3], d[3];
for (int axis = 0; axis < 3; axis++) {
    o[axis] = Simd::splat(0.0f);
    d[axis] = Simd::splat(1.0f);
    for (int k = 0; k < SDFPRT_LANES; k++) {
        Simd::set(o[axis], k, origins.data[3 * (base + k) + axis]);
        Simd::set(d[axis], k, directions.data[3 * (base + k) + axis]);
    }
}
F enter, leave;
Tracer::clip(o[0], o[1], o[2], d[0], d[1], d[2], box.data, enter, leave);
