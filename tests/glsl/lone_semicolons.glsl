;;
const float R = .5;;
struct S { float a; };;
float f(float x) { return x;; };
float map(vec3 p) { ;;{;} if (p.x > 9.) ; else ; for (;;) { break; } while (false) ; return f(length(p)) - R; };
