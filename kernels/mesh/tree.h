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
#if defined(SDFPRT_WARP_TREE) && defined(SDFPRT_MASKS)
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
#ifdef SDFPRT_WARP_TREE
        const int MOST_HOLES = 1024;     // in a row; more are a fault of numbers
        const float BEHIND = 1.000001f;  // of the distance to a hole, some roundings of it: there the ray begins anew
        float t, first, second, side;
        vec3 normal;
        int face;
        const vec3 along(ray.u, ray.v, ray.w);
        for (int passed = 0; live; passed++) {
            const vec3 from = vec3(ray.x, ray.y, ray.z) + along * ray.near;
            if (!mesh_query_ray(address[0], from, along, ray.far, t, first, second, side, normal, face)) return 0;
#ifdef SDFPRT_MASKS
            if (passed < MOST_HOLES && hole(face, second, 1.0f - first - second)) {
                ray.near = (ray.near + t) * BEHIND;
                continue;
            }
#endif
            ray.far = ray.near + t, ray.second = second, ray.third = 1.0f - first - second, ray.triangle = (unsigned)face, ray.mesh = 0u;
            ray.normal_x = normal[0], ray.normal_y = normal[1], ray.normal_z = normal[2];
            return -1;
        }
        return 0;
#else
        cast(address[2], ray, live);
        return live & ~eq(as_I(ray.mesh), splat(-1));
#endif
    }
#ifdef SDFPRT_MASKS
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
#endif
#ifndef SDFPRT_WARP_TREE
#ifdef SDFPRT_MASKS
    // Laid out as Embree has them: RTCFilterFunctionNArguments, RTCRayQueryContext with room for more, RTCIntersectArguments
    struct Asked {
        int* valid;
        void* geometry;
        const void *context, *ray;
        const float* hit;  // normal, weights, triangle, of `count` rays each
        unsigned count;
    };
    struct Context {
        unsigned instance[16];
        const Tree* tree;
    };
    struct Arguments {
        int flags, features;
        Context* context;
        void (*filter)(const Asked*);
        void* more[4];
    };
    // What Embree asks at each hit: it goes on where the hit is a hole
    static void pass(const Asked* asked) {
        const Tree* tree = ((const Context*)asked->context)->tree;
        const unsigned count = asked->count;
        for (unsigned k = 0; k < count; k++) {
            const float* hit = asked->hit + k;
            if (asked->valid[k] && tree->hole(((const int*)hit)[5 * count], hit[3 * count], hit[4 * count])) asked->valid[k] = 0;
        }
    }
#endif
    inline void cast(unsigned long long function, Ray& ray, M live) const {
        void* scene = (void*)address[0];
#ifdef SDFPRT_MASKS
        Context context;
        for (int k = 0; k < 16; k++) context.instance[k] = 0xffffffffu;
        context.tree = this;
        const int ALL = -1;  // RTC_FEATURE_FLAG_ALL
        Arguments asking = {0, ALL, &context, pass, {nullptr, nullptr, nullptr, nullptr}};
        void* arguments = &asking;
#else
        void* arguments = nullptr;
#endif
#if SDFPRT_LANES == 1
        if (live) ((void (*)(void*, Ray*, void*))function)(scene, &ray, arguments);
#else
        ((void (*)(const M*, void*, Ray*, void*))function)(&live, scene, &ray, arguments);
#endif
    }
#endif
};
