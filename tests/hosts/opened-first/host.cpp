// host [OTHER...] LIBRARY: a program that links nothing of ours. It opens other libraries first, such as another TBB and
// another Embree, so that their names are found before all others, and then the library: rays hit, imprints are made, and
// triangles are subdivided by OpenSubdiv.
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

RlvMesh mesh_of(RlvContext context, const std::vector<float> &points, const std::vector<uint32_t> &corners,
                uint32_t face_size = 4) {
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    RlvMesh mesh = RLV_NULL;
    arrays.points = points.data();
    arrays.point_count = points.size() / 3;
    arrays.face_size = face_size;
    arrays.face_count = corners.size() / face_size;
    arrays.corners = corners.data();
    arrays.corner_count = corners.size();
    CALL(rlv_mesh_create, context, &arrays, &mesh);
    return mesh;
}

/// A tetrahedron under Loop: its points go inwards, and its refined mesh has four triangles for each of a level.
void subdivide(RlvContext context) {
    const RlvMesh cage = mesh_of(context, {1, 1, 1, -1, -1, 1, -1, 1, -1, 1, -1, -1}, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}, 3);
    RlvSubdivision subdivision = RLV_NULL;
    RlvSubdivisionOptions options = RLV_SUBDIVISION_OPTIONS_INIT;
    options.scheme = RLV_SCHEME_LOOP;
    CALL(rlv_subdivision_create, context, cage, &options, &subdivision);
    const uint32_t tile = 0;
    const float uv[2] = {0, 0};
    float point[3] = {0, 0, 0};
    RlvSubdivisionArrays arrays = RLV_SUBDIVISION_ARRAYS_INIT;
    arrays.count = 1;
    arrays.tiles = &tile;
    arrays.uvs = uv;
    arrays.values = point;
    CALL(rlv_subdivision_evaluate, subdivision, nullptr, &arrays);
    // All corners pull alike, so that the point stays on the line through the corner.
    if (!(point[0] > 0.05f && point[0] < 0.95f && std::fabs(point[0] - point[1]) < 1e-5f && std::fabs(point[0] - point[2]) < 1e-5f)) {
        std::fprintf(stderr, "the limit of the corner is at %g, %g, %g\n", double(point[0]), double(point[1]), double(point[2]));
        std::exit(1);
    }
    RlvMesh refined = RLV_NULL;
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    CALL(rlv_subdivision_refine, subdivision, 2, &refined);
    CALL(rlv_mesh_info, refined, &info);
    if (info.triangle_count != 64) {
        std::fprintf(stderr, "the refined mesh has %zu triangles\n", info.triangle_count);
        std::exit(1);
    }
    CALL(rlv_mesh_release, refined);
    CALL(rlv_subdivision_release, subdivision);
    CALL(rlv_mesh_release, cage);
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
    subdivide(context);
    CALL(rlv_caster_release, caster);
    CALL(rlv_collider_release, collider);
    CALL(rlv_detail_release, detail);
    CALL(rlv_surface_release, surface);
    CALL(rlv_mesh_release, tool);
    CALL(rlv_mesh_release, plane);
    CALL(rlv_context_release, context);
    return 0;
}
