/* Checks of the C tests: a failed one says where and ends the program. */
#ifndef CHECK_H
#define CHECK_H

#include <relievo/relievo.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CHECK(condition)                                                                          \
    do {                                                                                          \
        if (!(condition)) {                                                                       \
            fprintf(stderr, "%s:%d: failed: %s (last error: %s)\n", __FILE__, __LINE__, #condition, \
                    rlv_error_last());                                                            \
            exit(1);                                                                              \
        }                                                                                         \
    } while (0)

#define CHECK_OK(call) CHECK((call) == RLV_OK)

/* The call fails with the result, and its message contains the text. */
#define CHECK_FAILS(result, call, text)                        \
    do {                                                       \
        CHECK((call) == (result));                             \
        CHECK(strstr(rlv_error_last(), (text)) != NULL);       \
    } while (0)

#define CHECK_NEAR(a, b, tolerance) CHECK(fabs((double)(a) - (double)(b)) <= (tolerance))

/* No call is at work on the object, which is of that noun: rlv_object_wait returns at once, whatever the time. */
static inline void check_idle(uint64_t id, const char *noun) {
    RlvObjectInfo info = RLV_OBJECT_INFO_INIT;
    info.is_busy = 7;
    CHECK_OK(rlv_object_wait(id, -1.0, &info));
    CHECK(info.is_busy == 0 && info.worker[0] == 0 && strcmp(info.noun, noun) == 0);
}

/* The arrays of a mesh whose faces have as many corners each. */
static inline RlvMeshArrays check_faces(const float *points, size_t point_count, uint32_t face_size, size_t face_count,
                                        const uint32_t *corners) {
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    arrays.points = points;
    arrays.point_count = point_count;
    arrays.face_size = face_size;
    arrays.face_count = face_count;
    arrays.corners = corners;
    arrays.corner_count = face_count * face_size;
    return arrays;
}

/* A mesh of them. */
static inline RlvMesh check_mesh_of(RlvContext context, const float *points, size_t point_count, uint32_t face_size,
                                    size_t face_count, const uint32_t *corners) {
    const RlvMeshArrays arrays = check_faces(points, point_count, face_size, face_count, corners);
    RlvMesh mesh = RLV_NULL;
    CHECK_OK(rlv_mesh_create(context, &arrays, &mesh));
    return mesh;
}

/* A flat cage of columns x rows quads of side 1 in the plane z = 0, from (0, 0) on. */
static inline RlvMesh check_plane(RlvContext context, uint32_t columns, uint32_t rows) {
    size_t points = (size_t)(columns + 1) * (rows + 1), faces = (size_t)columns * rows;
    float *positions = (float *)malloc(points * 3 * sizeof(float));
    uint32_t *corners = (uint32_t *)malloc(faces * 4 * sizeof(uint32_t));
    CHECK(positions != NULL && corners != NULL);
    for (uint32_t y = 0; y <= rows; ++y) {
        for (uint32_t x = 0; x <= columns; ++x) {
            float *position = positions + 3 * ((size_t)y * (columns + 1) + x);
            position[0] = (float)x;
            position[1] = (float)y;
            position[2] = 0.0f;
        }
    }
    for (uint32_t y = 0; y < rows; ++y) {
        for (uint32_t x = 0; x < columns; ++x) {
            uint32_t *corner = corners + 4 * ((size_t)y * columns + x);
            corner[0] = y * (columns + 1) + x;
            corner[1] = corner[0] + 1;
            corner[2] = corner[1] + columns + 1;
            corner[3] = corner[0] + columns + 1;
        }
    }
    const RlvMesh mesh = check_mesh_of(context, positions, points, 4, faces, corners);
    free(positions);
    free(corners);
    return mesh;
}

/* A closed box over the square from (low, low) to (high, high), between the heights bottom and top. */
static inline RlvMesh check_box(RlvContext context, float low, float high, float bottom, float top) {
    static const uint32_t corners[24] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6};
    float points[24];
    for (int k = 0; k < 8; ++k) {
        points[3 * k] = k & 1 ? high : low;
        points[3 * k + 1] = k & 2 ? high : low;
        points[3 * k + 2] = k & 4 ? top : bottom;
    }
    return check_mesh_of(context, points, 8, 4, 6, corners);
}

/* Soft tissue that fills a mesh, in cells of 0.05 m. */
static inline RlvTissue check_tissue(RlvContext context, RlvMesh mesh) {
    RlvTissueMaterial flesh = RLV_TISSUE_MATERIAL_INIT;
    RlvTissueVolume block = RLV_TISSUE_VOLUME_INIT;
    RlvTissueDescription description = RLV_TISSUE_DESCRIPTION_INIT;
    RlvTissue tissue = RLV_NULL;
    flesh.name = "flesh";
    flesh.library = "muscle";
    block.name = "block";
    block.mesh = mesh;
    description.cell[0] = description.cell[1] = description.cell[2] = 0.05f;
    description.materials = &flesh;
    description.material_count = 1;
    description.volumes = &block;
    description.volume_count = 1;
    CHECK_OK(rlv_tissue_build(context, &description, NULL, NULL, NULL, &tissue));
    return tissue;
}

/* Evaluates a detail at (u, v) of a tile, into arrays of one element each. */
static inline void check_evaluate(RlvDetail detail, uint32_t tile, float u, float v, RlvEvaluateArrays arrays) {
    const float uv[2] = {u, v};
    arrays.count = 1;
    arrays.tiles = &tile;
    arrays.uvs = uv;
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
}

/* The displacement at (u, v) of a tile. */
static inline float check_displacement(RlvDetail detail, uint32_t tile, float u, float v) {
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    float out = 7.0f;
    arrays.displacements = &out;
    check_evaluate(detail, tile, u, v, arrays);
    return out;
}

/* Commits a detail, and evaluates its colour and displacement in the middle of a tile. */
static inline void check_look(RlvDetail detail, uint32_t tile, float *color, float *height) {
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    CHECK_OK(rlv_detail_commit(detail, NULL));
    arrays.colors = color;
    arrays.displacements = height;
    check_evaluate(detail, tile, 0.5f, 0.5f, arrays);
}

/* The first hit of a ray. */
static inline RlvHit check_cast(RlvCaster caster, const float *origin, const float *direction) {
    RlvRayArrays rays = RLV_RAY_ARRAYS_INIT;
    RlvHit hit;
    rays.count = 1;
    rays.origins = origin;
    rays.directions = direction;
    rays.hits = &hit;
    CHECK_OK(rlv_caster_cast(caster, &rays));
    return hit;
}

/* Draws a line between two points with a brush of the options and the radius. */
static inline void check_line(RlvContext context, RlvDetail detail, const RlvBrushOptions *options, float radius,
                              const RlvStrokePoint *points) {
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvBrush brush = RLV_NULL;
    settings.radius = radius;
    CHECK_OK(rlv_brush_create(context, options, &settings, &brush));
    CHECK_OK(rlv_stroke_run(detail, brush, points, 2, 0, NULL));
    CHECK_OK(rlv_brush_release(brush));
}

/* Paints or sculpts a line on a plane, from (0.3, 1, 0) to (x, y, 0). */
static inline void check_stroke(RlvContext context, RlvDetail detail, uint32_t action, double x, double y, float radius) {
    RlvBrushOptions options = RLV_BRUSH_OPTIONS_INIT;
    const RlvStrokePoint points[2] = {{{0.3, 1.0, 0.0}, 1.0, -1.0}, {{x, y, 0.0}, 1.0, -1.0}};
    options.action = action;
    options.color[1] = 0.2f;
    options.height = 0.2f;
    check_line(context, detail, &options, radius, points);
}

/* A dent along a row of a plate, from x = 0.2 to 2.8. */
static inline void check_dent(RlvContext context, RlvDetail detail, double row) {
    RlvBrushOptions options = RLV_BRUSH_OPTIONS_INIT;
    const RlvStrokePoint points[2] = {{{0.2, row, 0.0}, 1.0, -1.0}, {{2.8, row, 0.0}, 1.0, -1.0}};
    options.action = RLV_BRUSH_SCULPT;
    options.height = 0.1f;
    check_line(context, detail, &options, 0.3f, points);
}

#endif
