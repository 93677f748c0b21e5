// rate [--json]: the ray rate and memory of a detail as user geometry beside Embree's own triangles of the same cells, and
// what a call of the library costs. One line per figure: `cargo xtask bench hosts` runs it.
#include "../figure.h"
#include "renderer.h"

#include <cmath>
#include <cstring>
#include <ctime>
#include <limits>
#include <string>
#include <vector>

namespace {

constexpr uint32_t CELLS = 128;
constexpr size_t RAYS = 1 << 18;
constexpr int RUNS = 5;

/// Of the processor: all that is measured runs on one thread, and others may be busy.
double seconds() { return double(std::clock()) / CLOCKS_PER_SEC; }

/// Million rays a second.
double cast_all(RTCScene scene, const std::vector<RTCRayHit> &rays, bool is_shadow) {
    const double start = seconds();
    for (const RTCRayHit &ray : rays) {
        RTCRayHit own = ray;
        if (is_shadow) {
            shadow(scene, own.ray);
        } else {
            trace(scene, own);
        }
    }
    return 1e-6 * double(rays.size()) / (seconds() - start);
}

RTCRayHit ray_of(const float *from, const float *to) {
    RTCRayHit ray = {};
    ray.ray.org_x = from[0];
    ray.ray.org_y = from[1];
    ray.ray.org_z = from[2];
    ray.ray.dir_x = to[0] - from[0];
    ray.ray.dir_y = to[1] - from[1];
    ray.ray.dir_z = to[2] - from[2];
    ray.ray.tfar = std::numeric_limits<float>::infinity();
    ray.ray.mask = 0xffffffffu;
    ray.hit.geomID = ray.hit.primID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return ray;
}

/// Rays of a camera, row by row.
std::vector<RTCRayHit> camera_rays() {
    std::vector<RTCRayHit> rays;
    const float eye[3] = {0.5f, -3.0f, 3.0f};
    for (int y = 0; y < 512; ++y) {
        for (int x = 0; x < 512; ++x) {
            const float to[3] = {float(x) / 128.0f - 2.0f, float(y) / 128.0f - 2.0f, 0.0f};
            rays.push_back(ray_of(eye, to));
        }
    }
    return rays;
}

/// Rays that have nothing to do with one another.
std::vector<RTCRayHit> scattered_rays() {
    std::vector<RTCRayHit> rays;
    uint32_t state = 1;
    const auto next = [&state] {
        state = state * 1664525u + 1013904223u;
        return float(state >> 8) / 8388608.0f - 1.0f;
    };
    while (rays.size() < RAYS) {
        const float from[3] = {2.0f * next(), 2.0f * next(), 0.6f + 0.4f * next()}, to[3] = {2.0f * next(), 2.0f * next(), 0.0f};
        rays.push_back(ray_of(from, to));
    }
    return rays;
}

bool json = false;

void line(const char *name, double ours, double peer, const char *peer_name, const char *unit, const char *goal, bool met) {
    if (json) {
        std::printf("{\"bench\":\"hosts\",\"case\":\"%s\",\"ours\":%g,\"peer\":", name, ours);
        if (peer > 0.0) {
            std::printf("%g,\"peer_name\":\"%s\",\"ratio\":%g", peer, peer_name, ours / peer);
        } else {
            std::printf("null,\"peer_name\":null,\"ratio\":null");
        }
        std::printf(",\"unit\":\"%s\",\"goal\":\"%s\",\"met\":%s}\n", unit, goal, met ? "true" : "false");
    } else if (peer > 0.0) {
        std::printf("%-34s %10.3f %-10s %10.3f %-18s %7.3f  %-14s %s\n", name, ours, unit, peer, peer_name, ours / peer, goal, met ? "yes" : "NO");
    } else {
        std::printf("%-34s %10.3f %-10s %10s %-18s %7s  %-14s %s\n", name, ours, unit, "", "", "", goal, met ? "yes" : "NO");
    }
}

/// A plane of 8 x 8 quads with waves carved all over.
RlvDetail terrain(RlvContext context) {
    RlvMesh cage = check_plane(context, 8, 8);
    float points[81][3];
    CHECK_OK(rlv_mesh_get_points(cage, points[0], 81, 0));
    for (float *point : points) {
        point[0] = 0.5f * point[0] - 2.0f;
        point[1] = 0.5f * point[1] - 2.0f;
        point[2] = 0.2f * std::sin(2.0f * point[0]) * std::cos(2.0f * point[1]);
    }
    CHECK_OK(rlv_mesh_set_points(cage, points[0], 81, 0));
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    options.tile_size = CELLS;
    CHECK_OK(rlv_surface_create(context, cage, nullptr, &surface));
    CHECK_OK(rlv_detail_create(surface, &options, nullptr, &detail));
    RlvBrushOptions brush_options = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvBrush brush = RLV_NULL;
    brush_options.action = RLV_BRUSH_SCULPT;
    brush_options.height = 0.04f;
    settings.radius = 0.12f;
    settings.reach = 8.0f;
    CHECK_OK(rlv_brush_create(context, &brush_options, &settings, &brush));
    for (int row = 0; row < 14; ++row) {
        const double y = -1.95 + 0.3 * row;
        const RlvStrokePoint ends[3] = {{{-1.95, y, 0}, 1.0, -1.0}, {{0.0, y + 0.1, 0}, 1.0, -1.0}, {{1.95, y, 0}, 1.0, -1.0}};
        CHECK_OK(rlv_stroke_run(detail, brush, ends, 3, 0, nullptr));
    }
    CHECK_OK(rlv_detail_commit(detail, nullptr));
    CHECK_OK(rlv_brush_release(brush));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(cage));
    return detail;
}

/// Nanoseconds of a call.
template <class Call> double nanoseconds(Call call) {
    std::vector<double> runs;
    for (int run = 0; run < RUNS; ++run) {
        const double start = seconds();
        for (int k = 0; k < 1000000; ++k) {
            call();
        }
        runs.push_back(1e3 * (seconds() - start));
    }
    return median(runs);
}

} // namespace

int main(int argc, char **argv) {
    json = argc > 1 && std::strcmp(argv[1], "--json") == 0;
    RlvContext context = RLV_NULL;
    CHECK_OK(rlv_context_create(nullptr, &context));
    const RlvDetail detail = terrain(context);
    RTCDevice device = rtcNewDevice("threads=1");
    rtcSetDeviceMemoryMonitorFunction(device, count_bytes, nullptr);

    size_t count_of_triangles = 0;
    RTCScene triangles = triangles_of(device, detail, CELLS, 12, &count_of_triangles);
    const int64_t theirs = device_bytes;

    RlvProceduralOptions cells = RLV_PROCEDURAL_OPTIONS_INIT;
    RlvProceduralInfo info = RLV_PROCEDURAL_INFO_INIT;
    Geometry geometry;
    RlvProcedural procedural = RLV_NULL;
    cells.coarse = cells.fine = CELLS;
    const double start = seconds();
    CHECK_OK(rlv_procedural_create(detail, &cells, &procedural));
    const double made = seconds() - start;
    CHECK_OK(rlv_procedural_info(procedural, &info));
    RTCScene scene = scene_of(device, geometry, procedural);
    const int64_t hierarchy = device_bytes - theirs, ours = hierarchy + int64_t(info.bytes);
    RlvDetailInfo kept = RLV_DETAIL_INFO_INIT;
    CHECK_OK(rlv_detail_info(detail, &kept));

    struct Kind {
        const char *name;
        std::vector<RTCRayHit> rays;
        bool shadow;
    };
    const Kind kinds[] = {{"rays of a camera", camera_rays(), false},
                          {"scattered rays", scattered_rays(), false},
                          {"scattered shadow rays", scattered_rays(), true}};
    for (const Kind &kind : kinds) {
        std::vector<double> mine, peer;
        for (int run = 0; run < RUNS; ++run) {
            mine.push_back(cast_all(scene, kind.rays, kind.shadow));
            peer.push_back(cast_all(triangles, kind.rays, kind.shadow));
        }
        const double ratio = median(mine) / median(peer);
        line(kind.name, median(mine), median(peer), "Embree triangles", "Mrays/s", "ratio >= 0.6", ratio >= 0.6);
    }
    const double count = double(info.cell_count);
    line("memory", double(ours) / count, double(theirs) / count, "Embree triangles", "B/cell", "ratio <= 0.1",
         ours * 10 <= theirs);
    line("memory, with the detail", double(ours + int64_t(kept.bytes)) / count, double(theirs) / count, "Embree triangles",
         "B/cell", "ratio <= 0.1", (ours + int64_t(kept.bytes)) * 10 <= theirs);
    line("making the procedural, all threads", 1e9 * made / count, 0.0, "", "ns/cell", "", true);
    RlvContextInfo context_info = RLV_CONTEXT_INFO_INIT;
    const double call = nanoseconds([&] { CHECK_OK(rlv_context_info(context, &context_info)); });
    line("rlv_context_info", call, 0.0, "", "ns", "<= 50", call <= 50.0);
    const double detail_call = nanoseconds([&] { CHECK_OK(rlv_detail_info(detail, &kept)); });
    line("rlv_detail_info", detail_call, 0.0, "", "ns", "", true);
    rtcReleaseScene(scene);
    rtcReleaseScene(triangles);
    rtcReleaseDevice(device);
    CHECK_OK(rlv_procedural_release(procedural));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
