#include "renderer.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace studio {

namespace {

const Vec SUN = normalized({0.5f, -0.6f, 0.6f});

RTCRay ray_of(const Vec &origin, const Vec &direction) {
    RTCRay ray{};
    ray.org_x = origin[0];
    ray.org_y = origin[1];
    ray.org_z = origin[2];
    ray.dir_x = direction[0];
    ray.dir_y = direction[1];
    ray.dir_z = direction[2];
    ray.tfar = std::numeric_limits<float>::infinity();
    ray.mask = ~0u;
    return ray;
}

} // namespace

// The callbacks hand over what Embree gives; see relievo/procedural.h.
static void bounds(const RTCBoundsFunctionArguments *args) {
    const auto &table = *static_cast<const RlvProceduralTable *>(args->geometryUserPtr);
    table.bounds(table.data, args->primID, args->timeStep, reinterpret_cast<float *>(args->bounds_o));
}

static void intersect(const RTCIntersectFunctionNArguments *args) {
    const auto &table = *static_cast<const RlvProceduralTable *>(args->geometryUserPtr);
    table.intersect(table.data, args->valid, args->primID, args->geomID, args->context->instID[0], args->rayhit, args->N);
}

static void occluded(const RTCOccludedFunctionNArguments *args) {
    const auto &table = *static_cast<const RlvProceduralTable *>(args->geometryUserPtr);
    table.occluded(table.data, args->valid, args->primID, args->ray, args->N);
}

Renderer::Renderer(Pool &pool, const std::vector<Object> &objects)
    // Embree builds on the thread that asks for it: all other threads are the pool's.
    : pool_(pool), device_(rtcNewDevice("threads=1")), scene_(rtcNewScene(device_)) {
    std::vector<relievo::JobOf<relievo::Procedural>> jobs;
    for (const Object &object : objects) {
        jobs.push_back(relievo::Job::procedural(object.detail));
    }
    for (std::size_t k = 0; k < objects.size(); ++k) {
        auto shown = std::make_unique<Shown>();
        shown->procedural = jobs[k].take();
        shown->table = shown->procedural.table();
        shown->place = objects[k].place;
        shown->scene = rtcNewScene(device_);
        RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_USER);
        rtcSetGeometryUserPrimitiveCount(geometry, shown->table.primitive_count);
        rtcSetGeometryUserData(geometry, &shown->table);
        rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
        rtcSetGeometryIntersectFunction(geometry, intersect);
        rtcSetGeometryOccludedFunction(geometry, occluded);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(shown->scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(shown->scene);
        RTCGeometry instance = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
        std::array<float, 12> place{};
        std::transform(shown->place.begin(), shown->place.end(), place.begin(), [](double v) { return static_cast<float>(v); });
        rtcSetGeometryInstancedScene(instance, shown->scene);
        rtcSetGeometryTransform(instance, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, place.data());
        rtcCommitGeometry(instance);
        rtcAttachGeometryByID(scene_, instance, static_cast<unsigned>(k));
        rtcReleaseGeometry(instance);
        shown_.push_back(std::move(shown));
    }
    rtcCommitScene(scene_);
    if (rtcGetDeviceError(device_) != RTC_ERROR_NONE) {
        throw std::runtime_error("the host's Embree does not take the scene");
    }
}

Renderer::~Renderer() {
    rtcReleaseScene(scene_);
    for (const auto &shown : shown_) {
        rtcReleaseScene(shown->scene);
    }
    rtcReleaseDevice(device_);
}

void Renderer::row(const Camera &camera, unsigned y, bool shadows, Picture &picture) const {
    const auto [ahead, right, up] = camera.axes();
    const auto size = static_cast<float>(picture.width);
    const float v = (0.5f * static_cast<float>(picture.height) - static_cast<float>(y) - 0.5f) / size;
    // Hits of each object are shaded together, since a call for many costs little more than one for a single one.
    std::vector<std::vector<relievo::ProceduralHit>> hits(shown_.size());
    std::vector<std::vector<std::pair<unsigned, Vec>>> pixels(shown_.size());
    for (unsigned x = 0; x < picture.width; ++x) {
        const float u = (static_cast<float>(x) + 0.5f) / size - 0.5f;
        const Vec direction = normalized(ahead + right * (camera.width * u) + up * (camera.width * v));
        RTCRayHit ray{};
        ray.ray = ray_of(camera.eye, direction);
        ray.hit.geomID = ray.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene_, &context, &ray);
        picture.pixels[y * picture.width + x] = Vec{0.45f, 0.6f, 0.85f} * (0.5f + 0.5f * std::max(direction[2], 0.0f));
        if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
            continue;
        }
        const unsigned object = ray.hit.instID[0];
        hits[object].push_back({ray.hit.primID, {ray.hit.u, ray.hit.v}, 0.0f});
        pixels[object].emplace_back(x, camera.eye + direction * ray.ray.tfar);
    }
    for (std::size_t object = 0; object < shown_.size(); ++object) {
        const relievo::ShadedHits shaded = shown_[object]->procedural.evaluate(hits[object], true);
        for (std::size_t k = 0; k < hits[object].size(); ++k) {
            const Vec normal = normalized(turned(shown_[object]->place, shaded.normals[k]));
            const auto [x, point] = pixels[object][k];
            const std::size_t pixel = std::size_t{y} * picture.width + x;
            float sun = std::max(dot(normal, SUN), 0.0f);
            if (shadows && sun > 0.0f) {
                RTCRay shadow = ray_of(point + normal * 2e-3f, SUN);
                RTCIntersectContext context;
                rtcInitIntersectContext(&context);
                rtcOccluded1(scene_, &context, &shadow);
                sun = shadow.tfar < 0.0f ? 0.0f : sun;
            }
            const Vec light = Vec{0.9f, 0.82f, 0.7f} * sun + Vec{0.25f, 0.3f, 0.4f} * (0.6f + 0.4f * normal[2]);
            const auto &color = shaded.colors[k];
            picture.pixels[pixel] = {light[0] * color[0], light[1] * color[1], light[2] * color[2]};
            picture.covered[pixel] = 1;
        }
    }
}

Picture Renderer::render(const Camera &camera, unsigned width, unsigned height, bool shadows) const {
    const std::size_t count = std::size_t{width} * height;
    Picture picture{width, height, std::vector<Vec>(count), std::vector<std::uint8_t>(count, 0)};
    pool_.loop(height, [&](std::size_t y) { row(camera, static_cast<unsigned>(y), shadows, picture); });
    return picture;
}

} // namespace studio
