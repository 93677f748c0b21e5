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

/* One object for each content, which `check_rows` writes. */
static RlvMesh box;
static RlvDetail detail;
static RlvParticles particles;
static RlvGrid volume;
static RlvProgressive progressive;
static RlvCrowdModel crowd;
static RlvTissue tissue;

static void make_objects(const RlvCapability *capability) {
    RlvParticlesArrays arrays = RLV_PARTICLES_ARRAYS_INIT;
    RlvSurface surface = RLV_NULL;
    const float points[6] = {0, 0, 0, 1, 0, 0};
    box = check_box(context, 0.0f, 0.1f, 0.0f, 0.1f);
    CHECK_OK(rlv_surface_create(context, box, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    CHECK_OK(rlv_surface_release(surface));
    arrays.points = points;
    arrays.count = 2;
    CHECK_OK(rlv_particles_create(context, &arrays, &particles));
    if (capability->openvdb_version != 0) {
        RlvGridSettings coarse = RLV_GRID_SETTINGS_INIT;
        coarse.voxel = 0.02f;
        CHECK_OK(rlv_grid_from_mesh(box, &coarse, NULL, NULL, &volume));
    }
    CHECK_OK(rlv_progressive_create(box, NULL, NULL, NULL, &progressive));
    CHECK_OK(rlv_mesh_write(box, "capability_box.obj"));
    CHECK_OK(rlv_crowd_model_build(context, "capability_box.obj", NULL, 0, NULL, NULL, NULL, &crowd));
    remove("capability_box.obj");
    tissue = check_tissue(context, box);
}

static void release_objects(void) {
    CHECK_OK(rlv_tissue_release(tissue));
    CHECK_OK(rlv_crowd_model_release(crowd));
    CHECK_OK(rlv_progressive_release(progressive));
    if (volume.id != 0) {
        CHECK_OK(rlv_grid_release(volume));
    }
    CHECK_OK(rlv_particles_release(particles));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_mesh_release(box));
}

/* A patch of degree 1. */
static void write_patch(const char *path) {
    FILE *file = fopen(path, "w");
    CHECK(file != NULL);
    fputs("1\n1 1\n0 0 0\n1 0 0\n0 1 0\n1 1 0\n", file);
    fclose(file);
}

static RlvResult write_row(const RlvCapabilityFormat *row, const char *path) {
    RlvDocument document = RLV_NULL;
    RlvResult result;
    switch (row->content) {
    case RLV_CONTENT_MESH: return rlv_mesh_write(box, path);
    case RLV_CONTENT_PATCHES: write_patch(path); return RLV_ERROR_UNSUPPORTED;
    case RLV_CONTENT_PARTICLES: return rlv_particles_write(particles, path);
    case RLV_CONTENT_GRID: return rlv_grid_write(&volume, 1, path, RLV_GRID_PACK_BLOSC);
    case RLV_CONTENT_TEXTURE: return rlv_ptex_write(detail, RLV_CHANNEL_DISPLACEMENT, path, NULL, NULL);
    case RLV_CONTENT_DOCUMENT:
        result = rlv_document_create(detail, path, 0, &document);
        CHECK_OK(rlv_document_release(document));
        return result;
    case RLV_CONTENT_PROGRESSIVE: return rlv_progressive_write(progressive, path);
    case RLV_CONTENT_CROWD: return rlv_crowd_model_write(crowd, path);
    default: CHECK(row->content == RLV_CONTENT_TISSUE); return rlv_tissue_write(tissue, path);
    }
}

static RlvResult write_row_bytes(const RlvCapabilityFormat *row, RlvBytes *out) {
    RlvDocument document = RLV_NULL;
    RlvResult result;
    switch (row->content) {
    case RLV_CONTENT_MESH: return rlv_mesh_write_bytes(box, row->extension, out);
    case RLV_CONTENT_DOCUMENT:
        CHECK_OK(rlv_document_create(detail, NULL, 0, &document));
        result = rlv_document_save_bytes(document, out);
        CHECK_OK(rlv_document_release(document));
        return result;
    case RLV_CONTENT_PROGRESSIVE: return rlv_progressive_write_bytes(progressive, out);
    case RLV_CONTENT_CROWD: return rlv_crowd_model_write_bytes(crowd, out);
    default: CHECK(row->content == RLV_CONTENT_TISSUE); return rlv_tissue_write_bytes(tissue, out);
    }
}

#define READ(type, noun, read)                        \
    do {                                              \
        type made = RLV_NULL;                         \
        RlvResult result = (read);                    \
        if (result == RLV_OK) {                       \
            CHECK_OK(rlv_##noun##_release(made));     \
        }                                             \
        return result;                                \
    } while (0)

static RlvResult read_row(const RlvCapabilityFormat *row, const char *path) {
    switch (row->content) {
    case RLV_CONTENT_MESH: READ(RlvMesh, mesh, rlv_mesh_read(context, path, &made));
    case RLV_CONTENT_PATCHES: READ(RlvBezier, bezier, rlv_bezier_read(context, path, &made));
    case RLV_CONTENT_PARTICLES: READ(RlvParticles, particles, rlv_particles_read(context, path, &made));
    case RLV_CONTENT_GRID: READ(RlvGrid, grid, rlv_grid_read(context, path, NULL, NULL, NULL, NULL, &made));
    case RLV_CONTENT_TEXTURE: return rlv_ptex_read(detail, path, NULL, NULL, NULL, NULL);
    case RLV_CONTENT_DOCUMENT: READ(RlvDocument, document, rlv_document_open(detail, path, 0, &made));
    case RLV_CONTENT_PROGRESSIVE: READ(RlvProgressive, progressive, rlv_progressive_read(context, path, SIZE_MAX, &made));
    case RLV_CONTENT_CROWD: READ(RlvCrowdModel, crowd_model, rlv_crowd_model_read(context, path, &made));
    default: READ(RlvTissue, tissue, rlv_tissue_read(context, path, &made));
    }
}

/* Every row is written where it says so, and read again; what cannot be written is refused. */
static void check_rows(const RlvCapability *capability, const RlvCapabilityFormat *formats, size_t count) {
    uint32_t contents = 0;
    make_objects(capability);
    for (size_t k = 0; k < count; ++k) {
        const RlvCapabilityFormat *row = &formats[k];
        char path[64];
        snprintf(path, sizeof path, "capability_row.%s", row->extension);
        remove(path);
        CHECK(write_row(row, path) == (row->can_write ? RLV_OK : RLV_ERROR_UNSUPPORTED));
        if (row->can_write || row->content == RLV_CONTENT_PATCHES) {
            CHECK(row->can_read);
            CHECK_OK(read_row(row, path));
            CHECK(remove(path) == 0);
        }
        if (row->can_write_bytes) {
            RlvBytes bytes = RLV_NULL;
            CHECK_OK(write_row_bytes(row, &bytes));
            CHECK_OK(rlv_bytes_release(bytes));
        }
        contents |= 1u << row->content;
    }
    CHECK((contents | 1u << RLV_CONTENT_GRID) == (1u << (RLV_CONTENT_TISSUE + 1)) - 1);
    release_objects();
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
    check_rows(&capability, formats, count);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
