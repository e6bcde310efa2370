// The coarse pass of the light's discs, an invocation for a tile of samples and four discs: how far from the tile's surface something
// may touch the cones from its points to a disc, or -1 where all of them are dark. Discs 4 to 7 lie right of discs 0 to 3, and so on.
ivec2 gridPlace();
float sdfprt_distance(vec3 p);
vec2 clipToBounds(vec3 o, vec3 d, float grown);
float coneAtBounds(vec3 o, float cone);
uniform vec3 boundsLow;
uniform vec3 boundsHigh;
uniform float stepFactor;
uniform float shadowLift;
uniform int sunCount;
uniform vec4 sunDirection[MOST_SUNS];
uniform sampler2D surfacePoint;
uniform sampler2D surfaceDirection;
uniform int grain;   // samples a tile along a side
uniform int across;  // tiles in a row
uniform int keepLoops; // 1, see network.glsl
layout(rgba32f, binding = 0) writeonly uniform image2D sunReaches;

const int TILE_STEPS = 24;      // at most; what is not free after them counts as touched
const float TILE_TOUCHED = 1.1; // balls less than this many radii of the cone do not carry on

// Of four discs, for the place `at`.
vec4 reaches(ivec2 at) {
    // A ball about the tile's points, and a cone about their normals
    ivec2 first = grain * ivec2(at.x % across, at.y), size = textureSize(surfacePoint, 0);
    vec3 low = vec3(1e30), high = vec3(-1e30), mean = vec3(0.0);
    for (int k = 0; k < grain * grain; k++) {
        ivec2 texel = first + ivec2(k % grain, k / grain);
        if (any(greaterThanEqual(texel, size))) continue;
        vec4 seen = texelFetch(surfacePoint, texel, 0);
        if (seen.w < 0.5) continue;
        low = min(low, seen.xyz);
        high = max(high, seen.xyz);
        mean += texelFetch(surfaceDirection, texel, 0).xyz;
    }
    vec4 reach = vec4(0.0);
    if (low.x > high.x) return reach;
    mean = normalize(mean + vec3(0.0, 1e-20, 0.0));
    float least = 1.0;
    for (int k = 0; k < grain * grain; k++) {
        ivec2 texel = first + ivec2(k % grain, k / grain);
        if (any(greaterThanEqual(texel, size))) continue;
        if (texelFetch(surfacePoint, texel, 0).w > 0.5) least = min(least, dot(texelFetch(surfaceDirection, texel, 0).xyz, mean));
    }
    vec3 middle = 0.5 * (low + high);
    float ball = 0.5 * length(high - low) + shadowLift;

    int begin = 4 * (at.x / across);
    for (int k = begin; k < min(begin + 4 * keepLoops, sunCount); k++) {
        vec3 w = sunDirection[k].xyz;
        float tangent = tan(sunDirection[k].w), c = dot(mean, w);
        // Below the horizon of every normal
        float steepest = c >= least ? 1.0 : c * least + sqrt(max((1.0 - c * c) * (1.0 - least * least), 0.0));
        if (least > 0.0 && steepest <= -sin(sunDirection[k].w)) continue;

        // Backwards from the bounds until something touches the cones; then on, for a section that lies in the solid as a whole
        float most = ball * (1.0 + tangent), t = clipToBounds(middle, w, most + coneAtBounds(middle, tangent)).y, touched = 0.0;
        for (int i = 0; i < TILE_STEPS && t > 0.0; i++) {
            vec3 place = middle + t * w;
            float r = sdfprt_distance(place) * stepFactor, wide = most + tangent * t;
            if (touched <= 0.0 && r <= TILE_TOUCHED * wide) touched = t;
            // What the bounds cut off stops nothing
            bool inside = all(greaterThan(place - boundsLow, vec3(wide))) && all(greaterThan(boundsHigh - place, vec3(wide)));
            if (inside && r < -wide && t > ball) {
                touched = -1.0;
                break;
            }
            t -= touched > 0.0 ? max(abs(r), wide) : sqrt(max(r * r - wide * wide, 0.0));
        }
        reach[k - begin] = touched < 0.0 ? -1.0 : touched <= 0.0 && t > 0.0 ? t + ball : touched > 0.0 ? touched + ball : 0.0;
    }
    return reach;
}

void main() {
    ivec2 at = gridPlace();
    if (all(lessThan(at, imageSize(sunReaches)))) imageStore(sunReaches, at, reaches(at));
}
