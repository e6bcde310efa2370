// Stands before what has a mesh's point an item: the tree that its rays meet, where they begin, lifted off the surface along its normal,
// and their directions.
Tree tree(handles.data);
const float* n = normals.data + 3 * item;
const F ox = Simd::splat(points.data[3 * item] + n[0] * lift), oy = Simd::splat(points.data[3 * item + 1] + n[1] * lift);
const F oz = Simd::splat(points.data[3 * item + 2] + n[2] * lift);
const Directions directions(n, numbers.data[item], seed, sequence.data, rays);
