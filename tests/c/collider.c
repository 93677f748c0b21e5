/* Colliders: closed or open, moved and deformed, and what is refused. */
#include "ball.h"

int main(void) {
    RlvContext context = RLV_NULL;
    RlvCollider collider = RLV_NULL, untouched = {77};
    RlvColliderInfo info = RLV_COLLIDER_INFO_INIT;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh ball = check_ball(context, 1.0), plane = check_plane(context, 2, 2);

    const double place[12] = CHECK_MOVED(1, 2, 3);
    CHECK_OK(rlv_collider_create_mesh(context, ball, place, &collider));
    CHECK_OK(rlv_collider_info(collider, &info));
    CHECK(info.is_closed == 1 && info.open_edge_count == 0);
    CHECK(info.triangle_count == 2u * (BALL_ROWS - 1) * BALL_COLUMNS);
    CHECK(memcmp(info.matrix, place, sizeof(place)) == 0);
    const double other[12] = {2, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0};
    CHECK_OK(rlv_collider_set_transform(collider, other));
    CHECK_OK(rlv_collider_info(collider, &info));
    CHECK(info.matrix[0] == 2.0 && info.matrix[9] == 0.0);
    const double flat[12] = {1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0}, odd[12] = {NAN};
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_collider_set_transform(collider, flat), "transform");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_collider_set_transform(collider, odd), "transform");
    CHECK_OK(rlv_collider_info(collider, &info));
    CHECK(info.matrix[0] == 2.0);

    /* A tool of radius 1 pressed by the force that displaces a cap 0.2 high, from above and at (5, 6, 7). */
    const double one[12] = CHECK_MOVED(0, 0, 0), spot[3] = {5, 6, 7}, up[3] = {0, 0, 2};
    const double cap = 3.14159265358979 * 0.2 * 0.2 * (3.0 - 0.2) / 3.0;
    RlvToolSettings tool = RLV_TOOL_SETTINGS_INIT;
    tool.stiffness = 10.0f;
    CHECK_OK(rlv_collider_set_transform(collider, one));
    CHECK_OK(rlv_collider_press(collider, spot, up, 10.0 * cap, &tool));
    CHECK_OK(rlv_collider_info(collider, &info));
    CHECK_NEAR(info.matrix[9], 5, 1e-6);
    CHECK_NEAR(info.matrix[11], 7 + 1 - 0.2, 0.005);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_collider_press(collider, spot, up, -1.0, NULL), "force");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_collider_press(collider, NULL, up, 1.0, NULL), "place");
    tool.stiffness = 0.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_collider_press(collider, spot, up, 1.0, &tool), "stiffness");

    float *points = malloc(info.point_count * 12);
    CHECK(points != NULL);
    CHECK_OK(rlv_mesh_get_points(ball, points, info.point_count, 0));
    CHECK_OK(rlv_collider_set_points(collider, points, info.point_count, 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_collider_set_points(collider, points, info.point_count - 1, 0), "points");
    points[4] = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_collider_set_points(collider, points, info.point_count, 0), "point 1");
    free(points);
    CHECK_OK(rlv_collider_release(collider));

    CHECK_OK(rlv_collider_create_mesh(context, plane, NULL, &collider));
    CHECK_OK(rlv_collider_info(collider, &info));
    CHECK(info.is_closed == 0 && info.open_edge_count == 8 && info.triangle_count == 8 && info.matrix[0] == 1.0 && info.matrix[11] == 0.0);
    CHECK_OK(rlv_collider_release(collider));

    /* Of surfaces and details. */
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvTessellateOptions options = RLV_TESSELLATE_OPTIONS_INIT;
    options.coarse = 4;
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_collider_create_surface(surface, &options, place, &collider));
    CHECK_OK(rlv_collider_info(collider, &info));
    CHECK(info.triangle_count == 4 * 4 * 4 * 2 && info.matrix[10] == 2.0);
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_detail_create(surface, NULL, place, &detail));
    CHECK_OK(rlv_collider_create_detail(detail, &options, &collider));
    CHECK_OK(rlv_collider_info(collider, &info));
    CHECK(info.triangle_count == 4 * 4 * 4 * 2 && info.matrix[11] == 3.0);
    CHECK_OK(rlv_collider_release(collider));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_collider_release(collider), "not alive");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_collider_create_mesh(context, ball, flat, &untouched), "transform");
    CHECK(untouched.id == 77);

    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_mesh_release(ball));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
