// Whole exponents of negative numbers are products, however they are written
const float SEVEN = 7.0;
const float EIGHT = pow(2.0, 3.0);
#define CUBE(x) pow(x, 3.0)
#define HALVES(x) pow(x, vec3(0.5, 1.5, 2.5))
float power(float x, float n) { return pow(x, n); }
float table[int(pow(3.0, 2.0))];
float map(vec3 p) {
    float d = pow(p.x, 2.0) + pow(p.y, 3.) + pow(p.z, 1.0) + pow(p.x, 0.0) + pow(p.x - 2.0, -1.0) + pow(p.y - 2.0, -4.0);
    d += pow(p.x, SEVEN) + pow(p.y, EIGHT) + CUBE(p.z) + power(p.x, 5.0) + pow(p.z, float(3 + 2)) + pow(p.y, 4.0 - 1.0);
    d += dot(pow(p, vec3(2.0, 3.0, 5.0)), vec3(1.0, 2.0, 3.0)) + pow(p.xy, vec2(2)).y + dot(HALVES(abs(p)), vec3(1.0));
    d += pow(pow(p.x, 3.0), 3.0) + pow(0.5 * p.x, 21.0) + pow(abs(p.y), 2.2) + float(table.length());
    return d;
}
