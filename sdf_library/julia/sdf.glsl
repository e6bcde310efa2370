// A Julia set of quaternions, z -> z z + c; coloured by how near the orbit came to three planes.
const vec4 C = vec4(-0.291, -0.399, 0.339, 0.437);
const float SCALE = 0.78;

vec4 squared(vec4 z) { return vec4(z.x * z.x - dot(z.yzw, z.yzw), 2.0 * z.x * z.yzw); }

// Half of |z| log |z| / |dz|, a lower bound (Hart, Sandin, Kauffman 1989); trap is the nearest that the orbit came to planes.
float julia(vec3 p, out vec3 trap) {
    vec4 z = vec4(p, 0.0);
    float slope = 1.0, size = dot(z, z);
    trap = vec3(1e3);
    for (int i = 0; i < 9; i++) {
        slope *= 4.0 * size;
        z = squared(z) + C;
        size = dot(z, z);
        if (i < 4) trap = min(trap, abs(z.xyw));  // later turns would speckle
        if (size > 64.0) break;
    }
    return 0.25 * log(size) * sqrt(size / slope);
}

float sdf(vec3 p) {
    vec3 trap;
    return SCALE * julia(p / SCALE, trap);
}

vec3 albedo(vec3 p, vec3 n) {
    vec3 trap;
    julia(p / SCALE, trap);
    vec3 colour = mix(vec3(0.1, 0.25, 0.4), vec3(0.82, 0.72, 0.52), smoothstep(0.02, 0.3, trap.x));
    colour = mix(colour, vec3(0.55, 0.16, 0.07), smoothstep(0.16, 0.04, trap.z));
    return mix(colour, vec3(0.05, 0.09, 0.16), smoothstep(0.05, 0.005, trap.y));
}
