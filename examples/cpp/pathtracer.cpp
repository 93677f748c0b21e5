// A small path tracer with an Embree scene of its own. It loads Relievo at run time, and details are user geometry of
// the scene: snow that a ball has rolled through, and the ball, carved and still rolling.
//
//   c++ -std=c++17 -O2 pathtracer.cpp $(pkg-config --cflags relievo) -lembree3 -ldl -lpthread -o pathtracer
//   ./pathtracer picture.ppm [librelievo.so.0.1 [width [samples]]]
#include <relievo/relievo.h>

#include <dlfcn.h>
#include <embree3/rtcore.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

// Relievo, loaded at run time ------------------------------------------------------------------------------------------

/// The functions that are used; the headers say their types, nothing is linked.
struct Relievo {
    void *library;

    explicit Relievo(const char *path) : library(dlopen(path, RTLD_NOW | RTLD_LOCAL)) {
        if (!library) {
            throw std::runtime_error(dlerror());
        }
        if (get<decltype(&rlv_version)>("rlv_version")() >> 12 != RLV_VERSION >> 12) {
            throw std::runtime_error(std::string(path) + " is another version");
        }
    }

    template <class Function> Function get(const char *name) const {
        void *const function = dlsym(library, name);
        if (!function) {
            throw std::runtime_error(std::string("there is no ") + name);
        }
        return reinterpret_cast<Function>(function);
    }

    void check(RlvResult result) const {
        if (result != RLV_OK) {
            throw std::runtime_error(get<decltype(&rlv_error_last)>("rlv_error_last")());
        }
    }
};

/// Calls a function of the library and throws what it says if it fails.
#define CALL(relievo, function, ...) (relievo).check((relievo).get<decltype(&function)>(#function)(__VA_ARGS__))

// Vectors --------------------------------------------------------------------------------------------------------------

struct Vec {
    float x, y, z;
};
static Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static Vec operator*(Vec a, float s) { return {a.x * s, a.y * s, a.z * s}; }
static Vec operator*(Vec a, Vec b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
static float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static Vec cross(Vec a, Vec b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
static Vec normalized(Vec a) { return a * (1.0f / std::sqrt(std::max(dot(a, a), 1e-30f))); }

// Details as user geometry ---------------------------------------------------------------------------------------------

/// A procedural in the scene: all that a renderer needs of Relievo while it renders.
struct Surface {
    RlvProcedural procedural = RLV_NULL;
    RlvProceduralTable table = RLV_PROCEDURAL_TABLE_INIT;
};

static void bounds(const RTCBoundsFunctionArguments *args) {
    const RlvProceduralTable &table = static_cast<Surface *>(args->geometryUserPtr)->table;
    table.bounds(table.data, args->primID, args->timeStep, reinterpret_cast<float *>(args->bounds_o));
}

static void intersect(const RTCIntersectFunctionNArguments *args) {
    const RlvProceduralTable &table = static_cast<Surface *>(args->geometryUserPtr)->table;
    table.intersect(table.data, args->valid, args->primID, args->geomID, args->context->instID[0], args->rayhit, args->N);
}

static void occluded(const RTCOccludedFunctionNArguments *args) {
    const RlvProceduralTable &table = static_cast<Surface *>(args->geometryUserPtr)->table;
    table.occluded(table.data, args->valid, args->primID, args->ray, args->N);
}

static void attach(RTCDevice device, RTCScene scene, const Relievo &relievo, Surface &surface) {
    CALL(relievo, rlv_procedural_table, surface.procedural, &surface.table);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, surface.table.primitive_count);
    rtcSetGeometryTimeStepCount(geometry, surface.table.time_step_count);
    rtcSetGeometryUserData(geometry, &surface);
    rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcSetGeometryOccludedFunction(geometry, occluded);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
}

// The scene ------------------------------------------------------------------------------------------------------------

static RlvMesh mesh_of(const Relievo &relievo, RlvContext context, const std::vector<Vec> &points,
                       const std::vector<uint32_t> &corners) {
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    RlvMesh mesh = RLV_NULL;
    arrays.points = &points[0].x;
    arrays.point_count = points.size();
    arrays.face_size = 4;
    arrays.face_count = corners.size() / 4;
    arrays.corners = corners.data();
    arrays.corner_count = corners.size();
    CALL(relievo, rlv_mesh_create, context, &arrays, &mesh);
    return mesh;
}

/// 12 x 8 quads in the plane z = 0.
static RlvMesh make_field(const Relievo &relievo, RlvContext context) {
    std::vector<Vec> points;
    std::vector<uint32_t> corners;
    for (uint32_t y = 0; y <= 8; ++y) {
        for (uint32_t x = 0; x <= 12; ++x) {
            points.push_back({float(x) - 6.0f, float(y) - 4.0f, 0.12f * std::sin(1.3f * float(x)) * std::cos(float(y))});
        }
    }
    for (uint32_t y = 0; y < 8; ++y) {
        for (uint32_t x = 0; x < 12; ++x) {
            const uint32_t first = 13 * y + x;
            corners.insert(corners.end(), {first, first + 1, first + 14, first + 13});
        }
    }
    return mesh_of(relievo, context, points, corners);
}

/// The points of a cube whose limit surface is a ball.
static std::vector<Vec> ball_points(Vec middle, float turn) {
    std::vector<Vec> points;
    for (int k = 0; k < 8; ++k) {
        const float x = k & 1 ? 1.0f : -1.0f, y = k & 2 ? 1.0f : -1.0f, z = k & 4 ? 1.0f : -1.0f;
        const float c = std::cos(turn), s = std::sin(turn);
        points.push_back(middle + Vec{c * x + s * z, y, c * z - s * x});
    }
    return points;
}

static const std::vector<uint32_t> BALL_CORNERS = {0, 2, 3, 1, 4, 5, 7, 6, 0, 1, 5, 4, 1, 3, 7, 5, 3, 2, 6, 7, 2, 0, 4, 6};

static RlvDetail detail_of(const Relievo &relievo, RlvContext context, RlvMesh cage, std::array<float, 4> color) {
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvPaintOptions paint = RLV_PAINT_OPTIONS_INIT;
    std::copy(color.begin(), color.end(), paint.color);
    CALL(relievo, rlv_surface_create, context, cage, nullptr, &surface);
    CALL(relievo, rlv_detail_create, surface, nullptr, nullptr, &detail);
    CALL(relievo, rlv_detail_add_paint, detail, &paint);
    CALL(relievo, rlv_surface_release, surface);
    return detail;
}

/// A spiral around the ball, carved and painted.
static void carve(const Relievo &relievo, RlvContext context, RlvDetail ball) {
    std::vector<RlvStrokePoint> points;
    for (int k = 0; k <= 400; ++k) {
        const double t = k / 400.0, angle = 40.0 * t, height = 1.6 * t - 0.8, radius = std::sqrt(1.0 - height * height);
        points.push_back({{0.85 * radius * std::cos(angle), 0.85 * radius * std::sin(angle), 0.85 * height}, 1.0, -1.0});
    }
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    settings.radius = 0.07f;
    settings.reach = 4.0f;
    for (const uint32_t action : {RLV_BRUSH_SCULPT, RLV_BRUSH_PAINT}) {
        RlvBrushOptions options = RLV_BRUSH_OPTIONS_INIT;
        RlvBrush brush = RLV_NULL;
        options.action = action;
        options.height = -0.02f;
        const float color[4] = {0.75f, 0.12f, 0.05f, 1.0f};
        std::copy(color, color + 4, options.color);
        CALL(relievo, rlv_brush_create, context, &options, &settings, &brush);
        CALL(relievo, rlv_stroke_run, ball, brush, points.data(), points.size(), 0, nullptr);
        CALL(relievo, rlv_brush_release, brush);
    }
    CALL(relievo, rlv_detail_commit, ball, nullptr);
}

struct World {
    RTCScene scene;
    std::vector<Surface> surfaces;
};

static World make_world(const Relievo &relievo, RlvContext context, RTCDevice device) {
    World world{rtcNewScene(device), std::vector<Surface>(2)};
    const float radius = 0.85f, depth = 0.3f, from = -4.0f, to = 1.5f, blur = 0.1f;
    const Vec start{from, 0.3f, radius - depth}, stop{to, 0.3f, radius - depth};

    // The ball, carved where it stands in the middle, then rolled to where it is.
    const std::vector<Vec> still = ball_points({0, 0, 0}, 0.0f);
    const RlvMesh cube = mesh_of(relievo, context, still, BALL_CORNERS);
    const RlvDetail ball = detail_of(relievo, context, cube, {0.75f, 0.7f, 0.6f, 1.0f});
    carve(relievo, context, ball);

    // The snow: the ball goes through it, pushes it aside and leaves its track darker.
    const RlvMesh field = make_field(relievo, context);
    const RlvDetail snow = detail_of(relievo, context, field, {0.86f, 0.88f, 0.92f, 1.0f});
    RlvCollider collider = RLV_NULL;
    RlvImprintSettings settings = RLV_IMPRINT_SETTINGS_INIT;
    settings.rim = 0.6f;
    settings.rim_width = 0.4f;
    const double before[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, start.x, start.y, start.z};
    const double now[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, stop.x, stop.y, stop.z};
    CALL(relievo, rlv_collider_create_detail, ball, nullptr, &collider);
    CALL(relievo, rlv_imprint_sweep, snow, collider, before, now, &settings, nullptr, nullptr, nullptr, nullptr);
    CALL(relievo, rlv_detail_commit, snow, nullptr);
    CALL(relievo, rlv_procedural_create, snow, nullptr, &world.surfaces[0].procedural);

    // The shutter is open while it rolls on a little.
    RlvProcedural begin = RLV_NULL;
    for (const float t : {0.0f, 1.0f}) {
        const Vec middle = stop + Vec{blur * t, 0, 0};
        const std::vector<Vec> points = ball_points(middle, 0.9f + blur * t / radius);
        CALL(relievo, rlv_detail_set_points, ball, &points[0].x, points.size(), 0);
        CALL(relievo, rlv_detail_commit, ball, nullptr);
        if (t == 0.0f) {
            CALL(relievo, rlv_procedural_create, ball, nullptr, &begin);
        } else {
            CALL(relievo, rlv_procedural_create_moving, begin, ball, &world.surfaces[1].procedural);
        }
    }
    for (Surface &surface : world.surfaces) {
        attach(device, world.scene, relievo, surface);
    }
    rtcCommitScene(world.scene);
    // Procedurals keep what they need.
    CALL(relievo, rlv_procedural_release, begin);
    CALL(relievo, rlv_collider_release, collider);
    CALL(relievo, rlv_detail_release, ball);
    CALL(relievo, rlv_detail_release, snow);
    CALL(relievo, rlv_mesh_release, cube);
    CALL(relievo, rlv_mesh_release, field);
    return world;
}

// Light transport ------------------------------------------------------------------------------------------------------

/// A path that is under way.
struct Path {
    size_t pixel;
    Vec origin, direction, weight;
    float time;
    RTCRayHit hit;
    Vec normal, albedo;
};

static const Vec SUN = normalized({0.45f, -0.7f, 0.5f});

static Vec sky(Vec direction) {
    const float up = std::max(direction.z, 0.0f);
    return Vec{0.5f, 0.65f, 0.9f} * (0.25f + 0.35f * up);
}

static RTCRay ray_of(Vec origin, Vec direction, float time) {
    RTCRay ray = {};
    ray.org_x = origin.x;
    ray.org_y = origin.y;
    ray.org_z = origin.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tfar = std::numeric_limits<float>::infinity();
    ray.mask = 0xffffffffu;
    ray.time = time;
    return ray;
}

/// Traces all paths one step, and asks for normals and colours of all hits on a surface at once.
static void trace(const World &world, const Relievo &relievo, std::vector<Path> &paths) {
    for (Path &path : paths) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        path.hit = {};
        path.hit.ray = ray_of(path.origin, path.direction, path.time);
        path.hit.hit.geomID = path.hit.hit.primID = path.hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect1(world.scene, &context, &path.hit);
    }
    for (uint32_t geometry = 0; geometry < world.surfaces.size(); ++geometry) {
        std::vector<size_t> on;
        std::vector<uint32_t> primitives;
        std::vector<float> uvs, times;
        for (size_t k = 0; k < paths.size(); ++k) {
            const RTCHit &hit = paths[k].hit.hit;
            if (hit.geomID == geometry) {
                on.push_back(k);
                primitives.push_back(hit.primID);
                uvs.insert(uvs.end(), {hit.u, hit.v});
                times.push_back(paths[k].time);
            }
        }
        std::vector<Vec> normals(on.size());
        std::vector<std::array<float, 4>> colors(on.size());
        if (on.empty()) {
            continue;
        }
        RlvProceduralHits hits = RLV_PROCEDURAL_HITS_INIT;
        hits.count = on.size();
        hits.primitives = primitives.data();
        hits.uvs = uvs.data();
        hits.times = times.data();
        hits.normals = &normals[0].x;
        hits.colors = colors[0].data();
        CALL(relievo, rlv_procedural_evaluate, world.surfaces[geometry].procedural, &hits);
        for (size_t k = 0; k < on.size(); ++k) {
            paths[on[k]].normal = normals[k];
            paths[on[k]].albedo = {colors[k][0], colors[k][1], colors[k][2]};
        }
    }
}

/// A direction around `normal`, more often where it is nearer to it: of diffuse light.
static Vec scattered(Vec normal, float a, float b) {
    const Vec side = normalized(std::fabs(normal.x) > 0.5f ? cross(normal, {0, 1, 0}) : cross(normal, {1, 0, 0}));
    const float r = std::sqrt(a), angle = 6.2831853f * b;
    return normalized(side * (r * std::cos(angle)) + cross(normal, side) * (r * std::sin(angle)) +
                      normal * std::sqrt(std::max(1.0f - a, 0.0f)));
}

/// The light of one row of pixels.
static void render_row(const World &world, const Relievo &relievo, int width, int height, int row, int samples,
                       std::vector<Vec> &picture) {
    std::mt19937 random(uint32_t(row) * 9781u + 1u);
    const auto unit = [&random] { return float(random() >> 8) / 16777216.0f; };
    const Vec eye{2.2f, -4.6f, 2.6f}, ahead = normalized(Vec{0.6f, 0.3f, 0.15f} - eye);
    const Vec right = normalized(cross(ahead, {0, 0, 1})), up = cross(right, ahead);
    std::vector<Path> paths;
    for (int x = 0; x < width; ++x) {
        for (int sample = 0; sample < samples; ++sample) {
            const float u = (float(x) + unit()) / float(width) - 0.5f;
            const float v = (0.5f * float(height) - float(row) - unit()) / float(width);
            const Vec direction = normalized(ahead + right * (0.9f * u) + up * (0.9f * v));
            paths.push_back({size_t(row * width + x), eye, direction, {1, 1, 1}, unit(), {}, {}, {}});
        }
    }
    for (int bounce = 0; bounce < 4 && !paths.empty(); ++bounce) {
        trace(world, relievo, paths);
        std::vector<Path> next;
        for (const Path &path : paths) {
            Vec &pixel = picture[path.pixel];
            if (path.hit.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
                pixel = pixel + path.weight * sky(path.direction);
                continue;
            }
            Path onward = path;
            const Vec flat = normalized({path.hit.hit.Ng_x, path.hit.hit.Ng_y, path.hit.hit.Ng_z});
            const float front = dot(flat, path.direction) < 0.0f ? 1.0f : -1.0f;
            onward.origin = path.origin + path.direction * path.hit.ray.tfar + flat * (front * 1e-3f);
            onward.weight = path.weight * path.albedo;
            const Vec normal = path.normal * front;
            const float facing = dot(normal, SUN);
            if (facing > 0.0f) {
                RTCIntersectContext context;
                rtcInitIntersectContext(&context);
                RTCRay shadow = ray_of(onward.origin, SUN, path.time);
                rtcOccluded1(world.scene, &context, &shadow);
                if (shadow.tfar > 0.0f) {
                    pixel = pixel + onward.weight * Vec{0.75f, 0.68f, 0.58f} * facing;
                }
            }
            onward.direction = scattered(normal, unit(), unit());
            next.push_back(onward);
        }
        paths = std::move(next);
    }
}

static void write_picture(const std::string &path, const std::vector<Vec> &picture, int width, int height, int samples) {
    std::FILE *file = std::fopen(path.c_str(), "wb");
    if (!file) {
        throw std::runtime_error("cannot write " + path);
    }
    std::fprintf(file, "P6\n%d %d\n255\n", width, height);
    for (const Vec &pixel : picture) {
        for (const float value : {pixel.x, pixel.y, pixel.z}) {
            const float light = std::min(value / float(samples), 1.0f);
            std::fputc(int(255.0f * std::pow(light, 1.0f / 2.2f) + 0.5f), file);
        }
    }
    if (std::fclose(file) != 0) {
        throw std::runtime_error("cannot write " + path);
    }
}

int main(int argc, char **argv) try {
    const std::string path = argc > 1 ? argv[1] : "picture.ppm";
    const Relievo relievo(argc > 2 ? argv[2] : "librelievo.so.0.1");
    const int width = argc > 3 ? std::stoi(argv[3]) : 640, samples = argc > 4 ? std::stoi(argv[4]) : 16;
    const int height = width * 9 / 16;
    RlvContext context = RLV_NULL;
    CALL(relievo, rlv_context_create, nullptr, &context);
    RTCDevice device = rtcNewDevice(nullptr);
    World world = make_world(relievo, context, device);
    for (const Surface &surface : world.surfaces) {
        RlvProceduralInfo info = RLV_PROCEDURAL_INFO_INIT;
        CALL(relievo, rlv_procedural_info, surface.procedural, &info);
        std::printf("%u primitives of %llu cells, %llu bytes\n", info.primitive_count, (unsigned long long)info.cell_count,
                    (unsigned long long)info.bytes);
    }
    std::vector<Vec> picture(size_t(width * height), Vec{0, 0, 0});
    std::vector<std::thread> threads;
    std::atomic<int> row{0};
    for (unsigned k = 0; k < std::max(std::thread::hardware_concurrency(), 1u); ++k) {
        threads.emplace_back([&] {
            for (int mine = row++; mine < height; mine = row++) {
                render_row(world, relievo, width, height, mine, samples, picture);
            }
        });
    }
    for (std::thread &thread : threads) {
        thread.join();
    }
    write_picture(path, picture, width, height, samples);
    rtcReleaseScene(world.scene);
    rtcReleaseDevice(device);
    for (const Surface &surface : world.surfaces) {
        CALL(relievo, rlv_procedural_release, surface.procedural);
    }
    CALL(relievo, rlv_context_release, context);
    return 0;
} catch (const std::exception &error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
}
