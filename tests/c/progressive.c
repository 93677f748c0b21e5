/* Progressive meshes: built of a mesh, in the background too, written, read, and refused. */
#include "sheet.h"

int main(void) {
    RlvContext context = RLV_NULL;
    RlvProgressive built = RLV_NULL, again = RLV_NULL, untouched = {77};
    RlvProgressiveInfo info = RLV_PROGRESSIVE_INFO_INIT, coarse = RLV_PROGRESSIVE_INFO_INIT;
    const char *path = "progressive_test.rlvpm";
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh ball = check_ball(context, 1.0);
    RlvMeshInfo given = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(ball, &given));

    CHECK_OK(rlv_progressive_create(ball, NULL, NULL, NULL, &built));
    CHECK_OK(rlv_progressive_info(built, &info));
    CHECK(info.vertex_count == given.point_count && info.triangle_count == given.face_count);
    CHECK(info.base_triangle_count <= 100 && info.base_triangle_count >= 4);
    /* Closed: V - E + F = 2 with E = 3/2 F. */
    CHECK(2 * info.base_vertex_count == info.base_triangle_count + 4);
    CHECK(info.bytes <= 41 * info.triangle_count);

    /* Coarser and with points that stay. */
    const uint32_t poles[2] = {0, 1};
    RlvProgressiveOptions options = RLV_PROGRESSIVE_OPTIONS_INIT;
    options.base_triangles = 20;
    options.locked = poles;
    options.locked_count = 2;
    CHECK_OK(rlv_progressive_create(ball, &options, NULL, NULL, &again));
    CHECK_OK(rlv_progressive_info(again, &coarse));
    CHECK(coarse.base_triangle_count <= 20 && coarse.triangle_count == info.triangle_count);
    CHECK_OK(rlv_progressive_release(again));

    /* Progress is told here, and may stop it. */
    int patience = 3;
    CHECK(rlv_progressive_create(ball, NULL, check_patience, &patience, &untouched) == RLV_ERROR_CANCELLED);
    CHECK(untouched.id == 77);

    /* In the background. */
    RlvJob job = RLV_NULL;
    RlvProgressive one = RLV_NULL, two = RLV_NULL;
    RlvMesh none = RLV_NULL;
    CHECK_OK(rlv_job_progressive(ball, NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_progressive_mesh(job, &one));
    CHECK_OK(rlv_job_progressive_mesh(job, &two));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_mesh(job, &none), "not started for triangles");
    CHECK(one.id == two.id);
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_progressive_info(one, &coarse));
    CHECK(memcmp(&coarse, &info, sizeof info) == 0);
    CHECK_OK(rlv_progressive_release(one));
    CHECK_OK(rlv_progressive_release(two));

    /* A file, all of it and its beginning. */
    CHECK_OK(rlv_progressive_write(built, path));
    CHECK_OK(rlv_progressive_read(context, path, SIZE_MAX, &again));
    CHECK_OK(rlv_progressive_info(again, &coarse));
    CHECK(memcmp(&coarse, &info, sizeof info) == 0);
    CHECK_OK(rlv_progressive_release(again));
    CHECK_OK(rlv_progressive_read(context, path, 200, &again));
    CHECK_OK(rlv_progressive_release(again));

    /* Refused, and nothing written. */
    options.locked_count = 1;
    options.locked = (const uint32_t[1]){(uint32_t)given.point_count};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_progressive_create(ball, &options, NULL, NULL, &untouched), "no point");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_progressive(ball, &options, &job), "no point");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_progressive_create(ball, NULL, NULL, NULL, NULL), "out");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_progressive_read(context, "no/such/file.rlvpm", 1, &untouched), "no/such/file.rlvpm");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_progressive_read(context, NULL, 1, &untouched), "path");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_progressive_write(built, NULL), "path");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_progressive_info(built, NULL), "RlvProgressiveInfo");
    CHECK_OK(rlv_mesh_write(ball, "progressive_test.obj"));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_progressive_read(context, "progressive_test.obj", 1, &untouched), "no progressive mesh");
    CHECK(check_removed("progressive_test.obj"));
    CHECK(untouched.id == 77);

    RlvContextOptions small = RLV_CONTEXT_OPTIONS_INIT;
    RlvContext poor = RLV_NULL;
    small.memory_limit = 1 << 16;
    CHECK_OK(rlv_context_create(&small, &poor));
    CHECK(rlv_progressive_read(poor, path, SIZE_MAX, &untouched) == RLV_ERROR_MEMORY && untouched.id == 77);
    CHECK_OK(rlv_context_release(poor));
    CHECK(check_removed(path));

    CHECK_OK(rlv_progressive_retain(built));
    CHECK_OK(rlv_progressive_release(built));
    CHECK_OK(rlv_progressive_release(built));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_progressive_info(built, &info), "not alive");
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
