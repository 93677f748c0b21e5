// Presses a ball into a plane and writes the dented plane as an OBJ file.
//
//   c++ -std=c++17 dent.cpp $(pkg-config --cflags --libs relievo) -o dent && ./dent dent.obj
#include <relievo/relievo.hpp>

#include <iostream>

using relievo::Float3;

/// The control cage: 8 x 8 quads in the plane z = 0, from (-2, -2) to (2, 2).
static relievo::Mesh make_plane(const relievo::Context &context) {
    const std::uint32_t side = 8;
    std::vector<Float3> points;
    std::vector<std::uint32_t> corners;
    for (std::uint32_t y = 0; y <= side; ++y) {
        for (std::uint32_t x = 0; x <= side; ++x) {
            points.push_back({static_cast<float>(x) * 0.5f - 2.0f, static_cast<float>(y) * 0.5f - 2.0f, 0.0f});
        }
    }
    for (std::uint32_t y = 0; y < side; ++y) {
        for (std::uint32_t x = 0; x < side; ++x) {
            const std::uint32_t first = y * (side + 1) + x;
            corners.insert(corners.end(), {first, first + 1, first + side + 2, first + side + 1});
        }
    }
    return relievo::Mesh::create(context, points, std::vector<std::uint32_t>(side * side, 4), corners);
}

/// A ball: the limit surface of a cube is round.
static relievo::Mesh make_ball(const relievo::Context &context) {
    std::vector<Float3> points;
    for (int i = 0; i < 8; ++i) {
        points.push_back({i & 1 ? 1.0f : -1.0f, i & 2 ? 1.0f : -1.0f, i & 4 ? 1.0f : -1.0f});
    }
    const auto cube = relievo::Mesh::create(context, points, std::vector<std::uint32_t>(6, 4),
                                            {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6});
    RlvTessellateOptions options = RLV_TESSELLATE_OPTIONS_INIT;
    options.coarse = 64;
    return relievo::Surface::create(context, cube).tessellate(options);
}

int main(int argc, char **argv) try {
    const std::string path = argc > 1 ? argv[1] : "dent.obj";
    const auto context = relievo::Context::create();

    // The smooth surface of the cage, and a detail on it that can be edited.
    const auto detail = relievo::Detail::create(relievo::Surface::create(context, make_plane(context)));

    // What is pressed into it: a ball over the plane, its lowest point 0.25 below.
    const auto ball = make_ball(context);
    const auto collider = relievo::Collider::create(context, ball, relievo::moved(0, 0, -0.25 - ball.info().low[2]));

    // Press; the edit becomes visible with the commit.
    const RlvImprintReport report = relievo::imprint(detail, collider);
    const RlvDetailChanges changes = detail.commit();
    std::cout << changes.tile_count << " tiles changed, exact to " << report.voxel_diagonal << '\n';

    const auto dented = detail.tessellate();
    std::cout << "depth " << -dented.info().low[2] << '\n';
    dented.write(path);
    return 0;
} catch (const std::exception &error) {
    // Failures of the library are relievo::Error: what went wrong, where, and what can be done.
    std::cerr << error.what() << '\n';
    return 1;
}
