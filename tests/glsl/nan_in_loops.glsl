// A fractal that runs away to infinity, and what is no number then in both places of min
float square(float x) { return x * x; }
float map(vec3 p) {
    vec2 z = 3.0 * p.xy;
    float trap = 10.0, other = 10.0;
    for (int i = 0; i < 12; i++) {
        z = vec2(square(z.x) - square(z.y), 2.0 * z.x * z.y) + p.yz;
        trap = min(trap, length(z - 0.5));
        other = min(0.5 * length(z + 0.5), other);
    }
    return min(trap, other) + 0.1 * max(other, trap);
}
