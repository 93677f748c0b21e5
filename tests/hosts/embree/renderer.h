// What the programs of this folder share: a detail as user geometry of an Embree scene, and as Embree's triangles.
#pragma once

#include "../../c/check.h"

#include <embree3/rtcore.h>

#include <atomic>

// The whole of what a renderer writes.

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

inline RTCScene scene_of(RTCDevice device, Geometry &made, RlvProcedural procedural) {
    CHECK_OK(rlv_procedural_table(procedural, &made.table));
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, made.table.primitive_count);
    rtcSetGeometryTimeStepCount(geometry, made.table.time_step_count);
    rtcSetGeometryUserData(geometry, &made);
    rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
    rtcSetGeometryIntersectFunction(geometry, intersect);
    rtcSetGeometryOccludedFunction(geometry, occluded);
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
