// Embree's packets of rays (Embree 4, rtcore_ray.h), laid out as it has them, and the functions of its library by their addresses.
struct Embree : Simd {
    struct Ray {
        F x, y, z, near, u, v, w, time, far;  // origin, from how far, direction, to how far; far is -infinity where one is blocked
        U mask, id, flags;
        F normal_x, normal_y, normal_z, second, third;  // of the hit: not of unit length; weights of the corners
        U triangle, mesh, instance[8];                  // mesh is -1 where nothing was met
    };
    typedef void (*Cast)(const M* valid, void* scene, Ray* ray, void* arguments);
    typedef void (*CastOne)(void* scene, Ray* ray, void* arguments);
    void* scene;
    unsigned long long blocks, meets;  // rtcOccluded, rtcIntersect

    // `handles`: the scene, then the two functions for so many lanes
    inline Embree(const int* handles) {
        unsigned long long address[3];
        for (int k = 0; k < 3; k++) address[k] = (unsigned)handles[2 * k] | (unsigned long long)(unsigned)handles[2 * k + 1] << 32;
        scene = (void*)address[0], blocks = address[1], meets = address[2];
    }
    inline void start(Ray& ray, F x, F y, F z, F u, F v, F w, float near) const {
        ray.x = x, ray.y = y, ray.z = z, ray.near = splat(near);
        ray.u = u, ray.v = v, ray.w = w, ray.time = splat(0.0f), ray.far = splat(1e30f);
        ray.mask = splat(0xffffffffu), ray.id = ray.flags = splat(0u);
        ray.triangle = ray.mesh = splat(0xffffffffu);
        for (int k = 0; k < 8; k++) ray.instance[k] = splat(0xffffffffu);
    }
    inline void cast(unsigned long long function, Ray& ray, M live) const {
#if SDFPRT_LANES == 1
        if (live) ((CastOne)function)(scene, &ray, nullptr);
#else
        ((Cast)function)(&live, scene, &ray, nullptr);
#endif
    }
    // Which of the live rays meet nothing
    inline M free(Ray& ray, M live) const {
        cast(blocks, ray, live);
        return live & le(splat(0.0f), ray.far);
    }
    // Which of the live rays meet something: triangle, weights, normal and far are what they meet
    inline M meet(Ray& ray, M live) const {
        cast(meets, ray, live);
        return live & ~eq(as_I(ray.mesh), splat(-1));
    }
};
