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
    unsigned long long address[7];  // of the tree; of rtcOccluded and rtcIntersect for so many lanes; of mesh/masks.py's four arrays

    // `handles`: the addresses in halves
    inline CUDA_CALLABLE Tree(const int* handles) {
        for (int k = 0; k < 7; k++) address[k] = (unsigned)handles[2 * k] | (unsigned long long)(unsigned)handles[2 * k + 1] << 32;
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
#ifdef SDFPRT_MASKS
        return live & ~meet(ray, live);
#elif defined(SDFPRT_WARP_TREE)
        return live && !mesh_query_ray_anyhit(address[0], vec3(ray.x, ray.y, ray.z), vec3(ray.u, ray.v, ray.w), ray.far) ? -1 : 0;
#else
        cast(address[1], ray, live);
        return live & le(splat(0.0f), ray.far);
#endif
    }
    // Which of the live rays meet something: triangle, weights, normal and far are what they meet
    inline CUDA_CALLABLE M meet(Ray& ray, M live) const {
#ifdef SDFPRT_MASKS
        const int MOST_HOLES = 1024;     // in a row; more are a fault of numbers
        const float BEHIND = 1.000001f;  // of the distance to a hole: some roundings of it
        M met = nearest(ray, live), within = holes(ray, met);
        // Behind a hole a ray begins anew
        for (int passed = 0; passed < MOST_HOLES && any(within); passed++) {
            ray.near = sel(within, ray.far * BEHIND, ray.near);
            ray.far = sel(within, splat(1e30f), ray.far);
            ray.mesh = sel(within, splat(0xffffffffu), ray.mesh);
            const M again = nearest(ray, within);
            met = met & (~within | again);
            within = holes(ray, again);
        }
        return met;
    }
    // Which of the rays that have met something have met a hole
    inline CUDA_CALLABLE M holes(const Ray& ray, M met) const {
        I found = splat(0);
        for (unsigned left = bits(met); left; left &= left - 1) {
            const int k = lowest(left);
            if (hole(lane(as_I(ray.triangle), k), lane(ray.second, k), lane(ray.third, k))) set(found, k, -1);
        }
        return lt(found, splat(0));
    }
    // Whether a place on a triangle is in a hole: bilinear, as parts.bilinear has it
    inline CUDA_CALLABLE bool hole(int face, float second, float third) const {
        const int mask = ((const int*)address[3])[face];
        if (mask < 0) return false;
        const float *corner = (const float*)address[4] + 6 * face, first = 1.0f - second - third;
        const int *size = (const int*)address[5] + 3 * mask, height = size[0], width = size[1];
        const float* texels = (const float*)address[6] + size[2];
        const float x = (first * corner[0] + second * corner[2] + third * corner[4]) * (float)width - 0.5f;
        const float y = (1.0f - (first * corner[1] + second * corner[3] + third * corner[5])) * (float)height - 0.5f;
        const float left = floorf(x), top = floorf(y), across = x - left, down = y - top;
        const int column = wrapped((int)left, width), row = wrapped((int)top, height);
        const int next = column + 1 < width ? column + 1 : 0, below = row + 1 < height ? row + 1 : 0;
        const float* upper = texels + (long long)row * width;
        const float* lower = texels + (long long)below * width;
        const float high = upper[column] * (1.0f - across) + upper[next] * across;
        return high * (1.0f - down) + (lower[column] * (1.0f - across) + lower[next] * across) * down < 0.0f;
    }
    static inline CUDA_CALLABLE int wrapped(int at, int count) { return at % count < 0 ? at % count + count : at % count; }
    // `meet` without holes, from `near` on
    inline CUDA_CALLABLE M nearest(Ray& ray, M live) const {
#endif
#ifdef SDFPRT_WARP_TREE
        float t, one, second, side;
        vec3 normal;
        int face;
        const vec3 along(ray.u, ray.v, ray.w), from = vec3(ray.x, ray.y, ray.z) + along * ray.near;
        if (!live || !mesh_query_ray(address[0], from, along, ray.far, t, one, second, side, normal, face)) return 0;
        ray.far = ray.near + t, ray.second = second, ray.third = 1.0f - one - second, ray.triangle = (unsigned)face, ray.mesh = 0u;
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
