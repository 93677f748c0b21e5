// host [OTHER...] LIBRARY: a program that links nothing of ours. It opens other libraries first, such as another TBB and
// another Embree, so that their names are found before all others, and then the library: rays hit and imprints are made.
#include <relievo/relievo.h>

#include <dlfcn.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

namespace {

void *library = nullptr;

void fail(const char *what, const char *why) {
    std::fprintf(stderr, "%s: %s\n", what, why);
    std::exit(1);
}

template <class Function> Function find(const char *name) {
    void *const found = dlsym(library, name);
    if (!found) {
        fail(name, "the library does not have it");
    }
    return reinterpret_cast<Function>(found);
}

void check(const char *name, RlvResult result) {
    if (result != RLV_OK) {
        fail(name, find<decltype(&rlv_error_last)>("rlv_error_last")());
    }
}

/// Calls a function of the library, which must succeed.
#define CALL(function, ...) check(#function, find<decltype(&function)>(#function)(__VA_ARGS__))

RlvMesh mesh_of(RlvContext context, const std::vector<float> &points, const std::vector<uint32_t> &corners) {
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    RlvMesh mesh = RLV_NULL;
    arrays.points = points.data();
    arrays.point_count = points.size() / 3;
    arrays.face_size = 4;
    arrays.face_count = corners.size() / 4;
    arrays.corners = corners.data();
    arrays.corner_count = corners.size();
    CALL(rlv_mesh_create, context, &arrays, &mesh);
    return mesh;
}

} // namespace

int main(int argc, char **argv) {
    for (int k = 1; k < argc; ++k) {
        library = dlopen(argv[k], RTLD_NOW | (k + 1 < argc ? RTLD_GLOBAL : RTLD_LOCAL));
        if (!library) {
            fail(argv[k], dlerror());
        }
    }
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvCollider collider = RLV_NULL;
    RlvCaster caster = RLV_NULL;
    CALL(rlv_context_create, nullptr, &context);
    const RlvMesh plane = mesh_of(context, {0, 0, 0, 4, 0, 0, 4, 4, 0, 0, 4, 0}, {0, 1, 2, 3});
    std::vector<float> box;
    for (int k = 0; k < 8; ++k) {
        box.insert(box.end(), {k & 1 ? 2.5f : 1.5f, k & 2 ? 2.5f : 1.5f, k & 4 ? 1.0f : -0.25f});
    }
    const RlvMesh tool = mesh_of(context, box, {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6});
    CALL(rlv_surface_create, context, plane, nullptr, &surface);
    CALL(rlv_detail_create, surface, nullptr, nullptr, &detail);
    CALL(rlv_collider_create_mesh, context, tool, nullptr, &collider);
    CALL(rlv_imprint_run, detail, collider, nullptr, nullptr, nullptr);
    CALL(rlv_detail_commit, detail, nullptr);
    CALL(rlv_caster_create_detail, detail, nullptr, &caster);
    for (const float z : {1.0f, -3.0f}) {
        const float origin[3] = {2.0f, 2.1f, z}, direction[3] = {0, 0, z > 0.0f ? -1.0f : 1.0f};
        RlvHit hit;
        RlvRayArrays rays = RLV_RAY_ARRAYS_INIT;
        rays.count = 1;
        rays.origins = origin;
        rays.directions = direction;
        rays.hits = &hit;
        CALL(rlv_caster_cast, caster, &rays);
        if (!(std::fabs(hit.position[2] + 0.25f) < 0.02f)) {
            std::fprintf(stderr, "the ray from %g hit at %g\n", double(z), double(hit.position[2]));
            return 1;
        }
    }
    CALL(rlv_caster_release, caster);
    CALL(rlv_collider_release, collider);
    CALL(rlv_detail_release, detail);
    CALL(rlv_surface_release, surface);
    CALL(rlv_mesh_release, tool);
    CALL(rlv_mesh_release, plane);
    CALL(rlv_context_release, context);
    return 0;
}
