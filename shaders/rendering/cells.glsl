// Transfer of a scene in cells: each point by its cell's network, and by a blend of its neighbours' about a cut (learnt transfer,
// Sec. 4.4). Twin of `Cells.shares` in sdfprt/network/cells.py. CELLS networks lie in the texture of weights, STRIDE texels each;
// after them stands, a texel a cell and x fastest, which network knows it.
vec4 weightTexel(int at);
void cellNetwork(vec3 p[POINTS], vec3 n[POINTS], out vec4 transfer[POINTS * NETWORK_OUTPUTS]);
int networkStart;
uniform vec3 cellsLow;
uniform vec3 cellsSide;
uniform ivec3 cellsCount;
uniform float cellsBand;

// Networks of the eight cells about the nearest cut along each axis, and how much each has to say: they add up to 1.
void cellsAbout(vec3 p, out int number[8], out float share[8]) {
    vec3 u = (p - cellsLow) / cellsSide;
    ivec3 last = cellsCount - 1;
    vec3 cut = min(max(floor(u + 0.5), 1.0), vec3(max(last, 1)));
    vec3 t = clamp((u - cut) / (2.0 * cellsBand) + 0.5, 0.0, 1.0);
    vec3 above = t * t * (3.0 - 2.0 * t);
    for (int corner = 0; corner < 8; corner++) {
        ivec3 bits = ivec3(corner & 1, (corner >> 1) & 1, corner >> 2);
        ivec3 cell = min(ivec3(cut) - 1 + bits, last);
        vec3 part = mix(1.0 - above, above, vec3(bits));
        number[corner] = int(weightTexel(CELLS * STRIDE + (cell.z * cellsCount.y + cell.y) * cellsCount.x + cell.x).x);
        share[corner] = part.x * part.y * part.z;
    }
}

// T_i at POINTS points, as `network` of network.glsl: all of them go through each network that one of them asks for, the lower
// number first, which is one network but for a few near the cuts.
void network(vec3 p[POINTS], vec3 n[POINTS], out vec4 transfer[POINTS * NETWORK_OUTPUTS]) {
    int number[8 * POINTS];
    float share[8 * POINTS];
    networkStart = 0;
    for (int k = 0; k < POINTS; k++) {
        int own[8];
        float part[8];
        cellsAbout(p[k], own, part);
        for (int i = 0; i < 8; i++) {
            number[8 * k + i] = part[i] > 0.0 ? own[i] : CELLS;
            share[8 * k + i] = part[i];
        }
    }
    for (int i = 0; i < POINTS * NETWORK_OUTPUTS; i++) transfer[i] = vec4(0.0);
    for (int at = -1; at < CELLS;) {
        int next = CELLS;
        for (int i = 0; i < 8 * POINTS; i++) if (number[i] > at) next = min(next, number[i]);
        at = next;
        if (at == CELLS) break;
        networkStart = at * STRIDE;
        vec4 found[POINTS * NETWORK_OUTPUTS];
        cellNetwork(p, n, found);
        for (int k = 0; k < POINTS; k++) {
            float whole = 0.0;
            for (int i = 8 * k; i < 8 * k + 8; i++) if (number[i] == at) whole += share[i];
            for (int row = 0; row < NETWORK_OUTPUTS; row++) transfer[k * NETWORK_OUTPUTS + row] += whole * found[k * NETWORK_OUTPUTS + row];
        }
    }
}
