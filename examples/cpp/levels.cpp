// A camera goes around a mesh, which is as fine as the camera needs it; says what changed in the buffers of every frame.
//
//   c++ -std=c++17 levels.cpp $(pkg-config --cflags --libs relievo) -o levels && ./levels MESH
#include <relievo/relievo.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>

int main(int argc, char **argv) try {
    if (argc < 2) {
        std::fprintf(stderr, "usage: levels MESH\n");
        return 2;
    }
    const auto context = relievo::Context::create();
    const auto mesh = relievo::Mesh::read(context, argv[1]);
    const RlvMeshInfo box = mesh.info();
    const auto whole = relievo::Progressive::create(mesh);
    const auto level = relievo::Level::create(whole);
    relievo::Level::Buffers buffers(whole);

    float size = 0;
    for (int axis = 0; axis < 3; ++axis) {
        size = std::max(size, box.high[axis] - box.low[axis]);
    }
    RlvLevelView view = RLV_LEVEL_VIEW_INIT;
    view.pixels = 720;
    for (int frame = 0; frame < 24; ++frame) {
        const float angle = 6.2831853f * static_cast<float>(frame) / 24;
        view.eye[0] = (box.low[0] + box.high[0]) / 2 + 1.5f * size * std::cos(angle);
        view.eye[1] = (box.low[1] + box.high[1]) / 2 + 1.5f * size * std::sin(angle);
        view.eye[2] = (box.low[2] + box.high[2]) / 2;
        level.set_view(view);
        // A renderer sends these ranges of its buffers again, and draws as many triangles as there are.
        level.update(buffers);
        const RlvLevelUpdate &made = buffers.last;
        std::printf("frame %d: %zu of %zu triangles; vertices %zu to %zu and triangles %zu to %zu are new\n", frame,
                    made.triangle_count, whole.info().triangle_count, made.first_vertex,
                    made.first_vertex + made.changed_vertex_count, made.first_triangle,
                    made.first_triangle + made.changed_triangle_count);
    }
} catch (const relievo::Error &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
