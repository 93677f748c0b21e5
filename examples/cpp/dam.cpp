// A block of water falls into a basin while a wind of the host blows; meshes the surface of some frames, and says which share
// of the particles the surface needs.
//
//   c++ -std=c++17 dam.cpp $(pkg-config --cflags --libs relievo) -o dam && ./dam
#include <relievo/relievo.hpp>

#include <algorithm>
#include <cstdio>

int main() try {
    const auto context = relievo::Context::create();
    RlvFluidOptions options = RLV_FLUID_OPTIONS_INIT;
    options.spacing = 0.04f;
    const auto fluid = relievo::Fluid::create(context, options);
    fluid.set_basin({0, 0, 0}, {1.2, 0.4, 0.8});
    fluid.add_box({0, 0, 0}, {0.4, 0.4, 0.48});
    RlvIsosurfaceOptions function = RLV_ISOSURFACE_OPTIONS_INIT;
    function.function = RLV_ISOSURFACE_ZHU_BRIDSON;
    function.radius = 0.5f * options.spacing;
    for (int frame = 1; frame <= 6; ++frame) {
        double left = 1.0 / 24.0;
        while (left > 1e-6) {
            // What is high up is blown to the right.
            const auto state = fluid.state();
            std::vector<relievo::Float3> wind(state.points.size());
            std::transform(state.points.begin(), state.points.end(), wind.begin(), [](const relievo::Float3 &point) {
                return relievo::Float3{point[2] > 0.3f ? 2.0f : 0.0f, 0.0f, 0.0f};
            });
            fluid.accelerate(wind);
            left -= fluid.step(static_cast<float>(std::min<double>(fluid.info().time_step, left))).seconds;
        }
        const auto surface = fluid.isosurface(function);
        const auto classes = surface.classify();
        const auto hidden = std::count(classes.begin(), classes.end(), std::uint8_t(RLV_ISOSURFACE_HIDDEN));
        std::printf("frame %d: %zu triangles, %d of %zu particles could be left out\n", frame,
                    surface.mesh().info().triangle_count, static_cast<int>(hidden), classes.size());
    }
} catch (const relievo::Error &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
