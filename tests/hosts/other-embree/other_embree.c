/* The Embree of a host: it has the names of the real one, but other signatures and nothing that works. Whoever reaches
 * it by accident is counted. */
int other_embree_calls = 0;

#define OTHER(name)               \
    void *name(void);             \
    void *name(void) {            \
        ++other_embree_calls;     \
        return &other_embree_calls; \
    }

OTHER(rtcNewDevice)
OTHER(rtcReleaseDevice)
OTHER(rtcGetDeviceProperty)
OTHER(rtcGetDeviceError)
OTHER(rtcSetDeviceErrorFunction)
OTHER(rtcNewScene)
OTHER(rtcReleaseScene)
OTHER(rtcSetSceneFlags)
OTHER(rtcSetSceneBuildQuality)
OTHER(rtcCommitScene)
OTHER(rtcAttachGeometryByID)
OTHER(rtcDetachGeometry)
OTHER(rtcNewGeometry)
OTHER(rtcReleaseGeometry)
OTHER(rtcCommitGeometry)
OTHER(rtcSetGeometryBuildQuality)
OTHER(rtcSetNewGeometryBuffer)
OTHER(rtcGetGeometryBufferData)
OTHER(rtcUpdateGeometryBuffer)
OTHER(rtcSetGeometryInstancedScene)
OTHER(rtcSetGeometryTransform)
OTHER(rtcSetGeometrySubdivisionMode)
OTHER(rtcInterpolate)
OTHER(rtcIntersect1)
OTHER(rtcOccluded1)
