// What the tests use of the C interface of Embree 4.4, as its documentation describes it: Debian 12 has the headers of
// Embree 3 alone.
#pragma once

#include <cstddef>
#include <sys/types.h>

constexpr unsigned RTC_INVALID_GEOMETRY_ID = 0xffffffffu;

using RTCDevice = struct RTCDeviceTy *;
using RTCScene = struct RTCSceneTy *;
using RTCGeometry = struct RTCGeometryTy *;
struct RTCRayN;
struct RTCRayHitN;
struct RTCHitN;

enum RTCError { RTC_ERROR_NONE = 0 };
enum RTCGeometryType { RTC_GEOMETRY_TYPE_TRIANGLE = 0, RTC_GEOMETRY_TYPE_USER = 120 };
enum RTCBufferType { RTC_BUFFER_TYPE_INDEX = 0, RTC_BUFFER_TYPE_VERTEX = 1 };
enum RTCFormat { RTC_FORMAT_UINT3 = 0x5003, RTC_FORMAT_FLOAT3 = 0x9003 };
constexpr unsigned RTC_FEATURE_FLAG_ALL = 0xffffffffu;

struct alignas(16) RTCRay {
    float org_x, org_y, org_z, tnear;
    float dir_x, dir_y, dir_z, time;
    float tfar;
    unsigned mask, id, flags;
};

struct alignas(16) RTCHit {
    float Ng_x, Ng_y, Ng_z, u, v;
    unsigned primID, geomID, instID[1], instPrimID[1];
};

struct RTCRayHit {
    RTCRay ray;
    RTCHit hit;
};

struct RTCRayQueryContext {
    unsigned instID[1], instPrimID[1];
};

struct RTCFilterFunctionNArguments {
    int *valid;
    void *geometryUserPtr;
    RTCRayQueryContext *context;
    RTCRayN *ray;
    RTCHitN *hit;
    unsigned N;
};
using RTCFilterFunctionN = void (*)(const RTCFilterFunctionNArguments *);

struct RTCBoundsFunctionArguments {
    void *geometryUserPtr;
    unsigned primID, timeStep;
    void *bounds_o;
};

struct RTCIntersectFunctionNArguments {
    int *valid;
    void *geometryUserPtr;
    unsigned primID;
    RTCRayQueryContext *context;
    RTCRayHitN *rayhit;
    unsigned N, geomID;
};

struct RTCOccludedFunctionNArguments {
    int *valid;
    void *geometryUserPtr;
    unsigned primID;
    RTCRayQueryContext *context;
    RTCRayN *ray;
    unsigned N, geomID;
};

/// RTCIntersectArguments and RTCOccludedArguments, which have the same layout; only some builds have the last field.
struct RTCQueryArguments {
    int flags;
    unsigned feature_mask;
    RTCRayQueryContext *context;
    RTCFilterFunctionN filter;
    void (*callback)(const void *);
    float minWidthDistanceFactor;
};

extern "C" {
RTCDevice rtcNewDevice(const char *config);
void rtcReleaseDevice(RTCDevice);
RTCError rtcGetDeviceError(RTCDevice);
void rtcSetDeviceMemoryMonitorFunction(RTCDevice, bool (*monitor)(void *, ssize_t, bool), void *user);
RTCScene rtcNewScene(RTCDevice);
void rtcReleaseScene(RTCScene);
void rtcCommitScene(RTCScene);
RTCGeometry rtcNewGeometry(RTCDevice, RTCGeometryType);
void rtcReleaseGeometry(RTCGeometry);
void rtcCommitGeometry(RTCGeometry);
unsigned rtcAttachGeometry(RTCScene, RTCGeometry);
void rtcSetGeometryUserPrimitiveCount(RTCGeometry, unsigned);
void rtcSetGeometryTimeStepCount(RTCGeometry, unsigned);
void rtcSetGeometryUserData(RTCGeometry, void *);
void rtcSetGeometryBoundsFunction(RTCGeometry, void (*)(const RTCBoundsFunctionArguments *), void *user);
void rtcSetGeometryIntersectFunction(RTCGeometry, void (*)(const RTCIntersectFunctionNArguments *));
void rtcSetGeometryOccludedFunction(RTCGeometry, void (*)(const RTCOccludedFunctionNArguments *));
void rtcSetGeometryIntersectFilterFunction(RTCGeometry, RTCFilterFunctionN);
void rtcSetGeometryOccludedFilterFunction(RTCGeometry, RTCFilterFunctionN);
void rtcInvokeIntersectFilterFromGeometry(const RTCIntersectFunctionNArguments *, const RTCFilterFunctionNArguments *);
void rtcInvokeOccludedFilterFromGeometry(const RTCOccludedFunctionNArguments *, const RTCFilterFunctionNArguments *);
void *rtcSetNewGeometryBuffer(RTCGeometry, RTCBufferType, unsigned slot, RTCFormat, size_t stride, size_t count);
void rtcIntersect1(RTCScene, RTCRayHit *, RTCQueryArguments *);
void rtcIntersect4(const int *valid, RTCScene, void *, RTCQueryArguments *);
void rtcIntersect8(const int *valid, RTCScene, void *, RTCQueryArguments *);
void rtcIntersect16(const int *valid, RTCScene, void *, RTCQueryArguments *);
void rtcOccluded1(RTCScene, RTCRay *, RTCQueryArguments *);
void rtcOccluded4(const int *valid, RTCScene, void *, RTCQueryArguments *);
void rtcOccluded8(const int *valid, RTCScene, void *, RTCQueryArguments *);
void rtcOccluded16(const int *valid, RTCScene, void *, RTCQueryArguments *);
}
