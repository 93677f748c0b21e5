// A deformer for a host that loads plugins as shared libraries: what a ball presses into a mesh stays there.
//
// Entry points are plain C. They return 0, or 1 after a failure, which press_error puts into words; nothing is thrown
// across them. The ball moves from where it was to where it is, so that fast ones leave no gaps.
#include <relievo/relievo.hpp>

#include <memory>

using relievo::Float3;

namespace {

/// What the host holds for one mesh. All of it is released with the struct, in any order.
struct Press {
    relievo::Detail detail;
    relievo::Collider ball;
    relievo::Tessellation triangles;
    std::vector<Float3> positions, normals;
    std::vector<relievo::Triangle> corners;
    relievo::Matrix place;
};

thread_local std::string failure;

/// The border to the host: failures of the library, and of anything else, become a result and a sentence.
template <class Work> int guarded(Work &&work) noexcept {
    try {
        work();
        return 0;
    } catch (const std::exception &error) {
        failure = error.what();
        return 1;
    }
}

/// A ball: the limit surface of a cube is round.
relievo::Mesh make_ball(const relievo::Context &context, float radius) {
    std::vector<Float3> points;
    for (int i = 0; i < 8; ++i) {
        const float half = radius * 1.2f;
        points.push_back({i & 1 ? half : -half, i & 2 ? half : -half, i & 4 ? half : -half});
    }
    const auto cube = relievo::Mesh::create(context, points, std::vector<std::uint32_t>(6, 4),
                                            {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6});
    RlvTessellateOptions options = RLV_TESSELLATE_OPTIONS_INIT;
    options.coarse = 32;
    return relievo::Surface::create(context, cube).tessellate(options);
}

} // namespace

#define PRESS_EXPORT extern "C" __attribute__((visibility("default")))

/// Why the last call of this thread failed.
PRESS_EXPORT const char *press_error() { return failure.c_str(); }

/// Takes a mesh of quads as it lies in the host's memory, and where a ball of `radius` is at first.
PRESS_EXPORT int press_create(const float *points, std::size_t point_count, const std::uint32_t *quads,
                              std::size_t quad_count, float radius, const double *place, Press **out) {
    return guarded([&] {
        RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
        arrays.points = points;
        arrays.point_count = point_count;
        arrays.face_size = 4;
        arrays.face_count = quad_count;
        arrays.corners = quads;
        arrays.corner_count = 4 * quad_count;
        const auto context = relievo::Context::create();
        const auto cage = relievo::Mesh::create(context, arrays);
        const auto detail = relievo::Detail::create(relievo::Surface::create(context, cage));
        const auto at = relievo::moved(place[0], place[1], place[2]);
        // As many triangles where something happened as elsewhere: their number never changes.
        RlvTessellateOptions options = RLV_TESSELLATE_OPTIONS_INIT;
        options.coarse = options.fine = 16;
        const auto triangles = relievo::Tessellation::create(detail, options);
        const auto mesh = triangles.mesh();
        const auto ball = relievo::Collider::create(context, make_ball(context, radius), at);
        const std::vector<Float3> positions = mesh.points();
        *out = new Press{detail, ball, triangles, positions, std::vector<Float3>(positions.size()), mesh.triangles(), at};
    });
}

/// Moves the ball to `place`, presses it in on the way, and brings up to date the points that this changed.
PRESS_EXPORT int press_move(Press *press, const double *place) {
    return guarded([&] {
        const auto at = relievo::moved(place[0], place[1], place[2]);
        relievo::sweep(press->detail, press->ball, press->place, at);
        press->place = at;
        press->detail.commit();
        press->triangles.update();
        for (const auto &range : press->triangles.changed_ranges()) {
            press->triangles.get_points(range, press->positions, press->normals);
        }
    });
}

/// The positions of all points, three floats each, and three points of every triangle. They stay where they are until
/// press_destroy, and only positions change.
PRESS_EXPORT void press_mesh(const Press *press, const float **positions, std::size_t *point_count,
                             const std::uint32_t **corners, std::size_t *triangle_count) {
    *positions = press->positions.front().data();
    *point_count = press->positions.size();
    *corners = press->corners.front().data();
    *triangle_count = press->corners.size();
}

/// Releases all of it.
PRESS_EXPORT void press_destroy(Press *press) { delete press; }
