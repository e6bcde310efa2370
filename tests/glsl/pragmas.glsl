#pragma STDGL invariant(all)
#pragma optimize(on)
#pragma debug(off)
float map(vec3 p) { return length(p) - .5; }
