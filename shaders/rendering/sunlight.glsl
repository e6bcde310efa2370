// The pass between surface and network where discs were taken out of the light: their sums at each sample that hit. Before it, with
// `coarse`, the shares of discs that are seen at every grain-th sample.
void sunsBetween(int first, int last, bool corner, vec3 p, vec3 n, vec3 o, float s, out vec3 diffuse, out vec3 glossy, out vec4 shares);
layout(local_size_x = GROUP) in;
layout(std430, binding = 0) readonly buffer SeenSamples {
    uint seenCount;
    uint seen[];  // y << 16 | x
};
layout(rgba32f, binding = 0) writeonly uniform image2D sunDiffuse;  // of the coarse pass: the shares
layout(rgba32f, binding = 1) writeonly uniform image2D sunGlossy;
uniform sampler2D surfacePoint;
uniform sampler2D surfaceDirection;
uniform sampler2D surfaceColour;
uniform vec3 eye;
uniform float lobeExponent;    // of the material, where the scene's file gives none
uniform bool hasExponent;
uniform int sunCount;
uniform vec2 sunRough;
uniform int grain;             // samples a tile along a side
uniform int across;            // tiles in a row
uniform bool coarse;
uniform sampler2D sunTiles;    // how far something may touch the cones of a tile
uniform sampler2D sunCorners;  // what the coarse pass found

const float SPREAD = 0.15;     // of shares at a tile's corners that tell of what is between, for a disc that is worth sunRough.x
const float SAME = 0.9;        // cosine of normals on the same surface
const float LEVEL = 0.15;      // sine of the way to a point on the same surface
ivec2 sunTile;
vec4 cornerWeight;             // of the tile's corners, 0 where one lies on another surface

float sunReach(int k) {
    return texelFetch(sunTiles, sunTile + ivec2(across * (k / 4), 0), 0)[k % 4];
}

float sunNearby(int k, float worth) {
    if (coarse || worth > sunRough.y) return -1.0;
    float low = 1.0, high = 0.0, sum = 0.0, all = 0.0;
    ivec2 first = sunTile + ivec2((across + 1) * (k / 4), 0);
    for (int corner = 0; corner < 4; corner++) {
        float share = texelFetch(sunCorners, first + ivec2(corner & 1, corner >> 1), 0)[k % 4];
        if (cornerWeight[corner] <= 0.0 || share < 0.0) continue;
        low = min(low, share);
        high = max(high, share);
        sum += cornerWeight[corner] * share;
        all += cornerWeight[corner];
    }
    bool tell = all > (worth < sunRough.x ? 0.0 : 0.999) && (high - low) * worth <= SPREAD * sunRough.x;
    return tell ? sum / all : -1.0;
}

void main() {
    // This sample; of the coarse pass four discs of it, side by side
    uint number = (gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x) * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    ivec2 size = textureSize(surfacePoint, 0), tiles = (size + grain - 1) / grain, at, place;
    int first = 0;
    if (coarse) {
        int row = (tiles.x + 1) * ((sunCount + 3) / 4);
        place = ivec2(int(number) % row, int(number) / row);
        if (place.y > tiles.y) return;
        first = 4 * (place.x / (tiles.x + 1));
        at = min(grain * ivec2(place.x % (tiles.x + 1), place.y), size - 1);
    } else {
        if (number >= seenCount) return;
        at = place = ivec2(seen[number] & 0xffffu, seen[number] >> 16);
    }
    vec4 point = texelFetch(surfacePoint, at, 0);
    vec3 n = texelFetch(surfaceDirection, at, 0).xyz;
    sunTile = at / grain;

    // Which corners lie on the same surface
    vec2 part = vec2(at - grain * sunTile) / float(grain);
    cornerWeight = vec4((1.0 - part.x) * (1.0 - part.y), part.x * (1.0 - part.y), (1.0 - part.x) * part.y, part.x * part.y) + 1e-3;
    for (int corner = 0; corner < 4; corner++) {
        ivec2 texel = min(grain * (sunTile + ivec2(corner & 1, corner >> 1)), size - 1);
        vec4 other = texelFetch(surfacePoint, texel, 0);
        vec3 apart = other.xyz - point.xyz;
        bool same = other.w > 0.5 && dot(n, texelFetch(surfaceDirection, texel, 0).xyz) > SAME && abs(dot(n, apart)) <= LEVEL * length(apart);
        if (!same) cornerWeight[corner] = 0.0;
    }
    float s = coarse ? 1.0 : hasExponent ? texelFetch(surfaceColour, at, 0).a : lobeExponent;
    vec3 diffuse, glossy;
    vec4 shares;
    int last = point.w < 0.5 ? first - 1 : coarse ? min(first + 4, sunCount) : sunCount;
    sunsBetween(first, last, coarse, point.xyz, n, normalize(eye - point.xyz), s, diffuse, glossy, shares);
    imageStore(sunDiffuse, place, coarse ? shares : vec4(diffuse, 1.0));
    if (!coarse) imageStore(sunGlossy, place, vec4(glossy, 1.0));
}
