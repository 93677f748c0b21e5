/* Details of triangle meshes: painted, sculpted and pressed into, evaluated, followed, baked, faded, undone and kept in
 * documents. */
#include "sheet.h"

/* A closed mesh: every edge has two triangles. */
static int is_closed(RlvMesh mesh) {
    RlvCollider collider = RLV_NULL;
    RlvColliderInfo info = RLV_COLLIDER_INFO_INIT;
    RlvMeshInfo about = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(mesh, &about));
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    CHECK_OK(rlv_collider_create_mesh(context, mesh, NULL, &collider));
    CHECK_OK(rlv_collider_info(collider, &info));
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_context_release(context));
    return (int)info.is_closed;
}

typedef struct Look {
    float position[3], normal[3], vector[3], color[4], displacement;
} Look;

static Look look(RlvDetail detail, uint32_t tile, float u, float v, int painted) {
    Look out = {{0}, {0}, {0}, {0}, 7.0f};
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    arrays.positions = out.position;
    arrays.normals = out.normal;
    arrays.vectors = out.vector;
    arrays.displacements = &out.displacement;
    arrays.colors = painted ? out.color : NULL;
    check_evaluate(detail, tile, u, v, arrays);
    return out;
}

/* Where strokes go: over the pole, and along the side that faces -y. */
static const RlvStrokePoint POLE[2] = {{{0.3, 0, 0.95}, 1.0, -1.0}, {{-0.3, 0.1, 0.95}, 1.0, -1.0}};
static const RlvStrokePoint SIDE[2] = {{{0.1, -0.86, -0.5}, 1.0, -1.0}, {{-0.1, -0.86, -0.5}, 1.0, -1.0}};

static void stroke_of(RlvContext context, RlvDetail detail, uint32_t action, float height, float radius,
                      const RlvStrokePoint points[2]) {
    RlvBrushOptions options = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvStrokeReport report = RLV_STROKE_REPORT_INIT;
    RlvBrush brush = RLV_NULL;
    options.action = action;
    options.color[1] = 0.25f;
    options.height = height;
    settings.radius = radius;
    CHECK_OK(rlv_brush_create(context, &options, &settings, &brush));
    CHECK_OK(rlv_stroke_run(detail, brush, points, 2, 0, &report));
    CHECK(report.dabs > 2 && report.missed_dabs == 0 && report.changed_tiles > 4 && report.bytes > 0);
    CHECK_OK(rlv_brush_release(brush));
}

static void stroke(RlvContext context, RlvDetail detail, uint32_t action, float height) {
    stroke_of(context, detail, action, height, 0.3f, POLE);
}

/* The radius of the ball's surface over a direction, by a ray. */
static float radius(RlvDetail detail, float x, float y, float z, RlvHit *hit) {
    RlvCaster caster = RLV_NULL;
    const float origin[3] = {3 * x, 3 * y, 3 * z}, direction[3] = {-x, -y, -z};
    CHECK_OK(rlv_caster_create_detail(detail, NULL, &caster));
    *hit = check_cast(caster, origin, direction);
    CHECK_OK(rlv_caster_release(caster));
    return sqrtf(hit->position[0] * hit->position[0] + hit->position[1] * hit->position[1] +
                 hit->position[2] * hit->position[2]);
}

static void same_points(RlvTessellation followed, RlvDetail detail) {
    RlvTessellation fresh = RLV_NULL;
    RlvTessellationInfo one = RLV_TESSELLATION_INFO_INIT, other = RLV_TESSELLATION_INFO_INIT;
    CHECK_OK(rlv_tessellation_create(detail, NULL, &fresh));
    CHECK_OK(rlv_tessellation_info(followed, &one));
    CHECK_OK(rlv_tessellation_info(fresh, &other));
    CHECK(one.point_count == other.point_count && one.triangle_count == other.triangle_count);
    float *points = malloc(one.point_count * 48);
    size_t half = one.point_count * 6;
    CHECK(points != NULL);
    CHECK_OK(rlv_tessellation_get_points(followed, 0, one.point_count, points, 24, points + 3, 24));
    CHECK_OK(rlv_tessellation_get_points(fresh, 0, one.point_count, points + half, 24, points + half + 3, 24));
    CHECK(memcmp(points, points + half, half * 4) == 0);
    free(points);
    CHECK_OK(rlv_tessellation_release(fresh));
}

/* What a ball pushes out of a closed mesh of triangles rises around it, as much of it as is asked for. */
static void rim(RlvContext context, RlvSurface surface, RlvMesh ball) {
    const double place[12] = CHECK_MOVED(1.3, 0.0, 0.0);
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
    RlvDetail detail = RLV_NULL;
    RlvCollider collider = RLV_NULL;
    RlvHit hit;
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    CHECK_OK(rlv_collider_create_mesh(context, ball, place, &collider));
    settings.rim = 0.75f;
    settings.rim_width = 0.3f;
    settings.repose = 1.2f;
    CHECK_OK(rlv_imprint_run(detail, collider, &settings, NULL, &report));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    /* The lens of two balls of radius 1 and 0.4 whose centres are 1.3 apart is larger, since both are of flat faces. */
    CHECK(report.pushed_volume > 0.0068 && report.pushed_volume < 0.00856);
    CHECK_NEAR(report.raised_volume, 0.75 * report.pushed_volume, 0.02 * report.pushed_volume);
    CHECK_NEAR(radius(detail, 1, 0, 0, &hit), 0.9, 0.02);
    CHECK(radius(detail, 0.9578f, 0.2873f, 0.0f, &hit) > 1.005f);
    CHECK_NEAR(radius(detail, 0, 1, 0, &hit), 1.0, 0.01);
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_detail_release(detail));
}

/* A split takes no more memory than its context allows, and ends where floats do. */
static void too_large_to_split(void) {
    static const float far[9] = {1048576.0f, 0.0f, 0.0f, 1048580.0f, 0.0f, 0.0f, 1048576.0f, 3.0f, 0.0f};
    static const uint32_t corners[3] = {0, 1, 2};
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvContext small = RLV_NULL;
    RlvMesh mesh = RLV_NULL, split = RLV_NULL;
    options.memory_limit = 1 << 20;
    CHECK_OK(rlv_context_create(&options, &small));
    RlvMesh plane = check_plane(small, 2, 2);
    CHECK_OK(rlv_mesh_split(plane, 0.2, &split));
    CHECK_OK(rlv_mesh_release(split));
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_mesh_split(plane, 0.02, &split), "memory limit");
    mesh = check_mesh_of(small, far, 3, 3, 1, corners);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_split(mesh, 0.1, &split), "cannot get as short");
    CHECK_OK(rlv_mesh_split(mesh, 1.0, &split));
    CHECK_OK(rlv_mesh_release(split));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(small));
}

enum { SIZE = 64 };

static float pixels[SIZE * SIZE * 4];

static uint32_t keep(void *user, const RlvBakePicture *picture) {
    *(uint32_t *)user = picture->channels;
    CHECK(picture->width == SIZE && picture->height == SIZE);
    memcpy(pixels, picture->pixels, sizeof(float) * SIZE * SIZE * picture->channels);
    return RLV_PROGRESS_CONTINUE;
}

/* Bakes of a sheet of triangles have what evaluation says. */
static void bakes(RlvContext context, RlvSurface surface) {
    RlvDetail detail = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvBrushOptions draw = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvBakeOptions bake = RLV_BAKE_OPTIONS_INIT;
    RlvBakeReport report = RLV_BAKE_REPORT_INIT;
    RlvBrush brush = RLV_NULL;
    const RlvStrokePoint point = {{2.0, 2.0, 0.0}, 1.0, -1.0};
    uint32_t channels = 0;
    char path[64];
    options.tile_size = 32;
    draw.action = RLV_BRUSH_SCULPT;
    draw.height = 0.5f;
    settings.radius = 1.2f;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, NULL));
    CHECK_OK(rlv_brush_create(context, &draw, &settings, &brush));
    CHECK_OK(rlv_stroke_run(detail, brush, &point, 1, 0, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    bake.width = bake.height = SIZE;
    bake.gutter = 0;
    CHECK_OK(rlv_bake_run(detail, &bake, keep, NULL, &channels, &report));
    CHECK(channels == 1 && report.covered_pixels == SIZE * SIZE && report.overlapping_pixels == 0 && report.flat_tiles == 0);
    float highest = 0.0f;
    for (int row = 0; row < SIZE; ++row) {
        for (int column = 0; column < SIZE; ++column) {
            /* The quad, and the triangle of it, over the middle of the pixel. */
            const float x = 4.0f * ((float)column + 0.5f) / SIZE, y = 4.0f * ((float)(SIZE - 1 - row) + 0.5f) / SIZE;
            const float s = x - floorf(x), t = y - floorf(y);
            const uint32_t quad = (uint32_t)y * 4 + (uint32_t)x, tile = 2 * quad + (t > s ? 1 : 0);
            const Look there = t > s ? look(detail, tile, s, t - s, 0) : look(detail, tile, s - t, t, 0);
            CHECK_NEAR(there.position[0], x, 1e-4);
            CHECK_NEAR(there.position[1], y, 1e-4);
            CHECK_NEAR(pixels[row * SIZE + column], there.displacement, 2e-3);
            highest = fmaxf(highest, pixels[row * SIZE + column]);
        }
    }
    CHECK(highest > 0.4f && pixels[0] == 0.0f);
    bake.quantity = RLV_BAKE_VECTOR;
    CHECK_OK(rlv_bake_run(detail, &bake, keep, NULL, &channels, NULL));
    /* Tangent, normal, bitangent. */
    const float *middle = pixels + 3 * (SIZE / 2 * SIZE + SIZE / 2);
    CHECK(channels == 3 && middle[0] == 0.0f && middle[2] == 0.0f);
    CHECK_NEAR(middle[1], highest, 0.02);
    bake.quantity = RLV_BAKE_NORMAL;
    CHECK_OK(rlv_bake_run(detail, &bake, keep, NULL, &channels, NULL));
    CHECK_NEAR(pixels[2], 1.0, 1e-5);
    /* East of the hill it looks east, and as far as west of it west. */
    const float east = pixels[3 * (SIZE / 2 * SIZE + 40)], west = pixels[3 * (SIZE / 2 * SIZE + 23)];
    CHECK(east > 0.1f);
    CHECK_NEAR(east, -west, 0.05);
    bake.quantity = RLV_BAKE_COLOR;
    CHECK_OK(rlv_bake_run(detail, &bake, keep, NULL, &channels, NULL));
    CHECK(channels == 4 && pixels[0] == 1.0f && pixels[3] == 1.0f);
    bake.quantity = RLV_BAKE_TIME;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bake_run(detail, &bake, keep, NULL, &channels, NULL), "traces");
    bake.quantity = RLV_BAKE_DISPLACEMENT;
    bake.samples = 2;
    snprintf(path, sizeof path, "sheet-%p.png", (void *)&channels);
    CHECK_OK(rlv_bake_write(detail, &bake, path, NULL, NULL, &report));
    CHECK(check_removed(path) && report.scale > 0.9f && report.mid_level == 0.5f);
    CHECK_OK(rlv_brush_release(brush));
    CHECK_OK(rlv_detail_release(detail));
}

/* Contact, depth and age at the first corner of a triangle: of the 20th, the middle of the sheet. */
static void trace_at(RlvDetail detail, uint32_t tile, float out[3]) {
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    arrays.traces = out;
    check_evaluate(detail, tile, 0.0f, 0.0f, arrays);
}

/* Imprints leave traces on triangles: evaluated, baked and tessellated, and older with time. */
static void traces(RlvContext context, RlvSurface surface) {
    RlvDetail detail = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvCollider collider = RLV_NULL;
    RlvChannelInfo channel = RLV_CHANNEL_INFO_INIT;
    RlvTessellation followed = RLV_NULL;
    RlvBakeOptions bake = RLV_BAKE_OPTIONS_INIT;
    RlvMesh ball = check_ball_of(context, 0.8, 16, 32), mesh = RLV_NULL;
    const double place[12] = CHECK_MOVED(2, 2, 0.6);
    uint32_t channels = 0, index = 0;
    float trace[3], bare[3];
    options.tile_size = 16;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_collider_create_mesh(context, ball, place, &collider));
    CHECK_OK(rlv_detail_add_traces(detail, 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_add_traces(detail, 0), "already");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_advance(detail, NAN), "time");
    CHECK_OK(rlv_detail_advance(detail, 2.0));
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, NULL));
    CHECK_OK(rlv_detail_advance(detail, 5.0));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_detail_channel_info(detail, RLV_CHANNEL_TRACES, &channel));
    CHECK(channel.is_there == 1 && channel.allocated_count > 0 && channel.bytes > 0);
    trace_at(detail, 20, trace);
    trace_at(detail, 0, bare);
    CHECK_NEAR(trace[0], 1.0, 1e-6);
    CHECK_NEAR(trace[1], 0.2, 0.03);
    CHECK(trace[2] == 3.0f && bare[0] == 0.0f && bare[1] == 0.0f && bare[2] == -1.0f);
    bake.width = bake.height = SIZE;
    bake.gutter = 0;
    bake.quantity = RLV_BAKE_TIME;
    CHECK_OK(rlv_bake_run(detail, &bake, keep, NULL, &channels, NULL));
    CHECK(channels == 1 && pixels[SIZE / 2 * SIZE + SIZE / 2] == 2.0f && pixels[0] == -1.0f);
    bake.quantity = RLV_BAKE_DEPTH;
    CHECK_OK(rlv_bake_run(detail, &bake, keep, NULL, &channels, NULL));
    CHECK_NEAR(pixels[SIZE / 2 * SIZE + SIZE / 2], trace[1], 0.02);

    /* Triangles have them, and get older. */
    CHECK_OK(rlv_tessellation_create(detail, NULL, &followed));
    CHECK_OK(rlv_detail_advance(detail, 6.0));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_tessellation_update(followed, NULL));
    RlvTessellationInfo info = RLV_TESSELLATION_INFO_INIT;
    CHECK_OK(rlv_tessellation_info(followed, &info));
    float *all = malloc(info.point_count * 12);
    CHECK(all != NULL);
    CHECK_OK(rlv_tessellation_get_traces(followed, 0, info.point_count, all, 0));
    size_t old = 0;
    for (size_t point = 0; point < info.point_count; ++point) {
        CHECK(all[3 * point + 2] == (all[3 * point] > 0.0f ? 4.0f : -1.0f));
        old += all[3 * point] > 0.0f;
    }
    CHECK(old > 20 && old < info.point_count);
    free(all);
    CHECK_OK(rlv_tessellate_detail(detail, NULL, &mesh));
    CHECK_OK(rlv_mesh_find_attribute(mesh, "age", &index));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_tessellation_release(followed));
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_detail_release(detail));
}

/* Edits of triangles fade linearly and give their blocks back. */
static void decay(RlvContext context, RlvSurface surface) {
    RlvDetail detail = RLV_NULL, reopened = RLV_NULL;
    RlvDocument document = RLV_NULL;
    char path[80];
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvDecayOptions times = RLV_DECAY_OPTIONS_INIT;
    RlvDetailInfo start = RLV_DETAIL_INFO_INIT, info = RLV_DETAIL_INFO_INIT;
    RlvBrushOptions draw = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvBrush brush = RLV_NULL;
    const RlvStrokePoint point = {{2.0, 2.0, 0.0}, 1.0, -1.0};
    RlvLayerOptions layer = RLV_LAYER_OPTIONS_INIT;
    uint32_t id = 0;
    options.tile_size = layer.tile_size = 16;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    times.duration = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_set_decay(detail, &times), "fade");
    times.duration = 2.0f;
    times.delay = 1.0f;
    CHECK_OK(rlv_detail_set_decay(detail, &times));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_set_decay(detail, &times), "already");
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_detail_info(detail, &start));
    draw.action = RLV_BRUSH_SCULPT;
    draw.height = 0.5f;
    settings.radius = 0.6f;
    CHECK_OK(rlv_brush_create(context, &draw, &settings, &brush));
    CHECK_OK(rlv_stroke_run(detail, brush, &point, 1, 0, NULL));
    CHECK_OK(rlv_detail_advance(detail, 1.0));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_detail_info(detail, &info));
    CHECK(info.time == 1.0 && info.stamp_bytes > start.stamp_bytes && info.allocated_count > 0);
    const float fresh = look(detail, 20, 0, 0, 0).displacement;
    CHECK(fresh > 0.4f);
    CHECK_OK(rlv_detail_advance(detail, 2.0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_advance(detail, 1.5), "before");
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_NEAR(look(detail, 20, 0, 0, 0).displacement, 0.5 * fresh, 1e-3);
    CHECK_OK(rlv_detail_advance(detail, 3.5));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_detail_info(detail, &info));
    CHECK(look(detail, 20, 0, 0, 0).displacement == 0.0f && info.allocated_count == 0);
    CHECK(info.bytes == start.bytes && info.stamp_bytes == start.stamp_bytes);
    /* Over a layer that fades, one that stays, which gets the edits then; the document keeps the stamps of the first. */
    CHECK_OK(rlv_document_create(detail, NULL, 0, &document));
    CHECK_OK(rlv_document_begin(document, "fades"));
    CHECK_OK(rlv_stroke_run(detail, brush, &point, 1, 0, NULL));
    CHECK_OK(rlv_document_end(document, NULL));
    CHECK_OK(rlv_document_undo(document, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK(look(detail, 20, 0, 0, 0).displacement == 0.0f);
    CHECK_OK(rlv_document_redo(document, NULL));
    CHECK_OK(rlv_document_begin(document, "stays"));
    CHECK_OK(rlv_layer_add(detail, "more", &layer, &id));
    CHECK_OK(rlv_stroke_run(detail, brush, &point, 1, 0, NULL));
    CHECK_OK(rlv_document_end(document, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    const float both = look(detail, 20, 0, 0, 0).displacement;
    CHECK(both > 1.1f * fresh);
    snprintf(path, sizeof path, "fading-triangles-%p.relievo", (void *)&context);
    CHECK_OK(rlv_document_save(document, path));
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_detail_advance(detail, 5.5));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    const float left = look(detail, 20, 0, 0, 0).displacement;
    CHECK_NEAR(left, both - 0.5 * fresh, 1e-3);
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &reopened));
    CHECK_OK(rlv_document_open(reopened, path, 0, &document));
    CHECK_OK(rlv_detail_advance(reopened, 5.5));
    CHECK_OK(rlv_detail_commit(reopened, NULL));
    CHECK(look(reopened, 20, 0, 0, 0).displacement == left);
    CHECK_OK(rlv_detail_advance(reopened, 9.0));
    CHECK_OK(rlv_detail_commit(reopened, NULL));
    CHECK_NEAR(look(reopened, 20, 0, 0, 0).displacement, both - fresh, 1e-3);
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_detail_release(reopened));
    remove(path);
    CHECK_OK(rlv_brush_release(brush));
    CHECK_OK(rlv_detail_release(detail));
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL, untouched = {77}, cage = RLV_NULL;
    RlvSurfaceOptions kind = RLV_SURFACE_OPTIONS_INIT;
    RlvSurfaceInfo about = RLV_SURFACE_INFO_INIT;
    RlvTileInfo tile = RLV_TILE_INFO_INIT;
    RlvDetail detail = RLV_NULL, copy = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvDetailInfo info = RLV_DETAIL_INFO_INIT;
    RlvDetailChanges changes = RLV_DETAIL_CHANGES_INIT;
    RlvChannelInfo channel = RLV_CHANNEL_INFO_INIT;
    RlvHit hit;
    char path[64];
    int patience = 0;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh sheet = check_sheet(context, 4, 4, 0.0f);
    kind.kind = RLV_SURFACE_TRIANGLES;
    CHECK_OK(rlv_surface_create(context, sheet, &kind, &surface));
    bakes(context, surface);
    traces(context, surface);
    decay(context, surface);
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(sheet));
    /* Few triangles: the test runs under Valgrind too. */
    const uint32_t rows = 18, columns = 24;
    RlvMesh ball = check_ball_of(context, 1.0, rows, columns), small = check_ball_of(context, 0.4, 16, 32), split = RLV_NULL, plane = check_plane(context, 2, 2);
    const size_t faces = 2 * (rows - 1) * columns;

    /* The surface. */
    kind.kind = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_surface_create(context, ball, &kind, &untouched), "kind of surface");
    CHECK(untouched.id == 77);
    kind.kind = RLV_SURFACE_TRIANGLES;
    CHECK_OK(rlv_surface_create(context, ball, &kind, &surface));
    CHECK_OK(rlv_surface_info(surface, &about));
    CHECK(about.kind == RLV_SURFACE_TRIANGLES && about.tile_count == faces && about.face_count == faces);
    CHECK(about.point_count == faces / 2 + 2 && about.non_manifold == 0);
    CHECK_NEAR(about.extent, sqrt(12.0), 1e-3);
    CHECK_OK(rlv_surface_tile_info(surface, 17, &tile));
    CHECK(tile.face == 17 && tile.is_part == 0 && tile.low[2] < tile.high[2]);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_surface_tile_info(surface, (uint32_t)faces, &tile), "does not exist");
    uint32_t first = 0, count = 0;
    CHECK_OK(rlv_surface_face_tiles(surface, 17, &first, &count));
    CHECK(first == 17 && count == 1);
    const float places[4] = {0.25f, 0.5f, 0.75f, 0.5f};
    const uint32_t tiles[2] = {3, 3};
    float out[2][3], du[2][3];
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    arrays.count = 1;
    arrays.tiles = tiles;
    arrays.uvs = places;
    arrays.positions = out[0];
    arrays.normals = out[1];
    arrays.du = du[0];
    arrays.dv = du[1];
    CHECK_OK(rlv_evaluate_surface(surface, &arrays));
    CHECK_NEAR(out[1][0] * out[1][0] + out[1][1] * out[1][1] + out[1][2] * out[1][2], 1.0, 1e-5);
    CHECK_NEAR(out[0][0] * out[1][0] + out[0][1] * out[1][1] + out[0][2] * out[1][2], 1.0, 1e-2);
    CHECK(du[0][0] * out[1][0] + du[0][1] * out[1][1] + du[0][2] * out[1][2] < 0.1f);
    arrays.count = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_evaluate_surface(surface, &arrays), "make at most 1");

    /* Polygons are fans. */
    CHECK_OK(rlv_surface_create(context, plane, &kind, &cage));
    CHECK_OK(rlv_surface_info(cage, &about));
    CHECK(about.tile_count == 8 && about.face_count == 4);
    CHECK_OK(rlv_surface_face_tiles(cage, 3, &first, &count));
    CHECK(first == 6 && count == 2);
    CHECK_OK(rlv_surface_tile_info(cage, 7, &tile));
    CHECK(tile.face == 3);
    CHECK_OK(rlv_surface_release(cage));
    CHECK_OK(rlv_mesh_split(plane, 0.5, &split));
    RlvMeshInfo pieces = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(split, &pieces));
    CHECK(pieces.face_count >= 64 && pieces.high[0] == 2.0f);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_split(plane, NAN, &split), "NaN");
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_mesh_split(plane, 1e-9, &split), "longer");
    CHECK_OK(rlv_mesh_release(split));
    too_large_to_split();

    /* A detail on it. */
    options.tile_size = 9;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_create(surface, &options, NULL, &copy), "9 segments");
    options.tile_size = 8;
    const uint32_t sizes[2] = {3, 8};
    options.face_sizes = sizes;
    options.face_size_count = 1;
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_detail_create(surface, &options, NULL, &copy), "face_sizes");
    options.face_sizes = NULL;
    options.face_size_count = 0;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, NULL));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_add_paint(detail, NULL), "already");
    CHECK_OK(rlv_detail_add_vectors(detail, NULL));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_add_vectors(detail, NULL), "already");
    RlvTessellation followed = RLV_NULL;
    RlvTessellationChanges renewed = RLV_TESSELLATION_CHANGES_INIT;
    CHECK_OK(rlv_tessellation_create(detail, NULL, &followed));
    stroke(context, detail, RLV_BRUSH_SCULPT, 0.02f);
    stroke(context, detail, RLV_BRUSH_PAINT, 0.0f);
    stroke_of(context, detail, RLV_BRUSH_SCULPT, 0.01f, 0.3f, SIDE);
    RlvDetailInfo nothing = RLV_DETAIL_INFO_INIT;
    CHECK_OK(rlv_detail_info(detail, &nothing));
    CHECK(nothing.allocated_count == 0 && nothing.tile_count == faces);
    CHECK_OK(rlv_detail_commit(detail, &changes));
    CHECK_OK(rlv_detail_info(detail, &info));
    CHECK(info.is_painted == 1 && info.allocated_count > 4 && info.painted_count > 4 && info.bytes > nothing.bytes);
    CHECK(info.bytes < info.full_bytes && info.revision > nothing.revision);
    CHECK(changes.tile_count > info.allocated_count / 2 && changes.high[2] > 1.05f && changes.moved == 0);
    CHECK_OK(rlv_detail_channel_info(detail, RLV_CHANNEL_VECTORS, &channel));
    CHECK(channel.is_there == 1 && channel.allocated_count == 0);
    CHECK(radius(detail, 0, 0, 1, &hit) > 1.05f && hit.face == hit.tile && hit.u + hit.v <= 1.0f);
    /* Face 1 is at the other pole. */
    const Look raised = look(detail, hit.tile, hit.u, hit.v, 1), bare = look(detail, 1, 0.2f, 0.3f, 1);
    CHECK(raised.displacement > 0.05f && raised.color[1] < 0.9f && bare.displacement == 0.0f && bare.color[1] == 1.0f);
    for (int axis = 0; axis < 3; ++axis) {
        CHECK_NEAR(raised.position[axis], hit.position[axis], 5e-3);
        CHECK(raised.vector[axis] == 0.0f);
    }
    arrays.count = 1;
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_evaluate_detail(detail, &arrays), "derivatives");

    /* Triangles follow, are closed, and have the colours. */
    CHECK_OK(rlv_tessellation_update(followed, &renewed));
    CHECK(renewed.rebuilt == 1 && renewed.high[2] > 1.05f);
    same_points(followed, detail);
    /* Smaller, so that no face is divided that was not. */
    stroke_of(context, detail, RLV_BRUSH_SCULPT, 0.01f, 0.2f, POLE);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    stroke_of(context, detail, RLV_BRUSH_PAINT, 0.0f, 0.2f, POLE);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_tessellation_update(followed, &renewed));
    RlvTessellationInfo kept = RLV_TESSELLATION_INFO_INIT;
    CHECK_OK(rlv_tessellation_info(followed, &kept));
    CHECK(renewed.rebuilt == 0 && renewed.point_count > 100 && renewed.point_count < kept.point_count);
    same_points(followed, detail);
    /* What changed alone, though all vertices around it are kept in one block. */
    stroke_of(context, detail, RLV_BRUSH_SCULPT, 0.01f, 0.2f, SIDE);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_tessellation_update(followed, &renewed));
    CHECK(renewed.rebuilt == 0 && renewed.point_count > 100 && renewed.point_count < kept.point_count / 4);
    same_points(followed, detail);
    CHECK_OK(rlv_tessellation_update(followed, &renewed));
    CHECK(renewed.rebuilt == 0 && renewed.point_count == 0);
    RlvTessellateOptions with = RLV_TESSELLATE_OPTIONS_INIT;
    RlvMesh mesh = RLV_NULL;
    uint32_t index = 0;
    with.places = 1;
    CHECK_OK(rlv_tessellate_detail(detail, &with, &mesh));
    CHECK(is_closed(mesh));
    CHECK_OK(rlv_mesh_find_attribute(mesh, "color", &index));
    CHECK_OK(rlv_mesh_find_attribute(mesh, "tile_uv", &index));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_tessellate_surface(surface, NULL, &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &pieces));
    CHECK(pieces.triangle_count == faces && is_closed(mesh));
    CHECK_OK(rlv_mesh_release(mesh));

    /* Pressed in, at once and on the way; a cancelled way leaves nothing. */
    RlvCollider collider = RLV_NULL;
    RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
    const double place[12] = CHECK_MOVED(1.2, 0, 0), away[12] = CHECK_MOVED(0, 1.2, 0);
    CHECK_OK(rlv_collider_create_mesh(context, small, place, &collider));
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, &report));
    CHECK(report.changed_coefficients > 100 && report.refused_tiles == 0 && report.triangles > 0);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_NEAR(radius(detail, 1, 0, 0, &hit), 0.8, 0.03);
    /* It is asked before every sub-step and at the end. */
    int steps = 1000;
    CHECK_OK(rlv_imprint_sweep(detail, collider, place, place, NULL, NULL, check_patience, &steps, &report));
    CHECK(report.steps == 1 && steps == 998);
    for (patience = 0; patience < 4; ++patience) {
        int left = patience;
        CHECK_FAILS(RLV_ERROR_CANCELLED,
                    rlv_imprint_sweep(detail, collider, place, away, NULL, NULL, check_patience, &left, NULL), "cancel");
        CHECK(left == -1);
        CHECK_OK(rlv_detail_commit(detail, NULL));
        CHECK_NEAR(radius(detail, 0, 1, 0, &hit), 1.0, 0.01);
    }
    steps = 1000;
    CHECK_OK(rlv_imprint_sweep(detail, collider, place, away, NULL, NULL, check_patience, &steps, &report));
    CHECK(report.steps > 4 && steps == 1000 - (int)report.steps - 1);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    /* The lowest point over the way, where x = 0.4 / sqrt(2). */
    CHECK_NEAR(radius(detail, 0, 1, 0, &hit), 1.2 - 0.8 / sqrt(2.0), 0.02);
    CHECK(report.pushed_volume == 0.0 && report.raised_volume == 0.0);
    rim(context, surface, small);

    /* Undone to the bit, and back from a file into a bare detail. */
    RlvDocument document = RLV_NULL, again = RLV_NULL;
    RlvDocumentChanges edit = RLV_DOCUMENT_CHANGES_INIT;
    CHECK_OK(rlv_document_create(detail, NULL, 0, &document));
    const Look before = look(detail, hit.tile, hit.u, hit.v, 1);
    CHECK_OK(rlv_document_begin(document, "a stroke"));
    stroke(context, detail, RLV_BRUSH_SCULPT, 0.03f);
    CHECK_OK(rlv_document_end(document, &edit));
    CHECK(edit.is_done == 1 && edit.block_count > 4);
    CHECK_OK(rlv_document_undo(document, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    const Look undone = look(detail, hit.tile, hit.u, hit.v, 1);
    CHECK(memcmp(&before, &undone, sizeof before) == 0);
    snprintf(path, sizeof path, "triangles-%p.relievo", (void *)&context);
    CHECK_OK(rlv_document_save(document, path));
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &copy));
    CHECK_OK(rlv_document_open(copy, path, 0, &again));
    CHECK_OK(rlv_detail_commit(copy, NULL));
    const Look opened = look(copy, hit.tile, hit.u, hit.v, 1);
    CHECK(memcmp(&before, &opened, sizeof before) == 0);
    CHECK_OK(rlv_document_redo(again, &edit));
    CHECK(edit.is_done == 1);
    CHECK_OK(rlv_document_release(again));

    /* Layers. */
    RlvLayerOptions half = RLV_LAYER_OPTIONS_INIT;
    size_t layers = 0;
    uint32_t id = 0;
    half.opacity = 0.5f;
    CHECK_OK(rlv_layer_add(copy, "more", &half, &id));
    CHECK_OK(rlv_layer_count(copy, &layers));
    CHECK(layers == 3);
    stroke(context, copy, RLV_BRUSH_SCULPT, 0.03f);
    half.is_visible = 0;
    CHECK_OK(rlv_layer_set(copy, id, &half));
    /* Into a hidden layer nothing is pressed, and nothing is noted of it. */
    CHECK_OK(rlv_detail_add_traces(copy, 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_imprint_run(copy, collider, NULL, NULL, NULL), "cannot be seen");
    CHECK_OK(rlv_detail_commit(copy, NULL));
    CHECK_OK(rlv_detail_channel_info(copy, RLV_CHANNEL_TRACES, &channel));
    CHECK(channel.is_there == 1 && channel.allocated_count == 0);
    CHECK_OK(rlv_layer_remove(copy, id));

    /* Another mesh, and cages, are refused; so are files of theirs. */
    RlvDetail other = RLV_NULL;
    CHECK_OK(rlv_surface_create(context, ball, NULL, &cage));
    CHECK_OK(rlv_detail_create(cage, NULL, NULL, &other));
    CHECK(rlv_document_open(other, path, 0, &again) != RLV_OK);
    CHECK_OK(rlv_detail_release(other));
    CHECK_OK(rlv_surface_release(cage));
    CHECK(check_removed(path));

    /* Poses, transforms and budgets. */
    float *points = malloc((faces / 2 + 2) * 12);
    CHECK(points != NULL);
    CHECK_OK(rlv_mesh_get_points(ball, points, faces / 2 + 2, 0));
    for (size_t number = 0; number < faces / 2 + 2; ++number) {
        points[3 * number + 2] += 5.0f;
    }
    CHECK_OK(rlv_detail_set_points(detail, points, faces / 2 + 2, 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_detail_set_points(detail, points, 5, 0), "5 points");
    CHECK_OK(rlv_detail_set_transform(detail, place));
    CHECK_OK(rlv_detail_commit(detail, &changes));
    CHECK(changes.moved == 1);
    CHECK_OK(rlv_tessellation_update(followed, &renewed));
    CHECK(renewed.low[2] > 3.5f);
    same_points(followed, detail);
    CHECK_OK(rlv_surface_set_points(surface, points, faces / 2 + 2, 0));
    CHECK_OK(rlv_surface_info(surface, &about));
    CHECK(about.low[2] > 3.9f);
    free(points);

    /* Faces and their edges leave memory, and are read all the same. */
    CHECK_OK(rlv_detail_channel_info(detail, RLV_CHANNEL_DISPLACEMENT, &channel));
    const uint64_t before_paging = channel.bytes;
    CHECK(channel.paged_count == 0);
    CHECK_OK(rlv_detail_set_paging(detail, 1, NULL));
    CHECK_OK(rlv_detail_set_budget(detail, 1));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_detail_channel_info(detail, RLV_CHANNEL_DISPLACEMENT, &channel));
    CHECK(channel.paged_count == channel.allocated_count && channel.paged_count > 0 && channel.bytes < before_paging);
    same_points(followed, detail);
    CHECK_OK(rlv_detail_set_paging(detail, 0, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_detail_channel_info(detail, RLV_CHANNEL_DISPLACEMENT, &channel));
    CHECK(channel.paged_count == 0 && channel.bytes == before_paging);

    /* What they lack is said. */
    RlvBakeOptions bake = RLV_BAKE_OPTIONS_INIT;
    RlvDetailTileInfo state = RLV_DETAIL_TILE_INFO_INIT;
    unsigned char block[64] = {0};
    size_t size = 0;
    CHECK_OK(rlv_detail_tile_info(detail, RLV_CHANNEL_DISPLACEMENT, hit.tile, &state));
    CHECK(state.is_allocated == 1 && state.size == 8 && state.low[2] < state.high[2]);
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_detail_read_block(detail, RLV_CHANNEL_DISPLACEMENT, 0, block, 64, &size), "document");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_detail_write_block(detail, RLV_CHANNEL_DISPLACEMENT, 0, block, 64), "triangle");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_detail_set_face_sizes(detail, sizes, 1, 0), "triangle");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bake_write(detail, &bake, "bake.exr", NULL, NULL, NULL), "uv");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_ptex_write(detail, RLV_CHANNEL_DISPLACEMENT, "a.ptx", NULL, NULL), "triangle");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_imprint_collide(detail, copy, NULL, NULL, NULL, NULL, NULL), "triangle");

    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_collider_create_detail(copy, NULL, &collider));
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_collider_create_surface(surface, NULL, NULL, &collider));
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_tessellation_release(followed));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_detail_release(copy));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_mesh_release(small));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
