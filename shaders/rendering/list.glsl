// Lists the samples that a rasteriser has hit, for the second pass.
ivec2 gridPlace();
void listHit(bool hit, ivec2 at);
uniform sampler2D surfacePoint;

void main() {
    ivec2 at = gridPlace();
    bool inside = all(lessThan(at, textureSize(surfacePoint, 0)));
    listHit(inside && texelFetch(surfacePoint, min(at, textureSize(surfacePoint, 0) - 1), 0).w > 0.5, at);
}
