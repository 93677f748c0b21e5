// rate [--json]: what the calls cost that a host makes at every event of a brush and at every frame of an imprint: their
// time, and what they allocate once everything is warm. Time is the processor's, of all threads together, since others may
// be busy; what a clock on the wall says is beside it. One line per call: `cargo xtask bench hosts` runs it.
#include "../../c/check.h"
#include "../figure.h"
#include "allocations.h"
#include "embedding.h"
#include "follower.h"

#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <ctime>
#include <string>

namespace {

bool json = false;

double now() {
    return 1e3 * std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

double worked() { return 1e3 * double(std::clock()) / CLOCKS_PER_SEC; }

/// What a call cost: milliseconds of the processor and of the wall, allocations and their bytes.
struct Cost {
    double work = 0.0, wall = 0.0, count = 0.0, bytes = 0.0;
};

/// A call that is made again and again, and what each time cost.
struct Call {
    std::string name;
    std::vector<Cost> costs;

    explicit Call(std::string name) : name(std::move(name)) {}

    template <class Work> void measure(Work work) {
        const Allocations before = allocations();
        const double start = now(), begun = worked();
        work();
        const double took = worked() - begun, wall = now() - start;
        const Allocations made = allocations() - before;
        costs.push_back({took, wall, double(made.count), double(made.bytes)});
    }

    /// Of the last ones: the first find things cold.
    std::vector<double> warm(double Cost::*part) const {
        std::vector<double> values;
        for (size_t k = std::min<size_t>(5, costs.size() - 1); k < costs.size(); ++k) {
            values.push_back(costs[k].*part);
        }
        return values;
    }

    /// A goal of 0 ms is none. What records nothing is to ask for no memory.
    void print(double goal = 0.0, bool records = true) const {
        const double middle = median(warm(&Cost::work)), most = quantile(warm(&Cost::work), 0.95);
        const double wall = median(warm(&Cost::wall));
        const double count = median(warm(&Cost::count)), size = median(warm(&Cost::bytes)) / 1024.0;
        const bool met = records ? middle <= goal : count == 0.0;
        const std::string wanted = records ? "<= " + std::to_string(int(goal)) : "no allocations";
        const bool has_goal = goal > 0.0 || !records;
        if (json) {
            std::printf("{\"bench\":\"hosts\",\"case\":\"%s\",\"ours\":%g,\"peer\":null,\"peer_name\":null,\"unit\":\"ms\",\"ratio\":null,"
                        "\"p95\":%g,\"wall\":%g,\"allocations\":%g,\"allocated_kib\":%g,",
                        name.c_str(), middle, most, wall, count, size);
            if (has_goal) {
                std::printf("\"goal\":\"%s\",\"met\":%s}\n", wanted.c_str(), met ? "true" : "false");
            } else {
                std::printf("\"goal\":\"\",\"met\":null}\n");
            }
        } else {
            std::printf("%-40s %8.3f ms  95 %% %8.3f ms  wall %8.3f ms  %6.0f allocations %8.1f KiB", name.c_str(), middle, most,
                        wall, count, size);
            if (has_goal) {
                std::printf("  %s  %s", wanted.c_str(), met ? "yes" : "NO");
            }
            std::printf("\n");
        }
    }
};

/// The plane of `cells` x `cells` quads from (-1, -1) to (1, 1).
RlvMesh square(RlvContext context, uint32_t cells) {
    RlvMesh mesh = check_plane(context, cells, cells);
    std::vector<float> points(3 * size_t(cells + 1) * (cells + 1));
    CHECK_OK(rlv_mesh_get_points(mesh, points.data(), points.size() / 3, 0));
    for (size_t k = 0; k < points.size(); ++k) {
        points[k] = k % 3 == 2 ? 0.0f : 2.0f * points[k] / float(cells) - 1.0f;
    }
    CHECK_OK(rlv_mesh_set_points(mesh, points.data(), points.size() / 3, 0));
    return mesh;
}

/// A detail whose tiles have `size` texels a side, with colours, on a plane.
RlvDetail plane(RlvContext context, uint32_t cells, uint32_t size) {
    RlvMesh cage = square(context, cells);
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    options.tile_size = paint.tile_size = size;
    CHECK_OK(rlv_surface_create(context, cage, nullptr, &surface));
    CHECK_OK(rlv_detail_create(surface, &options, nullptr, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, &paint));
    CHECK_OK(rlv_detail_commit(detail, nullptr));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(cage));
    return detail;
}

/// Where a ray down at (x, y) meets the surface.
RlvHit meet(RlvCaster caster, float x, float y) {
    const float origin[3] = {x, y, 1.0f}, direction[3] = {0.0f, 0.0f, -1.0f};
    const RlvHit hit = check_cast(caster, origin, direction);
    CHECK(hit.tile != RLV_NO_ELEMENT);
    return hit;
}

/// A loop of a host that stays on the calling thread, and how often it was run: what is left is what handing over costs.
void loop_here(void *user, size_t count, RlvLoopBody body, void *work) {
    ++*static_cast<size_t *>(user);
    for (size_t index = 0; index < count; ++index) {
        body(work, index);
    }
}

/// What a loop costs more on a scheduler of the host than in a context of one thread, which has none.
void host_loops() {
    size_t loops = 0;
    double micros[2];
    for (int hosted = 0; hosted < 2; ++hosted) {
        RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
        RlvContext context = RLV_NULL;
        options.threads = 1;
        if (hosted) {
            options.host_loop = loop_here;
            options.host_user = &loops;
        }
        CHECK_OK(rlv_context_create(&options, &context));
        const RlvMesh mesh = square(context, 8);
        RlvSurface surface = RLV_NULL;
        CHECK_OK(rlv_surface_create(context, mesh, nullptr, &surface));
        std::vector<uint32_t> tiles(4096);
        std::vector<float> uvs(2 * tiles.size(), 0.5f), positions(3 * tiles.size());
        for (size_t k = 0; k < tiles.size(); ++k) {
            tiles[k] = uint32_t(k % 64);
        }
        RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
        arrays.count = tiles.size();
        arrays.tiles = tiles.data();
        arrays.uvs = uvs.data();
        arrays.positions = positions.data();
        loops = 0;
        std::vector<double> times;
        for (int k = 0; k < 2000; ++k) {
            const double start = now();
            CHECK_OK(rlv_evaluate_surface(surface, &arrays));
            times.push_back(1e3 * (now() - start));
        }
        micros[hosted] = median(times);
        CHECK_OK(rlv_surface_release(surface));
        CHECK_OK(rlv_mesh_release(mesh));
        CHECK_OK(rlv_context_release(context));
    }
    const double more = (micros[1] - micros[0]) / std::max(1.0, double(loops) / 2000.0);
    if (json) {
        std::printf("{\"bench\":\"hosts\",\"case\":\"a loop of the host\",\"ours\":%g,\"peer\":null,\"peer_name\":null,"
                    "\"unit\":\"us\",\"ratio\":null,\"goal\":\"<= 2 us\",\"met\":%s}\n",
                    more, more <= 2.0 ? "true" : "false");
    } else {
        std::printf("%-40s %8.3f us more than none, %.1f loops a call of %.1f us  <= 2 us  %s\n", "a loop of the host", more,
                    double(loops) / 2000.0, micros[0], more <= 2.0 ? "yes" : "NO");
    }
}

/// Strokes of a brush on 200,000 faces, an event at a time as a modal tool has them.
void brush_events(RlvContext context) {
    const RlvDetail detail = plane(context, 447, 8);
    Follower follower(detail, 1);
    RlvCaster caster = RLV_NULL;
    CHECK_OK(rlv_caster_create_tessellation(follower.handle, &caster));
    for (const uint32_t action : {uint32_t(RLV_BRUSH_SCULPT), uint32_t(RLV_BRUSH_PAINT)}) {
        RlvBrushOptions options = RLV_BRUSH_OPTIONS_INIT;
        RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
        RlvBrush brush = RLV_NULL;
        options.action = action;
        options.height = 0.02f;
        options.color[1] = 0.2f;
        settings.radius = 0.05f;
        CHECK_OK(rlv_brush_create(context, &options, &settings, &brush));
        const std::string name = action == RLV_BRUSH_SCULPT ? "sculpting" : "painting";
        Call event(name + ": an event"), cast("  ray"), extend("  dabs"), commit("  commit"), update("  triangles"), fetch("  copies");
        Call refit("  caster");
        Call *const stages[] = {&cast, &extend, &commit, &update, &fetch, &refit};
        for (const float y : {0.1f, 0.1f, 0.13f}) {
            RlvStroke stroke = RLV_NULL;
            CHECK_OK(rlv_stroke_begin(detail, brush, &stroke));
            for (int step = 0; step < 60; ++step) {
                RlvStrokePoint point = {{0.0, 0.0, 0.0}, 1.0, -1.0};
                cast.measure([&] {
                    const RlvHit hit = meet(caster, -0.6f + 0.02f * float(step), y);
                    std::copy(hit.position, hit.position + 3, point.position);
                });
                extend.measure([&] { CHECK_OK(rlv_stroke_extend(stroke, &point, 1, 0, nullptr)); });
                RlvDetailChanges changes = RLV_DETAIL_CHANGES_INIT;
                commit.measure([&] { CHECK_OK(rlv_detail_commit(detail, &changes)); });
                CHECK(step < 2 || changes.tile_count > 0);
                update.measure([&] { follower.update(); });
                fetch.measure([&] { follower.fetch(); });
                refit.measure([&] { CHECK_OK(rlv_caster_update(caster)); });
                Cost sum;
                for (const Call *stage : stages) {
                    const Cost &cost = stage->costs.back();
                    sum = {sum.work + cost.work, sum.wall + cost.wall, sum.count + cost.count, sum.bytes + cost.bytes};
                }
                event.costs.push_back(sum);
            }
            CHECK_OK(rlv_stroke_end(stroke, nullptr));
            CHECK_OK(rlv_stroke_release(stroke));
        }
        event.print(8.0);
        for (const Call *stage : stages) {
            stage->print(stage == &refit ? 1.0 : 0.0, stage == &extend || stage == &refit);
        }
        CHECK_OK(rlv_brush_release(brush));
    }
    CHECK_OK(rlv_caster_release(caster));
    CHECK_OK(rlv_detail_release(detail));
}

/// A cube that is dragged through a plane of 64 x 64 faces, frame by frame, and what a host reads at every frame.
void imprint_frames(RlvContext context) {
    const uint32_t side = 64, size = 32;
    const RlvDetail detail = plane(context, side, size);
    Follower follower(detail, 4);
    const RlvMesh mesh = check_box(context, -0.1f, 0.1f, -0.1f, 0.1f);
    RlvCollider collider = RLV_NULL;
    const auto moved = [](double x, double *out) {
        const double matrix[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, x, 0.0, 0.08};
        std::copy(matrix, matrix + 12, out);
    };
    double at[12];
    moved(-0.6, at);
    CHECK_OK(rlv_collider_create_mesh(context, mesh, at, &collider));
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    settings.voxels = 1 << 20;

    const uint32_t places = 10000;
    std::vector<uint32_t> tiles(places);
    std::vector<float> uvs(2 * places), positions(3 * places), normals(3 * places), origins(3 * places), directions(3 * places);
    std::vector<RlvHit> hits(places);
    for (uint32_t k = 0; k < places; ++k) {
        tiles[k] = k * 2654435761u % (side * side);
        uvs[2 * k] = float(k % 97) / 97.0f;
        uvs[2 * k + 1] = float(k % 89) / 89.0f;
        origins[3 * k] = float(k % 100) / 51.0f - 0.97f;
        origins[3 * k + 1] = float(k / 100) / 51.0f - 0.97f;
        origins[3 * k + 2] = 1.0f;
        directions[3 * k + 2] = -1.0f;
    }
    RlvEvaluateArrays wanted = RLV_EVALUATE_ARRAYS_INIT;
    wanted.count = places;
    wanted.tiles = tiles.data();
    wanted.uvs = uvs.data();
    wanted.positions = positions.data();
    wanted.normals = normals.data();
    RlvCaster caster = RLV_NULL;
    CHECK_OK(rlv_caster_create_detail(detail, nullptr, &caster));
    RlvRayArrays rays = RLV_RAY_ARRAYS_INIT;
    rays.count = places;
    rays.origins = origins.data();
    rays.directions = directions.data();
    rays.hits = hits.data();
    std::vector<float> cage(3 * (side + 1) * (side + 1));
    const RlvMesh posed = square(context, side);
    CHECK_OK(rlv_mesh_get_points(posed, cage.data(), cage.size() / 3, 0));

    Call place("rlv_collider_set_transform"), run("rlv_imprint_run"), commit("rlv_detail_commit"), update("rlv_tessellation_update");
    Call fetch("rlv_tessellation_get_points, all ranges"), evaluate("rlv_evaluate_detail, 10,000 places");
    Call cast("rlv_caster_cast, 10,000 rays"), pose("rlv_detail_set_points, 4,225 points"), info("rlv_detail_info");
    for (int frame = 0; frame < 60; ++frame) {
        moved(-0.6 + 0.02 * frame, at);
        RlvImprintMoment moment = RLV_IMPRINT_MOMENT_INIT;
        RlvDetailInfo known = RLV_DETAIL_INFO_INIT;
        moment.frame = uint64_t(frame);
        place.measure([&] { CHECK_OK(rlv_collider_set_transform(collider, at)); });
        run.measure([&] { CHECK_OK(rlv_imprint_run(detail, collider, &settings, &moment, nullptr)); });
        commit.measure([&] { CHECK_OK(rlv_detail_commit(detail, nullptr)); });
        update.measure([&] { follower.update(); });
        fetch.measure([&] { follower.fetch(); });
        evaluate.measure([&] { CHECK_OK(rlv_evaluate_detail(detail, &wanted)); });
        cast.measure([&] { CHECK_OK(rlv_caster_cast(caster, &rays)); });
        info.measure([&] { CHECK_OK(rlv_detail_info(detail, &known)); });
        CHECK(known.allocated_count > 0);
    }
    for (int frame = 0; frame < 20; ++frame) {
        for (size_t k = 2; k < cage.size(); k += 3) {
            cage[k] = 0.1f * std::sin(cage[k - 1] + 0.3f * float(frame));
        }
        pose.measure([&] { CHECK_OK(rlv_detail_set_points(detail, cage.data(), cage.size() / 3, 0)); });
    }
    for (const Call *call : {&place, &run, &commit, &update, &fetch, &evaluate, &cast, &info, &pose}) {
        call->print(0.0, call == &run);
    }
    CHECK_OK(rlv_caster_release(caster));
    CHECK_OK(rlv_collider_release(collider));
    CHECK_OK(rlv_mesh_release(posed));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_detail_release(detail));
}

} // namespace

int main(int argc, char **argv) {
    json = argc > 1 && std::strcmp(argv[1], "--json") == 0;
    host_loops();
    contexts(json);
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(nullptr, &context));
    brush_events(context);
    imprint_frames(context);
    borrowed_arrays(json);
    document_bytes(context, json);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
