// What the programs of this folder share: a detail as user geometry of an Embree scene, and as Embree's triangles.
#pragma once

#include "../../c/check.h"

#if RELIEVO_HOST_EMBREE == 4
#include "embree4.h"
#else
#include <embree3/rtcore.h>
#endif

#include <atomic>
#include <cmath>
#include <limits>

// The whole of what a renderer writes, and then what one writes that has filter functions.

struct Geometry {
    RlvProceduralTable table = RLV_PROCEDURAL_TABLE_INIT;
};

inline void bounds(const RTCBoundsFunctionArguments *args) {
    const RlvProceduralTable &table = static_cast<Geometry *>(args->geometryUserPtr)->table;
    table.bounds(table.data, args->primID, args->timeStep, reinterpret_cast<float *>(args->bounds_o));
}

inline void intersect(const RTCIntersectFunctionNArguments *args) {
    const RlvProceduralTable &table = static_cast<Geometry *>(args->geometryUserPtr)->table;
    table.intersect(table.data, args->valid, args->primID, args->geomID, args->context->instID[0], args->rayhit, args->N);
}

inline void occluded(const RTCOccludedFunctionNArguments *args) {
    const RlvProceduralTable &table = static_cast<Geometry *>(args->geometryUserPtr)->table;
    table.occluded(table.data, args->valid, args->primID, args->ray, args->N);
}

#if RELIEVO_HOST_EMBREE == 4
/// Embree 4 knows in callbacks of the geometry's filter alone: that of the call comes with its context.
struct Query : RTCRayQueryContext {
    RTCFilterFunctionN filter;
};
inline void ask_own_filter(const RTCFilterFunctionNArguments *filter) {
    const RTCFilterFunctionN own = static_cast<const Query *>(filter->context)->filter;
    if (own && filter->valid[0]) {
        own(filter);
    }
}
inline void ask_filter(const RTCIntersectFunctionNArguments *args, const RTCFilterFunctionNArguments *filter) {
    rtcInvokeIntersectFilterFromGeometry(args, filter);
    ask_own_filter(filter);
}
inline void ask_filter(const RTCOccludedFunctionNArguments *args, const RTCFilterFunctionNArguments *filter) {
    rtcInvokeOccludedFilterFromGeometry(args, filter);
    ask_own_filter(filter);
}
#else
inline void ask_filter(const RTCIntersectFunctionNArguments *args, const RTCFilterFunctionNArguments *filter) {
    rtcFilterIntersection(args, filter);
}
inline void ask_filter(const RTCOccludedFunctionNArguments *args, const RTCFilterFunctionNArguments *filter) {
    rtcFilterOcclusion(args, filter);
}
#endif

/// Kinds of numbers of a ray, and of a hit that Relievo writes.
constexpr unsigned RAY = 12, HIT = 8;

/// The nearest hit of ray `k` of a packet that the host's filter functions accept; false if there is none. `rays` has
/// `kinds` numbers of each ray.
template <class Arguments>
bool meet_filtered(const Arguments *args, const float *rays, unsigned kinds, unsigned k, RTCRayHit &one) {
    const RlvProceduralTable &table = static_cast<Geometry *>(args->geometryUserPtr)->table;
    float *const ray = &one.ray.org_x, *const hit = &one.hit.Ng_x;
    for (unsigned kind = 0; kind < kinds; ++kind) {
        (kind < RAY ? ray[kind] : hit[kind - RAY]) = rays[kind * args->N + k];
    }
    const float far = one.ray.tfar;
    for (;;) {
        int valid = -1;
        one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        table.intersect(table.data, &valid, args->primID, args->geomID, args->context->instID[0], &one, 1);
        if (one.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
            return false;
        }
        const RTCFilterFunctionNArguments filter = {&valid, args->geometryUserPtr, args->context,
                                                    reinterpret_cast<RTCRayN *>(&one.ray),
                                                    reinterpret_cast<RTCHitN *>(&one.hit), 1};
        ask_filter(args, &filter);
        if (valid) {
            return true;
        }
        // On, behind what was refused.
        one.ray.tnear = std::nextafter(one.ray.tfar, std::numeric_limits<float>::infinity());
        one.ray.tfar = far;
    }
}

inline void intersect_filtered(const RTCIntersectFunctionNArguments *args) {
    float *const rays = reinterpret_cast<float *>(args->rayhit);
    for (unsigned k = 0; k < args->N; ++k) {
        RTCRayHit one = {};
        if (args->valid[k] && meet_filtered(args, rays, RAY + HIT, k, one)) {
            rays[8 * args->N + k] = one.ray.tfar;
            const float *const hit = &one.hit.Ng_x;
            for (unsigned kind = 0; kind < HIT; ++kind) {
                rays[(RAY + kind) * args->N + k] = hit[kind];
            }
        }
    }
}

inline void occluded_filtered(const RTCOccludedFunctionNArguments *args) {
    float *const rays = reinterpret_cast<float *>(args->ray);
    for (unsigned k = 0; k < args->N; ++k) {
        RTCRayHit one = {};
        if (args->valid[k] && meet_filtered(args, rays, RAY, k, one)) {
            rays[8 * args->N + k] = -std::numeric_limits<float>::infinity();
        }
    }
}

// Rays, in either version; `filter` is called besides those of geometries.
#if RELIEVO_HOST_EMBREE == 4
inline Query query(RTCFilterFunctionN filter) {
    return {{{RTC_INVALID_GEOMETRY_ID}, {RTC_INVALID_GEOMETRY_ID}}, filter};
}
inline RTCQueryArguments arguments_of(Query &query) {
    RTCQueryArguments arguments = {};
    arguments.feature_mask = RTC_FEATURE_FLAG_ALL;
    arguments.context = &query;
    return arguments;
}
inline void trace(RTCScene scene, RTCRayHit &ray, RTCFilterFunctionN filter = nullptr) {
    Query context = query(filter);
    RTCQueryArguments arguments = arguments_of(context);
    rtcIntersect1(scene, &ray, &arguments);
}
inline void shadow(RTCScene scene, RTCRay &ray, RTCFilterFunctionN filter = nullptr) {
    Query context = query(filter);
    RTCQueryArguments arguments = arguments_of(context);
    rtcOccluded1(scene, &ray, &arguments);
}
/// Packets: all numbers of a kind together.
template <int N> void trace_packet(const int *valid, RTCScene scene, float *rays) {
    Query context = query(nullptr);
    RTCQueryArguments arguments = arguments_of(context);
    (N == 4 ? rtcIntersect4 : N == 8 ? rtcIntersect8 : rtcIntersect16)(valid, scene, rays, &arguments);
}
template <int N> void shadow_packet(const int *valid, RTCScene scene, float *rays) {
    Query context = query(nullptr);
    RTCQueryArguments arguments = arguments_of(context);
    (N == 4 ? rtcOccluded4 : N == 8 ? rtcOccluded8 : rtcOccluded16)(valid, scene, rays, &arguments);
}
#else
inline RTCIntersectContext query(RTCFilterFunctionN filter) {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.filter = filter;
    return context;
}
inline void trace(RTCScene scene, RTCRayHit &ray, RTCFilterFunctionN filter = nullptr) {
    RTCIntersectContext context = query(filter);
    rtcIntersect1(scene, &context, &ray);
}
inline void shadow(RTCScene scene, RTCRay &ray, RTCFilterFunctionN filter = nullptr) {
    RTCIntersectContext context = query(filter);
    rtcOccluded1(scene, &context, &ray);
}
/// Packets: all numbers of a kind together.
template <int N> void trace_packet(const int *valid, RTCScene scene, float *rays) {
    RTCIntersectContext context = query(nullptr);
    if constexpr (N == 4) {
        rtcIntersect4(valid, scene, &context, reinterpret_cast<RTCRayHit4 *>(rays));
    } else if constexpr (N == 8) {
        rtcIntersect8(valid, scene, &context, reinterpret_cast<RTCRayHit8 *>(rays));
    } else {
        rtcIntersect16(valid, scene, &context, reinterpret_cast<RTCRayHit16 *>(rays));
    }
}
template <int N> void shadow_packet(const int *valid, RTCScene scene, float *rays) {
    RTCIntersectContext context = query(nullptr);
    if constexpr (N == 4) {
        rtcOccluded4(valid, scene, &context, reinterpret_cast<RTCRay4 *>(rays));
    } else if constexpr (N == 8) {
        rtcOccluded8(valid, scene, &context, reinterpret_cast<RTCRay8 *>(rays));
    } else {
        rtcOccluded16(valid, scene, &context, reinterpret_cast<RTCRay16 *>(rays));
    }
}
#endif

/// Bytes that the device's memory monitor counted.
inline std::atomic<int64_t> device_bytes{0};

inline bool count_bytes(void *, ssize_t bytes, bool) {
    device_bytes += bytes;
    return true;
}

inline RTCScene scene_of(RTCDevice device, RTCGeometry geometry) {
    RTCScene scene = rtcNewScene(device);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    CHECK(rtcGetDeviceError(device) == RTC_ERROR_NONE);
    return scene;
}

/// `filter`, if it is not null, is asked about every hit.
inline RTCScene scene_of(RTCDevice device, Geometry &made, RlvProcedural procedural, RTCFilterFunctionN filter = nullptr,
                         bool is_filtered = false) {
    CHECK_OK(rlv_procedural_table(procedural, &made.table));
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, made.table.primitive_count);
    rtcSetGeometryTimeStepCount(geometry, made.table.time_step_count);
    rtcSetGeometryUserData(geometry, &made);
    rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry, is_filtered ? intersect_filtered : intersect);
    rtcSetGeometryOccludedFunction(geometry, is_filtered ? occluded_filtered : occluded);
    rtcSetGeometryIntersectFilterFunction(geometry, filter);
    rtcSetGeometryOccludedFilterFunction(geometry, filter);
    return scene_of(device, geometry);
}

/// Embree's triangles of the detail, whose points are `stride` bytes apart, and how many.
inline RTCScene triangles_of(RTCDevice device, RlvDetail detail, uint32_t cells, size_t stride, size_t *count) {
    RlvTessellateOptions options = RLV_TESSELLATE_OPTIONS_INIT;
    RlvMeshInfo info = RLV_MESH_INFO_INIT;
    RlvMesh mesh = RLV_NULL;
    options.coarse = options.fine = cells;
    CHECK_OK(rlv_tessellate_detail(detail, &options, &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &info));
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto *points = static_cast<float *>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, stride,
                                                                 info.point_count + 1));
    auto *corners = static_cast<uint32_t *>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, info.triangle_count));
    CHECK_OK(rlv_mesh_get_points(mesh, points, info.point_count, stride));
    CHECK_OK(rlv_mesh_get_triangles(mesh, corners, info.triangle_count, 0));
    CHECK_OK(rlv_mesh_release(mesh));
    *count = info.triangle_count;
    return scene_of(device, geometry);
}
