/* Bakes: pictures have what evaluation says, in memory and in files; nothing is made of what cannot be. */
#include "sheet.h"

enum { SIZE = 96 };

typedef struct Kept {
    float pixels[SIZE * SIZE * 4];
    uint8_t covered[SIZE * SIZE];
    uint32_t channels, udim;
    int pictures, answer;
} Kept;

static uint32_t keep(void *user, const RlvBakePicture *picture) {
    Kept *kept = user;
    CHECK(picture->struct_size == sizeof *picture && picture->width == SIZE && picture->height == SIZE);
    memcpy(kept->pixels, picture->pixels, sizeof(float) * picture->channels * SIZE * SIZE);
    memcpy(kept->covered, picture->covered, SIZE * SIZE);
    kept->channels = picture->channels;
    kept->udim = picture->udim;
    ++kept->pictures;
    return (uint32_t)kept->answer;
}

/* The numbers of the pixel over (x, y) of a sheet of this side. */
static const float *at(const Kept *kept, double x, double y, double side) {
    size_t column = (size_t)(x / side * SIZE), row = SIZE - 1 - (size_t)(y / side * SIZE);
    return kept->pixels + (row * SIZE + column) * kept->channels;
}

/* A sheet with a dent, a stroke of colour, traces, and a vector that is the same everywhere. */
static RlvDetail dented(RlvContext context, RlvSurface surface, uint32_t tiles) {
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvVectorOptions vectors = RLV_VECTOR_OPTIONS_INIT;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    RlvBrushOptions kind = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    const RlvStrokePoint point = {{2.5, 2.5, 0.0}, 1.0, -1.0};
    const double place[12] = CHECK_MOVED(2.5, 2.5, 0.1);
    RlvDetail detail = RLV_NULL;
    RlvCollider collider = RLV_NULL;
    RlvBrush brush = RLV_NULL;
    RlvMesh ball = check_ball(context, 0.6);
    unsigned char block[600];
    options.tile_size = paint.tile_size = 32;
    vectors.tile_size = 8;
    paint.color[3] = 0.0f;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    CHECK_OK(rlv_detail_add_traces(detail, 0));
    CHECK_OK(rlv_detail_add_vectors(detail, &vectors));
    CHECK_OK(rlv_detail_advance(detail, 4.0));
    CHECK_OK(rlv_collider_create_mesh(context, ball, place, &collider));
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, NULL));
    kind.color[0] = 0.25f;
    kind.falloff = RLV_FALLOFF_CONSTANT;
    settings.radius = 0.4f;
    settings.depth = 4.0f;
    CHECK_OK(rlv_brush_create(context, &kind, &settings, &brush));
    CHECK_OK(rlv_stroke_run(detail, brush, &point, 1, 0, NULL));
    for (size_t texel = 0; texel < 100; ++texel) {
        /* 0.25 along the tangent by u, -0.5 across it. */
        const unsigned char value[6] = {0x00, 0x34, 0x00, 0xb8, 0, 0};
        memcpy(block + 6 * texel, value, 6);
    }
    for (uint32_t tile = 0; tile < tiles; ++tile) {
        CHECK_OK(rlv_detail_write_block(detail, RLV_CHANNEL_VECTORS, tile, block, sizeof(block)));
    }
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_brush_release(brush));
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_mesh_release(ball));
    return detail;
}

int main(void) {
    static Kept kept;
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL, bare = RLV_NULL;
    RlvDetail detail, plain = RLV_NULL;
    RlvBakeOptions options = RLV_BAKE_OPTIONS_INIT;
    RlvBakeReport report = RLV_BAKE_REPORT_INIT;
    char path[64], file[64];
    int patience = 0;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh sheet = check_sheet(context, 5, 5, 0.0f), plane = check_plane(context, 5, 5);
    CHECK_OK(rlv_surface_create(context, sheet, NULL, &surface));
    CHECK_OK(rlv_surface_create(context, plane, NULL, &bare));
    detail = dented(context, surface, 25);
    options.width = options.height = SIZE;
    options.gutter = 0;

    /* Every quantity, against evaluation in the middle of tile 12 and where nothing happened. */
    const uint32_t tile = 12;
    const float uv[2] = {0.5f, 0.5f};
    float displacement, trace[3], color[4];
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    arrays.count = 1;
    arrays.tiles = &tile;
    arrays.uvs = uv;
    arrays.displacements = &displacement;
    arrays.traces = trace;
    arrays.colors = color;
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
    CHECK_OK(rlv_bake_run(detail, &options, keep, NULL, &kept, &report));
    CHECK(kept.channels == 1 && kept.udim == 1001 && kept.pictures == 1 && report.picture_count == 1);
    CHECK(report.covered_pixels == SIZE * SIZE && report.gutter_pixels == 0 && report.overlapping_pixels == 0);
    CHECK(displacement < -0.4f && report.flat_tiles == 0 && report.outside_count == 0 && kept.covered[7] == 1);
    CHECK_NEAR(at(&kept, 2.5, 2.5, 5)[0], displacement, 0.02);
    CHECK(at(&kept, 0.5, 4.5, 5)[0] == 0.0f);
    options.quantity = RLV_BAKE_VECTOR;
    options.space = RLV_BAKE_OBJECT;
    CHECK_OK(rlv_bake_run(detail, &options, keep, NULL, &kept, NULL));
    CHECK(kept.channels == 3);
    CHECK_NEAR(at(&kept, 0.5, 4.5, 5)[0], 0.25, 1e-5);
    CHECK_NEAR(at(&kept, 0.5, 4.5, 5)[1], -0.5, 1e-5);
    CHECK_NEAR(at(&kept, 2.5, 2.5, 5)[2], displacement, 0.02);
    options.space = RLV_BAKE_TANGENT;
    CHECK_OK(rlv_bake_run(detail, &options, keep, NULL, &kept, NULL));
    CHECK_NEAR(at(&kept, 0.5, 4.5, 5)[2], -0.5, 1e-5);
    CHECK_NEAR(at(&kept, 2.5, 2.5, 5)[1], displacement, 0.02);
    options.axes = RLV_BAKE_TBN;
    CHECK_OK(rlv_bake_run(detail, &options, keep, NULL, &kept, NULL));
    CHECK_NEAR(at(&kept, 0.5, 4.5, 5)[1], -0.5, 1e-5);
    options.quantity = RLV_BAKE_NORMAL;
    CHECK_OK(rlv_bake_run(detail, &options, keep, NULL, &kept, NULL));
    CHECK_NEAR(at(&kept, 0.5, 4.5, 5)[2], 1.0, 1e-5);
    const float green = at(&kept, 2.5, 2.8, 5)[1];
    options.handedness = RLV_BAKE_DIRECTX;
    CHECK_OK(rlv_bake_run(detail, &options, keep, NULL, &kept, NULL));
    /* South of the slope's rim the surface looks south. */
    CHECK(green < -0.1f && at(&kept, 2.5, 2.8, 5)[1] == -green);
    options.quantity = RLV_BAKE_COLOR;
    CHECK_OK(rlv_bake_run(detail, &options, keep, NULL, &kept, NULL));
    CHECK(kept.channels == 4 && at(&kept, 0.5, 4.5, 5)[3] == 0.0f);
    CHECK_NEAR(at(&kept, 2.5, 2.5, 5)[0], color[0], 0.01);
    CHECK_NEAR(color[0], 0.25, 0.01);
    options.quantity = RLV_BAKE_MASK;
    CHECK_OK(rlv_bake_run(detail, &options, keep, NULL, &kept, NULL));
    CHECK(kept.channels == 1 && at(&kept, 2.5, 2.5, 5)[0] == 1.0f && at(&kept, 0.5, 4.5, 5)[0] == 0.0f);
    options.quantity = RLV_BAKE_CONTACT;
    CHECK_OK(rlv_bake_run(detail, &options, keep, NULL, &kept, NULL));
    CHECK_NEAR(at(&kept, 2.5, 2.5, 5)[0], trace[0], 1e-3);
    options.quantity = RLV_BAKE_DEPTH;
    CHECK_OK(rlv_bake_run(detail, &options, keep, NULL, &kept, NULL));
    CHECK_NEAR(at(&kept, 2.5, 2.5, 5)[0], trace[1], 0.02);
    options.quantity = RLV_BAKE_TIME;
    CHECK_OK(rlv_bake_run(detail, &options, keep, NULL, &kept, NULL));
    CHECK(at(&kept, 2.5, 2.5, 5)[0] == 4.0f && at(&kept, 0.5, 4.5, 5)[0] == -1.0f);

    /* Files, of the picture and of its UDIM tiles. */
    options.quantity = RLV_BAKE_DISPLACEMENT;
    for (int png = 0; png < 2; ++png) {
        snprintf(path, sizeof path, "bake-%p.%s", (void *)&context, png ? "png" : "exr");
        CHECK_OK(rlv_bake_write(detail, &options, path, NULL, NULL, &report));
        CHECK(check_removed(path) && (png ? report.scale > 0.8f && report.mid_level == 0.5f : report.scale == 1.0f));
        options.is_udim = 1;
        CHECK_OK(rlv_bake_write(detail, &options, path, NULL, NULL, NULL));
        snprintf(file, sizeof file, "bake-%p.1001.%s", (void *)&context, png ? "png" : "exr");
        CHECK(check_removed(file) && !check_removed(path));
        options.is_udim = 0;
    }
    options.scale = 2.0f;
    options.mid_level = 0.25f;
    CHECK_OK(rlv_bake_write(detail, &options, path, NULL, NULL, &report));
    CHECK(check_removed(path) && report.scale == 2.0f && report.mid_level == 0.25f);

    /* Whoever has had enough leaves nothing. */
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_bake_write(detail, &options, path, check_patience, &patience, NULL), "cancel");
    CHECK(!check_removed(path));
    kept.answer = RLV_PROGRESS_CANCEL;
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_bake_run(detail, &options, keep, NULL, &kept, NULL), "receive");
    kept.answer = RLV_PROGRESS_CONTINUE;
    kept.pictures = 0;

    /* Refusals. */
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_bake_write(detail, &options, "bake.jpg", NULL, NULL, NULL), ".exr");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bake_write(detail, &options, NULL, NULL, NULL, NULL), "path");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_bake_write(detail, &options, "no/such/bake.exr", NULL, NULL, NULL), "no/such");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bake_run(detail, &options, NULL, NULL, NULL, NULL), "receive");
    options.scale = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bake_write(detail, &options, path, NULL, NULL, NULL), "scale");
    options.scale = 0.0f;
    options.quantity = 8;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bake_run(detail, &options, keep, NULL, &kept, NULL), "quantity 8");
    options.quantity = RLV_BAKE_VECTOR;
    options.space = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bake_run(detail, &options, keep, NULL, &kept, NULL), "space 2");
    options.space = 0;
    options.width = 40000;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bake_run(detail, &options, keep, NULL, &kept, NULL), "40000");
    options.width = SIZE;
    options.samples = 9;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bake_run(detail, &options, keep, NULL, &kept, NULL), "9 samples");
    options.samples = 1;
    options.uv = "map1";
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bake_run(detail, &options, keep, NULL, &kept, NULL), "map1");
    options.uv = NULL;
    CHECK_OK(rlv_detail_create(bare, NULL, NULL, &plain));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bake_run(plain, &options, keep, NULL, &kept, NULL), "uv");
    options.quantity = RLV_BAKE_COLOR;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bake_run(plain, &options, keep, NULL, &kept, NULL), "colours");
    options.quantity = RLV_BAKE_DEPTH;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bake_run(plain, &options, keep, NULL, &kept, NULL), "traces");
    CHECK(kept.pictures == 0);

    /* Texture coordinates of a tessellation are those that bakes go by. */
    RlvTessellateOptions cells = RLV_TESSELLATE_OPTIONS_INIT;
    RlvMesh mesh = RLV_NULL;
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    uint32_t index = 0;
    cells.smooth_uvs = 1;
    CHECK_OK(rlv_tessellate_surface(surface, &cells, &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK_OK(rlv_mesh_find_attribute(mesh, "uv", &index));
    RlvAttributeInfo about = RLV_ATTRIBUTE_INFO_INIT;
    CHECK_OK(rlv_mesh_attribute_info(mesh, index, &about));
    float *uvs = malloc(about.value_count * 8), *points = malloc(info.point_count * 12);
    uint32_t *indices = malloc(about.index_count * 4), *corners = malloc(info.corner_count * 4);
    CHECK(uvs != NULL && points != NULL && indices != NULL && corners != NULL && about.index_count == info.corner_count);
    CHECK_OK(rlv_mesh_get_attribute(mesh, index, uvs, about.value_count * 2, indices, about.index_count));
    CHECK_OK(rlv_mesh_get_points(mesh, points, info.point_count, 0));
    CHECK_OK(rlv_mesh_get_faces(mesh, NULL, 0, corners, info.corner_count));
    for (size_t corner = 0; corner < info.corner_count; ++corner) {
        CHECK_NEAR(5 * uvs[2 * indices[corner]], points[3 * corners[corner]], 1e-5);
    }
    free(uvs), free(points), free(indices), free(corners);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_detail_release(plain));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bake_run(detail, &options, keep, NULL, &kept, NULL), "alive");
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_surface_release(bare));
    CHECK_OK(rlv_mesh_release(sheet));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
