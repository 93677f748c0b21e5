/* Capabilities: versions are those that are there, and every format that is listed is read and written, and no other. */
#include "check.h"

static RlvContext context;

static const RlvCapabilityFormat *find(const RlvCapabilityFormat *formats, size_t count, uint32_t content,
                                       const char *extension) {
    for (size_t k = 0; k < count; ++k) {
        if (formats[k].content == content && strcmp(formats[k].extension, extension) == 0) {
            return &formats[k];
        }
    }
    return NULL;
}

static void check_meshes(const RlvCapabilityFormat *formats, size_t count) {
    static const char *const extensions[] = {"obj", "ply", "glb", "gltf", "stl", "off", "usd", "usda", "3ds", "fbx"};
    RlvMesh plane = check_plane(context, 2, 1), read = RLV_NULL;
    RlvBytes bytes = RLV_NULL;
    for (size_t k = 0; k < sizeof(extensions) / sizeof(*extensions); ++k) {
        const RlvCapabilityFormat *format = find(formats, count, RLV_CONTENT_MESH, extensions[k]);
        char path[64];
        snprintf(path, sizeof(path), "capability.%s", extensions[k]);
        remove(path);
        const RlvResult written = rlv_mesh_write(plane, path);
        CHECK(written == (format && format->can_write ? RLV_OK : RLV_ERROR_UNSUPPORTED));
        const RlvResult made = rlv_mesh_write_bytes(plane, extensions[k], &bytes);
        CHECK(made == (format && format->can_write_bytes ? RLV_OK : RLV_ERROR_UNSUPPORTED));
        if (made == RLV_OK) {
            CHECK_OK(rlv_bytes_release(bytes));
        }
        if (written == RLV_OK) {
            CHECK(format->can_read);
            CHECK_OK(rlv_mesh_read(context, path, &read));
            CHECK_OK(rlv_mesh_release(read));
            remove(path);
        }
    }
    CHECK_OK(rlv_mesh_release(plane));
}

int main(void) {
    RlvCapability capability = RLV_CAPABILITY_INIT;
    RlvContextInfo info = RLV_CONTEXT_INFO_INIT;
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvCapabilityFormat formats[64];
    size_t count = 0, adapters = 0;

    CHECK_OK(rlv_capability_get(&capability));
    CHECK(capability.version == rlv_version());
    CHECK(capability.opensubdiv_version >= RLV_MAKE_VERSION(3, 5, 0));
    CHECK_OK(rlv_adapter_list(NULL, 0, &adapters));
    CHECK(capability.adapter_count == adapters && (capability.has_devices || adapters == 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_capability_get(NULL), "RlvCapability");

    /* A context has what is said. */
    CHECK_OK(rlv_context_create(NULL, &context));
    CHECK_OK(rlv_context_info(context, &info));
    CHECK(info.threads == capability.cores && strcmp(info.simd, capability.simd) == 0);
    CHECK_OK(rlv_context_release(context));
    options.threads = capability.max_threads + 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_context_create(&options, &context), "threads");
    options.threads = 1;
    CHECK_OK(rlv_context_create(&options, &context));

    /* Rays need Embree. */
    RlvMesh plane = check_plane(context, 2, 2);
    RlvCaster caster = RLV_NULL;
    const RlvResult cast = rlv_caster_create_mesh(context, plane, &caster);
    CHECK((cast == RLV_OK) == (capability.embree_version != 0));
    CHECK(cast != RLV_OK || capability.embree_version >= RLV_MAKE_VERSION(3, 13, 0));
    if (cast == RLV_OK) {
        CHECK_OK(rlv_caster_release(caster));
    }

    /* Features are isolated to the level that is said, and to no other. */
    RlvSurfaceOptions isolation = RLV_SURFACE_OPTIONS_INIT;
    RlvSurface surface = RLV_NULL;
    isolation.isolation = capability.max_isolation;
    CHECK_OK(rlv_surface_create(context, plane, &isolation, &surface));
    CHECK_OK(rlv_surface_release(surface));
    isolation.isolation = capability.max_isolation + 1;
    CHECK(rlv_surface_create(context, plane, &isolation, &surface) == RLV_ERROR_INVALID);
    CHECK_OK(rlv_mesh_release(plane));

    /* Grids need OpenVDB. */
    const double background[1] = {0.0};
    RlvGrid grid = RLV_NULL;
    const RlvResult gridded = rlv_grid_create(context, RLV_GRID_FLOAT, background, 0.1, &grid);
    CHECK((gridded == RLV_OK) == (capability.openvdb_version != 0));
    if (gridded == RLV_OK) {
        CHECK_OK(rlv_grid_release(grid));
    }

    CHECK_FAILS(RLV_ERROR_INVALID, rlv_capability_list(formats, 64, NULL), "count");
    CHECK_OK(rlv_capability_list(NULL, 0, &count));
    CHECK(count > 8 && count <= 64);
    count = 0;
    CHECK(rlv_capability_list(formats, 1, &count) == RLV_ERROR_INVALID && count > 1); /* which says how many rows there are */
    CHECK_OK(rlv_capability_list(formats, 64, &count));
    CHECK((find(formats, count, RLV_CONTENT_GRID, "vdb") != NULL) == (capability.openvdb_version != 0));
    CHECK((find(formats, count, RLV_CONTENT_MESH, "usda") != NULL) == (capability.has_usd != 0));
    CHECK(find(formats, count, RLV_CONTENT_DOCUMENT, "relievo")->can_write_bytes);
    check_meshes(formats, count);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
