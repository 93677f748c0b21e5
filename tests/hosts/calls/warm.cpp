// warm: calls that a host makes at every event of a brush and at every frame of an animation ask for no memory once they
// are warm, on any thread of the library: it counts what malloc and its kin are asked for. With one thread no call of the
// later frames may ask for any; with two, threads get warm when they happen to be given work, so most calls may not. Those
// that record are made within edits that can be undone; they may ask for the blocks of tiles that get their first.
#include "../../c/check.h"
#include "../figure.h"
#include "allocations.h"
#include "follower.h"

#include <cmath>
#include <cstdint>
#include <string>
#include <type_traits>

namespace {

const uint32_t cells = 16, places = 3000;
const int frames = 120, warm_from = 60;
const float turn = 6.2831853f;
/// How often calls that record may ask beyond the blocks of tiles that get their first: for lists that grow, and for the
/// copies that undo holds of tiles of which no stroke before left one. A list of every stage would be more.
const double few = 24.0;

/// A call that is made at every frame, and how often it asked for memory once warm.
struct Call {
    std::string name;
    std::vector<double> counts;

    explicit Call(std::string name) : name(std::move(name)) {}

    /// What `work` asks for beyond what it returns, which is what may be asked for.
    template <class Work> void make(int frame, Work work) {
        const Allocations before = allocations();
        const uint64_t allowed = [&] {
            if constexpr (std::is_void_v<decltype(work())>) {
                work();
                return 0;
            } else {
                return work();
            }
        }();
        const Allocations made = allocations() - before;
        if (frame >= warm_from) {
            counts.push_back(double(made.count > allowed ? made.count - allowed : 0));
        }
    }

    /// Whether it asked for none, or as often as it may: at every frame, or at the median.
    bool holds(bool every, double may = 0.0) const {
        const double most = quantile(counts, every ? 1.0 : 0.5);
        if (most > may) {
            std::fprintf(stderr, "%s asks for memory %g times a call, %s\n", name.c_str(), most,
                         every ? "at most" : "at the median");
        }
        return most <= may;
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

/// A plane with displacement and colours.
RlvDetail painted_plane(RlvContext context, uint32_t side, uint32_t size) {
    const RlvMesh cage = check_plane(context, side, side);
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDetailOptions sizes = RLV_DETAIL_OPTIONS_INIT;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    sizes.tile_size = paint.tile_size = size;
    CHECK_OK(rlv_surface_create(context, cage, nullptr, &surface));
    CHECK_OK(rlv_detail_create(surface, &sizes, nullptr, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    CHECK_OK(rlv_detail_commit(detail, nullptr));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(cage));
    return detail;
}

/// Strokes around the middle of a plane, each of them an edit of a document: what undo holds of one is there for the next.
bool strokes(RlvContext context, uint32_t action, uint32_t size, bool every) {
    const RlvDetail detail = painted_plane(context, cells, size);
    RlvDocument document = RLV_NULL;
    CHECK_OK(rlv_document_create(detail, nullptr, 0, &document));
    const std::string name = action == RLV_BRUSH_PAINT ? "painting" : "sculpting";
    Call event("rlv_stroke_extend, " + name), commit("rlv_detail_commit, " + name);
    for (int stroke = 0, frame = 0; stroke < 10; ++stroke) {
        RlvBrushOptions options = RLV_BRUSH_OPTIONS_INIT;
        RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
        RlvBrush brush = RLV_NULL;
        RlvStroke open = RLV_NULL;
        options.action = action;
        options.height = stroke % 2 == 0 ? 0.02f : -0.02f;
        options.color[stroke % 2] = 0.8f;
        settings.radius = 1.5f;
        CHECK_OK(rlv_brush_create(context, &options, &settings, &brush));
        CHECK_OK(rlv_document_begin(document, "stroke"));
        CHECK_OK(rlv_stroke_begin(detail, brush, &open));
        for (int step = 0; step < 12; ++step, ++frame) {
            const float angle = turn * float(step) / 12.0f;
            const RlvStrokePoint point = {{8.0 + 4.0 * std::cos(angle), 8.0 + 4.0 * std::sin(angle), 0.0}, 1.0, -1.0};
            RlvStrokeReport report = RLV_STROKE_REPORT_INIT;
            event.make(frame, [&] {
                CHECK_OK(rlv_stroke_extend(open, &point, 1, 0, &report));
                return report.allocated_tiles;
            });
            CHECK(step == 0 || report.changed_tiles > 0);
            CHECK(stroke < 2 || report.allocated_tiles == 0);
            commit.make(frame, [&] { CHECK_OK(rlv_detail_commit(detail, nullptr)); });
        }
        CHECK_OK(rlv_stroke_end(open, nullptr));
        CHECK_OK(rlv_stroke_release(open));
        CHECK_OK(rlv_document_end(document, nullptr));
        CHECK_OK(rlv_brush_release(brush));
    }
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_detail_release(detail));
    const bool dabs = event.holds(every, few), commits = commit.holds(every);
    return dabs && commits;
}

/// A cube that goes around in a plane, deeper each time, and then along it where nothing was.
bool imprints(RlvContext context, uint32_t size, bool every) {
    const RlvDetail detail = painted_plane(context, cells, size);
    const RlvMesh mesh = check_box(context, -1.2f, 1.2f, -1.2f, 1.2f);
    RlvCollider collider = RLV_NULL;
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    settings.voxels = 1 << 16;
    double at[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0};
    CHECK_OK(rlv_collider_create_mesh(context, mesh, at, &collider));
    Call again("rlv_imprint_run, deeper"), further("rlv_imprint_run, further"), commit("rlv_detail_commit of an imprint");
    uint64_t allocated = 0;
    for (int frame = 0; frame < frames + 40; ++frame) {
        const bool goes_on = frame >= frames;
        const float angle = turn * float(frame % 12) / 12.0f;
        at[9] = goes_on ? 2.0 + 0.3 * (frame - frames) : 8.0 + 3.0 * std::cos(angle);
        at[10] = goes_on ? 2.0 : 8.0 + 3.0 * std::sin(angle);
        at[11] = 1.15 - 0.02 * (frame / 12);
        CHECK_OK(rlv_collider_set_transform(collider, at));
        RlvImprintMoment moment = RLV_IMPRINT_MOMENT_INIT;
        RlvImprintReport report = RLV_IMPRINT_REPORT_INIT;
        moment.frame = uint64_t(frame);
        (goes_on ? further : again).make(frame, [&] {
            CHECK_OK(rlv_imprint_run(detail, collider, &settings, &moment, &report));
            return report.allocated_tiles;
        });
        CHECK(report.changed_tiles > 0);
        CHECK(frame < 24 || goes_on || report.allocated_tiles == 0);
        allocated += goes_on ? report.allocated_tiles : 0;
        commit.make(frame, [&] { CHECK_OK(rlv_detail_commit(detail, nullptr)); });
    }
    CHECK(allocated > 10);
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_detail_release(detail));
    // Lists of what there is grow with it, now and then.
    const bool holds = again.holds(every, few), grows = further.holds(false, few), commits = commit.holds(false);
    return holds && grows && commits;
}

bool run(uint32_t threads) {
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    options.threads = threads;
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(&options, &context));
    const RlvMesh cage = check_plane(context, cells, cells);
    const RlvDetail detail = painted_plane(context, cells, 16);
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
    CHECK_OK(rlv_mesh_release(cage));
    // Blocks of 16 x 16 texels: one of a tile, and so many that tiles have lists of them.
    for (const uint32_t size : {16u, 64u}) {
        for (const uint32_t kind : {uint32_t(RLV_BRUSH_SCULPT), uint32_t(RLV_BRUSH_PAINT)}) {
            holds &= strokes(context, kind, size, threads == 1);
        }
        holds &= imprints(context, size, threads == 1);
    }
    CHECK_OK(rlv_context_release(context));
    return holds;
}

} // namespace

int main() {
    const bool alone = run(1), together = run(2);
    return alone && together ? 0 : 1;
}
