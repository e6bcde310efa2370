// Invocations over a plane: groups of GROUP hold GROUP_WIDTH side by side, so that those that run together see a small rectangle.
layout(local_size_x = GROUP) in;

// Where this invocation stands; beyond the plane's edges at the last groups.
ivec2 gridPlace() {
    int mine = int(gl_LocalInvocationID.x);
    return ivec2(gl_WorkGroupID.xy) * ivec2(GROUP_WIDTH, GROUP / GROUP_WIDTH) + ivec2(mine % GROUP_WIDTH, mine / GROUP_WIDTH);
}
