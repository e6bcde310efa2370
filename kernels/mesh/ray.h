// Stands before what has a packet of rays an item: their origins and directions, a column each of `total`.
const int at = item * SDFPRT_LANES;
Tree tree(handles.data);
Tree::Ray ray;
F v[6];
for (int k = 0; k < 6; k++) v[k] = Simd::fill(rows.data + k * total + at);
tree.start(ray, v[0], v[1], v[2], v[3], v[4], v[5], 0.0f);
