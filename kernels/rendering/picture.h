// Pixel `item` of a picture, pixels in tiles of 8 x 4: the mean over its samples of what the surface sends, or the light behind it.
// Of a sample lie there: `points` (place, and 1 where it hit), `normals` (and 1 inside of a closed mesh), `colours` (albedo,
// exponent), `sun_diffuse` and `sun_glossy`, in fours, and a row of `transfer`. They lie row after row, or with `tiled` as pixels do.
// `camera`: eye, and the axes of the image plane as far as its edges. `picture`: radiance and the share of samples that hit, row
// after row; `bad` becomes 1 where a value is not finite.
{
    const int across = (width + 7) / 8, tile = item / 32;
    const int px = tile % across * 8 + item % 8, py = tile / across * 4 + item % 32 / 8;
    if (px >= width || py >= height) return;
    const int wide = width * samples, tall = height * samples, tiles = (wide + 7) / 8;
    float sum[4] = {};
    for (int k = 0; k < samples * samples; k++) {
        const int x = px * samples + k % samples, y = py * samples + k / samples;
        const size_t at = tiled ? ((size_t)(y / 4) * tiles + x / 8) * 32 + y % 4 * 8 + x % 8 : (size_t)y * wide + x;
        const Four point = ((const Four*)points.data)[at];
        if (point.w > 0.5f) {
            const Four normal = ((const Four*)normals.data)[at];
            const float n[3] = {normal.x, normal.y, normal.z};
            float o[3] = {camera.data[0] - point.x, camera.data[1] - point.y, camera.data[2] - point.z}, sent[3];
            Shade::normalize(o);
            float base[3] = {numbers.data[AT_ALBEDO], numbers.data[AT_ALBEDO + 1], numbers.data[AT_ALBEDO + 2]};
            float s = numbers.data[AT_EXPONENT], sums[6] = {};
#if HAS_ALBEDO || HAS_EXPONENT
            const Four colour = ((const Four*)colours.data)[at];
#if HAS_ALBEDO
            base[0] = colour.x, base[1] = colour.y, base[2] = colour.z;
#endif
#if HAS_EXPONENT
            s = colour.w;
#endif
#endif
#if SUNLIT
            const Four soft = ((const Four*)sun_diffuse.data)[at], sharp = ((const Four*)sun_glossy.data)[at];
            sums[0] = soft.x, sums[1] = soft.y, sums[2] = soft.z, sums[3] = sharp.x, sums[4] = sharp.y, sums[5] = sharp.z;
#endif
            const float* row = transfer.data + at * (Shade::K * TRANSFERS);
            Shade::shade(row, n, o, base, s, sums, numbers.data, gloss.data, gloss_rows, opening.data, open_rows, environment.data,
                         environment_rows, environment_columns, sent);
            for (int c = 0; c < 3; c++) sum[c] += sent[c] * (1.0f - normal.w);
            sum[3] += 1.0f;
        } else {
#if BACKGROUND
            const float u = ((float)x + 0.5f) / (float)wide * 2.0f - 1.0f, v = 1.0f - ((float)y + 0.5f) / (float)tall * 2.0f;
            const float* axes = camera.data + 3;
            float d[3], ahead[3], found[3];
            for (int c = 0; c < 3; c++) d[c] = u * axes[c] + v * axes[3 + c] + axes[6 + c];
            Shade::normalize(d);
            Shade::turned(d, numbers.data + AT_ENVIRONMENT_FRAME, ahead);
            Shade::look(environment.data, environment_rows, environment_columns, ahead, found);
            for (int c = 0; c < 3; c++) sum[c] += found[c];
#endif
        }
    }
    const float share = 1.0f / (float)(samples * samples);
    Four mean = {sum[0] * share, sum[1] * share, sum[2] * share, sum[3] * share};
    ((Four*)picture.data)[(size_t)py * width + px] = mean;
    if (!(mean.x - mean.x == 0.0f && mean.y - mean.y == 0.0f && mean.z - mean.z == 0.0f)) bad.data[0] = 1;
}
