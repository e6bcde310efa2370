// A Julia set of quaternions, z -> z z + c, as far as its orbits have gone after a few turns; coloured by how near they came to
// three planes.
const vec4 C = vec4(-0.291, -0.399, 0.339, 0.437);
const float SCALE = 0.78;
const int TURNS = 5;  // more turns, finer ridges, until they are finer than a pixel

vec4 squared(vec4 z) { return vec4(z.x * z.x - dot(z.yzw, z.yzw), 2.0 * z.x * z.yzw); }

// Half of how z z changes along a
vec4 turned(vec4 z, vec4 a) { return vec4(z.x * a.x - dot(z.yzw, a.yzw), z.x * a.yzw + a.x * z.yzw); }

// By the potential g = log |z| / 2^n and how fast it grows: (1 - exp(-g)) / |grad g| is the distance of a ball, 0.7 of it a lower
// bound here. |dz|, as usual (Hart, Sandin, Kauffman 1989), grows too fast, since quaternions do not commute, and the gradient
// vanishes where arms meet; the larger of the one and a part of the other is close to a distance in both places.
float sdf(vec3 p) {
    vec4 z = vec4(p / SCALE, 0.0), a = vec4(1.0, 0.0, 0.0, 0.0), b = a.yxzw, c = a.yzxw;
    float size = dot(z, z), part = 1.0, most = 1.0;
    for (int i = 0; i < TURNS; i++) {
        a = turned(z, a);
        b = turned(z, b);
        c = turned(z, c);
        most *= sqrt(size);
        z = squared(z) + C;
        size = dot(z, z);
        part *= 0.5;
        if (size > 1000.0) break;
    }
    float gradient = length(vec3(dot(z, a), dot(z, b), dot(z, c))) / size;
    return 0.7 * SCALE * (1.0 - exp(-0.5 * part * log(size))) / max(gradient, 0.15 * most / sqrt(size));
}

vec3 albedo(vec3 p, vec3 n) {
    vec4 z = vec4(p / SCALE, 0.0);
    vec3 trap = vec3(1e3);
    for (int i = 0; i < 4; i++) {  // later turns would speckle
        z = squared(z) + C;
        trap = min(trap, abs(z.xyw));
    }
    vec3 colour = mix(vec3(0.1, 0.25, 0.4), vec3(0.82, 0.72, 0.52), smoothstep(0.02, 0.3, trap.x));
    colour = mix(colour, vec3(0.55, 0.16, 0.07), smoothstep(0.16, 0.04, trap.z));
    return mix(colour, vec3(0.05, 0.09, 0.16), smoothstep(0.05, 0.005, trap.y));
}
