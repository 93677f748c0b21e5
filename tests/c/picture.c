/* Pictures: documents and Ptex files as images. Pixels are what the detail has there, gutters continue tiles, levels are
 * means, meta data is there, damaged files and places outside are refused. */
#include "check.h"

enum { SIDE = 32, CELL = 40, GUTTER = 4, COLUMNS = 3 };

/* A name for a file of this process. */
static void name_file(char *out, size_t size, const char *extension, const void *unique) {
    snprintf(out, size, "picture-%p.%s", unique, extension);
}

/* All of a file. */
static unsigned char *load(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    unsigned char *bytes = malloc(1 << 20);
    CHECK(file != NULL && bytes != NULL);
    *size = fread(bytes, 1, 1 << 20, file);
    CHECK(*size > 64 && *size < 1 << 20 && fclose(file) == 0);
    return bytes;
}

static float half_of(uint16_t bits) {
    const int exponent = (bits >> 10) & 31;
    const float mantissa = (float)(bits & 1023);
    const float value = exponent == 0 ? ldexpf(mantissa, -24) : ldexpf(1024.0f + mantissa, exponent - 25);
    return bits & 0x8000 ? -value : value;
}

/* The numbers of a pixel of an image. */
static void pixel(RlvPicture picture, uint32_t image, uint32_t level, uint32_t x, uint32_t y, float *out) {
    RlvPictureImage info = RLV_PICTURE_IMAGE_INIT;
    union {
        uint16_t halves[4];
        float floats[4];
    } bytes;
    CHECK_OK(rlv_picture_image(picture, image, &info));
    CHECK_OK(rlv_picture_read(picture, image, level, x, y, 1, 1, &bytes, 0));
    for (uint32_t channel = 0; channel < info.channels; ++channel) {
        out[channel] = info.type == RLV_PICTURE_F16 ? half_of(bytes.halves[channel]) : bytes.floats[channel];
    }
}

/* What bilinear look-up gives at a place of a tile. */
static float look_up(RlvPicture picture, uint32_t image, uint32_t channel, uint32_t tile, float u, float v) {
    RlvPictureImage at = RLV_PICTURE_IMAGE_INIT;
    CHECK_OK(rlv_picture_image(picture, image, &at));
    const float x = (float)(tile % at.columns * at.cell + at.gutter) + u * (float)at.side - 0.5f;
    const float y = (float)(tile / at.columns * at.cell + at.gutter) + v * (float)at.side - 0.5f;
    const float s = x - floorf(x), t = y - floorf(y);
    float corners[4][4];
    for (uint32_t k = 0; k < 4; ++k) {
        pixel(picture, image, 0, (uint32_t)floorf(x) + k % 2, (uint32_t)floorf(y) + k / 2, corners[k]);
    }
    return (1 - t) * ((1 - s) * corners[0][channel] + s * corners[1][channel]) +
           t * ((1 - s) * corners[2][channel] + s * corners[3][channel]);
}

static void evaluate(RlvDetail detail, size_t count, const uint32_t *tiles, const float *uvs, float *heights, float *colors) {
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    arrays.count = count;
    arrays.tiles = tiles;
    arrays.uvs = uvs;
    arrays.displacements = heights;
    arrays.colors = colors;
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
}

/* A document of triangles: the middles of texels and their places on the sides have what the detail has, elsewhere it is
 * near, and both faces of a side agree. */
static void check_triangles(RlvContext context, const char *path) {
    enum { SEGMENTS = 16, FACES = 18, RUN = 24, PLACES = 6 * RUN };
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDocument document = RLV_NULL;
    RlvPicture picture = RLV_NULL;
    RlvSurfaceOptions kind = RLV_SURFACE_OPTIONS_INIT;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    RlvLayerOptions half = RLV_LAYER_OPTIONS_INIT;
    RlvPictureInfo info = RLV_PICTURE_INFO_INIT;
    RlvPictureImage image = RLV_PICTURE_IMAGE_INIT;
    uint32_t layer = 0;
    RlvMesh plane = check_plane(context, 3, 3);
    kind.kind = RLV_SURFACE_TRIANGLES;
    options.tile_size = paint.tile_size = SEGMENTS;
    CHECK_OK(rlv_surface_create(context, plane, &kind, &surface));
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    CHECK_OK(rlv_detail_add_vectors(detail, NULL));
    check_stroke(context, detail, RLV_BRUSH_PAINT, 1.8, 1.6, 0.6f);
    check_stroke(context, detail, RLV_BRUSH_SCULPT, 1.8, 1.6, 0.6f);
    /* Two layers of displacement, one of which counts half. */
    half.tile_size = SEGMENTS;
    half.opacity = 0.5f;
    CHECK_OK(rlv_layer_add(detail, "half", &half, &layer));
    CHECK_OK(rlv_layer_set_active(detail, layer));
    check_stroke(context, detail, RLV_BRUSH_SCULPT, 1.2, 2.6, 0.4f);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    CHECK_OK(rlv_document_create(detail, path, 0, &document));
    CHECK_OK(rlv_document_release(document));

    CHECK_OK(rlv_picture_open(context, path, &picture));
    CHECK_OK(rlv_picture_info(picture, &info));
    CHECK(info.format == RLV_PICTURE_DOCUMENT && info.face_count == FACES && info.tile_count == FACES);
    CHECK(info.image_count == 5);
    CHECK_OK(rlv_picture_image(picture, 1, &image));
    CHECK(image.content == RLV_PICTURE_DISPLACEMENT && image.is_layer == 0 && image.level_count == 2);
    CHECK(image.columns == 5 && image.side == SEGMENTS && image.cell == 20 && image.width == 100 && image.height == 80);
    CHECK_OK(rlv_picture_image(picture, 4, &image));
    CHECK(image.content == RLV_PICTURE_VECTORS && image.channels == 3);

    static uint32_t tiles[PLACES];
    static float uvs[PLACES][2], heights[PLACES], colors[PLACES][4];
    uint32_t random = 1;
    for (uint32_t k = 0; k < PLACES; ++k) {
        uint32_t at[2];
        tiles[k] = k % FACES;
        for (int axis = 0; axis < 2; ++axis) {
            random = random * 1664525u + 1013904223u;
            at[axis] = (random >> 8) % SEGMENTS;
        }
        const float middle = ((float)at[0] + 0.5f) / SEGMENTS;
        switch (k / RUN) {
        case 0: uvs[k][0] = middle, uvs[k][1] = 0.0f; break;
        case 1: uvs[k][0] = 0.0f, uvs[k][1] = middle; break;
        case 2: uvs[k][0] = middle, uvs[k][1] = 1.0f - middle; break;
        default: {
            /* Middles of texels, and then places between them. */
            const float add = k / RUN == 3 ? 0.5f : (float)(random >> 24) / 256.0f;
            uvs[k][0] = ((float)at[0] + add) / SEGMENTS;
            uvs[k][1] = ((float)at[1] + add) / SEGMENTS;
            if (uvs[k][0] + uvs[k][1] > 1.0f) {
                uvs[k][0] = 1.0f - uvs[k][0];
                uvs[k][1] = 1.0f - uvs[k][1];
            }
        }
        }
    }
    evaluate(detail, PLACES, tiles, uvs[0], heights, colors[0]);
    float highest = 0.0f;
    for (uint32_t k = 0; k < PLACES; ++k) {
        CHECK_NEAR(look_up(picture, 1, 0, tiles[k], uvs[k][0], uvs[k][1]), heights[k], k / RUN < 4 ? 1e-5 : 1.5e-2);
        for (uint32_t channel = 0; channel < 4; ++channel) {
            const float found = look_up(picture, 0, channel, tiles[k], uvs[k][0], uvs[k][1]);
            CHECK_NEAR(found, colors[k][channel], k / RUN < 4 ? 2e-3 : 4e-2);
        }
        highest = fmaxf(highest, fabsf(heights[k]));
    }
    CHECK(highest > 0.05f);
    /* The diagonal of the quad in the middle: the last side of one triangle, the first of the other; at any place. */
    for (uint32_t k = 0; k <= 24; ++k) {
        const float along = (float)k / 24.0f;
        const float across = look_up(picture, 1, 0, 8, 0.0f, along);
        CHECK_NEAR(across, look_up(picture, 1, 0, 9, along, 0.0f), k == 0 || k == 24 ? 1e-5 : 1e-3);
    }
    /* A level is the mean of the one before in the triangle. */
    float mean = 0.0f, found[4];
    for (uint32_t k = 0; k < 4; ++k) {
        pixel(picture, 1, 0, 3 * 20 + 2 + 4 + k % 2, 20 + 2 + 6 + k / 2, found);
        mean += 0.25f * found[0];
    }
    pixel(picture, 1, 1, 3 * 10 + 1 + 2, 10 + 1 + 3, found);
    CHECK_NEAR(found[0], mean, 1e-6);
    CHECK_OK(rlv_picture_release(picture));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
}

static void check_document(RlvContext context, RlvDetail detail, const char *path) {
    RlvPicture picture = RLV_NULL;
    RlvPictureInfo info = RLV_PICTURE_INFO_INIT;
    RlvPictureImage image = RLV_PICTURE_IMAGE_INIT;
    CHECK_OK(rlv_picture_open(context, path, &picture));
    CHECK_OK(rlv_picture_info(picture, &info));
    CHECK(info.format == RLV_PICTURE_DOCUMENT && info.image_count == 2 && info.face_count == 9 && info.tile_count == 9);
    CHECK_OK(rlv_picture_image(picture, 0, &image));
    CHECK(image.content == RLV_PICTURE_COLOR && image.type == RLV_PICTURE_F16 && image.channels == 4 && image.alpha == 3);
    CHECK(image.width == COLUMNS * CELL && image.height == COLUMNS * CELL && image.level_count == 3);
    CHECK(image.columns == COLUMNS && image.cell == CELL && image.side == SIDE && image.gutter == GUTTER);
    CHECK(image.is_layer == 1 && image.is_visible == 1 && image.opacity == 1.0f && image.name[0] != 0);
    CHECK_OK(rlv_picture_image(picture, 1, &image));
    CHECK(image.content == RLV_PICTURE_DISPLACEMENT && image.type == RLV_PICTURE_F32 && image.channels == 1);
    CHECK(image.alpha == RLV_PICTURE_NONE && image.face == RLV_PICTURE_NONE);

    /* Centres of texels of all tiles, and both sides of the edge between tiles 4 and 5. */
    enum { PLACES = 9 + 2 * 5 };
    uint32_t tiles[PLACES];
    float uvs[PLACES][2], heights[PLACES], colors[PLACES][4];
    for (uint32_t tile = 0; tile < 9; ++tile) {
        tiles[tile] = tile;
        uvs[tile][0] = (11.5f + (float)tile) / SIDE;
        uvs[tile][1] = (8.5f + (float)tile) / SIDE;
    }
    for (uint32_t k = 0; k < 10; ++k) {
        tiles[9 + k] = 4 + k % 2;
        uvs[9 + k][0] = k % 2 ? 0.0f : 1.0f;
        uvs[9 + k][1] = (0.5f + (float)(k / 2 * 7)) / SIDE;
    }
    evaluate(detail, PLACES, tiles, uvs[0], heights, colors[0]);
    float highest = 0.0f;
    for (uint32_t k = 0; k < PLACES; ++k) {
        CHECK_NEAR(look_up(picture, 1, 0, tiles[k], uvs[k][0], uvs[k][1]), heights[k], 2e-4);
        for (uint32_t channel = 0; channel < 4; ++channel) {
            CHECK_NEAR(look_up(picture, 0, channel, tiles[k], uvs[k][0], uvs[k][1]), colors[k][channel], 6e-3);
        }
        highest = fmaxf(highest, fabsf(heights[k]));
    }
    CHECK(highest > 0.05f);

    /* A level is the mean of the one before, tile by tile. */
    for (uint32_t at = 0; at < 2; ++at) {
        float mean = 0.0f, found[4];
        for (uint32_t k = 0; k < 4; ++k) {
            pixel(picture, 1, at, ((CELL + GUTTER) >> at) + 4 + k % 2, ((CELL + GUTTER) >> at) + 2 + k / 2, found);
            mean += 0.25f * found[0];
        }
        pixel(picture, 1, at + 1, (((CELL + GUTTER) >> at) + 4) / 2, (((CELL + GUTTER) >> at) + 2) / 2, found);
        CHECK_NEAR(found[0], mean, 1e-6);
    }

    /* Rows that are apart; what lies between them is left alone. */
    float rows[2][5] = {{9, 9, 9, 9, 9}, {9, 9, 9, 9, 9}}, one;
    CHECK_OK(rlv_picture_read(picture, 1, 0, 50, 60, 4, 2, rows, sizeof rows[0]));
    CHECK(rows[0][4] == 9 && rows[1][4] == 9);
    pixel(picture, 1, 0, 53, 61, &one);
    CHECK(rows[1][3] == one);

    CHECK_FAILS(RLV_ERROR_INVALID, rlv_picture_read(picture, 1, 0, 119, 0, 2, 1, rows, 0), "outside");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_picture_read(picture, 1, 0, 0xffffffffu, 0, 2, 1, rows, 0), "outside");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_picture_read(picture, 1, 3, 0, 0, 1, 1, rows, 0), "no level 3");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_picture_read(picture, 1, 1, 59, 60, 1, 1, rows, 0), "outside");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_picture_read(picture, 1, 0, 0, 0, 2, 1, rows, 4), "row_stride");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_picture_read(picture, 1, 0, 0, 0, 1, 1, NULL, 0), "pixels");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_picture_read(picture, 2, 0, 0, 0, 1, 1, rows, 0), "no image 2");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_picture_image(picture, 7, &image), "no image 7");

    int writers = 0;
    for (uint32_t index = 0; index < info.meta_count; ++index) {
        RlvPictureMeta meta = RLV_PICTURE_META_INIT;
        CHECK_OK(rlv_picture_meta(picture, index, &meta));
        if (strcmp(meta.name, "writer") == 0) {
            CHECK(meta.type == RLV_PICTURE_TEXT && strlen(meta.values) == meta.count);
            ++writers;
        } else if (strcmp(meta.name, "faces") == 0) {
            CHECK(meta.type == RLV_PICTURE_I32 && meta.count == 1 && *(const int32_t *)meta.values == 9);
        }
    }
    CHECK(writers == 1);
    RlvPictureMeta none = RLV_PICTURE_META_INIT;
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_picture_meta(picture, info.meta_count, &none), "nothing at index");
    CHECK_OK(rlv_picture_retain(picture));
    CHECK_OK(rlv_picture_release(picture));
    CHECK_OK(rlv_picture_release(picture));
    CHECK(rlv_picture_info(picture, &info) == RLV_ERROR_INVALID);
}

static void check_ptex(RlvContext context, const char *path) {
    RlvPicture picture = RLV_NULL;
    RlvPictureInfo info = RLV_PICTURE_INFO_INIT;
    RlvPictureImage image = RLV_PICTURE_IMAGE_INIT;
    unsigned char texels[SIDE * SIDE * 4];
    CHECK_OK(rlv_picture_open(context, path, &picture));
    CHECK_OK(rlv_picture_info(picture, &info));
    CHECK(info.format == RLV_PICTURE_PTEX && info.image_count == 9 && info.face_count == 9);
    CHECK_OK(rlv_picture_image(picture, 4, &image));
    CHECK(image.content == RLV_PICTURE_NUMBERS && image.face == 4 && image.width == SIDE && image.height == SIDE);
    CHECK(image.type == RLV_PICTURE_U8 && image.channels == 4 && image.level_count > 1);
    CHECK(strcmp(image.name, "face 4") == 0);
    CHECK_OK(rlv_picture_read(picture, 4, 0, 0, 0, SIDE, SIDE, texels, 0));
    CHECK(texels[4 * (16 * SIDE + 16) + 1] != texels[4 * (16 * SIDE + 16)]);
    CHECK_OK(rlv_picture_read(picture, 4, 1, 3, 4, 2, 2, texels, 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_picture_read(picture, 4, image.level_count, 0, 0, 1, 1, texels, 0), "no level");
    CHECK_OK(rlv_picture_release(picture));
}

/* Every cut and every flipped byte of a file is an error or a picture that reads, and never anything else. */
static void check_damage(RlvContext context, const char *path, const char *damaged) {
    size_t size = 0;
    unsigned char *bytes = load(path, &size);
    for (size_t step = 0; step < 60; ++step) {
        RlvPicture picture = RLV_NULL;
        const size_t at = step * size / 60;
        const size_t length = step % 2 ? at : size;
        bytes[at] ^= 0x5a;
        FILE *file = fopen(damaged, "wb");
        CHECK(file != NULL && fwrite(bytes, 1, length, file) == length && fclose(file) == 0);
        bytes[at] ^= 0x5a;
        if (rlv_picture_open(context, damaged, &picture) == RLV_OK) {
            RlvPictureInfo info = RLV_PICTURE_INFO_INIT;
            CHECK_OK(rlv_picture_info(picture, &info));
            for (uint32_t image = 0; image < info.image_count && image < 9; ++image) {
                unsigned char pixels[64];
                RlvPictureImage one = RLV_PICTURE_IMAGE_INIT;
                CHECK_OK(rlv_picture_image(picture, image, &one));
                if (one.channels <= 4) {
                    (void)rlv_picture_read(picture, image, 0, 0, 0, 1, 1, pixels, 0);
                }
            }
            CHECK_OK(rlv_picture_release(picture));
        } else {
            CHECK(strlen(rlv_error_last()) > 0 && picture.id == 0);
        }
    }
    free(bytes);
    remove(damaged);
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDocument document = RLV_NULL;
    RlvPicture picture = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    char path[64], ptex[64], damaged[64], triangles[80];
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh plane = check_plane(context, 3, 3);
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    options.tile_size = paint.tile_size = SIDE;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    check_stroke(context, detail, RLV_BRUSH_PAINT, 1.8, 1.6, 0.6f);
    check_stroke(context, detail, RLV_BRUSH_SCULPT, 1.8, 1.6, 0.6f);
    CHECK_OK(rlv_detail_commit(detail, NULL));
    name_file(path, sizeof path, "relievo", &context);
    name_file(ptex, sizeof ptex, "ptx", &context);
    name_file(damaged, sizeof damaged, "damaged", &context);
    CHECK_OK(rlv_document_create(detail, path, 0, &document));
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_ptex_write(detail, RLV_CHANNEL_COLOR, ptex, NULL, NULL));
    check_document(context, detail, path);
    check_ptex(context, ptex);
    check_damage(context, path, damaged);
    name_file(triangles, sizeof triangles, "triangles.relievo", &context);
    check_triangles(context, triangles);
    check_damage(context, triangles, damaged);
    remove(triangles);
    check_damage(context, ptex, damaged);

    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_picture_open(context, "nowhere.relievo", &picture), "nowhere.relievo");
    CHECK(rlv_picture_open(context, NULL, &picture) == RLV_ERROR_INVALID);
    CHECK(rlv_picture_open(context, path, NULL) == RLV_ERROR_INVALID);
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_picture_open(context, "/proc/self/exe", &picture), "neither");
    RlvContextOptions tight = RLV_CONTEXT_OPTIONS_INIT;
    RlvContext small = RLV_NULL;
    tight.threads = 1;
    tight.memory_limit = 1000;
    CHECK_OK(rlv_context_create(&tight, &small));
    CHECK(rlv_picture_open(small, path, &picture) == RLV_ERROR_MEMORY);
    CHECK_OK(rlv_context_release(small));

    remove(path);
    remove(ptex);
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
