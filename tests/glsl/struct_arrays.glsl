struct Part { vec3 at; float r; int kind; };
struct Row { Part parts[3]; mat2 turn; };
Row made(float x) {
    Row row;
    row.turn = mat2(cos(x), sin(x), -sin(x), cos(x));
    for (int i = 0; i < 3; i++) row.parts[i] = Part(vec3(0.3 * float(i - 1), 0.0, 0.05 * float(i)), 0.1 + 0.04 * float(i), i);
    return row;
}
float part(Part part, vec3 p) {
    vec3 q = p - part.at;
    return part.kind == 1 ? max(abs(q.x), max(abs(q.y), abs(q.z))) - part.r : length(q) - part.r;
}
float map(vec3 p) {
    Row row = made(0.3), other = made(0.3);
    p.xz = row.turn * p.xz;
    other.parts[2].r += p.x > 0.0 ? 0.1 : 0.0;
    bool same = row.parts[2] == other.parts[2] && row.turn == other.turn;
    Part held = row.parts[0];
    row.parts[0] = row.parts[2];
    row.parts[2] = held;
    float d = same ? 0.02 : 0.0;
    for (int i = 2; i >= 0; i--) d = i == 2 ? d + part(row.parts[i], p) : min(d, part(row.parts[i], p));
    return row != other ? d : -d;
}
