/* Arrivals: a file that comes in pieces, a level that becomes finer meanwhile, and what is refused. */
#include "ball.h"

enum { SIDE = 160, PIECE = 5000 };

static char *read_all(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    CHECK(file != NULL && fseek(file, 0, SEEK_END) == 0);
    *size = (size_t)ftell(file);
    char *bytes = malloc(*size);
    CHECK(bytes != NULL && fseek(file, 0, SEEK_SET) == 0 && fread(bytes, 1, *size, file) == *size);
    fclose(file);
    return bytes;
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvProgressive built = RLV_NULL, there = RLV_NULL, untouched = {77};
    RlvArrival arrival = RLV_NULL;
    RlvArrivalInfo info = RLV_ARRIVAL_INFO_INIT;
    RlvLevel level = RLV_NULL;
    RlvLevelInfo shown = RLV_LEVEL_INFO_INIT;
    const char *path = "arrival_test.rlvpm";
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh ball = check_ball_of(context, 1.0, SIDE, SIDE);
    RlvMeshInfo given = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(ball, &given));
    CHECK_OK(rlv_progressive_create(ball, NULL, NULL, NULL, &built));
    CHECK_OK(rlv_progressive_write(built, path));
    size_t size = 0, triangles = 0, steps = 0;
    char *bytes = read_all(path, &size);

    CHECK_OK(rlv_arrival_create(context, &arrival));
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_arrival_progressive(arrival, &untouched), "base");
    CHECK(untouched.id == 77);
    for (size_t at = 0; at < size; at += PIECE) {
        CHECK_OK(rlv_arrival_push(arrival, bytes + at, size - at < PIECE ? size - at : PIECE, &info));
        CHECK(info.triangle_count >= triangles && info.is_complete == (at + PIECE >= size));
        if (info.triangle_count == triangles) {
            continue;
        }
        triangles = info.triangle_count;
        ++steps;
        CHECK_OK(rlv_arrival_progressive(arrival, &there));
        if (level.id == 0) {
            CHECK_OK(rlv_level_create(there, &level));
        } else {
            CHECK_OK(rlv_level_take_up(level, there));
        }
        CHECK_OK(rlv_level_set_triangles(level, SIZE_MAX));
        CHECK_OK(rlv_level_info(level, &shown));
        CHECK(shown.triangle_count == triangles);
        if (!info.is_complete) {
            CHECK_FAILS(RLV_ERROR_INVALID, rlv_progressive_write(there, path), "not all");
        }
        CHECK_OK(rlv_progressive_release(there));
    }
    CHECK(steps > 2 && triangles == given.face_count);
    CHECK_OK(rlv_arrival_push(arrival, NULL, 0, NULL));
    CHECK_OK(rlv_level_take_up(level, built));
    CHECK_OK(rlv_arrival_release(arrival));

    /* Less of it than a level has, and another mesh. */
    CHECK_OK(rlv_progressive_read(context, path, 200, &there));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_take_up(level, there), "less of it");
    CHECK_OK(rlv_progressive_release(there));
    CHECK_OK(rlv_level_info(level, &shown));
    CHECK(shown.triangle_count == triangles);

    /* What is damaged is refused, with all that comes after it. */
    CHECK_OK(rlv_arrival_create(context, &arrival));
    bytes[size / 2] ^= 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_arrival_push(arrival, bytes, size, &info), "damaged");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_arrival_push(arrival, bytes, 1, &info), "refused");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_arrival_progressive(arrival, &untouched), "base");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_arrival_push(arrival, NULL, 1, &info), "bytes");
    CHECK_OK(rlv_arrival_retain(arrival));
    CHECK_OK(rlv_arrival_release(arrival));
    CHECK_OK(rlv_arrival_release(arrival));
    CHECK(rlv_arrival_push(arrival, bytes, 1, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_arrival_create(context, NULL) == RLV_ERROR_INVALID);

    free(bytes);
    CHECK(remove(path) == 0);
    CHECK_OK(rlv_level_release(level));
    CHECK_OK(rlv_progressive_release(built));
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
