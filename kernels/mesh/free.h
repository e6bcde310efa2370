// Whether each ray meets nothing, a packet an item: 1 or 0.
{
    const M open = tree.free(ray, Simd::ones());
    Simd::spill(out.data + at, Simd::sel(open, Simd::splat(1.0f), Simd::splat(0.0f)));
}
