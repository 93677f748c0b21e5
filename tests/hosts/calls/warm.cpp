// warm: calls that a host makes at every event of a brush and at every frame of an animation ask for no memory once they
// are warm, on any thread of the library: it counts what malloc and its kin are asked for. With one thread no call of the
// later frames may ask for any; with two, threads get warm when they happen to be given work, so most calls may not.
#include "../../c/check.h"
#include "../figure.h"
#include "allocations.h"
#include "follower.h"

#include <cmath>
#include <cstdint>
#include <string>

namespace {

const uint32_t cells = 16, places = 3000;
const int frames = 120, warm_from = 60;
const float turn = 6.2831853f;

/// A call that is made at every frame, and how often it asked for memory once warm.
struct Call {
    std::string name;
    std::vector<double> counts;

    explicit Call(std::string name) : name(std::move(name)) {}

    template <class Work> void make(int frame, Work work) {
        const Allocations before = allocations();
        work();
        const Allocations made = allocations() - before;
        if (frame >= warm_from) {
            counts.push_back(double(made.count));
        }
    }

    /// Whether it asked for none: at every frame, or at the median.
    bool holds(bool every) const {
        const double most = quantile(counts, every ? 1.0 : 0.5);
        if (most > 0.0) {
            std::fprintf(stderr, "%s asks for memory %g times a call, %s\n", name.c_str(), most,
                         every ? "at most" : "at the median");
        }
        return most == 0.0;
    }
};

/// Places all over the plane and rays down on it.
struct Reader {
    std::vector<uint32_t> tiles;
    std::vector<float> uvs, positions, normals, heights, colors, origins, directions;
    std::vector<RlvHit> hits;
    RlvEvaluateArrays wanted = RLV_EVALUATE_ARRAYS_INIT;
    RlvRayArrays rays = RLV_RAY_ARRAYS_INIT;

    Reader()
        : tiles(places), uvs(2 * places), positions(3 * places), normals(3 * places), heights(places), colors(4 * places),
          origins(3 * places), directions(3 * places), hits(places) {
        for (uint32_t k = 0; k < places; ++k) {
            tiles[k] = k * 2654435761u % (cells * cells);
            uvs[2 * k] = float(k % 97) / 96.0f;
            uvs[2 * k + 1] = float(k % 89) / 88.0f;
            origins[3 * k] = float(cells) * float(k % 60) / 60.0f;
            origins[3 * k + 1] = float(cells) * float(k / 60) / 50.0f;
            origins[3 * k + 2] = 5.0f;
            directions[3 * k + 2] = -1.0f;
        }
        wanted.count = rays.count = places;
        wanted.tiles = tiles.data();
        wanted.uvs = uvs.data();
        wanted.positions = positions.data();
        wanted.normals = normals.data();
        wanted.displacements = heights.data();
        wanted.colors = colors.data();
        rays.origins = origins.data();
        rays.directions = directions.data();
        rays.hits = hits.data();
    }
};

bool run(uint32_t threads) {
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    options.threads = threads;
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(&options, &context));
    const RlvMesh cage = check_plane(context, cells, cells);
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDetailOptions sizes = RLV_DETAIL_OPTIONS_INIT;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    sizes.tile_size = paint.tile_size = 16;
    CHECK_OK(rlv_surface_create(context, cage, nullptr, &surface));
    CHECK_OK(rlv_detail_create(surface, &sizes, nullptr, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    CHECK_OK(rlv_detail_commit(detail, nullptr));
    RlvCaster caster = RLV_NULL;
    CHECK_OK(rlv_caster_create_detail(detail, nullptr, &caster));
    RlvBrushOptions action = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvBrush brush = RLV_NULL;
    RlvStroke stroke = RLV_NULL;
    action.action = RLV_BRUSH_SCULPT;
    action.height = 0.02f;
    settings.radius = 1.5f;
    CHECK_OK(rlv_brush_create(context, &action, &settings, &brush));
    CHECK_OK(rlv_stroke_begin(detail, brush, &stroke));

    Call commit("rlv_detail_commit of a dab"), update("rlv_tessellation_update of a dab"), fetch("rlv_tessellation_get_points");
    Call evaluate("rlv_evaluate_detail"), cast("rlv_caster_cast"), info("rlv_detail_info");
    Call pose("rlv_detail_set_points"), posed("rlv_detail_commit of a pose"), moved("rlv_tessellation_update of a pose");
    Reader reader;
    Follower follower(detail, 4);
    for (int frame = 0; frame < frames; ++frame) {
        const float angle = turn * float(frame % 12) / 12.0f;
        const RlvStrokePoint point = {{8.0 + 4.0 * std::cos(angle), 8.0 + 4.0 * std::sin(angle), 0.0}, 1.0, -1.0};
        RlvDetailChanges changes = RLV_DETAIL_CHANGES_INIT;
        RlvDetailInfo known = RLV_DETAIL_INFO_INIT;
        CHECK_OK(rlv_stroke_extend(stroke, &point, 1, 0, nullptr));
        commit.make(frame, [&] { CHECK_OK(rlv_detail_commit(detail, &changes)); });
        CHECK(frame < 2 || changes.tile_count > 0);
        update.make(frame, [&] { follower.update(); });
        fetch.make(frame, [&] { follower.fetch(); });
        evaluate.make(frame, [&] { CHECK_OK(rlv_evaluate_detail(detail, &reader.wanted)); });
        cast.make(frame, [&] { CHECK_OK(rlv_caster_cast(caster, &reader.rays)); });
        info.make(frame, [&] { CHECK_OK(rlv_detail_info(detail, &known)); });
        CHECK(reader.hits[places / 2].tile != RLV_NO_ELEMENT);
    }
    CHECK_OK(rlv_stroke_end(stroke, nullptr));
    CHECK_OK(rlv_stroke_release(stroke));

    std::vector<float> points(3 * (cells + 1) * (cells + 1));
    CHECK_OK(rlv_mesh_get_points(cage, points.data(), points.size() / 3, 0));
    for (int frame = 0; frame < frames; ++frame) {
        for (size_t k = 0; k < points.size(); k += 3) {
            points[k + 2] = std::sin(points[k] + turn * float(frame % 12) / 12.0f);
        }
        pose.make(frame, [&] { CHECK_OK(rlv_detail_set_points(detail, points.data(), points.size() / 3, 0)); });
        posed.make(frame, [&] { CHECK_OK(rlv_detail_commit(detail, nullptr)); });
        moved.make(frame, [&] { follower.update(); });
        fetch.make(frame, [&] { follower.fetch(); });
        evaluate.make(frame, [&] { CHECK_OK(rlv_evaluate_detail(detail, &reader.wanted)); });
    }
    bool holds = true;
    for (const Call *call : {&commit, &update, &fetch, &evaluate, &cast, &info, &pose, &posed, &moved}) {
        holds &= call->holds(threads == 1);
    }
    CHECK_OK(rlv_brush_release(brush));
    CHECK_OK(rlv_caster_release(caster));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(cage));
    CHECK_OK(rlv_context_release(context));
    return holds;
}

} // namespace

int main() {
    const bool alone = run(1), together = run(2);
    return alone && together ? 0 : 1;
}
