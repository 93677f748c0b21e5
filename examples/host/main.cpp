// A small DCC that has everything of its own: threads, memory, a scene file with documents in it, an undo stack and a
// renderer. It plays a session without a window and says what it found.
//
//   cmake -S examples/host -B build/host -DCMAKE_PREFIX_PATH=PREFIX && cmake --build build/host
//   build/host/studio FOLDER [cpu|gpu [WIDTH]]
//
// Begin with pool.hpp (threads), heap.hpp (memory), object.hpp (an object and its document), scene_file.hpp, history.hpp
// (undo), session.hpp (edits) and renderer.hpp (an Embree of its own).
#include "heap.hpp"
#include "renderer.hpp"
#include "session.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>

using namespace studio;

namespace {

/// Quads in the plane z = 0, each of edge 1, around the origin.
relievo::Mesh make_field(const relievo::Context &context, unsigned columns, unsigned rows) {
    std::vector<relievo::Float3> points;
    std::vector<std::uint32_t> corners;
    for (unsigned y = 0; y <= rows; ++y) {
        for (unsigned x = 0; x <= columns; ++x) {
            points.push_back({static_cast<float>(x) - 0.5f * static_cast<float>(columns),
                              static_cast<float>(y) - 0.5f * static_cast<float>(rows), 0.0f});
        }
    }
    for (unsigned y = 0; y < rows; ++y) {
        for (unsigned x = 0; x < columns; ++x) {
            const unsigned first = (columns + 1) * y + x;
            corners.insert(corners.end(), {first, first + 1, first + columns + 2, first + columns + 1});
        }
    }
    return relievo::Mesh::create(context, points, std::vector<std::uint32_t>(columns * rows, 4), corners);
}

/// A cube whose limit surface is nearly a ball of radius 1.
relievo::Mesh make_ball(const relievo::Context &context) {
    std::vector<relievo::Float3> points;
    for (int k = 0; k < 8; ++k) {
        const float half = 1.2f;
        points.push_back({k & 1 ? half : -half, k & 2 ? half : -half, k & 4 ? half : -half});
    }
    return relievo::Mesh::create(context, points, std::vector<std::uint32_t>(6, 4),
                                 {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6});
}

/// A ring around the ball at the middle of the scene, at the height z.
std::vector<RlvStrokePoint> ring(double radius, double z) {
    std::vector<RlvStrokePoint> points;
    for (int k = 0; k <= 64; ++k) {
        const double angle = 6.283185307179586 * k / 64;
        points.push_back({{radius * std::cos(angle), radius * std::sin(angle), z}, 1.0, -1.0});
    }
    return points;
}

/// The points of all objects, to compare states with.
std::vector<std::vector<relievo::Float3>> state(const Session &session) {
    std::vector<std::vector<relievo::Float3>> points;
    for (std::size_t object = 0; object < session.objects().size(); ++object) {
        points.push_back(session.triangles(object).points());
    }
    return points;
}

void expect(bool holds, const char *what) {
    if (!holds) {
        throw std::runtime_error(std::string("not so: ") + what);
    }
}

void play(Pool &pool, RlvDevice device, const std::string &folder, unsigned width) {
    const std::string path = folder + "/scene.studio";
    Session session(pool, device);
    const auto field = session.add("field", make_field(session.context(), 6, 4), relievo::moved(0, 0, 0));
    const auto ball = session.add("ball", make_ball(session.context()), relievo::moved(0, 0, 0));

    // The artist carves and paints the ball, then rolls it through the field.
    RlvBrushOptions brush = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    settings.radius = 0.25f;
    settings.reach = 4.0f;
    brush.action = RLV_BRUSH_SCULPT;
    brush.height = 0.12f;
    session.stroke(ball, brush, settings, ring(0.8, 0.0));
    brush.action = RLV_BRUSH_PAINT;
    const float red[4] = {0.7f, 0.1f, 0.05f, 1.0f};
    std::copy(red, red + 4, brush.color);
    session.stroke(ball, brush, settings, ring(0.5, 0.5));
    session.move(ball, relievo::moved(-2.0, 0.2, 0.55));
    session.press(ball, field, relievo::moved(1.2, 0.2, 0.55));
    const auto done = state(session);
    const std::size_t steps = session.steps();

    // All is undone, the host's own steps and those of documents, and done again.
    while (session.undo()) {
    }
    expect(state(session) != done, "undone steps change something");
    while (session.redo()) {
    }
    expect(state(session) == done, "steps that are done again give the same points");
    std::printf("%zu steps undone and done again\n", steps);

    // The scene goes through its file.
    session.save(path);
    const Session opened(pool, device, path);
    expect(state(opened) == done, "a scene that is opened has the same points");
    std::size_t bytes = 0, edits = 0;
    for (const Object &object : opened.objects()) {
        bytes += object.section->length();
        edits += object.document.info().undo_count;
    }
    std::printf("%zu objects with %zu edits in %zu bytes of documents\n", opened.objects().size(), edits, bytes);

    // The renderer shows what was opened.
    const Renderer renderer(pool, opened.objects());
    const Picture picture = renderer.render({{4.2f, -4.6f, 3.4f}, {0.4f, 0.1f, 0.0f}}, width, width * 9 / 16);
    picture.write(folder + "/picture.ppm");
    std::printf("%zu of %zu pixels show objects\n", picture.covered, picture.pixels.size());
}

} // namespace

int main(int count, char **words) {
    if (count < 2) {
        std::fprintf(stderr, "usage: studio FOLDER [cpu|gpu [WIDTH]]\n");
        return 2;
    }
    try {
        heap::install();
        {
            Pool pool(4);
            const bool on_device = count > 2 && std::strcmp(words[2], "gpu") == 0;
            const int width = count > 3 ? std::atoi(words[3]) : 480;
            expect(width >= 16 && width <= 8192, "WIDTH is 16 to 8192");
            play(pool, on_device ? RLV_DEVICE_GPU : RLV_DEVICE_CPU, words[1], static_cast<unsigned>(width));
        }
        const heap::Use use = heap::use();
        std::printf("%.1f MiB of the host's memory at most\n", static_cast<double>(use.most) / 1048576.0);
        return 0;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "studio: %s\n", error.what());
        return 1;
    }
}
