/* A flat cage with texture coordinates for the tests of bakes and files. */
#ifndef SHEET_H
#define SHEET_H

#include "ball.h"

/* columns x rows quads of side 1 in the plane z = 0, whose texture coordinates are their place over columns and rows, put
 * into the UDIM tile with this column. */
static inline RlvMesh check_sheet(RlvContext context, uint32_t columns, uint32_t rows, float udim) {
    RlvMesh mesh = check_plane(context, columns, rows);
    size_t points = (size_t)(columns + 1) * (rows + 1), count = (size_t)columns * rows * 4;
    float *positions = malloc(points * 12), *uvs = malloc(count * 8);
    uint32_t *corners = malloc(count * 4);
    RlvAttributeArrays arrays = RLV_ATTRIBUTE_ARRAYS_INIT;
    CHECK(positions != NULL && uvs != NULL && corners != NULL);
    CHECK_OK(rlv_mesh_get_points(mesh, positions, points, 0));
    CHECK_OK(rlv_mesh_get_faces(mesh, NULL, 0, corners, count));
    for (size_t corner = 0; corner < count; ++corner) {
        uvs[2 * corner] = udim + positions[3 * corners[corner]] / (float)columns;
        uvs[2 * corner + 1] = positions[3 * corners[corner] + 1] / (float)rows;
    }
    arrays.domain = RLV_DOMAIN_CORNER;
    arrays.type = RLV_TYPE_F32;
    arrays.width = 2;
    arrays.name = "uv";
    arrays.values = uvs;
    arrays.value_count = count;
    CHECK_OK(rlv_mesh_add_attribute(mesh, &arrays));
    free(positions);
    free(uvs);
    free(corners);
    return mesh;
}

/* Cancels when its user, a counter, is down to 0. */
static uint32_t check_patience(void *user, float fraction, const char *stage) {
    int *left = user;
    CHECK(fraction >= 0.0f && fraction <= 1.0f && stage[0] != 0);
    return (*left)-- > 0 ? RLV_PROGRESS_CONTINUE : RLV_PROGRESS_CANCEL;
}

/* Whether there is a file, which is removed. */
static inline int check_removed(const char *path) { return remove(path) == 0; }

#endif
