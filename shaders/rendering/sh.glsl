// Real spherical harmonics: orthonormal, Condon-Shortley, polar axis z, index l(l+1)+m (Sloan 2008, App. A2).

// All basis functions at the unit direction d, times weights[l]: the recurrence in l of each order m.
void weightedBasis(vec3 d, float weights[RESULT_BANDS], out float y[4 * RESULTS]) {
    for (int i = RESULT_BANDS * RESULT_BANDS; i < 4 * RESULTS; i++) y[i] = 0.0;
    float re = 1.0, im = 0.0, diagonal = 1.0, first = 1.0;
    for (int m = 0; m < RESULT_BANDS; m++) {
        // P_l^m without its sin^m; ratio: (l-m)! / (l+m)!
        float before = 0.0, here = diagonal, ratio = first;
        for (int l = m; l < RESULT_BANDS; l++) {
            float value = weights[l] * sqrt(float(2 * l + 1) * 0.0795774715459477 * ratio) * here;
            int at = l * (l + 1);
            if (m == 0) {
                y[at] = value;
            } else {
                y[at + m] = 1.4142135623731 * value * re;
                y[at - m] = 1.4142135623731 * value * im;
            }
            float next = (float(2 * l + 1) * d.z * here - float(l + m) * before) / float(l - m + 1);
            before = here;
            here = next;
            ratio *= float(l - m + 1) / float(l + m + 1);
        }
        float turned = re * d.x - im * d.y;
        im = re * d.y + im * d.x;
        re = turned;
        diagonal *= -float(2 * m + 1);
        first /= float((2 * m + 1) * (2 * m + 2));
    }
}
