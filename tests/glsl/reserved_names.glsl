// valid in WebGL2, reserved or built in at desktop 4.30
float sample(vec3 p) { return length(p); }
float buffer(float x) { return x; }
float shared(float x) { return x; }
float map(vec3 p) { float patch = .5; float subroutine = 0.; float precise = 0.; float coherent = 0.; float fma = .0; vec3 resource = p; return sample(resource) - patch + subroutine + precise + coherent + buffer(fma) + shared(0.); }
