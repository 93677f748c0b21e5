/* Levels: finer, coarser and for a view, in the caller's buffers, edited, sculpted, taken back, settled, and refused. */
#include "sheet.h"

/* Buffers with more between their numbers, and something behind their ends. */
typedef struct Kept {
    RlvLevelBuffers buffers;
    RlvLevelUpdate update;
    float *vertices; /* point, normal, one more */
    uint32_t *triangles;
    size_t reported; /* vertices in the ranges of the last update */
} Kept;

enum { VERTEX = 7, TRIANGLE = 4 };

static Kept make_room(size_t vertices, size_t triangles) {
    Kept kept = {RLV_LEVEL_BUFFERS_INIT, RLV_LEVEL_UPDATE_INIT, NULL, NULL, 0};
    kept.vertices = malloc((vertices + 1) * VERTEX * sizeof(float));
    kept.triangles = malloc((triangles + 1) * TRIANGLE * sizeof(uint32_t));
    CHECK(kept.vertices != NULL && kept.triangles != NULL);
    for (size_t k = 0; k < (vertices + 1) * VERTEX; ++k) {
        kept.vertices[k] = 99.0f;
    }
    for (size_t k = 0; k < (triangles + 1) * TRIANGLE; ++k) {
        kept.triangles[k] = 99;
    }
    kept.buffers.points = kept.vertices;
    kept.buffers.normals = kept.vertices + 3;
    kept.buffers.point_stride = kept.buffers.normal_stride = VERTEX * sizeof(float);
    kept.buffers.vertex_capacity = vertices;
    kept.buffers.triangles = kept.triangles;
    kept.buffers.triangle_stride = TRIANGLE * sizeof(uint32_t);
    kept.buffers.triangle_capacity = triangles;
    return kept;
}

/* The ranges of a domain begin and end where the update says, have more than 8 elements between them, and all rows of a
 * buffer that differ from before are in them. Returns how many elements they have. */
static size_t check_ranges(RlvLevel level, uint32_t domain, const size_t told[2], const void *before, const void *now,
                           size_t row, size_t rows) {
    size_t count = 0, element = 0, all = 0;
    CHECK_OK(rlv_level_changed_ranges(level, domain, NULL, 0, &count));
    uint32_t *ranges = malloc(count * 8 + 8);
    CHECK(ranges != NULL);
    CHECK_OK(rlv_level_changed_ranges(level, domain, ranges, count, &count));
    CHECK((count == 0) == (told[1] == 0));
    for (size_t range = 0; range <= count; ++range) {
        const size_t first = range < count ? ranges[2 * range] : rows;
        CHECK(range > 0 || count == 0 || first == told[0]);
        CHECK(range == 0 || range == count || first > element + 8);
        for (; element < first; ++element) {
            CHECK(memcmp((const char *)before + row * element, (const char *)now + row * element, row) == 0);
        }
        if (range < count) {
            CHECK(ranges[2 * range + 1] > 0);
            element += ranges[2 * range + 1];
            all += ranges[2 * range + 1];
            CHECK(range + 1 < count || element == told[0] + told[1]);
        }
    }
    if (count > 0) {
        size_t needed = 77;
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_changed_ranges(level, domain, ranges, count - 1, &needed), "ranges");
        CHECK(needed == count);
    }
    free(ranges);
    return all;
}

/* Six times the volume within the triangles; every number is where it should be, and nothing else was written. */
static double check_update(RlvLevel level, Kept *kept) {
    RlvLevelInfo info = RLV_LEVEL_INFO_INIT;
    const size_t rows[2] = {kept->buffers.vertex_capacity, kept->buffers.triangle_capacity};
    const size_t bytes[2] = {VERTEX * sizeof(float), TRIANGLE * sizeof(uint32_t)};
    void *before[2] = {malloc(rows[0] * bytes[0]), malloc(rows[1] * bytes[1])};
    CHECK(before[0] != NULL && before[1] != NULL);
    memcpy(before[0], kept->vertices, rows[0] * bytes[0]);
    memcpy(before[1], kept->triangles, rows[1] * bytes[1]);
    CHECK_OK(rlv_level_update(level, &kept->buffers, &kept->update));
    const size_t told[2][2] = {{kept->update.first_vertex, kept->update.changed_vertex_count},
                               {kept->update.first_triangle, kept->update.changed_triangle_count}};
    kept->reported = check_ranges(level, RLV_DOMAIN_POINT, told[0], before[0], kept->vertices, bytes[0], rows[0]);
    check_ranges(level, RLV_DOMAIN_FACE, told[1], before[1], kept->triangles, bytes[1], rows[1]);
    free(before[0]), free(before[1]);
    CHECK_OK(rlv_level_info(level, &info));
    const RlvLevelUpdate *update = &kept->update;
    CHECK(update->vertex_count == info.vertex_count && update->triangle_count == info.triangle_count);
    CHECK(update->first_vertex + update->changed_vertex_count <= update->vertex_count);
    CHECK(update->first_triangle + update->changed_triangle_count <= update->triangle_count);
    double volume = 0.0;
    for (size_t k = 0; k < info.triangle_count; ++k) {
        const uint32_t *corners = kept->triangles + k * TRIANGLE;
        const float *p[3];
        for (int side = 0; side < 3; ++side) {
            CHECK(corners[side] < info.vertex_count);
            p[side] = kept->vertices + corners[side] * VERTEX;
        }
        CHECK(corners[3] == 99);
        volume += p[0][0] * ((double)p[1][1] * p[2][2] - (double)p[1][2] * p[2][1]) +
                  p[0][1] * ((double)p[1][2] * p[2][0] - (double)p[1][0] * p[2][2]) +
                  p[0][2] * ((double)p[1][0] * p[2][1] - (double)p[1][1] * p[2][0]);
    }
    for (size_t k = 0; k < info.vertex_count; ++k) {
        const float *n = kept->vertices + k * VERTEX + 3;
        CHECK_NEAR(n[0] * n[0] + n[1] * n[1] + n[2] * n[2], 1.0, 1e-4);
        CHECK(n[3] == 99.0f);
    }
    CHECK(kept->vertices[kept->buffers.vertex_capacity * VERTEX] == 99.0f);
    CHECK(kept->triangles[kept->buffers.triangle_capacity * TRIANGLE] == 99);
    return volume;
}

/* The largest height of a mesh. */
static float highest(RlvMesh mesh) {
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(mesh, &info));
    return info.high[2];
}

/* Strokes at a coarse level are seen at the finest one; each is one edit. */
static void check_strokes(RlvContext context, RlvProgressive ball) {
    RlvLevel level = RLV_NULL;
    RlvBrush brush = RLV_NULL, paint = RLV_NULL;
    RlvMesh mesh = RLV_NULL;
    RlvLevelInfo info = RLV_LEVEL_INFO_INIT;
    RlvBrushOptions options = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    CHECK_OK(rlv_brush_create(context, &options, NULL, &paint));
    options.action = RLV_BRUSH_SCULPT;
    options.mode = RLV_SCULPT_DRAW;
    options.height = 0.25f;
    settings.radius = 0.5f;
    settings.symmetry_x = 1;
    CHECK_OK(rlv_brush_create(context, &options, &settings, &brush));
    CHECK_OK(rlv_level_create(ball, &level));
    CHECK_OK(rlv_level_set_triangles(level, 500));

    /* Points between others, as a host may have them. */
    RlvStrokePoint points[4] = {{{0, 0, 1}, 1, -1}, {{9, 9, 9}, 9, 9}, {{0, 0, 9}, 1, -1}, {{9, 9, 9}, 9, 9}};
    RlvLevelSculpted done = RLV_LEVEL_SCULPTED_INIT;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_sculpt(level, brush, points, 0, 0, &done), "points");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_sculpt(level, brush, NULL, 1, 0, &done), "points");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_sculpt(level, brush, points + 2, 1, 0, &done), "no vertex is in the brush");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_sculpt(level, paint, points, 1, 0, &done), "no colours");
    points[0].pressure = NAN;
    CHECK(rlv_level_sculpt(level, brush, points, 1, 0, NULL) == RLV_ERROR_INVALID && done.dabs == 0);
    points[0].pressure = 1;
    CHECK_OK(rlv_level_info(level, &info));
    CHECK(info.undo_count == 0);

    /* The pole is at the middle of the dab, and of its mirror image before it rises. */
    points[2] = (RlvStrokePoint){{0, 0.05, 1}, 1, -1};
    CHECK_OK(rlv_level_sculpt(level, brush, points, 2, 2 * sizeof(RlvStrokePoint), &done));
    CHECK(done.dabs == 2 && done.missed_dabs == 0 && done.vertices > 10);
    CHECK_OK(rlv_level_info(level, &info));
    CHECK(info.undo_count == 1);
    CHECK_OK(rlv_level_set_triangles(level, SIZE_MAX));
    CHECK_OK(rlv_level_mesh(level, &mesh));
    const float top = highest(mesh);
    CHECK(top > 1.3f && top < 1.5f);
    CHECK_OK(rlv_mesh_release(mesh));
    /* Erased it is as it was built, and taken back as it was sculpted. */
    options.mode = RLV_SCULPT_ERASE;
    settings.symmetry_x = 0;
    settings.radius = 3.0f;
    CHECK_OK(rlv_brush_set(brush, &options, &settings));
    CHECK_OK(rlv_level_sculpt(level, brush, points, 1, 0, NULL));
    CHECK_OK(rlv_level_mesh(level, &mesh));
    CHECK(highest(mesh) < 1.1f);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_level_undo(level));
    CHECK_OK(rlv_level_mesh(level, &mesh));
    CHECK(highest(mesh) == top);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_level_release(level));
    CHECK_OK(rlv_brush_release(brush));
    CHECK_OK(rlv_brush_release(paint));
}

/* A handle with keys: at half of the time the pole has half of the way, and at rest all is as it was. */
static void check_motions(RlvProgressive ball) {
    RlvLevel level = RLV_NULL;
    RlvMesh mesh = RLV_NULL;
    RlvLevelInfo info = RLV_LEVEL_INFO_INIT;
    RlvLevelKey keys[2] = {{1.0, {0, 0, 0}, {0, 0, 1}, 0.0f, 0}, {3.0, {0, 0, 0.5f}, {0, 0, 1}, 0.3f, 0}};
    RlvLevelTrack track = {{{0, 0, 1}, 0.9f, RLV_FALLOFF_SMOOTH}, keys, 2, 0};
    RlvLevelMotion motion = RLV_LEVEL_MOTION_INIT;
    size_t reached = 7;
    motion.tracks = &track;
    motion.track_count = 1;
    CHECK_OK(rlv_level_create(ball, &level));
    CHECK_OK(rlv_level_set_triangles(level, 500));
    CHECK_OK(rlv_level_add_motion(level, &motion));
    CHECK_OK(rlv_level_set_triangles(level, SIZE_MAX));
    const double times[] = {2.0, 0.0, 9.0, 1.0};
    const double heights[] = {1.25, 1.0, 1.5, 1.0};
    for (int k = 0; k < 4; ++k) {
        CHECK_OK(rlv_level_set_time(level, times[k], &reached));
        CHECK((reached > 10) == (heights[k] > 1.0));
        CHECK_OK(rlv_level_mesh(level, &mesh));
        CHECK_NEAR(highest(mesh), heights[k], 1e-3);
        CHECK_OK(rlv_mesh_release(mesh));
    }
    CHECK_OK(rlv_level_set_time(level, 9.0, NULL));
    CHECK_OK(rlv_level_info(level, &info));
    CHECK(info.undo_count == 0);
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_level_undo(level), "no edit to take back");
    CHECK_OK(rlv_level_set_time(level, 9.0, NULL));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_set_time(level, NAN, NULL), "time");
    keys[1].time = 1.0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_add_motion(level, &motion), "later than the one before");
    track.keys = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_add_motion(level, &motion), "handle 0");
    track.key_count = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_add_motion(level, &motion), "one key or more");
    motion.tracks = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_add_motion(level, &motion), "tracks");
    CHECK_OK(rlv_level_set_time(level, 9.0, &reached));
    CHECK(reached > 10);
    CHECK_OK(rlv_level_clear_motions(level));
    CHECK_OK(rlv_level_set_time(level, 9.0, &reached));
    CHECK(reached == 0);
    CHECK_OK(rlv_level_mesh(level, &mesh));
    CHECK_NEAR(highest(mesh), 1.0, 1e-6);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_level_release(level));
}

/* Colours with a seam and materials in halves: those of the finest level, and of another, in the caller's buffers. */
static void check_attributes(RlvContext context) {
    RlvMesh mesh = check_ball(context, 1.0), made = RLV_NULL;
    RlvMeshInfo given = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(mesh, &given));
    float *points = malloc(given.point_count * 12), *colors = malloc(given.corner_count * 12);
    uint32_t *corners = malloc(given.corner_count * 4), *materials = malloc(given.face_count * 4);
    CHECK(points != NULL && colors != NULL && corners != NULL && materials != NULL);
    CHECK_OK(rlv_mesh_get_points(mesh, points, given.point_count, 0));
    CHECK_OK(rlv_mesh_get_faces(mesh, NULL, 0, corners, given.corner_count));
    for (size_t face = 0; face < given.face_count; ++face) {
        float low = 0.0f;
        for (size_t corner = 3 * face; corner < 3 * face + 3; ++corner) {
            low += points[3 * corners[corner] + 2];
        }
        materials[face] = low < 0.0f;
        for (size_t k = 0; k < 9; ++k) {
            colors[9 * face + k] = points[3 * corners[3 * face + k / 3] + k % 3] + (float)(10 * materials[face]);
        }
    }
    RlvAttributeArrays color = RLV_ATTRIBUTE_ARRAYS_INIT, material = RLV_ATTRIBUTE_ARRAYS_INIT;
    color.domain = RLV_DOMAIN_CORNER;
    color.type = RLV_TYPE_F32;
    color.width = 3;
    color.name = "color";
    color.values = colors;
    color.value_count = given.corner_count;
    material.domain = RLV_DOMAIN_FACE;
    material.type = RLV_TYPE_U32;
    material.width = 1;
    material.name = "material";
    material.values = materials;
    material.value_count = given.face_count;
    CHECK_OK(rlv_mesh_add_attribute(mesh, &material));
    CHECK_OK(rlv_mesh_add_attribute(mesh, &color));

    RlvProgressiveOptions options = RLV_PROGRESSIVE_OPTIONS_INIT;
    RlvSimplifyWeight weight = {"color", 0.01f, 0};
    RlvProgressive whole = RLV_NULL, untouched = {77};
    RlvProgressiveInfo info = RLV_PROGRESSIVE_INFO_INIT;
    RlvAttributeInfo first = RLV_ATTRIBUTE_INFO_INIT, second = RLV_ATTRIBUTE_INFO_INIT;
    options.keeps_attributes = 1;
    options.weights = &weight;
    options.weight_count = 1;
    CHECK_OK(rlv_progressive_create(mesh, &options, NULL, NULL, &whole));
    CHECK_OK(rlv_progressive_info(whole, &info));
    CHECK(info.attribute_count == 2 && info.wedge_width == 3 && info.face_width == 1);
    CHECK(info.wedge_count == info.vertex_count + BALL_COLUMNS);
    CHECK_OK(rlv_progressive_attribute_info(whole, 0, &first));
    CHECK_OK(rlv_progressive_attribute_info(whole, 1, &second));
    CHECK(strcmp(first.name, "color") == 0 && first.domain == RLV_DOMAIN_CORNER && first.value_count == info.wedge_count);
    CHECK(strcmp(second.name, "material") == 0 && second.type == RLV_TYPE_U32);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_progressive_attribute_info(whole, 2, &first), "attribute 2");
    weight.name = "nothing";
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_progressive_create(mesh, &options, NULL, NULL, &untouched), "`nothing`");
    options.keeps_attributes = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_progressive_create(mesh, &options, NULL, NULL, &untouched), "keeps_attributes");
    CHECK(untouched.id == 77);

    RlvLevel level = RLV_NULL;
    RlvLevelBuffers buffers = RLV_LEVEL_BUFFERS_INIT;
    RlvLevelUpdate update = RLV_LEVEL_UPDATE_INIT;
    uint32_t *triangles = malloc(info.triangle_count * 12), *wedges = malloc(info.triangle_count * 12);
    float *values = malloc(info.wedge_count * 16);
    CHECK(triangles != NULL && wedges != NULL && values != NULL);
    buffers.points = points;
    buffers.vertex_capacity = info.vertex_count;
    buffers.triangles = triangles;
    buffers.triangle_capacity = info.triangle_count;
    buffers.wedges = wedges;
    buffers.wedge_values = values;
    buffers.wedge_value_stride = 16;
    buffers.wedge_capacity = info.wedge_count - 1;
    buffers.face_values = materials;
    CHECK_OK(rlv_level_create(whole, &level));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_update(level, &buffers, &update), "wedge_values");
    buffers.wedge_capacity = info.wedge_count;
    const size_t sizes[3] = {SIZE_MAX, 800, SIZE_MAX};
    for (int step = 0; step < 3; ++step) {
        CHECK_OK(rlv_level_set_triangles(level, sizes[step]));
        CHECK_OK(rlv_level_update(level, &buffers, &update));
        CHECK(update.wedge_count <= info.wedge_count && update.changed_wedge_count > 0);
        const double tolerance = step == 1 ? 0.1 : 0.0;
        for (size_t corner = 0; corner < 3 * update.triangle_count; ++corner) {
            CHECK(wedges[corner] < update.wedge_count);
            for (size_t k = 0; k < 3; ++k) {
                const float expected = points[3 * triangles[corner] + k] + (float)(10 * materials[corner / 3]);
                CHECK_NEAR(values[4 * wedges[corner] + k], expected, tolerance);
            }
        }
    }
    CHECK_OK(rlv_level_mesh(level, &made));
    CHECK_OK(rlv_mesh_info(made, &given));
    CHECK(given.attribute_count == 3 && given.point_count == info.vertex_count);
    CHECK_OK(rlv_mesh_release(made));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_level_release(level));
    CHECK_OK(rlv_progressive_release(whole));
    free(points);
    free(colors);
    free(corners);
    free(materials);
    free(triangles);
    free(wedges);
    free(values);
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvProgressive ball = RLV_NULL, settled = RLV_NULL;
    RlvProgressiveInfo whole = RLV_PROGRESSIVE_INFO_INIT;
    RlvLevel level = RLV_NULL, other = RLV_NULL, untouched = {77};
    RlvLevelInfo info = RLV_LEVEL_INFO_INIT;
    RlvMesh mesh = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    mesh = check_ball(context, 1.0);
    /* The pole is there at all levels. */
    const uint32_t pole = 0;
    RlvProgressiveOptions options = RLV_PROGRESSIVE_OPTIONS_INIT;
    options.locked = &pole;
    options.locked_count = 1;
    CHECK_OK(rlv_progressive_create(mesh, &options, NULL, NULL, &ball));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_progressive_info(ball, &whole));
    CHECK_OK(rlv_level_create(ball, &level));
    CHECK_OK(rlv_level_info(level, &info));
    CHECK(info.triangle_count == whole.base_triangle_count && info.vertex_count == whole.base_vertex_count);

    /* A ball of radius 1 at all levels: 6 * 4/3 pi. */
    Kept kept = make_room(whole.vertex_count, whole.triangle_count);
    const double full = 25.13;
    CHECK_NEAR(check_update(level, &kept), full, 0.25 * full);
    CHECK(kept.update.changed_vertex_count == kept.update.vertex_count);
    CHECK_OK(rlv_level_set_triangles(level, 3000));
    double volume = check_update(level, &kept);
    CHECK_NEAR(volume, full, 0.01 * full);
    CHECK(kept.update.triangle_count <= 3000 && kept.update.triangle_count >= 2990);
    CHECK_OK(rlv_level_set_error(level, 0.01f));
    CHECK_NEAR(check_update(level, &kept), full, 0.05 * full);
    CHECK(kept.update.triangle_count < 2000);
    /* A bound is measured: a smaller one takes more triangles, and the finest mesh has no distance from itself. */
    float distance = -1.0f;
    size_t last = 0;
    const float bounds[] = {0.1f, 0.02f, 0.0f};
    for (int k = 0; k < 3; ++k) {
        CHECK_OK(rlv_level_set_bound(level, bounds[k], NULL, NULL, &distance));
        CHECK(distance >= 0.0f && distance <= bounds[k] + 1e-6f);
        check_update(level, &kept);
        CHECK(kept.update.triangle_count > last);
        last = kept.update.triangle_count;
    }
    CHECK_OK(rlv_level_set_bound(level, 0.1f, NULL, NULL, NULL));
    int patience = 1;
    CHECK(rlv_level_set_bound(level, 0.02f, check_patience, &patience, &distance) == RLV_ERROR_CANCELLED);
    CHECK_OK(rlv_level_set_triangles(level, SIZE_MAX));
    check_update(level, &kept);
    CHECK(kept.update.triangle_count == whole.triangle_count);
    CHECK_OK(rlv_level_set_triangles(level, 3000));
    CHECK(check_update(level, &kept) != 0.0);
    CHECK_OK(rlv_level_update(level, &kept.buffers, &kept.update));
    CHECK(kept.update.changed_vertex_count == 0 && kept.update.changed_triangle_count == 0);

    /* Finer where it is seen: above. */
    const float above[4] = {0, 0, 1, 0};
    RlvLevelView view = RLV_LEVEL_VIEW_INIT;
    view.eye[2] = 1.3f;
    view.planes = above;
    view.plane_count = 1;
    CHECK_OK(rlv_level_set_view(level, &view));
    check_update(level, &kept);
    size_t near = 0;
    for (size_t k = 0; k < kept.update.vertex_count; ++k) {
        near += kept.vertices[k * VERTEX + 2] > 0.0f;
    }
    CHECK(near > 2 * (kept.update.vertex_count - near));
    view.eye[1] = 1e300; /* which no float holds */
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_set_view(level, &view), "view");
    view.eye[1] = 0.0;

    /* What an edit moves is in ranges that are finer than from its first to its last vertex. */
    CHECK_OK(rlv_level_set_triangles(level, SIZE_MAX));
    check_update(level, &kept);
    RlvLevelHandle side = {{{1, 0, 0}, 0.3f, RLV_FALLOFF_SMOOTH}, {0.2f, 0, 0}, {0, 0, 1}, 0.0f, 0};
    RlvLevelEdit push = RLV_LEVEL_EDIT_INIT;
    push.handles = &side;
    push.handle_count = 1;
    size_t pushed = 0;
    CHECK_OK(rlv_level_edit(level, &push, &pushed));
    check_update(level, &kept);
    CHECK(kept.reported >= pushed && kept.reported <= 4 * pushed && 2 * kept.reported < kept.update.changed_vertex_count);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_changed_ranges(level, 3, NULL, 0, &last), "domain");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_changed_ranges(level, RLV_DOMAIN_POINT, NULL, 0, NULL), "count");
    CHECK_OK(rlv_level_undo(level));
    CHECK_OK(rlv_level_set_view(level, &view));
    check_update(level, &kept);

    /* The pole is pulled up at a coarse level, and turned; finer levels follow. */
    RlvLevelHandle handle = {{{0, 0, 1}, 0.9f, RLV_FALLOFF_SMOOTH}, {0, 0, 0.5f}, {0, 0, 1}, 0.3f, 0};
    RlvLevelRegion anchor = {{0, 1, 0}, 0.3f, RLV_FALLOFF_CONSTANT};
    RlvLevelEdit edit = RLV_LEVEL_EDIT_INIT;
    edit.handles = &handle;
    edit.handle_count = 1;
    edit.anchors = &anchor;
    edit.anchor_count = 1;
    size_t reached = 7;
    /* What is seen is edited there, and taken back there. */
    CHECK_OK(rlv_level_edit(level, &edit, &reached));
    CHECK(reached > 7);
    CHECK_OK(rlv_level_info(level, &info));
    CHECK(info.triangle_count == kept.update.triangle_count);
    CHECK_OK(rlv_level_mesh(level, &mesh));
    CHECK_NEAR(highest(mesh), 1.5, 1e-3);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_level_undo(level));
    CHECK_OK(rlv_level_info(level, &info));
    CHECK(info.triangle_count == kept.update.triangle_count && info.redo_count == 1);
    CHECK_OK(rlv_level_set_triangles(level, 500));
    CHECK_OK(rlv_level_edit(level, &edit, &reached));
    CHECK(reached > 10 && reached < 200);
    check_update(level, &kept);
    CHECK(kept.update.changed_triangle_count > 0);
    CHECK_OK(rlv_level_set_triangles(level, SIZE_MAX));
    CHECK_OK(rlv_level_mesh(level, &mesh));
    CHECK_NEAR(highest(mesh), 1.5, 1e-3);
    uint32_t normal = 7;
    CHECK_OK(rlv_mesh_find_attribute(mesh, "normal", &normal));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_level_info(level, &info));
    CHECK(info.undo_count == 1 && info.redo_count == 0);

    /* Splits of what was stretched are out of order, and in order where it is built anew. */
    RlvLevelMisplaced worst[3] = {{{77, 77, 77}, 77, 77}, {{77, 77, 77}, 77, 77}, {{77, 77, 77}, 77, 77}};
    size_t misplaced = 0, none = 7;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_misplaced(level, NULL, 2, &misplaced), "out");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_misplaced(level, worst, 2, NULL), "count");
    CHECK_OK(rlv_level_misplaced(level, worst, 2, &misplaced));
    CHECK(misplaced > 2 && worst[0].now >= worst[1].now && worst[1].now > 2 * worst[1].told && worst[2].now == 77);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_rebuild(level, NULL, NULL, NULL, NULL), "out");
    CHECK_OK(rlv_level_rebuild(level, &options, NULL, NULL, &settled));
    CHECK_OK(rlv_level_create(settled, &other));
    CHECK_OK(rlv_progressive_release(settled));
    CHECK_OK(rlv_level_misplaced(other, NULL, 0, &none));
    CHECK(none == 0);
    CHECK_OK(rlv_level_mesh(other, &mesh));
    CHECK_NEAR(highest(mesh), 1.5, 1e-3);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_level_release(other));

    /* Settled it is the same without the level, and others are as they were. */
    CHECK_OK(rlv_level_settle(level, &settled));
    CHECK_OK(rlv_level_create(settled, &other));
    CHECK_OK(rlv_progressive_release(settled));
    CHECK_OK(rlv_level_set_triangles(other, SIZE_MAX));
    CHECK_OK(rlv_level_mesh(other, &mesh));
    CHECK_NEAR(highest(mesh), 1.5, 1e-3);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_level_release(other));
    CHECK_OK(rlv_level_create(ball, &other));
    CHECK_OK(rlv_level_set_triangles(other, SIZE_MAX));
    CHECK_OK(rlv_level_mesh(other, &mesh));
    CHECK_NEAR(highest(mesh), 1.0, 1e-6);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_level_release(other));

    /* Taken back and made again. */
    CHECK_OK(rlv_level_undo(level));
    CHECK_OK(rlv_level_mesh(level, &mesh));
    CHECK_NEAR(highest(mesh), 1.0, 1e-6);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_level_undo(level), "no edit to take back");
    CHECK_OK(rlv_level_redo(level));
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_level_redo(level), "no edit to make again");
    check_update(level, &kept);

    /* Refused, and nothing changed. */
    kept.buffers.vertex_capacity = kept.update.vertex_count - 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_update(level, &kept.buffers, &kept.update), "points");
    kept.buffers.vertex_capacity = whole.vertex_count;
    kept.buffers.triangle_capacity = 5;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_update(level, &kept.buffers, &kept.update), "triangles");
    kept.buffers.triangle_capacity = whole.triangle_count;
    kept.buffers.points = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_update(level, &kept.buffers, &kept.update), "points");
    kept.buffers.points = kept.vertices;
    kept.buffers.is_whole = 1;
    CHECK_OK(rlv_level_update(level, &kept.buffers, NULL));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_set_error(level, -1.0f), "error");
    CHECK(rlv_level_set_error(level, NAN) == RLV_ERROR_INVALID);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_set_bound(level, -1.0f, NULL, NULL, NULL), "bound");
    CHECK(rlv_level_set_bound(level, NAN, NULL, NULL, NULL) == RLV_ERROR_INVALID);
    view.tolerance = 0.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_set_view(level, &view), "view");
    handle.region.falloff = 5;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_edit(level, &edit, NULL), "handle 0");
    handle.region.falloff = RLV_FALLOFF_SPHERE;
    handle.region.center[0] = 50.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_edit(level, &edit, NULL), "no vertex is in a region");
    handle.region.radius = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_edit(level, &edit, NULL), "handle 0");
    edit.handles = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_edit(level, &edit, NULL), "handles");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_create((RlvProgressive){level.id}, &untouched), "level");
    CHECK(untouched.id == 77);
    CHECK_OK(rlv_level_info(level, &info));
    CHECK(info.triangle_count == whole.triangle_count && info.undo_count == 1);

    check_strokes(context, ball);
    check_motions(ball);
    check_attributes(context);

    /* It keeps alive what it needs. */
    CHECK_OK(rlv_progressive_release(ball));
    CHECK_OK(rlv_context_release(context));
    CHECK_OK(rlv_level_set_triangles(level, 100));
    check_update(level, &kept);
    CHECK_OK(rlv_level_release(level));
    CHECK(rlv_level_info(level, &info) == RLV_ERROR_INVALID);
    free(kept.vertices);
    free(kept.triangles);
    return 0;
}
