struct Ball { vec3 c; float r; };
struct Pair { Ball a; Ball b; int which; };
float ball(Ball b, vec3 p) { return length(p - b.c) - b.r; }
float map(vec3 p) { Pair q = Pair(Ball(vec3(0.1), 0.3), Ball(vec3(-0.2, 0.1, 0.0), 0.2), 1); q.a.c.y += p.x * 0.1; return min(ball(q.a, p), ball(q.b, p)) + float(q.which) * 0.01; }
