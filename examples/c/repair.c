/* Repairs a mesh and tells what was wrong with it.
 *
 *   cc repair.c $(pkg-config --cflags --libs relievo) -o repair && ./repair MESH OUT [TOLERANCE]
 *
 * MESH is OBJ, PLY, glTF, STL, OFF or USD, OUT is OBJ, PLY, GLB or USD. Points within TOLERANCE of each other are joined, 0
 * if it is not given. */
#include <relievo/relievo.h>

#include <stdio.h>
#include <stdlib.h>

static void check(RlvResult result) {
    if (result != RLV_OK) {
        fprintf(stderr, "%s\n", rlv_error_last());
        exit(1);
    }
}

int main(int argc, char **argv) {
    if (argc < 3) {
        fprintf(stderr, "usage: repair MESH OUT [TOLERANCE]\n");
        return 2;
    }
    RlvContext context = RLV_NULL;
    RlvMesh mesh = RLV_NULL;
    RlvRepairSettings settings = RLV_REPAIR_SETTINGS_INIT;
    RlvRepairReport report = RLV_REPAIR_REPORT_INIT;
    settings.tolerance = argc > 3 ? strtof(argv[3], NULL) : 0.0f;
    check(rlv_context_create(NULL, &context));
    check(rlv_repair_read(context, argv[1], &settings, NULL, NULL, &report, &mesh));
    check(rlv_mesh_write(mesh, argv[2]));

    const struct {
        const char *name;
        const RlvRepairFinding *finding;
    } lines[] = {
        {"coincident points", &report.coincident_points},   {"degenerate faces", &report.degenerate_faces},
        {"duplicate faces", &report.duplicate_faces},       {"non-manifold edges", &report.non_manifold_edges},
        {"non-manifold points", &report.non_manifold_points}, {"misoriented edges", &report.misoriented_edges},
        {"holes", &report.holes},                           {"holes left open", &report.open_holes},
    };
    for (size_t line = 0; line < sizeof lines / sizeof *lines; ++line) {
        if (lines[line].finding->count > 0) {
            printf("%zu %s, the first at %u\n", lines[line].finding->count, lines[line].name,
                   lines[line].finding->first[0]);
        }
    }
    printf("%zu of %zu components closed, volume %g\n", report.after.closed_components, report.after.components,
           report.after.volume);
    check(rlv_mesh_release(mesh));
    check(rlv_context_release(context));
    return 0;
}
