// What each ray meets first, a packet an item: triangle (bits of a whole number, -1 for none), weights of its second and third
// corner, distance, and 1 where the ray meets the front, a column each of `total`.
{
    const M met = tree.meet(ray, Simd::ones());
    const F along = ray.normal_x * v[3] + ray.normal_y * v[4] + ray.normal_z * v[5];
    Simd::spill(out.data + at, Simd::sel(met, Simd::as_F(Simd::as_I(ray.triangle)), Simd::as_F(Simd::splat(-1))));
    Simd::spill(out.data + total + at, ray.second);
    Simd::spill(out.data + 2 * total + at, ray.third);
    Simd::spill(out.data + 3 * total + at, Simd::sel(met, ray.far, Simd::splat(-1.0f)));
    Simd::spill(out.data + 4 * total + at, Simd::sel(Simd::lt(along, Simd::splat(0.0f)), Simd::splat(1.0f), Simd::splat(0.0f)));
}
