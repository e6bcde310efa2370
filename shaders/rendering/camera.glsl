// The pinhole: rays through sample centres, row 0 on top; the first row of what is drawn to is the picture's first row.
uniform vec3 eye;
uniform mat3 axes;       // columns: right * half width, up * half height, forward
uniform vec4 viewport;   // xy: first sample of this tile, zw: samples of the whole picture; of the coarse pass, in its own

vec3 viewOrigin() {
    return eye;
}

// Unit direction through the place `at` of this tile; centres of samples lie at halves.
vec3 viewRay(vec2 at) {
    vec2 onPlane = (viewport.xy + at) / viewport.zw * 2.0 - 1.0;
    return normalize(axes * vec3(onPlane.x, -onPlane.y, 1.0));
}

// Width of a sample at distance 1.
float footprint() {
    return 2.0 * length(axes[1]) / viewport.w;
}
