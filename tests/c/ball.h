/* A ball of triangles for the tests of colliders and imprints. */
#ifndef BALL_H
#define BALL_H

#include "check.h"

enum { BALL_ROWS = 48, BALL_COLUMNS = 96 };

/* A closed ball of the radius around the origin, of rows of triangles from pole to pole; the poles are the first points. */
static inline RlvMesh check_ball_of(RlvContext context, double radius, uint32_t rows, uint32_t columns) {
    size_t points = 2 + (size_t)(rows - 1) * columns, faces = 2 * (size_t)(rows - 1) * columns;
    float *positions = malloc(points * 12), *position = positions;
    uint32_t *corners = malloc(faces * 12), *corner = corners;
    const double pi = 3.14159265358979323846;
    CHECK(positions != NULL && corners != NULL);
    for (int pole = 0; pole < 2; ++pole) {
        *position++ = 0, *position++ = 0, *position++ = (float)(pole == 0 ? radius : -radius);
    }
    for (uint32_t row = 1; row < rows; ++row) {
        for (uint32_t column = 0; column < columns; ++column) {
            double theta = pi * row / rows, phi = 2 * pi * column / columns;
            *position++ = (float)(radius * sin(theta) * cos(phi));
            *position++ = (float)(radius * sin(theta) * sin(phi));
            *position++ = (float)(radius * cos(theta));
        }
    }
    const uint32_t north = 0, south = 1;
    for (uint32_t column = 0; column < columns; ++column) {
        uint32_t next = (column + 1) % columns, last = 2 + (rows - 2) * columns;
        *corner++ = north, *corner++ = 2 + column, *corner++ = 2 + next;
        *corner++ = south, *corner++ = last + next, *corner++ = last + column;
        for (uint32_t row = 0; row + 2 < rows; ++row) {
            uint32_t a = 2 + row * columns + column, b = 2 + row * columns + next;
            *corner++ = a, *corner++ = a + columns, *corner++ = b + columns;
            *corner++ = a, *corner++ = b + columns, *corner++ = b;
        }
    }
    const RlvMesh mesh = check_mesh_of(context, positions, points, 3, faces, corners);
    free(positions);
    free(corners);
    return mesh;
}

static inline RlvMesh check_ball(RlvContext context, double radius) {
    return check_ball_of(context, radius, BALL_ROWS, BALL_COLUMNS);
}

/* The matrix that moves by (x, y, z). */
#define CHECK_MOVED(x, y, z) {1, 0, 0, 0, 1, 0, 0, 0, 1, (x), (y), (z)}

#endif
