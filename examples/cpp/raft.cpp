// A cube of half the density of water falls into a basin and floats: the program moves it by what the fluid gives it, as a
// host does with its own physics, and says at which depth it comes to rest.
//
//   c++ -std=c++17 raft.cpp $(pkg-config --cflags --libs relievo) -o raft && ./raft
#include <relievo/relievo.hpp>

#include <algorithm>
#include <cstdio>

namespace {

constexpr float spacing = 0.02f, side = 0.12f, width = 0.4f, depth = 0.16f, middle = 0.5f * width, half = 0.5f * side;

/// The corners of the cube at a height of its lower side.
std::vector<relievo::Float3> corners(double height) {
    std::vector<relievo::Float3> points;
    for (int k = 0; k < 8; ++k) {
        points.push_back({middle + (k & 1 ? half : -half), middle + (k & 2 ? half : -half),
                          static_cast<float>(height) + (k & 4 ? side : 0.0f)});
    }
    return points;
}

} // namespace

int main() try {
    const auto context = relievo::Context::create();
    RlvFluidOptions options = RLV_FLUID_OPTIONS_INIT;
    options.spacing = spacing;
    options.solver = RLV_FLUID_DFSPH;
    const auto fluid = relievo::Fluid::create(context, options);
    fluid.set_basin({0, 0, 0}, {width, width, 0.4f});
    fluid.add_box({0, 0, 0}, {width, width, depth});
    const std::vector<std::uint32_t> faces(6, 4), around = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4,
                                                            1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6};
    double height = depth + spacing, velocity = 0.0, due = 0.0, seconds = 0.0, mean = 0.0;
    const double mass = 500.0 * side * side * side;
    const auto cube = fluid.add_collider(relievo::Mesh::create(context, corners(height), faces, around));
    while (seconds < 2.0) {
        const double step = std::min(fluid.info().time_step, 0.002f);
        // A share of what is due in each step: a body that is lighter than the water it moves would be thrown to and fro by
        // all of it at once, and nothing is lost.
        const double given = 0.3 * due;
        due -= given;
        velocity += given / mass - 9.81 * step;
        height += velocity * step;
        fluid.move_collider(cube, corners(height), static_cast<float>(step));
        seconds += fluid.step(static_cast<float>(step)).seconds;
        due += fluid.impulse(cube)[2];
        if (seconds > 1.5) {
            mean += height * step / 0.5;
        }
    }
    // The level follows from the water and what of the cube is in it.
    const double area = width * width, share = side * side / area;
    const double draught = (depth - mean) / (1.0 - share);
    std::printf("the cube floats with %.2f of its height in the water\n", draught / side);
} catch (const relievo::Error &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
