/* Lays a label around a vase, drags one of its pins, and writes it as a mesh with texture coordinates.
 *
 *   cc decal.c $(pkg-config --cflags --libs relievo) -lm -o decal && ./decal OUT
 *
 * OUT is OBJ, PLY, GLB or USD. */
#include <relievo/relievo.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE = 80, WIDTH = 400, HEIGHT = 200 };

static void check(RlvResult result) {
    if (result != RLV_OK) {
        fprintf(stderr, "%s\n", rlv_error_last());
        exit(1);
    }
}

/* A point of the vase at an angle and a height of 0 to 1. */
static void on_vase(double turn, double height, double *point) {
    const double radius = 0.25 + 0.04 * sin(6.2831853 * height);
    point[0] = radius * sin(turn);
    point[1] = height;
    point[2] = radius * cos(turn);
}

static void print(const char *what, RlvDecal decal) {
    RlvDecalQuality quality = RLV_DECAL_QUALITY_INIT;
    check(rlv_decal_quality(decal, &quality));
    printf("%s: %zu triangles, %.1f %% covered, L2 stretch %.3f, %zu flipped\n", what, quality.triangle_count,
           100.0 * quality.coverage, quality.l2, quality.flip_count);
}

int main(int argc, char **argv) {
    if (argc < 2) {
        fprintf(stderr, "usage: decal OUT\n");
        return 2;
    }
    static float points[SIDE + 1][SIDE + 1][3];
    static uint32_t corners[SIDE][SIDE][4];
    for (uint32_t row = 0; row <= SIDE; ++row) {
        for (uint32_t column = 0; column <= SIDE; ++column) {
            double point[3];
            on_vase(5.0 * column / SIDE - 2.5, (double)row / SIDE, point);
            for (size_t axis = 0; axis < 3; ++axis) points[row][column][axis] = (float)point[axis];
            if (row < SIDE && column < SIDE) {
                const uint32_t first = row * (SIDE + 1) + column;
                const uint32_t quad[4] = {first, first + 1, first + SIDE + 2, first + SIDE + 1};
                for (size_t corner = 0; corner < 4; ++corner) corners[row][column][corner] = quad[corner];
            }
        }
    }
    /* Five points of the image with their places. */
    const double image[5][2] = {{60, 30}, {340, 30}, {60, 170}, {340, 170}, {200, 100}};
    RlvDecalPin pins[5] = {0};
    for (size_t pin = 0; pin < 5; ++pin) {
        for (size_t axis = 0; axis < 2; ++axis) pins[pin].image[axis] = image[pin][axis];
        on_vase(0.01 * (image[pin][0] - 200), 0.5 + 0.0025 * (image[pin][1] - 100), pins[pin].position);
    }

    RlvContext context = RLV_NULL;
    RlvMesh vase = RLV_NULL, made = RLV_NULL;
    RlvDecal decal = RLV_NULL;
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    RlvDecalOptions options = RLV_DECAL_OPTIONS_INIT;
    arrays.points = &points[0][0][0];
    arrays.point_count = (SIDE + 1) * (SIDE + 1);
    arrays.corners = &corners[0][0][0];
    arrays.corner_count = 4 * SIDE * SIDE;
    arrays.face_size = 4;
    arrays.face_count = SIDE * SIDE;
    options.width = WIDTH;
    options.height = HEIGHT;
    check(rlv_context_create(NULL, &context));
    check(rlv_mesh_create(context, &arrays, &vase));
    check(rlv_decal_on_mesh(vase, &options, pins, 5, 0, NULL, NULL, &decal));
    print("laid", decal);

    /* As while a pointer moves: the middle of the image follows, and the decal settles at the end. */
    for (int step = 1; step <= 10; ++step) {
        double position[3];
        on_vase(0.01 * step, 0.5 + 0.004 * step, position);
        check(rlv_decal_drag_pin(decal, 4, position));
    }
    check(rlv_decal_settle(decal, NULL, NULL));
    print("dragged", decal);

    check(rlv_decal_mesh(decal, 0.001, &made));
    check(rlv_mesh_write(made, argv[1]));
    check(rlv_mesh_release(made));
    check(rlv_decal_release(decal));
    check(rlv_mesh_release(vase));
    check(rlv_context_release(context));
    return 0;
}
