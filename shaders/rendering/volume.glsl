// Transfer from a grid of visibility in SH, looked up trilinearly: T_i = sum_jk tau_ijk V_j C_k(n), C the clamped cosine by three
// bands (Greger et al. 1998). Twin of VolumeTable.predict in sdfprt/tables/volume.py. The non-zero products are data.
uniform sampler3D volumeTexture;  // four coefficients a slab of volumeCounts.z layers, slab after slab
uniform vec3 volumeLow;           // the first grid point
uniform float volumeCell;
uniform vec3 volumeCounts;        // grid points along x, y, z
uniform float volumeLift;         // cells off the surface

// y_k(n) of three bands.
void threeBands(vec3 n, out float y[9]) {
    y = float[9](0.282094792, -0.488602512 * n.y, 0.488602512 * n.z, -0.488602512 * n.x, 1.09254843 * n.x * n.y,
                 -1.09254843 * n.y * n.z, 0.315391565 * (3.0 * n.z * n.z - 1.0), -1.09254843 * n.x * n.z,
                 0.546274215 * (n.x * n.x - n.y * n.y));
}

// T_i at POINTS points p with unit normals n, in fours, point after point; the name is the one that light.glsl calls.
void network(vec3 p[POINTS], vec3 n[POINTS], out vec4 transfer[POINTS * OUTPUTS]) {
    for (int k = 0; k < POINTS; k++) {
        vec3 at = clamp((p[k] - volumeLow) / volumeCell + volumeLift * n[k], vec3(0.0), volumeCounts - 1.0) + 0.5;
        float v[4 * OUTPUTS], t[4 * OUTPUTS], y[9];
        for (int i = 0; i < OUTPUTS; i++) {
            float layer = (at.z + float(i) * volumeCounts.z) / (float(OUTPUTS) * volumeCounts.z);
            vec4 four = textureLod(volumeTexture, vec3(at.xy / volumeCounts.xy, layer), 0.0);
            for (int c = 0; c < 4; c++) v[4 * i + c] = four[c], t[4 * i + c] = 0.0;
        }
        threeBands(n[k], y);
        for (int term = 0; term < COSINE_COUNT; term++) {
            int ijk = cosineIndex[term];
            t[ijk & 255] += cosineValue[term] * v[ijk >> 8 & 255] * y[ijk >> 16];
        }
        for (int i = 0; i < OUTPUTS; i++) transfer[k * OUTPUTS + i] = vec4(t[4 * i], t[4 * i + 1], t[4 * i + 2], t[4 * i + 3]);
    }
}
