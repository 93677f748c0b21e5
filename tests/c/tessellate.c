/* Tessellation: closed, with normals, attributes and places that evaluate to its points; and it follows commits. */
#include "ball.h"

/* A cube of side 2 with a face attribute, and creases around its top and along an upright edge if they are wanted. */
static RlvMesh cube(RlvContext context, int is_creased) {
    static const float points[] = {-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1};
    static const uint32_t corners[] = {0, 3, 2, 1, 4, 5, 6, 7, 0, 1, 5, 4, 1, 2, 6, 5, 2, 3, 7, 6, 3, 0, 4, 7};
    static const uint32_t material[] = {10, 11, 12, 13, 14, 15};
    RlvMeshArrays arrays = check_faces(points, 8, 4, 6, corners);
    static const uint32_t creases[] = {4, 5, 5, 6, 6, 7, 7, 4, 0, 4};
    static const float sharpness[] = {2.5f, 2.5f, 10.0f, 10.0f, 3.0f};
    if (is_creased) {
        arrays.creases = creases;
        arrays.crease_sharpness = sharpness;
        arrays.crease_count = 5;
    }
    RlvMesh mesh = RLV_NULL;
    CHECK_OK(rlv_mesh_create(context, &arrays, &mesh));
    RlvAttributeArrays slots = RLV_ATTRIBUTE_ARRAYS_INIT;
    slots.domain = RLV_DOMAIN_FACE;
    slots.type = RLV_TYPE_U32;
    slots.width = 1;
    slots.name = "material";
    slots.values = material;
    slots.value_count = 6;
    CHECK_OK(rlv_mesh_add_attribute(mesh, &slots));
    return mesh;
}

static void *get(RlvMesh mesh, const char *name, size_t numbers) {
    uint32_t index = 0;
    void *values = malloc(numbers * 4);
    CHECK(values != NULL);
    CHECK_OK(rlv_mesh_find_attribute(mesh, name, &index));
    CHECK_OK(rlv_mesh_get_attribute(mesh, index, values, numbers, NULL, 0));
    return values;
}

/* Points and normals as a host keeps them beside its index buffer. */
typedef struct Buffers {
    size_t count;
    float *positions, *normals;
} Buffers;

static Buffers fetch(RlvMesh mesh) {
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(mesh, &info));
    Buffers made = {info.point_count, malloc(info.point_count * 12), NULL};
    CHECK(made.positions != NULL);
    CHECK_OK(rlv_mesh_get_points(mesh, made.positions, made.count, 0));
    made.normals = get(mesh, "normal", made.count * 3);
    CHECK_OK(rlv_mesh_release(mesh));
    return made;
}

static void drop(Buffers buffers) {
    free(buffers.positions), free(buffers.normals);
}

/* Copies what the last update changed, and nothing else. */
static size_t refit(RlvTessellation tessellation, Buffers *buffers) {
    size_t count = 0, points = 0, end = 0;
    CHECK_OK(rlv_tessellation_changed_ranges(tessellation, NULL, 0, &count));
    uint32_t *ranges = malloc(count * 8 + 8);
    CHECK(ranges != NULL);
    if (count > 0) {
        size_t needed = 77;
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_tessellation_changed_ranges(tessellation, ranges, count - 1, &needed), "ranges");
        CHECK(needed == count);
    }
    CHECK_OK(rlv_tessellation_changed_ranges(tessellation, ranges, count, &count));
    for (size_t range = 0; range < count; ++range) {
        size_t first = ranges[2 * range], size = ranges[2 * range + 1];
        CHECK(size > 0 && (range == 0 || first > end + 8));
        CHECK_OK(rlv_tessellation_get_points(tessellation, first, size, buffers->positions + 3 * first, 0,
                                             buffers->normals + 3 * first, 0));
        end = first + size, points += size;
    }
    CHECK(end <= buffers->count);
    free(ranges);
    return points;
}

/* The buffers are those of a whole tessellation, to the last bit. */
static void check_whole(RlvDetail detail, const RlvTessellateOptions *options, Buffers buffers) {
    RlvMesh mesh = RLV_NULL;
    CHECK_OK(rlv_tessellate_detail(detail, options, &mesh));
    Buffers whole = fetch(mesh);
    CHECK(whole.count == buffers.count);
    CHECK(memcmp(whole.positions, buffers.positions, whole.count * 12) == 0);
    CHECK(memcmp(whole.normals, buffers.normals, whole.count * 12) == 0);
    drop(whole);
}

/* A host that refits what an imprint changed has what a host that starts anew would have. */
static void follow(RlvContext context) {
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvCollider collider = RLV_NULL;
    RlvTessellation tessellation = RLV_NULL, adaptive = RLV_NULL;
    RlvMesh plane = check_plane(context, 6, 6), ball = check_ball(context, 0.6), mesh = RLV_NULL;
    RlvDetailOptions detail_options = RLV_DETAIL_OPTIONS_INIT;
    detail_options.tile_size = 32;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, &detail_options, NULL, &detail));
    const double first[12] = CHECK_MOVED(2.0, 2.3, 0.4), second[12] = CHECK_MOVED(3.2, 2.3, 0.4);
    CHECK_OK(rlv_collider_create_mesh(context, ball, first, &collider));
    RlvTessellateOptions options = RLV_TESSELLATE_OPTIONS_INIT;
    options.coarse = options.fine = 16;
    CHECK_OK(rlv_tessellation_create(detail, &options, &tessellation));
    CHECK_OK(rlv_tessellation_create(detail, NULL, &adaptive));
    RlvTessellationInfo info = RLV_TESSELLATION_INFO_INIT;
    CHECK_OK(rlv_tessellation_info(tessellation, &info));
    CHECK(info.point_count == 97 * 97 && info.triangle_count == 2 * 96 * 96);
    CHECK_OK(rlv_tessellation_mesh(tessellation, &mesh));
    Buffers buffers = fetch(mesh);
    CHECK(buffers.count == info.point_count);

    /* Two commits, one update. */
    RlvTessellationChanges changes = RLV_TESSELLATION_CHANGES_INIT;
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, NULL));
    CHECK_OK(rlv_tessellation_update(tessellation, &changes));
    CHECK(changes.range_count == 0 && changes.point_count == 0 && changes.high[0] == 0.0f);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_collider_set_transform(collider, second));
    CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_tessellation_update(tessellation, &changes));
    CHECK(changes.rebuilt == 0 && changes.range_count > 1 && changes.point_count < buffers.count / 2);
    CHECK(changes.low[2] < -0.15f && changes.low[1] > 0.5f && changes.high[1] < 4.0f && changes.high[2] == 0.0f);
    CHECK(refit(tessellation, &buffers) == changes.point_count);
    check_whole(detail, &options, buffers);
    CHECK_OK(rlv_tessellation_update(tessellation, &changes));
    CHECK(changes.range_count == 0);

    /* Tiles that lose their displacement change too. */
    CHECK_OK(rlv_detail_write_block(detail, RLV_CHANNEL_DISPLACEMENT, 14, NULL, 0));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_tessellation_update(tessellation, &changes));
    CHECK(changes.rebuilt == 0 && refit(tessellation, &buffers) > 0);
    check_whole(detail, &options, buffers);

    /* A transform changes no points of object space, a pose those that it moves. */
    CHECK_OK(rlv_detail_set_transform(detail, second));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_tessellation_update(tessellation, &changes));
    CHECK(changes.range_count == 0);
    float points[49][3];
    CHECK_OK(rlv_mesh_get_points(plane, points[0], 49, 0));
    points[24][2] += 0.5f;
    CHECK_OK(rlv_detail_set_points(detail, points[0], 49, 0));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_tessellation_update(tessellation, &changes));
    CHECK(changes.rebuilt == 0 && changes.point_count > 61 * 61 && changes.point_count < buffers.count);
    CHECK(refit(tessellation, &buffers) == changes.point_count);
    check_whole(detail, &options, buffers);
    drop(buffers);

    /* Where tiles with displacement have more cells, it says so. */
    CHECK_OK(rlv_tessellation_update(adaptive, &changes));
    CHECK(changes.rebuilt == 1 && changes.range_count == 1);
    CHECK_OK(rlv_tessellation_mesh(adaptive, &mesh));
    buffers = fetch(mesh);
    check_whole(detail, NULL, buffers);

    /* Refusals. */
    CHECK_OK(rlv_tessellation_info(adaptive, &info));
    CHECK(info.point_count == buffers.count);
    CHECK_FAILS(RLV_ERROR_INVALID,
                rlv_tessellation_get_points(adaptive, 1, buffers.count, buffers.positions, 0, NULL, 0), "count");
    CHECK_FAILS(RLV_ERROR_INVALID,
                rlv_tessellation_get_points(adaptive, (size_t)-1, 2, buffers.positions, 0, NULL, 0), "count");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tessellation_changed_ranges(adaptive, NULL, 0, NULL), "count");
    drop(buffers);
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_tessellation_update(tessellation, NULL));
    CHECK_OK(rlv_tessellation_release(adaptive));
    CHECK_OK(rlv_tessellation_release(tessellation));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tessellation_update(tessellation, NULL), "not alive");
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_mesh_release(plane));
}

/* Copies the colours and traces of the points that the last update changed, six numbers a point. */
static void refit_coat(RlvTessellation tessellation, float *coat) {
    size_t count = 0;
    CHECK_OK(rlv_tessellation_changed_ranges(tessellation, NULL, 0, &count));
    uint32_t *ranges = malloc(count * 8 + 8);
    CHECK(ranges != NULL);
    CHECK_OK(rlv_tessellation_changed_ranges(tessellation, ranges, count, &count));
    for (size_t range = 0; range < count; ++range) {
        size_t first = ranges[2 * range], size = ranges[2 * range + 1];
        CHECK_OK(rlv_tessellation_get_colors(tessellation, first, size, coat + 6 * first, 24));
        CHECK_OK(rlv_tessellation_get_traces(tessellation, first, size, coat + 6 * first + 3, 24));
    }
    free(ranges);
}

/* A host that refits colours and traces where a stroke and a ball were has what a host that starts anew would have,
 * beside tiles of other sizes too. */
static void follow_coat(RlvContext context) {
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvCollider collider = RLV_NULL;
    RlvTessellation tessellation = RLV_NULL;
    RlvStroke stroke = RLV_NULL;
    RlvMesh plane = check_plane(context, 6, 6), ball = check_ball(context, 0.6);
    RlvDetailOptions detail_options = RLV_DETAIL_OPTIONS_INIT;
    RlvPaintOptions paint_options = RLV_PAINT_OPTIONS_INIT;
    detail_options.tile_size = paint_options.tile_size = 32;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, &detail_options, NULL, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, &paint_options));
    CHECK_OK(rlv_detail_add_traces(detail, 0));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    const double at[12] = CHECK_MOVED(2.0, 2.3, 0.4);
    CHECK_OK(rlv_collider_create_mesh(context, ball, at, &collider));
    RlvTessellateOptions options = RLV_TESSELLATE_OPTIONS_INIT;
    RlvTessellationInfo info = RLV_TESSELLATION_INFO_INIT;
    options.coarse = options.fine = 16;
    CHECK_OK(rlv_tessellation_create(detail, &options, &tessellation));
    CHECK_OK(rlv_tessellation_info(tessellation, &info));
    float *kept = calloc(info.point_count, 24), *whole = calloc(info.point_count, 24);
    CHECK(kept != NULL && whole != NULL);
    refit_coat(tessellation, kept);
    for (uint32_t level = 0; level < 3; ++level) {
        RlvBrushOptions brush_options = RLV_BRUSH_OPTIONS_INIT;
        RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
        RlvBrush brush = RLV_NULL;
        brush_options.color[level] = 0.1f;
        settings.radius = 0.7f;
        settings.level = 2 - level;
        CHECK_OK(rlv_brush_create(context, &brush_options, &settings, &brush));
        CHECK_OK(rlv_stroke_begin(detail, brush, &stroke));
        CHECK_OK(rlv_brush_release(brush));
        for (int event = 0; event < 6; ++event) {
            const RlvStrokePoint point = {{0.4 + 0.9 * event, 2.0 + 0.7 * level, 0.0}, 1.0, -1.0};
            RlvTessellationChanges changes = RLV_TESSELLATION_CHANGES_INIT;
            CHECK_OK(rlv_stroke_extend(stroke, &point, 1, 0, NULL));
            if (event == 3) {
                CHECK_OK(rlv_imprint_run(detail, collider, NULL, NULL, NULL));
            }
            CHECK_OK(rlv_detail_commit(detail, NULL));
            CHECK_OK(rlv_tessellation_update(tessellation, &changes));
            CHECK(changes.rebuilt == 0 && changes.point_count < info.point_count);
            CHECK(event == 0 || changes.point_count > 0);
            refit_coat(tessellation, kept);
            RlvTessellation fresh = RLV_NULL;
            CHECK_OK(rlv_tessellation_create(detail, &options, &fresh));
            refit_coat(fresh, whole);
            CHECK(memcmp(kept, whole, info.point_count * 24) == 0);
            CHECK_OK(rlv_tessellation_release(fresh));
        }
        CHECK_OK(rlv_stroke_end(stroke, NULL));
        CHECK_OK(rlv_stroke_release(stroke));
    }
    /* As time goes by all traces are older. */
    CHECK_OK(rlv_detail_advance(detail, 2.0));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_tessellation_update(tessellation, NULL));
    CHECK_OK(rlv_tessellation_get_traces(tessellation, 0, info.point_count, whole, 0));
    size_t old = 0;
    for (size_t point = 0; point < info.point_count; ++point) {
        old += whole[3 * point + 2] == 2.0f;
    }
    CHECK(old > 100);
    free(kept), free(whole);
    CHECK_OK(rlv_tessellation_release(tessellation));
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_mesh_release(plane));
}

/* Positions, normals and colours of all points, nine numbers each. */
static float *all_arrays(RlvTessellation tessellation, size_t count) {
    float *arrays = malloc(count * 36);
    CHECK(arrays != NULL);
    CHECK_OK(rlv_tessellation_get_points(tessellation, 0, count, arrays, 36, arrays + 3, 36));
    CHECK_OK(rlv_tessellation_get_colors(tessellation, 0, count, arrays + 6, 36));
    return arrays;
}

/* A brush of constant falloff fills a square. */
static double distance(const float *point, const double middle[3]) {
    return fmax(fabs(point[0] - middle[0]), fabs(point[1] - middle[1]));
}

/* One dab of a radius, which sculpts or paints. */
static void dab(RlvContext context, RlvDetail detail, RlvBrushOptions options, const double at[3], float radius) {
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    const RlvStrokePoint point = {{at[0], at[1], at[2]}, 1.0, -1.0};
    RlvBrush brush = RLV_NULL;
    settings.radius = radius;
    options.falloff = RLV_FALLOFF_CONSTANT;
    options.height = 0.02f;
    CHECK_OK(rlv_brush_create(context, &options, &settings, &brush));
    CHECK_OK(rlv_stroke_run(detail, brush, &point, 1, 0, NULL));
    CHECK_OK(rlv_brush_release(brush));
}

/* Ranges hold the points of which a bit differs in an array, with gaps of at most 8 others, and no more: after a dab that
 * sculpts and one that paints elsewhere, these are the points within their squares, and few around them. */
static void check_fine(RlvContext context, uint32_t kind, uint32_t size) {
    static const double middles[2][3] = {{1.3, 1.4, 0.0}, {2.8, 2.7, 0.0}};
    const float radius = 0.35f, around = 8.0f / (float)size;
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvTessellation tessellation = RLV_NULL;
    RlvMesh plane = check_plane(context, 4, 4);
    RlvSurfaceOptions surface_options = RLV_SURFACE_OPTIONS_INIT;
    RlvDetailOptions detail_options = RLV_DETAIL_OPTIONS_INIT;
    RlvPaintOptions paint_options = RLV_PAINT_OPTIONS_INIT;
    RlvTessellateOptions options = RLV_TESSELLATE_OPTIONS_INIT;
    RlvTessellationInfo info = RLV_TESSELLATION_INFO_INIT;
    RlvTessellationChanges changes = RLV_TESSELLATION_CHANGES_INIT;
    surface_options.kind = kind;
    detail_options.tile_size = paint_options.tile_size = size;
    options.coarse = options.fine = size;
    CHECK_OK(rlv_surface_create(context, plane, &surface_options, &surface));
    CHECK_OK(rlv_detail_create(surface, &detail_options, NULL, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, &paint_options));
    RlvBrushOptions sculpt = RLV_BRUSH_OPTIONS_INIT, paint = RLV_BRUSH_OPTIONS_INIT;
    sculpt.action = RLV_BRUSH_SCULPT;
    sculpt.mode = RLV_SCULPT_DRAW;
    for (int time = 0; time < 2; ++time) {
        paint.color[0] = paint.color[1] = paint.color[2] = 0.2f + 0.5f * (float)time;
        dab(context, detail, sculpt, middles[0], radius);
        dab(context, detail, paint, middles[1], radius);
        CHECK_OK(rlv_detail_commit(detail, NULL));
        if (time == 0) {
            CHECK_OK(rlv_tessellation_create(detail, &options, &tessellation));
            CHECK_OK(rlv_tessellation_info(tessellation, &info));
        }
        if (time == 1) {
            float *before = all_arrays(tessellation, info.point_count);
            CHECK_OK(rlv_tessellation_update(tessellation, &changes));
            CHECK(changes.rebuilt == 0);
            float *after = all_arrays(tessellation, info.point_count);
            uint32_t *ranges = malloc(changes.range_count * 8 + 8);
            CHECK(ranges != NULL);
            size_t count = 0, made = 0, differing = 0, reported = 0, end = 0;
            CHECK_OK(rlv_tessellation_changed_ranges(tessellation, ranges, changes.range_count, &count));
            CHECK(count == changes.range_count && count > 4);
            for (size_t point = 0; point < info.point_count; ++point) {
                const float *old = before + 9 * point, *now = after + 9 * point;
                const double sculpted = distance(old, middles[0]), painted = distance(old, middles[1]);
                const int is_other = memcmp(old, now, 36) != 0;
                CHECK(is_other || (sculpted > 0.7f * radius && painted > 0.7f * radius));
                CHECK(!is_other || sculpted < radius + around || painted < radius + around);
                CHECK(painted > 0.7f * radius || memcmp(old, now, 24) == 0);
                if (!is_other) {
                    continue;
                }
                differing += 1;
                if (made == 0 || point > end + 8) {
                    made += 1;
                    CHECK(made <= count && ranges[2 * made - 2] == point);
                }
                end = point + 1;
                CHECK(ranges[2 * made - 2] + ranges[2 * made - 1] >= end);
            }
            CHECK(made == count && ranges[2 * made - 2] + ranges[2 * made - 1] == end);
            for (size_t range = 0; range < count; ++range) {
                reported += ranges[2 * range + 1];
            }
            CHECK(reported == changes.point_count && differing > 100 && 2 * reported <= 3 * differing);
            CHECK(10 * reported < 3 * info.point_count);
            free(before), free(after), free(ranges);
        }
    }
    CHECK_OK(rlv_tessellation_release(tessellation));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
}

/* A stroke from one point of the cube's surface to another. */
static void stroke(RlvContext context, RlvDetail detail, RlvBrushOptions options, const RlvStrokePoint ends[2]) {
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvStrokeReport report = RLV_STROKE_REPORT_INIT;
    RlvBrush brush = RLV_NULL;
    settings.radius = 0.25f;
    CHECK_OK(rlv_brush_create(context, &options, &settings, &brush));
    CHECK_OK(rlv_stroke_run(detail, brush, ends, 2, 0, &report));
    CHECK(report.changed_tiles > 0);
    CHECK_OK(rlv_brush_release(brush));
}

/* Rays, on a square that looks down on the cube from each side. */
enum { SIDE = 24, RAYS = 6 * SIDE * SIDE };

static void cast(RlvCaster caster, RlvHit *hits) {
    static float origins[RAYS][3], directions[RAYS][3];
    RlvRayArrays rays = RLV_RAY_ARRAYS_INIT;
    for (int ray = 0; ray < RAYS; ++ray) {
        const int side = ray / (SIDE * SIDE), axis = side / 2;
        const float out = side % 2 == 0 ? 1.0f : -1.0f;
        origins[ray][axis] = 3.0f * out;
        directions[ray][axis] = -out;
        origins[ray][(axis + 1) % 3] = -1.0f + 2.0f * ((float)(ray % SIDE) + 0.4f) / SIDE;
        origins[ray][(axis + 2) % 3] = -1.0f + 2.0f * ((float)(ray / SIDE % SIDE) + 0.4f) / SIDE;
        directions[ray][(axis + 1) % 3] = directions[ray][(axis + 2) % 3] = 0.0f;
    }
    rays.count = RAYS;
    rays.origins = origins[0];
    rays.directions = directions[0];
    rays.hits = hits;
    CHECK_OK(rlv_caster_cast(caster, &rays));
    CHECK_OK(rlv_caster_release(caster));
}

/* Casters and colliders of a detail have the triangles of its tessellation, whatever is on its tiles. */
static void same_triangles(RlvContext context, RlvSurface surface) {
    static RlvHit hits[2][RAYS];
    static const RlvStrokePoint ends[3][2] = {{{{0.2, 0.2, 0.6}, 1.0, -1.0}, {{-0.2, 0.1, 0.6}, 1.0, -1.0}},
                                              {{{0.1, -0.6, 0.2}, 1.0, -1.0}, {{-0.1, -0.6, -0.2}, 1.0, -1.0}},
                                              {{{-0.6, 0.1, 0.1}, 1.0, -1.0}, {{-0.6, -0.2, 0.1}, 1.0, -1.0}}};
    RlvBrushOptions paint = RLV_BRUSH_OPTIONS_INIT, pinch = RLV_BRUSH_OPTIONS_INIT, draw = RLV_BRUSH_OPTIONS_INIT;
    RlvDetail detail = RLV_NULL;
    RlvCaster caster = RLV_NULL;
    RlvCollider collider = RLV_NULL;
    RlvColliderInfo about = RLV_COLLIDER_INFO_INIT;
    RlvMesh mesh = RLV_NULL;
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    paint.color[1] = 0.2f;
    pinch.action = draw.action = RLV_BRUSH_SCULPT;
    pinch.mode = RLV_SCULPT_PINCH;
    draw.mode = RLV_SCULPT_DRAW;
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, NULL));
    CHECK_OK(rlv_detail_add_vectors(detail, NULL));
    for (int step = 0; step < 4; ++step) {
        if (step > 0) {
            stroke(context, detail, step == 1 ? paint : step == 2 ? pinch : draw, ends[step - 1]);
        }
        CHECK_OK(rlv_detail_commit(detail, NULL));
        const size_t before = info.triangle_count;
        CHECK_OK(rlv_tessellate_detail(detail, NULL, &mesh));
        CHECK_OK(rlv_mesh_info(mesh, &info));
        CHECK(info.triangle_count > before);
        CHECK_OK(rlv_caster_create_mesh(context, mesh, &caster));
        cast(caster, hits[0]);
        CHECK_OK(rlv_caster_create_detail(detail, NULL, &caster));
        cast(caster, hits[1]);
        size_t met = 0;
        for (int ray = 0; ray < RAYS; ++ray) {
            met += !isinf(hits[0][ray].distance);
            CHECK(memcmp(&hits[0][ray].distance, &hits[1][ray].distance, sizeof(float)) == 0);
            CHECK(memcmp(hits[0][ray].position, hits[1][ray].position, 3 * sizeof(float)) == 0);
        }
        CHECK(met > RAYS / 4);
        CHECK_OK(rlv_collider_create_detail(detail, NULL, &collider));
        CHECK_OK(rlv_collider_info(collider, &about));
        CHECK(about.triangle_count == info.triangle_count && about.point_count == info.point_count);
        CHECK_OK(rlv_collider_release(collider));
        CHECK_OK(rlv_mesh_release(mesh));
    }
    CHECK_OK(rlv_detail_release(detail));
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvMesh mesh = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    for (int is_creased = 1; is_creased >= 0; --is_creased) {
        RlvMesh cage = cube(context, is_creased);
        CHECK_OK(rlv_surface_create(context, cage, NULL, &surface));
        CHECK_OK(rlv_mesh_release(cage));
        same_triangles(context, surface);
        if (is_creased) {
            CHECK_OK(rlv_surface_release(surface));
        }
    }

    RlvTessellateOptions options = RLV_TESSELLATE_OPTIONS_INIT;
    options.coarse = 4;
    options.places = 1;
    CHECK_OK(rlv_tessellate_surface(surface, &options, &mesh));
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK(info.face_count == 6 * 4 * 4 * 2 && info.triangle_count == info.face_count);
    /* Euler's number of a sphere. */
    CHECK(info.point_count == 2 + info.face_count / 2);

    /* The place of every corner leads to its point, and faces keep their material. */
    size_t corners = info.corner_count;
    float *points = malloc(info.point_count * 12), *found = malloc(corners * 12);
    uint32_t *indices = malloc(corners * 4), *corner_tiles = malloc(corners * 4);
    CHECK(points && found && indices && corner_tiles);
    CHECK_OK(rlv_mesh_get_points(mesh, points, info.point_count, 0));
    CHECK_OK(rlv_mesh_get_faces(mesh, NULL, 0, indices, corners));
    uint32_t *tiles = get(mesh, "tile", info.face_count), *materials = get(mesh, "material", info.face_count);
    float *uvs = get(mesh, "tile_uv", corners * 2), *normals = get(mesh, "normal", info.point_count * 3);
    for (size_t corner = 0; corner < corners; ++corner) {
        corner_tiles[corner] = tiles[corner / 3];
        CHECK(materials[corner / 3] == 10 + tiles[corner / 3]);
    }
    RlvEvaluateArrays places = RLV_EVALUATE_ARRAYS_INIT;
    places.count = corners;
    places.tiles = corner_tiles;
    places.uvs = uvs;
    places.positions = found;
    CHECK_OK(rlv_evaluate_surface(surface, &places));
    for (size_t corner = 0; corner < corners; ++corner) {
        const float *point = points + 3 * indices[corner], *normal = normals + 3 * indices[corner];
        for (int axis = 0; axis < 3; ++axis) {
            CHECK_NEAR(found[3 * corner + axis], point[axis], 1e-5);
        }
        CHECK(normal[0] * point[0] + normal[1] * point[1] + normal[2] * point[2] > 0.5f);
    }
    free(points), free(found), free(indices), free(corner_tiles);
    free(tiles), free(materials), free(uvs), free(normals);
    CHECK_OK(rlv_mesh_release(mesh));

    /* Refusals. */
    RlvMesh untouched = {77};
    options.coarse = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tessellate_surface(surface, &options, &untouched), "coarse");
    options.coarse = 8;
    options.places = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tessellate_surface(surface, &options, &untouched), "places");
    options.places = 1;
    options.smooth_uvs = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tessellate_surface(surface, &options, &untouched), "smooth_uvs");
    options.smooth_uvs = 0;
    options.coarse = 1024;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tessellate_surface(surface, &options, &untouched), "coarse");
    CHECK(untouched.id == 77);
    CHECK_OK(rlv_surface_release(surface));

    RlvContextOptions limits = RLV_CONTEXT_OPTIONS_INIT;
    RlvContext small = RLV_NULL;
    limits.memory_limit = 64 << 20;
    CHECK_OK(rlv_context_create(&limits, &small));
    RlvMesh cage = cube(small, 0);
    CHECK_OK(rlv_surface_create(small, cage, NULL, &surface));
    options.coarse = 512;
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_tessellate_surface(surface, &options, &untouched), "memory limit");
    CHECK_OK(rlv_mesh_release(cage));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_context_release(small));
    follow(context);
    follow_coat(context);
    check_fine(context, RLV_SURFACE_CATMULL_CLARK, 32);
    check_fine(context, RLV_SURFACE_TRIANGLES, 32);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
