// A small DCC that has everything of its own: threads, memory, a scene file with documents in it, an undo stack and a
// renderer. It plays a session without a window and says what it found.
//
//   cmake -S examples/host -B build/host -DCMAKE_PREFIX_PATH=PREFIX && cmake --build build/host
//   build/host/studio FOLDER [cpu|gpu [WIDTH]]
//
// Begin with pool.hpp (threads), heap.hpp (memory), object.hpp (an object and its document), scene_file.hpp, history.hpp
// (undo), session.hpp (edits), renderer.hpp (an Embree of its own) and viewport.hpp (a Vulkan device of its own, on which
// the library works with "gpu"). Without a Vulkan driver there is no viewport, and the processor works.
#include "heap.hpp"
#include "renderer.hpp"
#include "session.hpp"
#include "viewport.hpp"

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

/// Shows a session in a viewport; without a driver it does nothing.
class Screen {
public:
    Screen(VulkanDevice *device, const Session &session, unsigned width, unsigned height) : session_(session) {
        if (device) {
            viewport_ = std::make_unique<Viewport>(*device, session.context(), width, height);
        }
    }

    /// Follows the session. `some` says whether it changed points: then some of them are written and not all, else none.
    void follow(bool some) {
        if (viewport_) {
            const Viewport::Written written = viewport_->follow(session_.objects());
            expect((written.points > 0) == some && written.points < written.all, "what changed is written again, and no more");
            written_ += written.points;
            all_ = written.all;
            ++times_;
        }
    }

    /// Draws to a file what the renderer shows, but for shadows, in another picture.
    void compare(const Camera &camera, const Picture &rendered, const std::string &path) {
        if (!viewport_) {
            std::printf("no Vulkan driver, so no viewport\n");
            return;
        }
        const Picture drawn = viewport_->draw(camera);
        drawn.write(path);
        const std::size_t apart = drawn.apart(rendered, 0.02f);
        std::printf("viewport: %zu of %zu pixels apart from the renderer's; %.1f %% of the points written after an edit\n", apart,
                    drawn.covered_count(), 100.0 * static_cast<double>(written_) / static_cast<double>(all_ * times_));
        // Silhouettes, and edges of strokes where triangles are coarser than the surface.
        expect(100 * apart <= 4 * drawn.covered_count(), "the viewport shows what the renderer does");
    }

    /// Makes buffers of the objects.
    void begin() {
        if (viewport_) {
            const Viewport::Written written = viewport_->follow(session_.objects());
            expect(written.points == written.all, "all points are written at first");
        }
    }

private:
    const Session &session_;
    std::unique_ptr<Viewport> viewport_;
    std::size_t written_ = 0, all_ = 0, times_ = 0;
};

void play(Pool &pool, VulkanDevice *vulkan, bool on_device, const std::string &folder, unsigned width) {
    const std::string path = folder + "/scene.studio";
    const auto context = [&] {
        return on_device && vulkan ? vulkan->context(pool.options(RLV_DEVICE_GPU))
                                   : relievo::Context::create(pool.options(RLV_DEVICE_CPU));
    };
    Session session(context());
    const auto field = session.add("field", make_field(session.context(), 6, 4), relievo::moved(0, 0, 0));
    const auto ball = session.add("ball", make_ball(session.context()), relievo::moved(0, 0, 0));
    const unsigned height = width * 9 / 16;
    Screen screen(vulkan, session, width, height);
    screen.begin();

    // The artist carves and paints the ball, then rolls it through the field.
    RlvBrushOptions brush = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    settings.radius = 0.25f;
    settings.reach = 4.0f;
    brush.action = RLV_BRUSH_SCULPT;
    brush.height = 0.12f;
    session.stroke(ball, brush, settings, ring(0.8, 0.0));
    screen.follow(true);
    brush.action = RLV_BRUSH_PAINT;
    const float red[4] = {0.7f, 0.1f, 0.05f, 1.0f};
    std::copy(red, red + 4, brush.color);
    session.stroke(ball, brush, settings, ring(0.5, 0.5));
    screen.follow(true);
    session.move(ball, relievo::moved(-2.0, 0.2, 0.55));
    screen.follow(false);
    session.press(ball, field, relievo::moved(1.2, 0.2, 0.55));
    screen.follow(true);
    const auto done = state(session);
    const std::size_t steps = session.steps();

    // All is undone, the host's own steps and those of documents, and done again.
    while (session.undo()) {
    }
    screen.follow(true);
    expect(state(session) != done, "undone steps change something");
    while (session.redo()) {
    }
    screen.follow(true);
    expect(state(session) == done, "steps that are done again give the same points");
    std::printf("%zu steps undone and done again\n", steps);

    // The scene goes through its file.
    session.save(path);
    const Session opened(context(), path);
    expect(state(opened) == done, "a scene that is opened has the same points");
    std::size_t bytes = 0, edits = 0;
    for (const Object &object : opened.objects()) {
        bytes += object.section->length();
        edits += object.document.info().undo_count;
    }
    std::printf("%zu objects with %zu edits in %zu bytes of documents\n", opened.objects().size(), edits, bytes);

    // All of it was done on the host's threads and, where it has one, on its device.
    expect(pool.library_loops() > 0, "the library works on the pool");
    if (on_device && vulkan) {
        expect(session.context().info().device == RLV_DEVICE_GPU, "the context works on the host's device");
        for (const Object &object : session.objects()) {
            object.detail.check_device();
        }
    }

    // The renderer shows what was opened, and the viewport what was edited.
    const Renderer renderer(pool, opened.objects());
    const Camera camera{{4.2f, -4.6f, 3.4f}, {0.4f, 0.1f, 0.0f}};
    const Picture picture = renderer.render(camera, width, height, true);
    picture.write(folder + "/picture.ppm");
    std::printf("%zu of %zu pixels show objects\n", picture.covered_count(), picture.pixels.size());
    screen.compare(camera, renderer.render(camera, width, height, false), folder + "/viewport.ppm");
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
            const auto vulkan = VulkanDevice::open();
            play(pool, vulkan.get(), on_device, words[1], static_cast<unsigned>(width));
        }
        const heap::Use use = heap::use();
        std::printf("%.1f MiB of the host's memory at most\n", static_cast<double>(use.most) / 1048576.0);
        return 0;
    } catch (const std::exception &error) {
        std::fprintf(stderr, "studio: %s\n", error.what());
        return 1;
    }
}
