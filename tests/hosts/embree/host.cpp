// A host with an Embree scene of its own, of version 3 or 4, in which a detail is user geometry: hits, silhouettes,
// packets, motion blur, filter functions, attributes and memory, held against Embree's own triangles of the same surface.
#include "renderer.h"

#include <cmath>
#include <cstring>
#include <limits>
#include <thread>
#include <vector>

namespace {

/// A cube's cage, shifted along x, which is round in the limit.
RlvMesh cube(RlvContext context, float shift) {
    const float points[8][3] = {{-1, -1, -1}, {1, -1, -1}, {-1, 1, -1}, {1, 1, -1},
                                {-1, -1, 1},  {1, -1, 1},  {-1, 1, 1},  {1, 1, 1}};
    const uint32_t corners[24] = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6};
    float moved[8][3];
    for (int k = 0; k < 8; ++k) {
        for (int axis = 0; axis < 3; ++axis) {
            moved[k][axis] = points[k][axis] + (axis == 0 ? shift : 0.0f);
        }
    }
    return check_mesh_of(context, moved[0], 8, 4, 6, corners);
}

/// Numbers from 0 to 1.
struct Random {
    uint32_t state = 1;

    float next() {
        state = state * 1664525u + 1013904223u;
        return float(state >> 8) / 16777216.0f;
    }
};

struct Ray {
    float origin[3], direction[3];
};

/// Rays from around the model to places in it, or past it.
std::vector<Ray> rays_around(size_t count) {
    std::vector<Ray> rays;
    Random random;
    while (rays.size() < count) {
        Ray ray;
        float length = 0.0f;
        for (float &value : ray.origin) {
            value = 2.0f * random.next() - 1.0f;
            length += value * value;
        }
        if (length < 0.01f || length > 1.0f) {
            continue;
        }
        for (int axis = 0; axis < 3; ++axis) {
            ray.origin[axis] *= 3.0f / std::sqrt(length);
            ray.direction[axis] = 2.0f * random.next() - 1.0f - ray.origin[axis];
        }
        rays.push_back(ray);
    }
    return rays;
}

RTCRayHit prepared(const Ray &ray, float time) {
    RTCRayHit out = {};
    out.ray.org_x = ray.origin[0];
    out.ray.org_y = ray.origin[1];
    out.ray.org_z = ray.origin[2];
    out.ray.dir_x = ray.direction[0];
    out.ray.dir_y = ray.direction[1];
    out.ray.dir_z = ray.direction[2];
    out.ray.tfar = std::numeric_limits<float>::infinity();
    out.ray.mask = 0xffffffffu;
    out.ray.time = time;
    out.hit.geomID = out.hit.primID = out.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return out;
}

RTCRayHit cast(RTCScene scene, const Ray &ray, float time = 0.0f, RTCFilterFunctionN filter = nullptr) {
    RTCRayHit out = prepared(ray, time);
    trace(scene, out, filter);
    return out;
}

bool is_occluded(RTCScene scene, const Ray &ray, float time = 0.0f, RTCFilterFunctionN filter = nullptr) {
    RTCRay out = prepared(ray, time).ray;
    shadow(scene, out, filter);
    return out.tfar < 0.0f;
}

bool is_hit(const RTCRayHit &ray) { return ray.hit.geomID != RTC_INVALID_GEOMETRY_ID; }

float length_of(const float *v) { return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]); }

/// Hits, misses and shadow rays are those of Embree's triangles, but for rays that graze.
void check_hits(RTCScene procedural, RTCScene triangles, const std::vector<Ray> &rays, float tolerance) {
    size_t hits = 0, grazing = 0, different = 0;
    for (const Ray &ray : rays) {
        const RTCRayHit ours = cast(procedural, ray), theirs = cast(triangles, ray);
        CHECK(is_occluded(procedural, ray) == is_hit(ours));
        if (is_hit(ours) != is_hit(theirs)) {
            ++grazing;
            continue;
        }
        if (!is_hit(ours)) {
            continue;
        }
        ++hits;
        const float off = std::fabs(ours.ray.tfar - theirs.ray.tfar) * length_of(ray.direction);
        const float ng[3] = {theirs.hit.Ng_x, theirs.hit.Ng_y, theirs.hit.Ng_z};
        const float slope = std::fabs(ng[0] * ray.direction[0] + ng[1] * ray.direction[1] + ng[2] * ray.direction[2]) /
                            (length_of(ng) * length_of(ray.direction));
        different += off > tolerance / std::max(slope, 0.05f);
        // Fronts look out of the model: Ng is du x dv, as the triangles' is.
        const float mine[3] = {ours.hit.Ng_x, ours.hit.Ng_y, ours.hit.Ng_z};
        if (slope > 0.3f && off < tolerance) {
            CHECK(mine[0] * ng[0] + mine[1] * ng[1] + mine[2] * ng[2] > 0.0f);
        }
    }
    CHECK(hits > rays.size() / 4);
    if (grazing > rays.size() / 500 || different > rays.size() / 500) {
        fprintf(stderr, "%zu of %zu rays hit but one, %zu hit elsewhere\n", grazing, rays.size(), different);
        exit(1);
    }
}

/// Whether packets of N rays leave lanes that are off alone. Embree 3 makes packets that the processor lacks of smaller ones,
/// and may write such lanes.
template <int N> bool leaves_lanes([[maybe_unused]] RTCScene scene) {
#if RELIEVO_HOST_EMBREE == 3
    const RTCDeviceProperty property = N == 4   ? RTC_DEVICE_PROPERTY_NATIVE_RAY4_SUPPORTED
                                       : N == 8 ? RTC_DEVICE_PROPERTY_NATIVE_RAY8_SUPPORTED
                                                : RTC_DEVICE_PROPERTY_NATIVE_RAY16_SUPPORTED;
    const RTCDevice device = rtcGetSceneDevice(scene);
    const bool is_native = rtcGetDeviceProperty(device, property) != 0;
    rtcReleaseDevice(device);
    return is_native;
#else
    return true;
#endif
}

/// Packets find to the bit what single rays find, and shadows where these hit.
template <int N> void check_packets(RTCScene scene, const std::vector<Ray> &rays, float time) {
    const bool has_idle_lanes = leaves_lanes<N>(scene);
    // A later Embree has a number more.
    constexpr int KINDS = RAY + HIT + 1;
    for (size_t first = 0; first + N <= rays.size(); first += N) {
        alignas(64) float numbers[KINDS * N], shadows[RAY * N];
        alignas(64) int valid[N];
        for (int k = 0; k < N; ++k) {
            // Every fifth lane is off.
            valid[k] = (first + size_t(k)) % 5 == 4 ? 0 : -1;
            const RTCRayHit one = prepared(rays[first + size_t(k)], time);
            float single[KINDS];
            std::memset(single, 0xff, sizeof single);
            std::memcpy(single, &one.ray, 4 * RAY);
            std::memcpy(single + RAY, &one.hit, 4 * HIT);
            for (int kind = 0; kind < KINDS; ++kind) {
                numbers[kind * N + k] = single[kind];
            }
            for (int kind = 0; kind < int(RAY); ++kind) {
                shadows[kind * N + k] = single[kind];
            }
        }
        trace_packet<N>(valid, scene, numbers);
        shadow_packet<N>(valid, scene, shadows);
        for (int k = 0; k < N; ++k) {
            if (!valid[k] && !has_idle_lanes) {
                continue;
            }
            const RTCRayHit one = valid[k] ? cast(scene, rays[first + size_t(k)], time)
                                           : prepared(rays[first + size_t(k)], time);
            float single[RAY + HIT], lane[RAY + HIT];
            std::memcpy(single, &one.ray, 4 * RAY);
            std::memcpy(single + RAY, &one.hit, 4 * HIT);
            for (int kind = 0; kind < int(RAY + HIT); ++kind) {
                lane[kind] = numbers[kind * N + k];
            }
            CHECK(std::memcmp(single, lane, sizeof single) == 0);
            CHECK((shadows[8 * N + k] < 0.0f) == is_hit(one));
        }
    }
}

void check_all_packets(RTCScene scene, const std::vector<Ray> &rays, float time) {
    check_packets<4>(scene, rays, time);
    check_packets<8>(scene, rays, time);
    check_packets<16>(scene, rays, time);
}

/// Refuses hits on fronts.
void refuse_fronts(const RTCFilterFunctionNArguments *args) {
    const float *const ray = reinterpret_cast<const float *>(args->ray), *const hit = reinterpret_cast<const float *>(args->hit);
    CHECK(args->N == 1 && args->valid[0] == -1);
    if (ray[4] * hit[0] + ray[5] * hit[1] + ray[6] * hit[2] < 0.0f) {
        args->valid[0] = 0;
    }
}

void refuse_all(const RTCFilterFunctionNArguments *args) { args->valid[0] = 0; }

/// Filter functions of the geometry and of the call are asked about hits, and rays go on behind what they refuse.
void check_filters(RTCDevice device, RTCScene plain, RlvProcedural procedural, const std::vector<Ray> &rays) {
    Geometry through, open;
    RTCScene backs = scene_of(device, through, procedural, refuse_fronts, true);
    RTCScene all = scene_of(device, open, procedural, nullptr, true);
    size_t passed = 0;
    for (const Ray &ray : rays) {
        RTCRayHit wanted = cast(plain, ray);
        const RTCRayHit same = cast(all, ray);
        CHECK(std::memcmp(&wanted.hit, &same.hit, 4 * HIT) == 0);
        while (is_hit(wanted) && wanted.hit.Ng_x * ray.direction[0] + wanted.hit.Ng_y * ray.direction[1] +
                                         wanted.hit.Ng_z * ray.direction[2] < 0.0f) {
            const float far = wanted.ray.tfar;
            wanted = prepared(ray, 0.0f);
            wanted.ray.tnear = std::nextafter(far, INFINITY);
            trace(plain, wanted);
        }
        for (const RTCRayHit &found : {cast(backs, ray), cast(all, ray, 0.0f, refuse_fronts)}) {
            CHECK(is_hit(found) == is_hit(wanted) && found.ray.tfar == wanted.ray.tfar);
            CHECK(!is_hit(found) || std::memcmp(&found.hit, &wanted.hit, 4 * HIT) == 0);
        }
        CHECK(is_occluded(backs, ray) == is_hit(wanted) && is_occluded(all, ray, 0.0f, refuse_fronts) == is_hit(wanted));
        CHECK(!is_hit(cast(all, ray, 0.0f, refuse_all)) && !is_occluded(all, ray, 0.0f, refuse_all));
        passed += is_hit(wanted);
    }
    CHECK(passed > rays.size() / 4);
    check_all_packets(backs, rays, 0.0f);
    rtcReleaseScene(backs);
    rtcReleaseScene(all);
}

/// The attributes at hits are those of the detail.
void check_attributes(RTCScene scene, RlvProcedural procedural, RlvDetail detail, const std::vector<Ray> &rays) {
    std::vector<uint32_t> primitives;
    std::vector<float> uvs, seen;
    for (const Ray &ray : rays) {
        const RTCRayHit hit = cast(scene, ray);
        if (is_hit(hit)) {
            primitives.push_back(hit.hit.primID);
            uvs.insert(uvs.end(), {hit.hit.u, hit.hit.v});
            for (int axis = 0; axis < 3; ++axis) {
                seen.push_back(ray.origin[axis] + hit.ray.tfar * ray.direction[axis]);
            }
        }
    }
    const size_t count = primitives.size();
    std::vector<uint32_t> tiles(count);
    std::vector<float> points(3 * count), normals(3 * count), colors(4 * count);
    std::vector<float> same(3 * count), same_normals(3 * count), same_colors(4 * count);
    RlvProceduralHits hits = RLV_PROCEDURAL_HITS_INIT;
    hits.count = count;
    hits.primitives = primitives.data();
    hits.uvs = uvs.data();
    hits.tiles = tiles.data();
    hits.positions = points.data();
    hits.normals = normals.data();
    hits.colors = colors.data();
    CHECK_OK(rlv_procedural_evaluate(procedural, &hits));
    RlvEvaluateArrays arrays = RLV_EVALUATE_ARRAYS_INIT;
    arrays.count = count;
    arrays.tiles = tiles.data();
    arrays.uvs = uvs.data();
    arrays.positions = same.data();
    arrays.normals = same_normals.data();
    arrays.colors = same_colors.data();
    CHECK_OK(rlv_evaluate_detail(detail, &arrays));
    CHECK(points == same && normals == same_normals && colors == same_colors);
    RlvProceduralTable table = RLV_PROCEDURAL_TABLE_INIT;
    CHECK_OK(rlv_procedural_table(procedural, &table));
    for (size_t k = 0; k < count; ++k) {
        CHECK(tiles[k] == table.tiles[primitives[k]]);
    }
    size_t off = 0;
    for (size_t k = 0; k < count; ++k) {
        float distance = 0.0f;
        for (size_t axis = 0; axis < 3; ++axis) {
            distance = std::max(distance, std::fabs(points[3 * k + axis] - seen[3 * k + axis]));
        }
        off += distance > 0.004f;
        CHECK_NEAR(length_of(&normals[3 * k]), 1.0f, 1e-4);
    }
    CHECK(off < count / 500);

    hits.primitives = nullptr;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_procedural_evaluate(procedural, &hits), "primitives");
    const uint32_t none = 0xffffffffu;
    hits.count = 1;
    hits.primitives = &none;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_procedural_evaluate(procedural, &hits), "does not exist");
    hits.primitives = primitives.data();
    const float outside[2] = {0.5f, std::nanf("")};
    hits.uvs = outside;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_procedural_evaluate(procedural, &hits), "outside");
}

/// What a renderer may hand over by mistake meets nothing.
void check_garbage(RlvContext context, RlvProcedural procedural, RlvDetail detail) {
    RlvProceduralTable table = RLV_PROCEDURAL_TABLE_INIT;
    RlvProceduralInfo info = RLV_PROCEDURAL_INFO_INIT;
    RlvProceduralOptions options = RLV_PROCEDURAL_OPTIONS_INIT;
    RlvProcedural none = RLV_NULL;
    CHECK_OK(rlv_procedural_table(procedural, &table));
    float box[8] = {};
    table.bounds(table.data, table.primitive_count, 0, box);
    CHECK(box[0] > box[4]);
    table.bounds(nullptr, 0, 0, box);
    table.bounds(table.data, 0, 7, box);
    CHECK(box[0] < box[4]);
    const float bad[] = {std::nanf(""), INFINITY, -INFINITY, 0.0f, 1e38f, -1e-40f};
    int valid = -1;
    for (int step = 0; step < 6 * 9; ++step) {
        RTCRayHit ray = prepared({{3, 0.1f, 0.2f}, {-1, 0, 0}}, 0.0f);
        reinterpret_cast<float *>(&ray)[step / 6] = bad[step % 6];
        for (uint32_t primitive : {0u, 1u, table.primitive_count, 0xffffffffu}) {
            table.intersect(table.data, &valid, primitive, 0, 0, &ray, 1);
            table.occluded(table.data, &valid, primitive, &ray, 1);
        }
    }
    RTCRayHit still = prepared({{3, 0, 0}, {0, 0, 0}}, 0.0f);
    for (uint32_t primitive = 0; primitive < table.primitive_count; ++primitive) {
        table.intersect(table.data, &valid, primitive, 0, 0, &still, 1);
    }
    CHECK(!is_hit(still));
    table.intersect(nullptr, &valid, 0, 0, 0, &still, 1);
    table.intersect(table.data, nullptr, 0, 0, 0, &still, 1);
    table.intersect(table.data, &valid, 0, 0, 0, nullptr, 1);
    table.occluded(table.data, &valid, 0, nullptr, 1);
    table.occluded(table.data, nullptr, 0, &still, 0);

    CHECK(rlv_procedural_info(none, &info) == RLV_ERROR_INVALID);
    CHECK(rlv_procedural_table(procedural, nullptr) == RLV_ERROR_INVALID);
    CHECK(rlv_procedural_create(detail, nullptr, nullptr) == RLV_ERROR_INVALID);
    for (uint32_t cells : {1u, 3u, 1024u}) {
        options.fine = cells;
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_procedural_create(detail, &options, &none), "fine");
    }
    // Another cage, and a triangle mesh.
    RlvMesh plane = check_plane(context, 3, 2);
    RlvSurfaceOptions kind = RLV_SURFACE_OPTIONS_INIT;
    for (uint32_t triangles = 0; triangles < 2; ++triangles) {
        RlvSurface surface = RLV_NULL;
        RlvDetail other = RLV_NULL;
        kind.kind = triangles ? RLV_SURFACE_TRIANGLES : RLV_SURFACE_CATMULL_CLARK;
        CHECK_OK(rlv_surface_create(context, plane, &kind, &surface));
        CHECK_OK(rlv_detail_create(surface, nullptr, nullptr, &other));
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_procedural_create_moving(procedural, other, &none), "end");
        CHECK_OK(rlv_detail_release(other));
        CHECK_OK(rlv_surface_release(surface));
    }
    CHECK_OK(rlv_mesh_release(plane));
    CHECK(none.id == 0);
    RlvProcedural twice = RLV_NULL;
    CHECK_OK(rlv_procedural_create(detail, nullptr, &twice));
    CHECK_OK(rlv_procedural_retain(twice));
    CHECK_OK(rlv_procedural_release(twice));
    CHECK_OK(rlv_procedural_release(twice));
    CHECK(rlv_procedural_release(twice) == RLV_ERROR_INVALID);
}

/// Sculpts and paints on one side, so that most tiles have no displacement and rates differ.
void edit(RlvContext context, RlvDetail detail) {
    RlvBrushOptions options = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    RlvBrush brush = RLV_NULL;
    const RlvStrokePoint points[3] = {{{0.2, -0.3, 0.9}, 1.0, -1.0}, {{0.1, 0.1, 0.95}, 1.0, -1.0}, {{-0.3, 0.4, 0.8}, 1.0, -1.0}};
    settings.radius = 0.25f;
    settings.spacing = 0.5f;
    for (uint32_t action : {uint32_t(RLV_BRUSH_SCULPT), uint32_t(RLV_BRUSH_PAINT)}) {
        options.action = action;
        options.height = 0.12f;
        options.color[1] = 0.1f;
        CHECK_OK(rlv_brush_create(context, &options, &settings, &brush));
        CHECK_OK(rlv_stroke_run(detail, brush, points, 3, 0, nullptr));
        CHECK_OK(rlv_brush_release(brush));
    }
    CHECK_OK(rlv_detail_commit(detail, nullptr));
}

/// A detail of a triangle mesh: the triangles that it is tessellated as, in less memory, closed and moving.
void check_triangle_mesh(RlvContext context, RTCDevice device, const std::vector<Ray> &rays) {
    RlvSurface ball = RLV_NULL, surface = RLV_NULL;
    RlvMesh round = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvProcedural procedural = RLV_NULL, moving = RLV_NULL;
    RlvTessellateOptions rough = RLV_TESSELLATE_OPTIONS_INIT;
    RlvSurfaceOptions kind = RLV_SURFACE_OPTIONS_INIT;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvProceduralInfo info = RLV_PROCEDURAL_INFO_INIT;
    const RlvMesh cage = cube(context, 0.0f);
    CHECK_OK(rlv_surface_create(context, cage, nullptr, &ball));
    rough.coarse = rough.fine = 4;
    CHECK_OK(rlv_tessellate_surface(ball, &rough, &round));
    kind.kind = RLV_SURFACE_TRIANGLES;
    CHECK_OK(rlv_surface_create(context, round, &kind, &surface));
    options.tile_size = 32;
    CHECK_OK(rlv_detail_create(surface, &options, nullptr, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, nullptr));
    edit(context, detail);
    CHECK_OK(rlv_procedural_create(detail, nullptr, &procedural));
    CHECK_OK(rlv_procedural_info(procedural, &info));
    Geometry geometry, motion;
    size_t triangle_count = 0;
    const int64_t before = device_bytes;
    RTCScene triangles = triangles_of(device, detail, 0, 16, &triangle_count);
    const int64_t between = device_bytes;
    RTCScene scene = scene_of(device, geometry, procedural);
    const int64_t ours = device_bytes - between + int64_t(info.bytes), theirs = between - before;
    if (ours * 6 > theirs) {
        fprintf(stderr, "%lld bytes where %zu triangles take %lld\n", (long long)ours, triangle_count, (long long)theirs);
        exit(1);
    }
    check_hits(scene, triangles, rays, 2e-3f);
    check_all_packets(scene, std::vector<Ray>(rays.begin(), rays.begin() + 2000), 0.0f);
    check_attributes(scene, procedural, detail, rays);
    check_filters(device, scene, procedural, std::vector<Ray>(rays.begin(), rays.begin() + 500));
    Random random;
    for (int k = 0; k < 20000; ++k) {
        const Ray ray = {{0.1f * random.next(), 0.1f * random.next(), 0.1f * random.next()},
                         {random.next() - 0.5f, random.next() - 0.5f, random.next() - 0.5f}};
        CHECK(is_hit(cast(scene, ray)));
    }
    // Half of a square is no triangle.
    const uint32_t first = 0;
    const float outside[2] = {0.75f, 0.5f};
    RlvProceduralHits hits = RLV_PROCEDURAL_HITS_INIT;
    hits.count = 1;
    hits.primitives = &first;
    hits.uvs = outside;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_procedural_evaluate(procedural, &hits), "outside");

    RlvMeshInfo mesh = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(round, &mesh));
    std::vector<float> points(3 * mesh.point_count);
    CHECK_OK(rlv_mesh_get_points(round, points.data(), mesh.point_count, 0));
    for (size_t k = 0; k < points.size(); k += 3) {
        points[k] += 1.0f;
    }
    CHECK_OK(rlv_detail_set_points(detail, points.data(), mesh.point_count, 0));
    CHECK_OK(rlv_detail_commit(detail, nullptr));
    CHECK_OK(rlv_procedural_create_moving(procedural, detail, &moving));
    RTCScene blurred = scene_of(device, motion, moving);
    size_t grazing = 0;
    for (size_t k = 0; k < 2000; ++k) {
        Ray shifted = rays[k];
        shifted.origin[0] += 0.375f;
        const RTCRayHit still = cast(scene, rays[k]), now = cast(blurred, shifted, 0.375f);
        grazing += is_hit(still) != is_hit(now) || (is_hit(still) && std::fabs(still.ray.tfar - now.ray.tfar) > 1e-3f);
    }
    CHECK(grazing < 20);
    for (RTCScene made : {blurred, scene, triangles}) {
        rtcReleaseScene(made);
    }
    CHECK_OK(rlv_procedural_release(moving));
    CHECK_OK(rlv_procedural_release(procedural));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_surface_release(ball));
    CHECK_OK(rlv_mesh_release(round));
    CHECK_OK(rlv_mesh_release(cage));
}

} // namespace

int main() {
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvProcedural procedural = RLV_NULL, uniform = RLV_NULL, moving = RLV_NULL;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvProceduralOptions cells = RLV_PROCEDURAL_OPTIONS_INIT;
    RlvProceduralInfo info = RLV_PROCEDURAL_INFO_INIT;
    CHECK_OK(rlv_context_create(nullptr, &context));
    const RlvMesh cage = cube(context, 0.0f);
    CHECK_OK(rlv_surface_create(context, cage, nullptr, &surface));
    options.tile_size = 128;
    CHECK_OK(rlv_detail_create(surface, &options, nullptr, &detail));
    CHECK_OK(rlv_detail_add_paint(detail, nullptr));
    edit(context, detail);
    RTCDevice device = rtcNewDevice(nullptr);
    rtcSetDeviceMemoryMonitorFunction(device, count_bytes, nullptr);
    const std::vector<Ray> rays = rays_around(12000);

    // With the same number of cells everywhere: the same surface as Embree's triangles, under a tenth of its memory.
    Geometry geometry, motion;
    cells.coarse = cells.fine = 128;
    CHECK_OK(rlv_procedural_create(detail, &cells, &uniform));
    CHECK_OK(rlv_procedural_info(uniform, &info));
    CHECK(info.cell_count == 6 * 128 * 128 && info.time_step_count == 1 && info.step > 0.0f && info.step < 2e-5f);
    size_t triangle_count = 0;
    const int64_t before = device_bytes;
    RTCScene triangles = triangles_of(device, detail, 128, 16, &triangle_count);
    const int64_t between = device_bytes;
    RTCScene scene = scene_of(device, geometry, uniform);
    const int64_t ours = device_bytes - between + int64_t(info.bytes), theirs = between - before;
    CHECK(triangle_count == 2 * info.cell_count);
    if (ours * 10 > theirs) {
        fprintf(stderr, "%lld bytes where triangles take %lld\n", (long long)ours, (long long)theirs);
        return 1;
    }
    check_hits(scene, triangles, rays, 2e-3f);
    check_all_packets(scene, rays, 0.0f);
    check_attributes(scene, uniform, detail, rays);
    check_filters(device, scene, uniform, std::vector<Ray>(rays.begin(), rays.begin() + 2000));
    check_garbage(context, uniform, detail);
    rtcReleaseScene(scene);

    // As fine as there is detail: coarser sides beside finer ones let no ray through, from inside either.
    cells.coarse = 16;
    cells.fine = 0;
    CHECK_OK(rlv_procedural_create(detail, &cells, &procedural));
    scene = scene_of(device, geometry, procedural);
    check_hits(scene, triangles, rays, 6e-3f);
    Random random;
    for (int k = 0; k < 40000; ++k) {
        const Ray ray = {{0.1f * random.next(), 0.1f * random.next(), 0.1f * random.next()},
                         {random.next() - 0.5f, random.next() - 0.5f, random.next() - 0.5f}};
        CHECK(is_hit(cast(scene, ray)));
    }

    // From many threads at once.
    std::vector<std::thread> threads;
    for (int k = 0; k < 4; ++k) {
        threads.emplace_back([&] { check_packets<8>(scene, std::vector<Ray>(rays.begin(), rays.begin() + 800), 0.0f); });
    }
    for (std::thread &thread : threads) {
        thread.join();
    }

    check_triangle_mesh(context, device, rays);

    // Moves by one to the right, and loses nothing: at both ends what stands there, between them on the way.
    float points[8][3];
    const RlvMesh moved = cube(context, 1.0f);
    CHECK_OK(rlv_mesh_get_points(moved, points[0], 8, 0));
    CHECK_OK(rlv_detail_set_points(detail, points[0], 8, 0));
    CHECK_OK(rlv_detail_commit(detail, nullptr));
    CHECK_OK(rlv_procedural_create_moving(procedural, detail, &moving));
    CHECK_OK(rlv_procedural_info(moving, &info));
    CHECK(info.time_step_count == 2 && info.high[0] - info.low[0] > info.high[1] - info.low[1] + 0.9f);
    RTCScene blurred = scene_of(device, motion, moving);
    size_t hits = 0, grazing = 0;
    for (size_t k = 0; k < 4000; ++k) {
        for (float time : {0.0f, 0.375f, 1.0f}) {
            Ray shifted = rays[k];
            shifted.origin[0] += time;
            const RTCRayHit still = cast(scene, rays[k]), now = cast(blurred, shifted, time);
            if (is_hit(still) != is_hit(now)) {
                ++grazing;
            } else if (is_hit(still)) {
                ++hits;
                grazing += std::fabs(still.ray.tfar - now.ray.tfar) > 1e-3f;
            }
        }
    }
    CHECK(hits > 2000 && grazing < 40);
    check_all_packets(blurred, std::vector<Ray>(rays.begin(), rays.begin() + 2000), 0.625f);

    // The shape of the interval is blended, attributes too.
    const uint32_t first = 0;
    const float uv[2] = {0.25f, 0.75f}, time = 0.5f;
    float ends[3][3];
    RlvProceduralHits at = RLV_PROCEDURAL_HITS_INIT;
    at.count = 1;
    at.primitives = &first;
    at.uvs = uv;
    for (int k = 0; k < 3; ++k) {
        const float moment = k == 0 ? 0.0f : k == 1 ? 1.0f : time;
        at.times = &moment;
        at.positions = ends[k];
        CHECK_OK(rlv_procedural_evaluate(moving, &at));
    }
    CHECK_NEAR(ends[1][0] - ends[0][0], 1.0, 1e-5);
    CHECK_NEAR(ends[2][0], 0.5 * (ends[0][0] + ends[1][0]), 1e-5);

    // The objects it was made of may go before it.
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(cage));
    CHECK_OK(rlv_mesh_release(moved));
    CHECK(is_hit(cast(scene, {{3, 0, 0}, {-1, 0, 0}})));
    rtcReleaseScene(blurred);
    rtcReleaseScene(scene);
    rtcReleaseScene(triangles);
    rtcReleaseDevice(device);
    CHECK_OK(rlv_procedural_release(procedural));
    CHECK_OK(rlv_procedural_release(uniform));
    CHECK_OK(rlv_procedural_release(moving));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
