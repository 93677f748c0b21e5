/* Repairs a ball with a hole by OpenMesh, and prints a number that depends on all coordinates of the result. Built with an
 * OpenMesh of its own, whose names come first for everything that is looked up, it compares the number with that of the
 * same program without one, whose path it is given; and its own OpenMesh is left alone. */
#include "../../c/check.h"

enum { RINGS = 24, SEGMENTS = 32, FIRST = 5 };

/* The hash of the points of the ball whose northern cap was missing. */
static uint64_t repaired(void) {
    static float points[(RINGS + 1) * SEGMENTS * 3];
    static uint32_t corners[RINGS * SEGMENTS * 4];
    RlvContext context = RLV_NULL;
    RlvMesh made = RLV_NULL;
    RlvRepairReport report = RLV_REPAIR_REPORT_INIT;
    for (uint32_t ring = 0; ring <= RINGS; ++ring) {
        for (uint32_t segment = 0; segment < SEGMENTS; ++segment) {
            float *point = points + 3 * (ring * SEGMENTS + segment);
            const double polar = 3.14159265358979 * ring / RINGS, turn = 6.28318530717959 * segment / SEGMENTS;
            /* All points of the poles are in one place each. */
            const double radius = ring % RINGS == 0 ? 0.0 : sin(polar);
            point[0] = (float)(radius * cos(turn)), point[1] = (float)(radius * sin(turn)), point[2] = (float)cos(polar);
            if (ring < RINGS) {
                uint32_t *corner = corners + 4 * (ring * SEGMENTS + segment), next = (segment + 1) % SEGMENTS;
                corner[0] = ring * SEGMENTS + segment, corner[1] = corner[0] + SEGMENTS;
                corner[2] = (ring + 1) * SEGMENTS + next, corner[3] = ring * SEGMENTS + next;
            }
        }
    }
    const RlvMeshArrays arrays =
        check_faces(points, (RINGS + 1) * SEGMENTS, 4, (RINGS - FIRST) * SEGMENTS, corners + 4 * FIRST * SEGMENTS);
    CHECK_OK(rlv_context_create(NULL, &context));
    CHECK_OK(rlv_repair_arrays(context, &arrays, NULL, 0, NULL, NULL, NULL, &report, &made));
    CHECK(report.filled_holes == 1 && report.filling_points > 20 && report.after.boundary_edges == 0);
    CHECK(report.after.euler == 2 && report.after.closed_components == 1);
    /* The filling goes on round: the ball has its volume, and is as high. */
    CHECK_NEAR(report.after.volume, 4.15, 0.1);
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(made, &info));
    CHECK_NEAR(info.high[2], 1.0, 0.05);
    float *places = malloc(info.point_count * 12);
    CHECK(places != NULL);
    CHECK_OK(rlv_mesh_get_points(made, places, info.point_count, 0));
    uint64_t hash = 1469598103934665603u;
    for (size_t byte = 0; byte < info.point_count * 12; ++byte) {
        hash = (hash ^ ((const unsigned char *)places)[byte]) * 1099511628211u;
    }
    free(places);
    CHECK_OK(rlv_mesh_release(made));
    CHECK_OK(rlv_context_release(context));
    return hash;
}

#ifdef OTHER_OPENMESH
extern int other_openmesh_calls;
void *other_0(void) __asm__(OTHER_OPENMESH);

int main(int argc, char **argv) {
    char command[4096], line[64] = "", own[64];
    CHECK(argc == 2 && other_0() != NULL && other_openmesh_calls == 1);
    snprintf(own, sizeof own, "%016llx\n", (unsigned long long)repaired());
    CHECK(other_openmesh_calls == 1);
    snprintf(command, sizeof command, "'%s'", argv[1]);
    FILE *plain = popen(command, "r");
    CHECK(plain != NULL && fgets(line, sizeof line, plain) != NULL && pclose(plain) == 0);
    CHECK(strcmp(line, own) == 0);
    return 0;
}
#else
int main(void) {
    printf("%016llx\n", (unsigned long long)repaired());
    return 0;
}
#endif
