// Simplifies a mesh in the background to a tenth of its triangles, says how far that is, and writes what comes of it.
//
//   c++ -std=c++17 simplify.cpp $(pkg-config --cflags --libs relievo) -o simplify && ./simplify MESH OUT.obj
#include <relievo/relievo.hpp>

#include <cstdio>

int main(int argc, char **argv) try {
    if (argc < 3) {
        std::fprintf(stderr, "usage: simplify MESH OUT.obj\n");
        return 2;
    }
    const auto context = relievo::Context::create();
    const auto mesh = relievo::Mesh::read(context, argv[1]);
    relievo::Simplify how;
    how.options.triangles = mesh.info().triangle_count / 10;
    const auto job = relievo::Job::simplify(mesh, how);
    // A host draws its window between two looks.
    for (RlvJobInfo info = job.wait(0.05); info.state == RLV_JOB_RUNNING; info = job.wait(0.05)) {
        std::printf("%s: %.0f %%\n", info.stage, 100.0 * info.fraction);
    }
    const relievo::Mesh fewer = job.mesh();
    fewer.write(argv[2]);
    std::printf("%zu of %zu triangles, error %g\n", fewer.info().triangle_count, mesh.info().triangle_count,
                job.deviation());
} catch (const relievo::Error &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
