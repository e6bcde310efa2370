// What a ray meets of a mesh. On the CPU Embree's packets (Embree 4, rtcore_ray.h), laid out as it has them, by the addresses of its
// library's functions; on CUDA, with SDFPRT_WARP_TREE, Warp's tree, a ray a thread.
struct Tree : Simd {
    // Embree reads one ray, too, by whole vectors of four
    struct alignas(SDFPRT_LANES == 1 ? 16 : 4 * SDFPRT_LANES) Ray {
        F x, y, z, near, u, v, w, time, far;  // origin, from how far, direction, to how far; far is -infinity where one is blocked
        U mask, id, flags;
        F normal_x, normal_y, normal_z, second, third;  // of the hit: not of unit length; weights of the corners
        U triangle, mesh, instance[8];                  // mesh is -1 where nothing was met
    };
    unsigned long long address[3];  // of the tree; of rtcOccluded and rtcIntersect for so many lanes

    // `handles`: the addresses in halves
    inline CUDA_CALLABLE Tree(const int* handles) {
        for (int k = 0; k < 3; k++) address[k] = (unsigned)handles[2 * k] | (unsigned long long)(unsigned)handles[2 * k + 1] << 32;
    }
    inline CUDA_CALLABLE void start(Ray& ray, F x, F y, F z, F u, F v, F w, float near) const {
        ray.x = x, ray.y = y, ray.z = z, ray.near = splat(near);
        ray.u = u, ray.v = v, ray.w = w, ray.time = splat(0.0f), ray.far = splat(1e30f);
        ray.mask = splat(0xffffffffu), ray.id = ray.flags = splat(0u);
        ray.triangle = ray.mesh = splat(0xffffffffu);
        for (int k = 0; k < 8; k++) ray.instance[k] = splat(0xffffffffu);
    }
    // Which of the live rays meet nothing
    inline CUDA_CALLABLE M free(Ray& ray, M live) const {
#ifdef SDFPRT_WARP_TREE
        return live && !mesh_query_ray_anyhit(address[0], vec3(ray.x, ray.y, ray.z), vec3(ray.u, ray.v, ray.w), ray.far) ? -1 : 0;
#else
        cast(address[1], ray, live);
        return live & le(splat(0.0f), ray.far);
#endif
    }
    // Which of the live rays meet something: triangle, weights, normal and far are what they meet
    inline CUDA_CALLABLE M meet(Ray& ray, M live) const {
#ifdef SDFPRT_WARP_TREE
        float t, first, second, side;
        vec3 normal;
        int face;
        const vec3 from(ray.x, ray.y, ray.z), along(ray.u, ray.v, ray.w);
        if (!live || !mesh_query_ray(address[0], from, along, ray.far, t, first, second, side, normal, face)) return 0;
        ray.far = t, ray.second = second, ray.third = 1.0f - first - second, ray.triangle = (unsigned)face, ray.mesh = 0u;
        ray.normal_x = normal[0], ray.normal_y = normal[1], ray.normal_z = normal[2];
        return -1;
#else
        cast(address[2], ray, live);
        return live & ~eq(as_I(ray.mesh), splat(-1));
#endif
    }
#ifndef SDFPRT_WARP_TREE
    inline void cast(unsigned long long function, Ray& ray, M live) const {
        void* scene = (void*)address[0];
#if SDFPRT_LANES == 1
        if (live) ((void (*)(void*, Ray*, void*))function)(scene, &ray, nullptr);
#else
        ((void (*)(const M*, void*, Ray*, void*))function)(&live, scene, &ray, nullptr);
#endif
    }
#endif
};
