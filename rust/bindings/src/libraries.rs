//! The libraries whose headers are bound: which headers, which of their declarations, and the file that gets them.

use crate::binding::{Binding, Header, Place};

/// Every generated binding.
pub const BINDINGS: &[Binding] = &[
    Binding {
        output: "rust/native/embree/src/abi/common.rs",
        head: EMBREE_COMMON,
        headers: &[EMBREE_3, EMBREE_4],
        source: "static const unsigned int INVALID_ID = RTC_INVALID_GEOMETRY_ID;\n",
        functions: &[
            "rtcNewDevice",
            "rtcReleaseDevice",
            "rtcGetDeviceError",
            "rtcGetDeviceProperty",
            "rtcSetDeviceErrorFunction",
            "rtcSetDeviceMemoryMonitorFunction",
            "rtcNewScene",
            "rtcReleaseScene",
            "rtcSetSceneFlags",
            "rtcSetSceneBuildQuality",
            "rtcCommitScene",
            "rtcAttachGeometryByID",
            "rtcDetachGeometry",
            "rtcNewGeometry",
            "rtcReleaseGeometry",
            "rtcCommitGeometry",
            "rtcSetGeometryBuildQuality",
            "rtcSetNewGeometryBuffer",
            "rtcGetGeometryBufferData",
            "rtcUpdateGeometryBuffer",
            "rtcSetGeometryInstancedScene",
            "rtcSetGeometryTransform",
            "rtcSetGeometrySubdivisionMode",
            "rtcInterpolate",
        ],
        types: &["RTCRay", "RTCRay8"],
        constants: &[
            "INVALID_ID",
            "RTC_DEVICE_PROPERTY_(VERSION|TASKING_SYSTEM)",
            "RTC_GEOMETRY_TYPE_(TRIANGLE|SUBDIVISION|INSTANCE)",
            "RTC_BUFFER_TYPE_(INDEX|VERTEX|FACE|HOLE)",
            "RTC_BUFFER_TYPE_(EDGE|VERTEX)_CREASE_(INDEX|WEIGHT)",
            "RTC_FORMAT_(UINT|UINT2|UINT3|FLOAT|FLOAT3|FLOAT3X4_COLUMN_MAJOR)",
            "RTC_BUILD_QUALITY_(LOW|MEDIUM|REFIT)",
            "RTC_SCENE_FLAG_(NONE|DYNAMIC|ROBUST)",
            "RTC_SUBDIVISION_MODE_(SMOOTH_BOUNDARY|PIN_CORNERS)",
        ],
        imported: &[],
        table: Some("Embree"),
    },
    Binding {
        output: "rust/native/embree/src/abi/embree3.rs",
        head: EMBREE_3_HEAD,
        headers: &[EMBREE_3],
        source: "",
        functions: TRACING,
        types: &[],
        constants: &["RTC_INTERSECT_CONTEXT_FLAG_(NONE|COHERENT)"],
        imported: IN_COMMON,
        table: Some("Embree3"),
    },
    Binding {
        output: "rust/native/embree/src/abi/embree4.rs",
        head: EMBREE_4_HEAD,
        headers: &[EMBREE_4],
        source: "",
        functions: TRACING,
        types: &[],
        constants: &["RTC_RAY_QUERY_FLAG_(NONE|COHERENT)", "RTC_FEATURE_FLAG_ALL"],
        imported: IN_COMMON,
        table: Some("Embree4"),
    },
    Binding {
        output: "rust/native/openvdb/src/abi.rs",
        head: "// Made by `cargo xtask bindings` from cpp/openvdb/module.h; do not edit.",
        headers: &[Header { include: "\"cpp/openvdb/module.h\"", place: Place::Repository }],
        source: "",
        functions: &["rlvdb_.*"],
        types: &[],
        constants: &["RLVDB_.*"],
        imported: &[],
        table: Some("Rlvdb"),
    },
];

/// Embree 3.13 as Debian 12 has it.
const EMBREE_3: Header = Header { include: "<embree3/rtcore.h>", place: Place::Package("libembree-dev") };

/// Embree 4.4, which Debian 12 has not: `git clone --depth 1 --branch v4.4.0 https://github.com/RenderKit/embree`, then
/// `EMBREE4_INCLUDE=embree/include`.
const EMBREE_4: Header = Header {
    include: "<embree4/rtcore.h>",
    place: Place::Variable { name: "EMBREE4_INCLUDE", configured: ("embree4/rtcore_config.h", EMBREE_4_CONFIG) },
};

/// What CMake makes of `rtcore_config.h`, with the options on that make structures longer: a build without them leaves
/// the additional fields alone, while one with them would read beyond the end of shorter structures.
const EMBREE_4_CONFIG: &str = "\
#pragma once
#define RTC_MAX_INSTANCE_LEVEL_COUNT 1
#define RTC_GEOMETRY_INSTANCE_ARRAY
#define RTC_MIN_WIDTH 1
#define RTC_NAMESPACE_BEGIN
#define RTC_NAMESPACE_END
#define RTC_NAMESPACE_USE
#define RTC_API_EXTERN_C
#define RTC_API
#define RTC_SYCL_API
#define RTC_SYCL_INDIRECTLY_CALLABLE
";

/// The functions whose signatures differ between 3.x and 4.x.
const TRACING: &[&str] = &["rtcIntersect1", "rtcOccluded1", "rtcIntersect8", "rtcOccluded8"];

/// What `common.rs` declares for `embree3.rs` and `embree4.rs`.
const IN_COMMON: &[&str] = &["RTCScene(Ty)?", "RTCGeometry(Ty)?", "RTCRay", "RTCRay8"];

const EMBREE_COMMON: &str = "\
// Made by `cargo xtask bindings` from the headers of Embree 3.13.5 and 4.4.0, which declare this alike; do not edit.
// Copyright 2009-2021 Intel Corporation
// SPDX-License-Identifier: Apache-2.0";

const EMBREE_3_HEAD: &str = "\
// Made by `cargo xtask bindings` from the headers of Embree 3.13.5; do not edit.
// Copyright 2009-2021 Intel Corporation
// SPDX-License-Identifier: Apache-2.0
use super::common::*;";

const EMBREE_4_HEAD: &str = "\
// Made by `cargo xtask bindings` from the headers of Embree 4.4.0; do not edit.
// Copyright 2009-2021 Intel Corporation
// SPDX-License-Identifier: Apache-2.0
use super::common::*;";
