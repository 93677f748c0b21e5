/* Bytes: the same as the files of their nouns, read back as they were; damaged ones are refused. */
#include "ball.h"

/* The bytes of a file, which is removed. */
static uint8_t *load(const char *path, size_t *size) {
    FILE *file = fopen(path, "rb");
    CHECK(file != NULL && fseek(file, 0, SEEK_END) == 0);
    *size = (size_t)ftell(file);
    uint8_t *bytes = (uint8_t *)malloc(*size);
    CHECK(bytes != NULL && fseek(file, 0, SEEK_SET) == 0 && fread(bytes, 1, *size, file) == *size);
    CHECK(fclose(file) == 0 && remove(path) == 0);
    return bytes;
}

/* Whether bytes are those of a file, which is removed. */
static int is_file(RlvBytes bytes, const char *path) {
    const uint8_t *data = NULL;
    size_t size = 0, expected = 0;
    uint8_t *file = load(path, &expected);
    CHECK_OK(rlv_bytes_get(bytes, &data, &size));
    const int same = size == expected && memcmp(data, file, size) == 0;
    free(file);
    return same;
}

static void of_meshes(RlvContext context, RlvMesh ball) {
    const char *const formats[] = {"obj", "ply", "glb"};
    RlvBytes bytes = RLV_NULL;
    RlvMesh again = {77};
    RlvMeshInfo info = RLV_MESH_INFO_INIT, other = RLV_MESH_INFO_INIT;
    const uint8_t *data = NULL;
    size_t size = 0;
    char path[40];
    CHECK_OK(rlv_mesh_info(ball, &info));
    for (int k = 0; k < 3; ++k) {
        snprintf(path, sizeof path, "bytes_ball.%s", formats[k]);
        CHECK_OK(rlv_mesh_write_bytes(ball, formats[k], &bytes));
        CHECK_OK(rlv_mesh_write(ball, path));
        CHECK(is_file(bytes, path));
        CHECK_OK(rlv_bytes_get(bytes, &data, &size));
        CHECK_OK(rlv_mesh_read_bytes(context, formats[k], data, size, &again));
        CHECK_OK(rlv_mesh_info(again, &other));
        CHECK(other.face_count == info.face_count);
        CHECK_OK(rlv_mesh_release(again));
        again.id = 77;
        CHECK(rlv_mesh_read_bytes(context, formats[k], data, size / 2, &again) != RLV_OK && again.id == 77);
        CHECK_OK(rlv_bytes_release(bytes));
    }
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_mesh_write_bytes(ball, "stl", &bytes), "use obj, ply or glb");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_write_bytes(ball, NULL, &bytes), "format");
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_mesh_read_bytes(context, "doc", (const uint8_t *)"v 0 0 0", 7, &again), "format");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_mesh_read_bytes(context, "obj", NULL, 7, &again), "bytes");
    /* What bytes name lies in no folder. */
    const char *const outside = "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"uri\":\"/etc/hostname\",\"byteLength\":4}]}";
    CHECK(rlv_mesh_read_bytes(context, "gltf", (const uint8_t *)outside, strlen(outside), &again) != RLV_OK && again.id == 77);
}

static void of_progressive_meshes(RlvContext context, RlvMesh ball) {
    RlvProgressive built = RLV_NULL, again = {77};
    RlvBytes bytes = RLV_NULL;
    RlvProgressiveInfo info = RLV_PROGRESSIVE_INFO_INIT, other = RLV_PROGRESSIVE_INFO_INIT;
    const uint8_t *data = NULL;
    size_t size = 0;
    CHECK_OK(rlv_progressive_create(ball, NULL, NULL, NULL, &built));
    CHECK_OK(rlv_progressive_write_bytes(built, &bytes));
    CHECK_OK(rlv_progressive_write(built, "bytes_ball.rlvpm"));
    CHECK(is_file(bytes, "bytes_ball.rlvpm"));
    CHECK_OK(rlv_bytes_get(bytes, &data, &size));
    CHECK(rlv_progressive_read_bytes(context, data, size / 2, SIZE_MAX, &again) != RLV_OK && again.id == 77);
    CHECK_OK(rlv_progressive_read_bytes(context, data, size, SIZE_MAX, &again));
    CHECK_OK(rlv_progressive_info(built, &info));
    CHECK_OK(rlv_progressive_info(again, &other));
    CHECK(memcmp(&info, &other, sizeof info) == 0);
    CHECK_OK(rlv_progressive_release(again));
    CHECK_OK(rlv_progressive_release(built));
    CHECK_OK(rlv_bytes_release(bytes));
}

static RlvDetail plate(RlvSurface surface) {
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvDetail detail = RLV_NULL;
    options.tile_size = 32;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    return detail;
}

static void of_documents(RlvContext context) {
    RlvMesh plane = check_plane(context, 3, 3), mesh = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvDocument document = RLV_NULL, again = {77};
    RlvDocumentInfo info = RLV_DOCUMENT_INFO_INIT;
    RlvDocumentChanges changes = RLV_DOCUMENT_CHANGES_INIT;
    RlvMeshInfo of_mesh = RLV_MESH_INFO_INIT;
    RlvBytes bytes = RLV_NULL;
    const uint8_t *data = NULL;
    size_t size = 0;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    RlvDetail detail = plate(surface), other = plate(surface);
    CHECK_OK(rlv_document_create(detail, NULL, 0, &document));
    for (int k = 0; k < 4; ++k) {
        CHECK_OK(rlv_document_begin(document, "a dent"));
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_save_bytes(document, &bytes), "under way");
        check_dent(context, detail, 0.5 + 0.6 * k);
        CHECK_OK(rlv_document_end(document, NULL));
    }
    CHECK_OK(rlv_document_undo(document, NULL));
    CHECK_OK(rlv_document_save_bytes(document, &bytes));
    CHECK_OK(rlv_document_save(document, "bytes_plate.relievo"));
    CHECK_OK(rlv_document_release(document));
    CHECK(is_file(bytes, "bytes_plate.relievo"));

    /* All of it comes back, and goes on in memory. */
    CHECK_OK(rlv_bytes_get(bytes, &data, &size));
    CHECK_OK(rlv_document_open_bytes(other, data, size, 0, &again));
    CHECK_OK(rlv_document_info(again, &info));
    CHECK(info.undo_count == 3 && info.redo_count == 1);
    CHECK_OK(rlv_document_redo(again, &changes));
    CHECK(changes.is_done == 1 && changes.block_count > 2);
    CHECK_OK(rlv_document_begin(again, "one more"));
    check_dent(context, other, 1.4);
    CHECK_OK(rlv_document_end(again, &changes));
    CHECK(changes.is_done == 1);
    for (int k = 0; k < 5; ++k) {
        CHECK_OK(rlv_document_undo(again, &changes));
        CHECK(changes.is_done == 1);
    }
    CHECK_OK(rlv_document_release(again));
    CHECK_OK(rlv_document_mesh_bytes(context, data, size, &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &of_mesh));
    CHECK(of_mesh.face_count == 9);
    CHECK_OK(rlv_mesh_release(mesh));
    again.id = 77;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_open_bytes(other, data, 30, 0, &again), "bytes");
    CHECK(rlv_document_open_bytes(other, NULL, 0, 0, &again) != RLV_OK && again.id == 77);
    CHECK(rlv_document_mesh_bytes(context, data, size / 3, &mesh) != RLV_OK);
    CHECK_OK(rlv_bytes_release(bytes));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_detail_release(other));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvBytes bytes = {77};
    const uint8_t *data = NULL;
    size_t size = 0;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh ball = check_ball(context, 1.0);
    of_meshes(context, ball);
    of_progressive_meshes(context, ball);
    of_documents(context);

    /* Bytes outlive what they were made of, until they are released. */
    CHECK_OK(rlv_mesh_write_bytes(ball, "ply", &bytes));
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_context_release(context));
    CHECK_OK(rlv_bytes_retain(bytes));
    CHECK_OK(rlv_bytes_release(bytes));
    CHECK_OK(rlv_bytes_get(bytes, &data, &size));
    CHECK(size > 4 && memcmp(data, "ply\n", 4) == 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bytes_get(bytes, NULL, &size), "data");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bytes_get(bytes, &data, NULL), "size");
    CHECK_OK(rlv_bytes_release(bytes));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_bytes_get(bytes, &data, &size), "bytes");
    CHECK(rlv_bytes_release(bytes) == RLV_ERROR_INVALID && rlv_bytes_retain(bytes) == RLV_ERROR_INVALID);
    return 0;
}
