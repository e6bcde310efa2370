// Where a point stands along a Z-order curve through a box, 10 bits an axis, and its number: to be sorted, so that the threads of a
// warp read the same memory (`neighbours` of sdfprt/transfer/projection.py for a card).
{
    unsigned place = 0;
    for (int axis = 0; axis < 3; axis++) {
        const float at = (points.data[3 * item + axis] - low.data[axis]) * scale;
        unsigned bits = (unsigned)(at < 0.0f ? 0.0f : (at > 1023.0f ? 1023.0f : at));
        bits = (bits | bits << 16) & 0x030000ffu;
        bits = (bits | bits << 8) & 0x0300f00fu;
        bits = (bits | bits << 4) & 0x030c30c3u;
        bits = (bits | bits << 2) & 0x09249249u;
        place |= bits << axis;
    }
    places.data[item] = (int)place;
    order.data[item] = item;
}
