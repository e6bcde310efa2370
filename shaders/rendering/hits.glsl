// The list of the samples that hit, for the second pass.
layout(std430, binding = 0) buffer SeenSamples {
    uint seenCount;
    uint seen[];  // y << 16 | x
};
shared uint hitsOfGroup;
shared uint firstOfGroup;

// Appends the sample at `at` if it hit. All invocations of a group call it together: what they append stays together in the list.
void listHit(bool hit, ivec2 at) {
    bool first = gl_LocalInvocationID.x == 0u;
    if (first) hitsOfGroup = 0u;
    barrier();
    uint mine = hit ? atomicAdd(hitsOfGroup, 1u) : 0u;
    barrier();
    if (first) firstOfGroup = atomicAdd(seenCount, hitsOfGroup);
    barrier();
    if (hit) seen[firstOfGroup + mine] = uint(at.y) << 16 | uint(at.x);
}
