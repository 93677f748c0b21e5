/* Decals: laid on a mesh and on a detail, measured, dragged, posed, written into layers and a texture, cut out by alpha, as
 * strips, as a mesh, as a job, and kept in documents. */
#include "check.h"

enum { WIDTH = 40, HEIGHT = 20 };

static uint32_t cancel(void *user, float fraction, const char *stage) {
    (void)user;
    (void)fraction;
    (void)stage;
    return RLV_PROGRESS_CANCEL;
}

/* Pins that make the image 4 units wide, its lower left corner at (3, 4). */
static void set_pins(RlvDecalPin pins[4]) {
    const double places[4][2] = {{4, 4}, {36, 4}, {36, 16}, {4, 16}};
    for (size_t pin = 0; pin < 4; ++pin) {
        memset(&pins[pin], 0, sizeof pins[pin]);
        for (size_t axis = 0; axis < 2; ++axis) {
            pins[pin].image[axis] = places[pin][axis];
            pins[pin].position[axis] = (axis == 0 ? 3.0 : 4.0) + 0.1 * places[pin][axis];
        }
    }
}

/* Makes an image white in its one channel. Returns its pixels, for free(). */
static float *make_white(RlvDecalImage *image) {
    float *pixels = malloc(WIDTH * HEIGHT * 4);
    CHECK(pixels != NULL);
    for (size_t pixel = 0; pixel < WIDTH * HEIGHT; ++pixel) {
        pixels[pixel] = 1.0f;
    }
    image->channels = 1;
    image->pixels = pixels;
    image->pixel_count = WIDTH * HEIGHT;
    return pixels;
}

static void lay_on_mesh(RlvContext context, RlvMesh plane) {
    RlvDecalPin pins[4];
    RlvDecalOptions options = RLV_DECAL_OPTIONS_INIT;
    RlvDecalQuality quality = RLV_DECAL_QUALITY_INIT;
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    RlvDecal decal = RLV_NULL, untouched = {77};
    RlvMesh mesh = RLV_NULL;
    set_pins(pins);
    options.width = WIDTH;
    options.height = HEIGHT;
    CHECK_OK(rlv_decal_on_mesh(plane, &options, pins, 4, 0, NULL, NULL, &decal));
    CHECK_OK(rlv_decal_quality(decal, &quality));
    CHECK(quality.flip_count == 0 && quality.overlap_count == 0 && quality.pin_count == 4);
    CHECK(quality.coverage == 1.0 && quality.doubled == 0.0);
    CHECK_NEAR(quality.l2, 1.0, 1e-5);

    /* Texture coordinates are 0 at (3, 4) and 1 at (7, 6). */
    uint32_t uv = 77;
    CHECK_OK(rlv_decal_mesh(decal, 0.25, &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &info));
    CHECK(info.triangle_count == quality.triangle_count && info.low[2] == 0.25f && info.high[2] == 0.25f);
    CHECK_OK(rlv_mesh_find_attribute(mesh, "uv", &uv));
    float *points = malloc(info.point_count * 12), *uvs = malloc(info.point_count * 8);
    CHECK(points != NULL && uvs != NULL);
    CHECK_OK(rlv_mesh_get_points(mesh, points, info.point_count, 0));
    CHECK_OK(rlv_mesh_get_attribute(mesh, uv, uvs, 2 * info.point_count, NULL, 0));
    for (size_t point = 0; point < info.point_count; ++point) {
        CHECK_NEAR(uvs[2 * point], (points[3 * point] - 3.0) / 4.0, 1e-5);
        CHECK_NEAR(uvs[2 * point + 1], (points[3 * point + 1] - 4.0) / 2.0, 1e-5);
    }
    CHECK_OK(rlv_mesh_release(mesh));
    free(points);
    free(uvs);

    /* A pin is dragged and stays exact; far from the sticker it cannot be. */
    const double near_by[3] = {3.5, 4.5, 0.3}, far_away[3] = {0.1, 9.9, 0.0}, nothing[3] = {NAN, 0.0, 0.0};
    CHECK_OK(rlv_decal_drag_pin(decal, 0, near_by));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_drag_pin(decal, 0, far_away), "not under the sticker");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_drag_pin(decal, 4, near_by), "4 pins");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_drag_pin(decal, 0, nothing), "not finite");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_drag_pin(decal, 0, NULL), "NULL");
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_decal_settle(decal, cancel, NULL), "cancelled");
    CHECK_OK(rlv_decal_settle(decal, NULL, NULL));
    CHECK_OK(rlv_decal_quality(decal, &quality));
    CHECK(quality.flip_count == 0 && quality.l2 > 1.0001 && quality.l2 < 1.1 && quality.coverage > 0.999);

    /* The point of the image follows, and the distortion is gone. */
    const double image[2] = {5.0, 5.0}, outside[2] = {-1.0, 5.0};
    CHECK_OK(rlv_decal_move_image(decal, 0, image, NULL, NULL));
    CHECK_OK(rlv_decal_quality(decal, &quality));
    CHECK_NEAR(quality.l2, 1.0, 1e-3);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_move_image(decal, 0, outside, NULL, NULL), "outside");

    /* The surface grows to twice its size: the map stays what it is. */
    RlvMeshInfo whole = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(plane, &whole));
    float *posed = malloc(whole.point_count * 12);
    CHECK(posed != NULL);
    CHECK_OK(rlv_mesh_get_points(plane, posed, whole.point_count, 0));
    for (size_t value = 0; value < 3 * whole.point_count; ++value) {
        posed[value] *= 2.0f;
    }
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_pose(decal, posed, whole.point_count - 1, 0, NULL, NULL), "points");
    CHECK_OK(rlv_decal_pose(decal, posed, whole.point_count, 0, NULL, NULL));
    CHECK_OK(rlv_decal_quality(decal, &quality));
    CHECK(quality.flip_count == 0 && quality.coverage > 0.999);
    CHECK_NEAR(quality.l2, 1.0, 1e-2);
    free(posed);

    /* As a job it is the same. */
    RlvJob job = RLV_NULL;
    RlvDecal again = RLV_NULL;
    CHECK_OK(rlv_job_decal_on_mesh(plane, &options, pins, 4, 0, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_decal(job, &again));
    CHECK_OK(rlv_decal_quality(again, &quality));
    CHECK_NEAR(quality.l2, 1.0, 1e-5);
    CHECK_OK(rlv_job_release(job));
    check_idle(again.id, "decal");
    CHECK_OK(rlv_decal_release(again));

    /* One pin with a pose; outlines; refusals. */
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_on_mesh(plane, &options, pins, 1, 0, NULL, NULL, &untouched), "pose");
    options.pose_width = 4.0;
    CHECK_OK(rlv_decal_on_mesh(plane, &options, pins, 1, 0, NULL, NULL, &again));
    CHECK_OK(rlv_decal_quality(again, &quality));
    CHECK(quality.coverage == 1.0);
    CHECK_OK(rlv_decal_release(again));
    const double triangle[6] = {0.0, 0.0, 40.0, 0.0, 0.0, 20.0}, crossed[8] = {0, 0, 40, 20, 40, 0, 0, 12};
    options.outline = triangle;
    options.outline_count = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_on_mesh(plane, &options, pins, 4, 0, NULL, NULL, &untouched), "outline");
    CHECK_OK(rlv_decal_on_mesh(plane, &options, pins, 1, 0, NULL, NULL, &again));
    CHECK_OK(rlv_decal_release(again));
    options.outline = crossed;
    options.outline_count = 4;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_on_mesh(plane, &options, pins, 1, 0, NULL, NULL, &untouched), "cross");
    options.outline = NULL;
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_decal_on_mesh(plane, &options, pins, 4, 0, cancel, NULL, &untouched), "cancel");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_on_mesh(plane, &options, pins, 0, 0, NULL, NULL, &untouched), "no pins");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_on_mesh(plane, &options, NULL, 4, 0, NULL, NULL, &untouched), "pins");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_on_mesh(plane, NULL, pins, 4, 0, NULL, NULL, &untouched), "image");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_on_mesh(plane, &options, pins, 4, 0, NULL, NULL, NULL), "out");
    pins[2].position[0] = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_on_mesh(plane, &options, pins, 4, 0, NULL, NULL, &untouched), "pin 2");
    CHECK(untouched.id == 77);
    const RlvDecalImage pixels = RLV_DECAL_IMAGE_INIT;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_paint(decal, &pixels, 1.0f, NULL), "lies on a mesh");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_mesh(decal, INFINITY, &mesh), "offset");
    CHECK_OK(rlv_decal_retain(decal));
    CHECK_OK(rlv_decal_release(decal));
    CHECK_OK(rlv_decal_release(decal));
    CHECK(rlv_decal_quality(decal, &quality) != RLV_OK);
    (void)context;
}

static void write_into_layers(RlvContext context, RlvMesh plane) {
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDetailOptions detail_options = RLV_DETAIL_OPTIONS_INIT;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    RlvDecalPin pins[4];
    RlvDecalOptions options = RLV_DECAL_OPTIONS_INIT;
    RlvDecalImage image = RLV_DECAL_IMAGE_INIT;
    RlvDecalReport report = RLV_DECAL_REPORT_INIT;
    RlvDocument document = RLV_NULL;
    RlvDecal decal = RLV_NULL;
    float color[4], height = 0.0f;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    detail_options.tile_size = paint.tile_size = 16;
    CHECK_OK(rlv_detail_create(surface, &detail_options, NULL, &detail));
    set_pins(pins);
    options.width = WIDTH;
    options.height = HEIGHT;
    options.cells = 4;
    CHECK_OK(rlv_decal_on_detail(detail, &options, pins, 4, 0, NULL, NULL, &decal));

    /* The left half is red, the right half transparent. */
    float *pixels = calloc(WIDTH * HEIGHT, 16);
    CHECK(pixels != NULL);
    for (size_t pixel = 0; pixel < WIDTH * HEIGHT; ++pixel) {
        pixels[4 * pixel] = 1.0f;
        pixels[4 * pixel + 3] = pixel % WIDTH < WIDTH / 2 ? 1.0f : 0.0f;
    }
    image.pixels = pixels;
    image.pixel_count = WIDTH * HEIGHT;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_paint(decal, &image, 1.0f, &report), "no colours");
    paint.color[0] = paint.color[1] = paint.color[2] = 0.0f;
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    CHECK_OK(rlv_document_create(detail, NULL, 0, &document));
    CHECK_OK(rlv_document_begin(document, "a sticker"));
    CHECK_OK(rlv_decal_paint(decal, &image, 0.5f, &report));
    CHECK_OK(rlv_document_end(document, NULL));
    /* The left half is 2 by 2 units, of 16 by 16 texels each. */
    CHECK(report.refused_tiles == 0 && report.changed_tiles >= 4 && report.changed_tiles <= 9);
    CHECK_NEAR(report.texels, 4 * 256, 150);
    check_look(detail, 4 * 10 + 4, color, &height);
    CHECK_NEAR(color[0], 0.5, 0.02);
    CHECK_NEAR(color[1], 0.0, 0.001);
    check_look(detail, 4 * 10 + 5, color, &height);
    CHECK_NEAR(color[0], 0.0, 0.001);
    CHECK_OK(rlv_document_undo(document, NULL));
    check_look(detail, 4 * 10 + 4, color, &height);
    CHECK_NEAR(color[0], 0.0, 0.001);

    /* White raises by the height. */
    for (size_t pixel = 0; pixel < WIDTH * HEIGHT; ++pixel) {
        pixels[pixel] = 1.0f;
    }
    image.channels = 1;
    CHECK_OK(rlv_decal_emboss(decal, &image, 0.25f, &report));
    check_look(detail, 4 * 10 + 4, color, &height);
    CHECK_NEAR(height, 0.25, 0.01);
    check_look(detail, 1 * 10 + 1, color, &height);
    CHECK_NEAR(height, 0.0, 1e-6);

    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_paint(decal, &image, 1.5f, &report), "opacity");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_emboss(decal, &image, NAN, &report), "height");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_emboss(decal, NULL, 1.0f, &report), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_pose(decal, pixels, 1, 0, NULL, NULL), "detail");
    image.pixel_count -= 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_paint(decal, &image, 1.0f, &report), "800 pixels");
    options.cells = 3;
    RlvDecal untouched = {77};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_on_detail(detail, &options, pins, 4, 0, NULL, NULL, &untouched), "cells");
    RlvJob job = RLV_NULL;
    options.cells = 2;
    CHECK_OK(rlv_job_decal_on_detail(detail, &options, pins, 4, 0, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_result(job));
    CHECK_OK(rlv_job_release(job));
    CHECK(untouched.id == 77);
    free(pixels);
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_decal_release(decal));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
}

/* Colours, displacement and vectors of a triangle mesh, whose quads are two triangles each. */
static void write_on_triangles(RlvContext context, RlvMesh plane) {
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvSurfaceOptions kind = RLV_SURFACE_OPTIONS_INIT;
    RlvDetailOptions detail_options = RLV_DETAIL_OPTIONS_INIT;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    RlvDecalPin pins[4];
    RlvDecalOptions options = RLV_DECAL_OPTIONS_INIT;
    RlvDecalImage image = RLV_DECAL_IMAGE_INIT;
    RlvDecalInk ink = RLV_DECAL_INK_INIT;
    RlvDecalReport report = RLV_DECAL_REPORT_INIT;
    RlvDecal decal = RLV_NULL;
    RlvVectorOptions vectors = RLV_VECTOR_OPTIONS_INIT;
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    const uint32_t inside = 2 * (4 * 10 + 4), outside = 2 * (1 * 10 + 1);
    const float middle[2] = {0.3f, 0.3f};
    float color[4], moved[3], height = 0.0f;
    float *pixels = make_white(&image);
    kind.kind = RLV_SURFACE_TRIANGLES;
    CHECK_OK(rlv_surface_create(context, plane, &kind, &surface));
    detail_options.tile_size = paint.tile_size = 16;
    paint.color[0] = paint.color[1] = paint.color[2] = 0.0f;
    CHECK_OK(rlv_detail_create(surface, &detail_options, NULL, &detail));
    set_pins(pins);
    options.width = WIDTH;
    options.height = HEIGHT;
    CHECK_OK(rlv_decal_on_detail(detail, &options, pins, 4, 0, NULL, NULL, &decal));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_paint(decal, &image, 1.0f, &report), "no colours");
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    CHECK_OK(rlv_decal_paint(decal, &image, 0.5f, &report));
    /* From (3, 4) to (7, 6): 8 quads, and those around them at most. */
    CHECK(report.refused_tiles == 0 && report.changed_tiles >= 16 && report.changed_tiles <= 48);
    CHECK(report.texels > 16 * 100);
    check_look(detail, inside, color, &height);
    CHECK_NEAR(color[0], 0.5, 0.02);
    check_look(detail, outside, color, &height);
    CHECK_NEAR(color[0], 0.0, 1e-6);
    CHECK_OK(rlv_decal_emboss(decal, &image, 0.25f, &report));
    check_look(detail, inside, color, &height);
    CHECK_NEAR(height, 0.25, 1e-3);
    check_look(detail, outside, color, &height);
    CHECK_NEAR(height, 0.0, 1e-6);
    ink.channel = RLV_CHANNEL_VECTORS;
    ink.blend = RLV_BLEND_ADD;
    ink.height = 0.1f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_write(decal, &image, &ink, &report), "no vector displacement");
    vectors.tile_size = 16;
    CHECK_OK(rlv_detail_add_vectors(detail, &vectors));
    CHECK_OK(rlv_decal_write(decal, &image, &ink, &report));
    CHECK(report.refused_tiles == 0 && report.texels > 16 * 100);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    arrays.count = 1;
    arrays.tiles = &inside;
    arrays.uvs = middle;
    arrays.vectors = moved;
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
    for (int axis = 0; axis < 3; ++axis) {
        CHECK_NEAR(moved[axis], 0.1, 1e-3);
    }
    arrays.tiles = &outside;
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
    CHECK_NEAR(moved[0], 0.0, 1e-6);
    ink.blend = RLV_BLEND_MAX;
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_decal_write(decal, &image, &ink, NULL), "blend");
    CHECK_OK(rlv_decal_release(decal));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    free(pixels);
}

/* A sheet with texture coordinates: the texture has the image where the decal lies, and a gutter around the sheet. */
static void paint_texture(RlvContext context) {
    enum { SIDE = 100 };
    RlvMesh plane = check_plane(context, 10, 10);
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    RlvAttributeArrays uv = RLV_ATTRIBUTE_ARRAYS_INIT;
    RlvDecalPin pins[4];
    RlvDecalOptions options = RLV_DECAL_OPTIONS_INIT;
    RlvDecalImage image = RLV_DECAL_IMAGE_INIT;
    RlvDecalTexture texture = RLV_DECAL_TEXTURE_INIT;
    RlvDecal decal = RLV_NULL;
    size_t painted = 77;
    float *white = malloc(WIDTH * HEIGHT * 4), *pixels = calloc(SIDE * SIDE, 4);
    CHECK(white != NULL && pixels != NULL);
    for (size_t pixel = 0; pixel < WIDTH * HEIGHT; ++pixel) {
        white[pixel] = 1.0f;
    }
    image.channels = texture.channels = 1;
    image.pixels = white;
    image.pixel_count = WIDTH * HEIGHT;
    texture.width = texture.height = SIDE;
    texture.pixels = pixels;
    texture.pixel_count = SIDE * SIDE;
    set_pins(pins);
    options.width = WIDTH;
    options.height = HEIGHT;
    CHECK_OK(rlv_decal_on_mesh(plane, &options, pins, 4, 0, NULL, NULL, &decal));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_paint_texture(decal, &image, 1.0f, &texture, &painted),
                "no texture coordinates");
    CHECK_OK(rlv_decal_release(decal));

    CHECK_OK(rlv_mesh_info(plane, &info));
    float *points = malloc(info.point_count * 12), *uvs = malloc(info.point_count * 8);
    CHECK(points != NULL && uvs != NULL);
    CHECK_OK(rlv_mesh_get_points(plane, points, info.point_count, 0));
    for (size_t point = 0; point < info.point_count; ++point) {
        uvs[2 * point] = 0.1f * points[3 * point];
        uvs[2 * point + 1] = 0.1f * points[3 * point + 1];
    }
    uv.name = "uv";
    uv.domain = RLV_DOMAIN_POINT;
    uv.type = RLV_TYPE_F32;
    uv.width = 2;
    uv.values = uvs;
    uv.value_count = info.point_count;
    CHECK_OK(rlv_mesh_add_attribute(plane, &uv));
    CHECK_OK(rlv_decal_on_mesh(plane, &options, pins, 4, 0, NULL, NULL, &decal));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_paint_texture(decal, &image, 2.0f, &texture, &painted), "opacity");
    texture.pixel_count -= 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_paint_texture(decal, &image, 1.0f, &texture, &painted), "texture");
    texture.pixel_count += 1;
    texture.pixels = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_paint_texture(decal, &image, 1.0f, &texture, NULL), "NULL");
    texture.pixels = pixels;
    CHECK(painted == 77);
    CHECK_OK(rlv_decal_paint_texture(decal, &image, 0.5f, &texture, &painted));
    /* From (3, 4) to (7, 6) of 10 units, rows from the top. */
    CHECK(painted == 40 * 20);
    CHECK_NEAR(pixels[50 * SIDE + 50], 0.5, 1e-5);
    CHECK(pixels[50 * SIDE + 20] == 0.0f && pixels[30 * SIDE + 50] == 0.0f);
    CHECK_OK(rlv_decal_release(decal));
    CHECK_OK(rlv_mesh_release(plane));
    free(white);
    free(pixels);
    free(points);
    free(uvs);
}

/* The outline of what is opaque, and pins along a curve. */
static void cut_and_strip(RlvContext context, RlvMesh plane) {
    RlvDecalImage image = RLV_DECAL_IMAGE_INIT;
    RlvDecalOptions options = RLV_DECAL_OPTIONS_INIT;
    RlvDecalQuality quality = RLV_DECAL_QUALITY_INIT;
    RlvDecal decal = RLV_NULL;
    size_t count = 0;
    float *pixels = calloc(WIDTH * HEIGHT, 16);
    CHECK(pixels != NULL);
    for (size_t pixel = 0; pixel < WIDTH * HEIGHT; ++pixel) {
        pixels[4 * pixel + 3] = pixel % WIDTH >= 10 && pixel % WIDTH < 30 ? 1.0f : 0.0f;
    }
    image.pixels = pixels;
    image.pixel_count = WIDTH * HEIGHT;
    CHECK_OK(rlv_decal_contour(&image, WIDTH, HEIGHT, 0.5, 0.25, NULL, 0, &count));
    CHECK(count >= 4 && count <= 12);
    double corners[2 * 12], area = 0.0;
    size_t needed = 77;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_contour(&image, WIDTH, HEIGHT, 0.5, 0.25, corners, 3, &needed), "corners");
    CHECK(needed == count);
    CHECK_OK(rlv_decal_contour(&image, WIDTH, HEIGHT, 0.5, 0.25, corners, 12, &count));
    for (size_t corner = 0; corner < count; ++corner) {
        const double *a = corners + 2 * corner, *b = corners + 2 * ((corner + 1) % count);
        area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
    }
    CHECK_NEAR(area, 20.0 * HEIGHT, 20.0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_contour(&image, WIDTH, HEIGHT, 1.5, 0.25, NULL, 0, &count), "level");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_contour(&image, WIDTH, WIDTH, 0.5, 0.25, NULL, 0, &count), "1600 pixels");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_contour(&image, WIDTH, HEIGHT, 0.5, 0.25, NULL, 0, NULL), "count");
    image.channels = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_contour(&image, WIDTH, HEIGHT, 0.5, 0.25, NULL, 0, &count), "no alpha");
    free(pixels);

    /* A strip of 8 by 1 units. */
    const double curve[6] = {1.0, 5.0, 0.0, 9.0, 5.0, 0.0};
    RlvDecalPin pins[16];
    double length = 0.0;
    options.width = 80;
    options.height = 10;
    CHECK_OK(rlv_decal_strip_on_mesh(plane, &options, curve, 2, 0, NULL, 0, &count, &length));
    CHECK(count == 9);
    CHECK_NEAR(length, 8.0, 1e-9);
    CHECK_OK(rlv_decal_strip_on_mesh(plane, &options, curve, 2, 0, pins, 16, &count, NULL));
    for (size_t pin = 0; pin < count; ++pin) {
        CHECK_NEAR(pins[pin].position[0], 1.0 + 0.1 * pins[pin].image[0], 1e-3);
        CHECK_NEAR(pins[pin].image[1], 5.0, 1e-9);
    }
    CHECK_OK(rlv_decal_on_mesh(plane, &options, pins, count, 0, NULL, NULL, &decal));
    CHECK_OK(rlv_decal_quality(decal, &quality));
    CHECK(quality.flip_count == 0 && quality.coverage > 0.999);
    CHECK_NEAR(quality.l2, 1.0, 1e-3);
    CHECK_OK(rlv_decal_release(decal));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_strip_on_mesh(plane, &options, curve, 1, 0, pins, 16, &count, NULL), "curve");
    needed = 77;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_strip_on_mesh(plane, &options, curve, 2, 0, pins, 3, &needed, NULL), "pins");
    CHECK(needed == count);

    /* The same on the surface of a detail; its boundary is that of the plane. */
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    options.cells = 2;
    CHECK_OK(rlv_decal_strip_on_detail(detail, &options, curve, 2, 0, pins, 16, &count, &length));
    CHECK(count >= 9 && count <= 10);
    CHECK_NEAR(length, 8.0, 1e-4);
    options.cells = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_strip_on_detail(detail, &options, curve, 2, 0, pins, 16, &count, NULL),
                "cells");

    /* Vectors: grey leaves the surface where it is, red moves it along the image's direction to the right. */
    RlvVectorOptions vectors = RLV_VECTOR_OPTIONS_INIT;
    RlvDecalInk ink = RLV_DECAL_INK_INIT;
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    const uint32_t tile = 10 * 4 + 4;
    const float uv[2] = {0.5f, 0.5f};
    float moved[3] = {0.0f, 0.0f, 0.0f};
    set_pins(pins);
    /* The image is turned by a right angle about the middle of the sticker: right in it is up on the surface. */
    for (size_t pin = 0; pin < 4; ++pin) {
        const double across = pins[pin].position[0] - 5.0, up = pins[pin].position[1] - 5.0;
        pins[pin].position[0] = 5.0 - up;
        pins[pin].position[1] = 5.0 + across;
    }
    options.cells = 4;
    options.width = WIDTH;
    options.height = HEIGHT;
    CHECK_OK(rlv_decal_on_detail(detail, &options, pins, 4, 0, NULL, NULL, &decal));
    pixels = malloc(WIDTH * HEIGHT * 12);
    CHECK(pixels != NULL);
    for (size_t pixel = 0; pixel < WIDTH * HEIGHT; ++pixel) {
        pixels[3 * pixel] = 1.0f;
        pixels[3 * pixel + 1] = 0.5f;
        pixels[3 * pixel + 2] = 0.75f;
    }
    image.pixels = pixels;
    ink.channel = RLV_CHANNEL_VECTORS;
    ink.blend = RLV_BLEND_ADD;
    ink.height = 0.2f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_write(decal, &image, &ink, NULL), "no vector displacement");
    vectors.tile_size = 16;
    CHECK_OK(rlv_detail_add_vectors(detail, &vectors));
    ink.opacity = 0.5f;
    CHECK_OK(rlv_decal_write(decal, &image, &ink, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    arrays.count = 1;
    arrays.tiles = &tile;
    arrays.uvs = uv;
    arrays.vectors = moved;
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
    CHECK_NEAR(moved[0], 0.0, 1e-3);
    CHECK_NEAR(moved[1], 0.1, 1e-3);
    CHECK_NEAR(moved[2], 0.05, 1e-3);
    ink.blend = RLV_BLEND_SUBTRACT;
    CHECK_OK(rlv_decal_write(decal, &image, &ink, NULL));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
    CHECK_NEAR(moved[1], 0.0, 1e-3);
    ink.blend = RLV_BLEND_MAX;
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_decal_write(decal, &image, &ink, NULL), "blend");
    ink.channel = RLV_CHANNEL_TRACES;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_write(decal, &image, &ink, NULL), "channel");
    ink.blend = 77;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_write(decal, &image, &ink, NULL), "blend mode 77");

    /* The higher of relief and surface; colours multiplied. */
    float color[4], height = 0.0f;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    ink.channel = RLV_CHANNEL_DISPLACEMENT;
    ink.blend = RLV_BLEND_MAX;
    ink.opacity = 1.0f;
    ink.height = -1.0f;
    CHECK_OK(rlv_decal_write(decal, &image, &ink, NULL));
    paint.color[0] = paint.color[1] = paint.color[2] = 0.5f;
    paint.tile_size = 16;
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    ink.channel = RLV_CHANNEL_COLOR;
    ink.blend = RLV_BLEND_MULTIPLY;
    CHECK_OK(rlv_decal_write(decal, &image, &ink, NULL));
    check_look(detail, tile, color, &height);
    CHECK_NEAR(height, 0.0, 1e-6);
    CHECK_NEAR(color[0], 0.5, 0.01);
    CHECK_NEAR(color[1], 0.25, 0.01);
    CHECK_NEAR(color[2], 0.375, 0.01);
    free(pixels);
    CHECK_OK(rlv_decal_release(decal));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
}

/* Keeps a decal in a document of a surface, takes it up again with a moved pin, undoes that, and removes it. `tile` is
 * under the sticker as it was laid, `beside` as its pins were moved. */
static void keep_in_document(RlvContext context, RlvMesh plane, uint32_t kind, uint32_t tile, uint32_t beside) {
    RlvSurfaceOptions surface_options = RLV_SURFACE_OPTIONS_INIT;
    RlvDetailOptions detail_options = RLV_DETAIL_OPTIONS_INIT;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    RlvDecalOptions options = RLV_DECAL_OPTIONS_INIT;
    RlvDecalImage image = RLV_DECAL_IMAGE_INIT;
    RlvDecalInk ink = RLV_DECAL_INK_INIT;
    RlvDecalRecipe recipe = RLV_DECAL_RECIPE_INIT;
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDocument document = RLV_NULL;
    RlvDecal decal = RLV_NULL, again = RLV_NULL;
    RlvDecalPin pins[4], found[4];
    float color[4], height = 0.0f;
    uint32_t id = 77;
    size_t count = 77;
    float *pixels = make_white(&image);
    surface_options.kind = kind;
    CHECK_OK(rlv_surface_create(context, plane, &surface_options, &surface));
    detail_options.tile_size = paint.tile_size = 16;
    paint.color[0] = paint.color[1] = paint.color[2] = 0.0f;
    CHECK_OK(rlv_detail_create(surface, &detail_options, NULL, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_document_create(detail, NULL, 0, &document));
    set_pins(pins);
    options.width = WIDTH;
    options.height = HEIGHT;
    options.cells = 4;
    CHECK_OK(rlv_decal_on_detail(detail, &options, pins, 4, 0, NULL, NULL, &decal));
    ink.channel = RLV_CHANNEL_VECTORS;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_apply(decal, document, "label", &image, &ink, NULL, NULL, &id), "no layers");
    ink.channel = RLV_CHANNEL_COLOR;
    ink.opacity = 0.5f;
    CHECK_OK(rlv_decal_apply(decal, document, "label", &image, &ink, NULL, NULL, &id));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_apply(decal, document, "label", &image, &ink, NULL, NULL, &id), "name");
    CHECK_OK(rlv_decal_release(decal));
    check_look(detail, tile, color, &height);
    CHECK_NEAR(color[0], 0.5, 0.02);
    check_look(detail, beside, color, &height);
    CHECK_NEAR(color[0], 0.0, 1e-6);
    CHECK_OK(rlv_decal_count(document, &count));
    CHECK(count == 1);
    CHECK_OK(rlv_decal_recipe(document, 0, &recipe));
    CHECK(recipe.id == id && recipe.pin_count == 4 && recipe.width == WIDTH && recipe.height == HEIGHT);
    CHECK(recipe.channel == RLV_CHANNEL_COLOR && recipe.opacity == 0.5f && recipe.image_hash != 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_recipe(document, 1, &recipe), "there are 1");

    /* Moved by two quads to the right and up, and wholly opaque. */
    CHECK_OK(rlv_decal_take_up(document, id, NULL, NULL, &again));
    size_t needed = 77;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_pins(again, found, 3, &needed), "pins");
    CHECK(needed == 4);
    CHECK_OK(rlv_decal_pins(again, found, 4, &count));
    CHECK(count == 4);
    for (size_t pin = 0; pin < 4; ++pin) {
        for (size_t axis = 0; axis < 2; ++axis) {
            CHECK_NEAR(found[pin].image[axis], pins[pin].image[axis], 1e-9);
            CHECK_NEAR(found[pin].position[axis], pins[pin].position[axis], 1e-4);
            found[pin].position[axis] += 2.0;
        }
    }
    CHECK_OK(rlv_decal_release(again));
    CHECK_OK(rlv_decal_on_detail(detail, &options, found, 4, 0, NULL, NULL, &again));
    ink.opacity = 1.0f;
    CHECK_OK(rlv_decal_update(again, document, id, &image, &ink, NULL, NULL));
    check_look(detail, tile, color, &height);
    CHECK_NEAR(color[0], 0.0, 1e-6);
    check_look(detail, beside, color, &height);
    CHECK_NEAR(color[0], 1.0, 0.02);
    ink.channel = RLV_CHANNEL_DISPLACEMENT;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_update(again, document, id, &image, &ink, NULL, NULL), "another kind");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_update(again, document, id + 1, &image, NULL, NULL, NULL), "no decal");
    CHECK_OK(rlv_document_undo(document, NULL));
    check_look(detail, tile, color, &height);
    CHECK_NEAR(color[0], 0.5, 0.02);
    CHECK_OK(rlv_decal_remove(document, id));
    check_look(detail, tile, color, &height);
    CHECK_NEAR(color[0], 0.0, 1e-6);
    CHECK_OK(rlv_decal_count(document, &count));
    CHECK(count == 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_take_up(document, id, NULL, NULL, &decal), "no decal");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_remove(document, id), "no decal");

    /* A decal on a mesh has no detail, and none of another document. */
    CHECK_OK(rlv_decal_release(again));
    CHECK_OK(rlv_decal_on_mesh(plane, &options, pins, 4, 0, NULL, NULL, &again));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_decal_apply(again, document, "label", &image, NULL, NULL, NULL, &id),
                "the detail of the document");
    CHECK_OK(rlv_decal_release(again));
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    free(pixels);
}

int main(void) {
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh plane = check_plane(context, 10, 10);
    lay_on_mesh(context, plane);
    write_into_layers(context, plane);
    write_on_triangles(context, plane);
    paint_texture(context);
    cut_and_strip(context, plane);
    keep_in_document(context, plane, RLV_SURFACE_CATMULL_CLARK, 10 * 4 + 4, 10 * 7 + 7);
    keep_in_document(context, plane, RLV_SURFACE_TRIANGLES, 2 * (10 * 4 + 4), 2 * (10 * 7 + 7));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
