"""The C ABI of Relievo as ctypes sees it: constants, enumerations, structs and functions, named as in the headers.

Made by `cargo xtask bindings` from include/relievo; do not edit. `INIT` holds what the RLV_..._INIT of a struct hold.
"""

import ctypes
from ctypes import POINTER, Structure, c_char, c_char_p, c_void_p
from ctypes import c_double, c_float, c_int32, c_int64, c_size_t, c_uint16, c_uint32, c_uint64, c_uint8
from enum import IntEnum

RLV_VERSION_MAJOR = 0
RLV_VERSION_MINOR = 1
RLV_VERSION_PATCH = 0
RLV_NAME_SIZE = 48
RLV_TEXT_SIZE = 256
RLV_OK = 0
RLV_ERROR_INVALID = 1
RLV_ERROR_UNSUPPORTED = 2
RLV_ERROR_NOT_FOUND = 3
RLV_ERROR_IO = 4
RLV_ERROR_MEMORY = 5
RLV_ERROR_BUSY = 6
RLV_ERROR_CANCELLED = 7
RLV_ERROR_INTERNAL = 8
RLV_ERROR_DEVICE = 9
RLV_NO_ELEMENT = 4294967295
RLV_CROWD_PICTURE_SIDE = 32
RLV_LAYER_NAME_SIZE = 256
RLV_FLUID_WALLS = 4294967295
RLV_PICTURE_NAME_SIZE = 264
RLV_PICTURE_NONE = 4294967295


class RlvElement(IntEnum):
    NONE = 0
    POINT = 1
    CORNER = 2
    EDGE = 3
    FACE = 4
    TRIANGLE = 5
    TILE = 6
    PATCH = 7
    ITEM = 8
    PARTICLE = 9
    LINE = 10
    PIN = 11
    CREASE = 12


class RlvDevice(IntEnum):
    CPU = 0
    GPU = 1
    AUTO = 2


class RlvProgressAnswer(IntEnum):
    CONTINUE = 0
    CANCEL = 1


class RlvLogLevel(IntEnum):
    INFO = 0
    WARNING = 1


class RlvAdapterKind(IntEnum):
    DISCRETE = 0
    INTEGRATED = 1
    VIRTUAL = 2
    SOFTWARE = 3


class RlvDomain(IntEnum):
    POINT = 0
    CORNER = 1
    FACE = 2


class RlvType(IntEnum):
    F32 = 0
    U32 = 1


class RlvBoundary(IntEnum):
    EDGES_AND_CORNERS = 0
    EDGES = 1
    NONE = 2


class RlvSurfaceKind(IntEnum):
    CATMULL_CLARK = 0
    TRIANGLES = 1
    BILINEAR = 2


class RlvChannel(IntEnum):
    DISPLACEMENT = 0
    COLOR = 1
    VECTORS = 2
    TRACES = 3


class RlvColorFormat(IntEnum):
    RGBA8 = 0
    RGBA16F = 1


class RlvBakeQuantity(IntEnum):
    DISPLACEMENT = 0
    VECTOR = 1
    NORMAL = 2
    COLOR = 3
    MASK = 4
    CONTACT = 5
    DEPTH = 6
    TIME = 7


class RlvBakeSpace(IntEnum):
    TANGENT = 0
    OBJECT = 1


class RlvBakeAxes(IntEnum):
    TNB = 0
    TBN = 1


class RlvBakeHandedness(IntEnum):
    OPENGL = 0
    DIRECTX = 1


class RlvParameterKind(IntEnum):
    F32 = 0
    U32 = 1
    BOOL = 2


class RlvBrushAction(IntEnum):
    PAINT = 0
    SCULPT = 1


class RlvPaintMode(IntEnum):
    MIX = 0
    ADD = 1
    MULTIPLY = 2
    ERASE = 3
    BLUR = 4
    SMEAR = 5


class RlvSculptMode(IntEnum):
    DRAW = 0
    SMOOTH = 1
    FLATTEN = 2
    ERASE = 3
    CLAY = 4
    SCRAPE = 5
    LAYER = 6
    INFLATE = 7
    PINCH = 8
    VECTOR = 9


class RlvFalloff(IntEnum):
    CONSTANT = 0
    LINEAR = 1
    SMOOTH = 2
    SPHERE = 3
    GAUSSIAN = 4


class RlvCurve(IntEnum):
    SIZE = 0
    STRENGTH = 1
    ANGLE = 2


class RlvContent(IntEnum):
    MESH = 0
    PATCHES = 1
    PARTICLES = 2
    GRID = 3
    TEXTURE = 4
    DOCUMENT = 5
    PROGRESSIVE = 6
    CROWD = 7
    TISSUE = 8


class RlvIsosurfaceFunction(IntEnum):
    BLOBS = 0
    ZHU_BRIDSON = 1
    DENSITY = 2
    ANISOTROPIC = 3


class RlvIsosurfaceClass(IntEnum):
    SURFACE = 0
    BLIND = 1
    HIDDEN = 2


class RlvClientState(IntEnum):
    RUNNING = 0
    FORCES = 1
    PAUSED = 2
    DONE = 3
    CANCELLED = 4
    FAILED = 5


class RlvClientAction(IntEnum):
    PAUSE = 0
    RESUME = 1
    CANCEL = 2
    REMOVE = 3


class RlvClientParticles(IntEnum):
    ALL = 0
    BLIND = 1
    SURFACE = 2


class RlvClientForm(IntEnum):
    FRAME = 0
    MESH = 1
    LEVEL_SET = 2


class RlvCrowdBlend(IntEnum):
    LINEAR = 0
    DUAL_QUATERNION = 1


class RlvLayerKind(IntEnum):
    DISPLACEMENT = 0
    COLOR = 1


class RlvBlend(IntEnum):
    NORMAL = 0
    ADD = 1
    SUBTRACT = 2
    MULTIPLY = 3
    SCREEN = 4
    OVERLAY = 5
    MAX = 6
    MIN = 7


class RlvFluidKernels(IntEnum):
    WENDLAND = 0
    MUELLER = 1


class RlvFluidSolver(IntEnum):
    PCISPH = 0
    DFSPH = 1


class RlvFluidSteps(IntEnum):
    COURANT = 0
    FIXED = 1


class RlvFluidContact(IntEnum):
    SLIP = 0
    STOP = 1
    FRICTION = 2


class RlvFluidForceKind(IntEnum):
    GRAVITY = 0
    WIND = 1
    DRAG = 2
    VORTEX = 3
    ATTRACTOR = 4
    TURBULENCE = 5


class RlvFluidEmitterShape(IntEnum):
    DISC = 0
    RECTANGLE = 1
    SURFACE = 2


class RlvFoamKind(IntEnum):
    SPRAY = 0
    FLOAT = 1
    BUBBLE = 2


class RlvGridKind(IntEnum):
    FLOAT = 0
    DOUBLE = 1
    BOOL = 2
    MASK = 3
    INT32 = 4
    INT64 = 5
    VEC3S = 6
    VEC3D = 7
    VEC3I = 8
    POINTS = 9
    OTHER = 10


class RlvGridClass(IntEnum):
    UNKNOWN = 0
    LEVEL_SET = 1
    FOG = 2
    STAGGERED = 3


class RlvGridWriting(IntEnum):
    PACK_BLOSC = 0
    PACK_ZIP = 1
    PACK_NONE = 2
    HALF = 4
    STREAM = 8


class RlvGridOperation(IntEnum):
    UNION = 0
    INTERSECTION = 1
    DIFFERENCE = 2


class RlvGridChange(IntEnum):
    OFFSET = 0
    MEAN = 1
    GAUSSIAN = 2
    MEDIAN = 3
    LAPLACIAN = 4
    MEAN_CURVATURE = 5
    RESAMPLE = 6
    TO_FOG = 7
    TO_LEVEL_SET = 8


class RlvPictureFormat(IntEnum):
    DOCUMENT = 0
    PTEX = 1


class RlvPictureType(IntEnum):
    U8 = 0
    U16 = 1
    F16 = 2
    F32 = 3
    I32 = 4
    F64 = 5
    TEXT = 6


class RlvPictureContent(IntEnum):
    COLOR = 0
    DISPLACEMENT = 1
    VECTORS = 2
    TRACES = 3
    NUMBERS = 4


class RlvPtexKind(IntEnum):
    STATED = 0
    DISPLACEMENT = 1
    COLOR = 2
    VECTORS = 3


class RlvTissuePurpose(IntEnum):
    HOLD = 0
    SLIDE = 1
    BIND = 2


class RlvTissueBody(IntEnum):
    FLOOR = 0
    BALL = 1
    MESH = 2


class RlvJobState(IntEnum):
    RUNNING = 0
    DONE = 1
    FAILED = 2
    CANCELLED = 3


class RlvJobKind(IntEnum):
    NONE = 0
    MESH = 1
    PROGRESSIVE = 2
    GRID = 3
    DECAL = 4
    CROWD_MODEL = 5
    TISSUE = 6
    PARTICLES = 7
    SURFACE = 8
    CASTER = 9
    PROCEDURAL = 10
    COLLIDER = 11
    PICTURE = 12
    DOCUMENT = 13
    IMPRINT_REPORT = 14
    BAKE_REPORT = 15
    PTEX_REPORT = 16
    TRANSFER_REPORT = 17
    FLUID_REPORT = 18
    CLIENT_STATUS = 19
    BYTES = 20


class RlvShaderLanguage(IntEnum):
    GLSL = 0
    WGSL = 1


class RlvShaderStage(IntEnum):
    VERTEX = 0
    FRAGMENT = 1
    COMPUTE = 2


class RlvShaderText(IntEnum):
    MARKED = 0
    AUGMENTED = 1
    AUGMENTED_WGSL = 2


class RlvShaderDeclared(IntEnum):
    GLOBAL = 0
    PARAMETER = 1
    LOCAL = 2


class RlvShaderAccumulation(IntEnum):
    AVERAGE = 0
    SUM = 1
    MIN = 2
    MAX = 3
    FIRST = 4
    LAST = 5


class RlvShaderClass(IntEnum):
    NEGATIVE = 0
    POSITIVE = 1


class RlvShaderMode(IntEnum):
    RENDER = 0
    CLASSIFY = 1
    MASK = 2
    CLASSIFY_VERTEX = 3
    VERTICES = 4


class RlvScheme(IntEnum):
    CATMULL_CLARK = 0
    LOOP = 1
    BILINEAR = 2


class RlvFaceVarying(IntEnum):
    NONE = 0
    CORNERS_ONLY = 1
    CORNERS_PLUS_1 = 2
    CORNERS_PLUS_2 = 3
    BOUNDARIES = 4
    ALL = 5


class RlvCreasing(IntEnum):
    UNIFORM = 0
    CHAIKIN = 1


class RlvTriangleRule(IntEnum):
    CATMULL_CLARK = 0
    SMOOTH = 1


class RlvPointRule(IntEnum):
    VERTEX = 0
    VARYING = 1


class c_float_p(c_void_p):
    target = c_float


class c_double_p(c_void_p):
    target = c_double


class c_uint8_p(c_void_p):
    target = c_uint8


class c_uint16_p(c_void_p):
    target = c_uint16


class c_uint32_p(c_void_p):
    target = c_uint32


class c_uint64_p(c_void_p):
    target = c_uint64


class c_int32_p(c_void_p):
    target = c_int32


class c_int64_p(c_void_p):
    target = c_int64


class c_size_t_p(c_void_p):
    target = c_size_t


RlvResult = c_int32


class RlvError(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("result", RlvResult),
        ("message", c_char_p),
        ("what", c_char_p),
        ("place", c_char_p),
        ("remedy", c_char_p),
        ("code", c_uint32),
        ("element_kind", c_uint32),
        ("element", c_uint64),
    ]


class RlvContext(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


RlvLoopBody = ctypes.CFUNCTYPE(None, c_void_p, c_size_t)

RlvLoop = ctypes.CFUNCTYPE(None, c_void_p, c_size_t, RlvLoopBody, c_void_p)

RlvTask = ctypes.CFUNCTYPE(None, c_void_p)

RlvSpawn = ctypes.CFUNCTYPE(None, c_void_p, RlvTask, c_void_p)


class RlvContextOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("device", c_uint32),
        ("threads", c_uint32),
        ("reserved", c_uint32),
        ("memory_limit", c_uint64),
        ("device_memory_limit", c_uint64),
        ("adapter", c_char_p),
        ("shared", RlvContext),
        ("host_loop", RlvLoop),
        ("host_spawn", RlvSpawn),
        ("host_user", c_void_p),
    ]


class RlvContextInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("device", c_uint32),
        ("threads", c_uint32),
        ("reserved", c_uint32),
        ("memory_limit", c_uint64),
        ("simd", c_char * 48),
        ("device_memory_limit", c_uint64),
        ("device_memory", c_uint64),
        ("adapter", c_char * 256),
        ("fallback", c_char * 256),
    ]


class RlvContextStat(Structure):
    _fields_ = [
        ("stage", c_char * 48),
        ("quantity", c_char * 48),
        ("total", c_double),
        ("samples", c_uint64),
    ]


RlvProgress = ctypes.CFUNCTYPE(c_uint32, c_void_p, c_float, c_char_p)

RlvLog = ctypes.CFUNCTYPE(None, c_void_p, c_uint32, c_char_p)

RlvMemoryMonitor = ctypes.CFUNCTYPE(c_uint32, c_void_p, c_int64)


class RlvAdapterInfo(Structure):
    _fields_ = [
        ("kind", c_uint32),
        ("is_usable", c_uint32),
        ("buffer_limit", c_uint64),
        ("binding_limit", c_uint64),
        ("backend", c_char * 48),
        ("name", c_char * 256),
        ("driver", c_char * 256),
    ]


RlvAllocate = ctypes.CFUNCTYPE(c_void_p, c_void_p, c_size_t, c_size_t)

RlvFree = ctypes.CFUNCTYPE(None, c_void_p, c_void_p, c_size_t, c_size_t)


class RlvAllocator(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("allocate", RlvAllocate),
        ("free", RlvFree),
        ("user", c_void_p),
    ]


class RlvAllocatorInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("is_set", c_uint32),
        ("bytes", c_uint64),
        ("limit", c_uint64),
    ]


class RlvBytes(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvMesh(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvMeshArrays(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("face_size", c_uint32),
        ("points", c_float_p),
        ("point_count", c_size_t),
        ("point_stride", c_size_t),
        ("face_sizes", c_uint32_p),
        ("face_count", c_size_t),
        ("face_stride", c_size_t),
        ("corners", c_uint32_p),
        ("corner_count", c_size_t),
        ("corner_stride", c_size_t),
        ("creases", c_uint32_p),
        ("crease_sharpness", c_float_p),
        ("crease_count", c_size_t),
        ("crease_stride", c_size_t),
        ("crease_sharpness_stride", c_size_t),
        ("sharp_points", c_uint32_p),
        ("sharp_point_sharpness", c_float_p),
        ("sharp_point_count", c_size_t),
        ("sharp_point_stride", c_size_t),
        ("sharp_point_sharpness_stride", c_size_t),
        ("holes", c_uint32_p),
        ("hole_count", c_size_t),
        ("hole_stride", c_size_t),
    ]


class RlvMeshInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("attribute_count", c_uint32),
        ("point_count", c_size_t),
        ("face_count", c_size_t),
        ("corner_count", c_size_t),
        ("triangle_count", c_size_t),
        ("crease_count", c_size_t),
        ("sharp_point_count", c_size_t),
        ("hole_count", c_size_t),
        ("low", c_float * 3),
        ("high", c_float * 3),
    ]


class RlvAttributeArrays(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("domain", c_uint32),
        ("type", c_uint32),
        ("width", c_uint32),
        ("name", c_char_p),
        ("values", c_void_p),
        ("value_count", c_size_t),
        ("value_stride", c_size_t),
        ("indices", c_uint32_p),
        ("index_count", c_size_t),
        ("index_stride", c_size_t),
    ]


class RlvAttributeInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("domain", c_uint32),
        ("type", c_uint32),
        ("width", c_uint32),
        ("value_count", c_size_t),
        ("index_count", c_size_t),
        ("name", c_char * 48),
    ]


RlvMeshReleased = ctypes.CFUNCTYPE(None, c_void_p)


class RlvSimplifyWeight(Structure):
    _fields_ = [
        ("name", c_char_p),
        ("weight", c_float),
        ("is_left_out", c_uint32),
    ]


class RlvSimplifyOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("error", c_float),
        ("triangles", c_size_t),
        ("weights", POINTER(RlvSimplifyWeight)),
        ("weight_count", c_size_t),
        ("weight_stride", c_size_t),
        ("locked", c_uint32_p),
        ("locked_count", c_size_t),
        ("locked_stride", c_size_t),
        ("factors", c_float_p),
        ("factor_count", c_size_t),
        ("factor_stride", c_size_t),
        ("bound", c_float),
        ("is_border_locked", c_uint32),
    ]


class RlvProgressive(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvProgressiveOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("keeps_attributes", c_uint32),
        ("base_triangles", c_size_t),
        ("locked", c_uint32_p),
        ("locked_count", c_size_t),
        ("locked_stride", c_size_t),
        ("weights", POINTER(RlvSimplifyWeight)),
        ("weight_count", c_size_t),
        ("weight_stride", c_size_t),
    ]


class RlvProgressiveInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("attribute_count", c_uint32),
        ("vertex_count", c_size_t),
        ("triangle_count", c_size_t),
        ("base_vertex_count", c_size_t),
        ("base_triangle_count", c_size_t),
        ("bytes", c_size_t),
        ("wedge_count", c_size_t),
        ("wedge_width", c_uint32),
        ("face_width", c_uint32),
    ]


class RlvArrival(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvArrivalInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("is_complete", c_uint32),
        ("triangle_count", c_size_t),
    ]


class RlvSurface(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvSurfaceOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("boundary", c_uint32),
        ("isolation", c_uint32),
        ("patch_limit", c_uint32),
        ("kind", c_uint32),
        ("reserved", c_uint32),
    ]


class RlvSurfaceInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("non_manifold", c_uint32),
        ("point_count", c_size_t),
        ("face_count", c_size_t),
        ("tile_count", c_size_t),
        ("patch_count", c_size_t),
        ("bytes", c_uint64),
        ("low", c_float * 3),
        ("high", c_float * 3),
        ("extent", c_float),
        ("kind", c_uint32),
    ]


class RlvTileInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("face", c_uint32),
        ("corner", c_uint32),
        ("is_part", c_uint32),
        ("is_hole", c_uint32),
        ("low", c_float * 3),
        ("high", c_float * 3),
    ]


class RlvDetail(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvDetailOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("tile_size", c_uint32),
        ("budget", c_uint64),
        ("face_sizes", c_uint32_p),
        ("face_size_count", c_size_t),
        ("face_size_stride", c_size_t),
    ]


class RlvDetailInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("is_painted", c_uint32),
        ("tile_count", c_size_t),
        ("allocated_count", c_size_t),
        ("revision", c_uint64),
        ("bytes", c_uint64),
        ("full_bytes", c_uint64),
        ("budget", c_uint64),
        ("painted_count", c_size_t),
        ("paint_bytes", c_uint64),
        ("paint_budget", c_uint64),
        ("time", c_double),
        ("stamp_bytes", c_uint64),
    ]


class RlvChannelInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("is_there", c_uint32),
        ("allocated_count", c_size_t),
        ("bytes", c_uint64),
        ("full_bytes", c_uint64),
        ("budget", c_uint64),
        ("texel_size", c_uint32),
        ("paged_count", c_uint32),
    ]


class RlvDetailFolds(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("tile", c_uint32),
        ("triangle_count", c_uint64),
        ("folded_count", c_uint64),
    ]


class RlvPaintOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("tile_size", c_uint32),
        ("budget", c_uint64),
        ("color", c_float * 4),
        ("format", c_uint32),
        ("reserved", c_uint32),
    ]


class RlvVectorOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("tile_size", c_uint32),
        ("budget", c_uint64),
    ]


class RlvDecayOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("delay", c_float),
        ("duration", c_float),
        ("reserved", c_uint32),
        ("budget", c_uint64),
    ]


class RlvDetailChanges(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("moved", c_uint32),
        ("revision", c_uint64),
        ("tile_count", c_size_t),
        ("low", c_float * 3),
        ("high", c_float * 3),
    ]


class RlvDetailTileInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("is_allocated", c_uint32),
        ("size", c_uint32),
        ("reserved", c_uint32),
        ("version", c_uint64),
        ("block_size", c_size_t),
        ("low", c_float * 3),
        ("high", c_float * 3),
    ]


class RlvBakeOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("quantity", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("is_udim", c_uint32),
        ("gutter", c_uint32),
        ("samples", c_uint32),
        ("space", c_uint32),
        ("axes", c_uint32),
        ("handedness", c_uint32),
        ("scale", c_float),
        ("mid_level", c_float),
        ("uv", c_char_p),
    ]


class RlvBakePicture(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("udim", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("channels", c_uint32),
        ("reserved", c_uint32),
        ("pixels", c_float_p),
        ("covered", c_uint8_p),
    ]


class RlvBakeReport(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("picture_count", c_uint32),
        ("covered_pixels", c_uint64),
        ("gutter_pixels", c_uint64),
        ("overlapping_pixels", c_uint64),
        ("flat_tiles", c_size_t),
        ("outside_count", c_size_t),
        ("scale", c_float),
        ("mid_level", c_float),
    ]


RlvBakeReceiver = ctypes.CFUNCTYPE(c_uint32, c_void_p, POINTER(RlvBakePicture))


class RlvEvaluateArrays(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("count", c_size_t),
        ("tiles", c_uint32_p),
        ("tile_stride", c_size_t),
        ("uvs", c_float_p),
        ("uv_stride", c_size_t),
        ("positions", c_float_p),
        ("position_stride", c_size_t),
        ("normals", c_float_p),
        ("normal_stride", c_size_t),
        ("du", c_float_p),
        ("du_stride", c_size_t),
        ("dv", c_float_p),
        ("dv_stride", c_size_t),
        ("duu", c_float_p),
        ("duu_stride", c_size_t),
        ("duv", c_float_p),
        ("duv_stride", c_size_t),
        ("dvv", c_float_p),
        ("dvv_stride", c_size_t),
        ("displacements", c_float_p),
        ("displacement_stride", c_size_t),
        ("colors", c_float_p),
        ("color_stride", c_size_t),
        ("vectors", c_float_p),
        ("vector_stride", c_size_t),
        ("traces", c_float_p),
        ("trace_stride", c_size_t),
        ("footprints", c_float_p),
        ("footprint_stride", c_size_t),
    ]


class RlvBezier(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvBezierArrays(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("points", c_float_p),
        ("point_count", c_size_t),
        ("point_stride", c_size_t),
        ("weights", c_float_p),
        ("weight_stride", c_size_t),
        ("indices", c_uint32_p),
        ("index_count", c_size_t),
        ("index_stride", c_size_t),
    ]


class RlvBezierInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("is_rational", c_uint32),
        ("patch_count", c_size_t),
        ("curve_count", c_size_t),
        ("low", c_float * 3),
        ("high", c_float * 3),
    ]


class RlvBezierView(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("most", c_uint32),
        ("eye", c_double * 3),
        ("forward", c_double * 3),
        ("pixels", c_double),
        ("corner", c_double),
        ("tolerance", c_double),
    ]


class RlvBezierLevels(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("level", c_uint32),
        ("levels", c_uint32_p),
        ("level_count", c_size_t),
        ("level_stride", c_size_t),
    ]


class RlvBezierTriangles(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("positions", c_float_p),
        ("position_stride", c_size_t),
        ("normals", c_float_p),
        ("normal_stride", c_size_t),
        ("point_capacity", c_size_t),
        ("corners", c_uint32_p),
        ("triangle_stride", c_size_t),
        ("triangle_capacity", c_size_t),
    ]


class RlvParameter(Structure):
    _fields_ = [
        ("name", c_char_p),
        ("unit", c_char_p),
        ("help", c_char_p),
        ("kind", c_uint32),
        ("offset", c_uint32),
        ("min", c_double),
        ("max", c_double),
        ("value", c_double),
    ]


class RlvBrush(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvBrushOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("action", c_uint32),
        ("mode", c_uint32),
        ("falloff", c_uint32),
        ("color", c_float * 4),
        ("height", c_float),
        ("reserved", c_uint32),
    ]


class RlvBrushSettings(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("radius", c_float),
        ("depth", c_float),
        ("spacing", c_float),
        ("strength", c_float),
        ("strength_pressure", c_float),
        ("size_pressure", c_float),
        ("angle", c_float),
        ("angle_pressure", c_float),
        ("jitter_position", c_float),
        ("jitter_size", c_float),
        ("jitter_strength", c_float),
        ("jitter_angle", c_float),
        ("seed", c_uint32),
        ("string", c_float),
        ("rate", c_float),
        ("symmetry_x", c_uint32),
        ("symmetry_y", c_uint32),
        ("symmetry_z", c_uint32),
        ("reach", c_float),
        ("level", c_uint32),
    ]


class RlvStampOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("channel", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("channels", c_uint32),
        ("reserved", c_uint32),
        ("pixels", c_float_p),
    ]


class RlvStampSettings(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("angle", c_float),
        ("repeat", c_float),
        ("mirror", c_uint32),
        ("alternate", c_uint32),
        ("mid", c_float),
        ("scale", c_float),
    ]


class RlvTessellateOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("coarse", c_uint32),
        ("fine", c_uint32),
        ("places", c_uint32),
        ("smooth_uvs", c_uint32),
        ("reserved", c_uint32),
    ]


class RlvTessellation(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvTessellationInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("point_count", c_size_t),
        ("triangle_count", c_size_t),
        ("revision", c_uint64),
    ]


class RlvTessellationChanges(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("rebuilt", c_uint32),
        ("range_count", c_size_t),
        ("point_count", c_size_t),
        ("low", c_float * 3),
        ("high", c_float * 3),
    ]


class RlvBuffer(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvBufferInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("rebuilt", c_uint32),
        ("point_count", c_size_t),
        ("triangle_count", c_size_t),
        ("written_count", c_size_t),
        ("bytes", c_uint64),
    ]


class RlvBufferVulkan(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("queue_family", c_uint32),
        ("queue_index", c_uint32),
        ("reserved", c_uint32),
        ("instance", c_uint64),
        ("physical_device", c_uint64),
        ("device", c_uint64),
        ("queue", c_uint64),
        ("points", c_uint64),
        ("triangles", c_uint64),
    ]


class RlvCapability(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("version", c_uint32),
        ("embree_version", c_uint32),
        ("opensubdiv_version", c_uint32),
        ("openvdb_version", c_uint32),
        ("has_devices", c_uint32),
        ("has_usd", c_uint32),
        ("has_shaders", c_uint32),
        ("has_tls", c_uint32),
        ("adapter_count", c_uint32),
        ("cores", c_uint32),
        ("max_threads", c_uint32),
        ("max_isolation", c_uint32),
        ("reserved", c_uint32),
        ("max_objects", c_uint64),
        ("simd", c_char * 48),
    ]


class RlvCapabilityFormat(Structure):
    _fields_ = [
        ("content", c_uint32),
        ("can_read", c_uint32),
        ("can_write", c_uint32),
        ("can_write_bytes", c_uint32),
        ("extension", c_char * 48),
    ]


class RlvCaster(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvHit(Structure):
    _fields_ = [
        ("distance", c_float),
        ("face", c_uint32),
        ("tile", c_uint32),
        ("u", c_float),
        ("v", c_float),
        ("position", c_float * 3),
        ("normal", c_float * 3),
    ]


class RlvRayArrays(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("count", c_size_t),
        ("origins", c_float_p),
        ("origin_stride", c_size_t),
        ("directions", c_float_p),
        ("direction_stride", c_size_t),
        ("hits", POINTER(RlvHit)),
        ("hit_stride", c_size_t),
        ("min_distance", c_float),
        ("max_distance", c_float),
        ("min_distances", c_float_p),
        ("min_distance_stride", c_size_t),
        ("max_distances", c_float_p),
        ("max_distance_stride", c_size_t),
        ("masks", c_uint32_p),
        ("mask_stride", c_size_t),
        ("times", c_float_p),
        ("time_stride", c_size_t),
    ]


class RlvIsosurface(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvIsosurfaceOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("function", c_uint32),
        ("radius", c_float),
        ("support", c_float),
        ("sharpness", c_float),
        ("iso", c_float),
        ("centring", c_float),
        ("shutter_open", c_float),
        ("shutter_close", c_float),
        ("march_steps", c_float),
    ]


class RlvIsosurfaceParticles(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("count", c_size_t),
        ("points", c_float_p),
        ("point_stride", c_size_t),
        ("velocities", c_float_p),
        ("velocity_stride", c_size_t),
        ("blind", c_uint8_p),
        ("blind_stride", c_size_t),
    ]


class RlvIsosurfaceInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("has_velocities", c_uint32),
        ("particle_count", c_size_t),
        ("support", c_float),
        ("reach", c_float),
        ("influence", c_float),
        ("reserved", c_float),
    ]


class RlvIsosurfaceMeshOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("iterations", c_uint32),
        ("cell", c_float),
        ("forwards", c_float),
        ("backwards", c_float),
        ("reserved", c_uint32),
        ("channels", POINTER(RlvAttributeArrays)),
        ("channel_count", c_size_t),
        ("channel_stride", c_size_t),
    ]


class RlvIsosurfaceClasses(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("surface_count", c_size_t),
        ("blind_count", c_size_t),
        ("hidden_count", c_size_t),
        ("kept", c_double),
    ]


class RlvIsosurfaceRay(Structure):
    _fields_ = [
        ("origin", c_float * 3),
        ("direction", c_float * 3),
        ("min_distance", c_float),
        ("max_distance", c_float),
        ("time", c_float),
    ]


class RlvIsosurfaceHit(Structure):
    _fields_ = [
        ("distance", c_float),
        ("position", c_float * 3),
        ("normal", c_float * 3),
        ("velocity", c_float * 3),
        ("enters", c_uint32),
    ]


RlvIsosurfaceIntersect = ctypes.CFUNCTYPE(c_uint32, c_void_p, POINTER(RlvIsosurfaceRay), POINTER(RlvIsosurfaceHit))


class RlvIsosurfaceTable(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("data", c_void_p),
        ("intersect", RlvIsosurfaceIntersect),
        ("low", c_float * 3),
        ("high", c_float * 3),
    ]


class RlvParticles(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvParticlesArrays(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("has_time", c_uint32),
        ("time", c_double),
        ("spacing", c_float),
        ("reserved", c_uint32),
        ("count", c_size_t),
        ("points", c_float_p),
        ("point_stride", c_size_t),
        ("numbers", c_uint32_p),
        ("number_stride", c_size_t),
        ("channels", POINTER(RlvAttributeArrays)),
        ("channel_count", c_size_t),
        ("channel_stride", c_size_t),
    ]


class RlvParticlesInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("channel_count", c_uint32),
        ("count", c_size_t),
        ("has_numbers", c_uint32),
        ("has_time", c_uint32),
        ("time", c_double),
        ("spacing", c_float),
        ("reserved", c_uint32),
    ]


class RlvClient(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvClientOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("address", c_char_p),
        ("token", c_char_p),
        ("authorities", c_char_p),
        ("timeout", c_double),
        ("patience", c_double),
    ]


class RlvClientStatus(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("state", c_uint32),
        ("ready", c_uint64),
        ("frames", c_uint64),
        ("particles", c_uint64),
        ("seconds_left", c_double),
        ("fraction", c_float),
        ("reserved", c_uint32),
        ("text", c_char * 256),
    ]


class RlvClientInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("protocol", c_uint32 * 2),
        ("reserved", c_uint32),
        ("server", c_char * 48),
        ("user", c_char * 256),
        ("kinds", c_char * 256),
    ]


class RlvClientFile(Structure):
    _fields_ = [
        ("name", c_char_p),
        ("path", c_char_p),
    ]


class RlvClientScene(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("is_forced", c_uint32),
        ("name", c_char_p),
        ("kind", c_char_p),
        ("description", c_char_p),
        ("files", POINTER(RlvClientFile)),
        ("file_count", c_size_t),
    ]


class RlvClientFetch(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("particles", c_uint32),
        ("is_half", c_uint32),
        ("is_plain", c_uint32),
        ("channels", c_char_p),
    ]


class RlvCollider(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvColliderInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("is_closed", c_uint32),
        ("point_count", c_size_t),
        ("triangle_count", c_size_t),
        ("matrix", c_double * 12),
        ("open_edge_count", c_size_t),
    ]


class RlvToolSettings(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("stiffness", c_float),
        ("max_depth", c_float),
    ]


class RlvColorBuffer(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvColorBufferInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("rebuilt", c_uint32),
        ("format", c_uint32),
        ("reserved", c_uint32),
        ("tile_count", c_size_t),
        ("allocated_count", c_size_t),
        ("written_count", c_size_t),
        ("bytes", c_uint64),
        ("color", c_float * 4),
    ]


class RlvColorBufferVulkan(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("queue_family", c_uint32),
        ("queue_index", c_uint32),
        ("reserved", c_uint32),
        ("instance", c_uint64),
        ("physical_device", c_uint64),
        ("device", c_uint64),
        ("queue", c_uint64),
        ("tiles", c_uint64),
        ("texels", c_uint64),
        ("mip_firsts", c_uint64),
        ("mips", c_uint64),
    ]


class RlvCrowdModel(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvCrowd(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvCrowdBuildSettings(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("pose_distance", c_float),
        ("cluster_triangles", c_uint32),
        ("group_clusters", c_uint32),
        ("pose_rate", c_float),
    ]


class RlvCrowdClipName(Structure):
    _fields_ = [
        ("name", c_char_p),
    ]


class RlvCrowdRefitReport(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("grown_groups", c_uint32),
        ("growth", c_double),
        ("is_rebuild_due", c_uint32),
        ("reserved", c_uint32),
    ]


class RlvCrowdModelInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("vertex_count", c_uint32),
        ("triangle_count", c_uint32),
        ("input_triangles", c_uint32),
        ("cluster_count", c_uint32),
        ("group_count", c_uint32),
        ("bone_count", c_uint32),
        ("clip_count", c_uint32),
        ("material_count", c_uint32),
        ("pose_count", c_uint32),
        ("representatives", c_uint32),
        ("largest_error", c_float),
        ("measured", c_uint64),
        ("exceeded", c_uint64),
        ("low", c_float * 3),
        ("high", c_float * 3),
        ("morph_count", c_uint32),
        ("offset_count", c_uint32),
        ("blend", c_uint32),
        ("reserved", c_uint32),
    ]


class RlvCrowdClip(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("pose_count", c_uint32),
        ("rate", c_float),
        ("name", c_char * 48),
    ]


class RlvCrowdMaterial(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("name", c_char * 256),
    ]


class RlvCrowdVertices(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("capacity", c_size_t),
        ("points", c_float_p),
        ("normals", c_float_p),
        ("uvs", c_float_p),
        ("bones", c_uint32_p),
        ("weights", c_float_p),
    ]


class RlvCrowdCollapse(Structure):
    _fields_ = [
        ("group", c_uint32),
        ("target", c_uint32),
    ]


class RlvCrowdOffset(Structure):
    _fields_ = [
        ("vertex", c_uint32),
        ("morph", c_uint32),
        ("offset", c_float * 3),
    ]


class RlvCrowdCluster(Structure):
    _fields_ = [
        ("first_triangle", c_uint32),
        ("triangle_count", c_uint32),
        ("made_by", c_uint32),
        ("used_by", c_uint32),
        ("depth", c_uint32),
        ("deformation", c_float),
    ]


class RlvCrowdAgent(Structure):
    _fields_ = [
        ("model", c_uint32),
        ("clip", c_uint32),
        ("phase", c_double),
        ("transform", c_double * 12),
    ]


class RlvCrowdSun(Structure):
    _fields_ = [
        ("towards", c_double * 3),
        ("angular_radius", c_double),
    ]


class RlvCrowdView(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("tolerance", c_float),
        ("eye", c_double * 3),
        ("target", c_double * 3),
        ("up", c_double * 3),
        ("fov", c_double),
        ("time", c_double),
        ("occlusion", c_uint32),
        ("geomorph", c_uint32),
        ("impostors", c_uint32),
        ("reserved", c_uint32),
        ("suns", POINTER(RlvCrowdSun)),
        ("sun_count", c_size_t),
        ("around", c_double),
    ]


class RlvCrowdFrame(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("agent_count", c_uint32),
        ("draw_count", c_uint32),
        ("matrix_count", c_uint32),
        ("changed", c_uint32),
        ("hidden", c_uint32),
        ("clusters", c_uint64),
        ("triangles", c_uint64),
        ("hidden_triangles", c_uint64),
        ("occluder_triangles", c_uint64),
        ("weight_count", c_uint32),
        ("impostor_count", c_uint32),
        ("picture_count", c_uint32),
        ("hidden_clusters", c_uint32),
    ]


class RlvCrowdDraw(Structure):
    _fields_ = [
        ("index_count", c_uint32),
        ("instance_count", c_uint32),
        ("first_index", c_uint32),
        ("base_vertex", c_int32),
        ("first_instance", c_uint32),
    ]


class RlvCrowdInstance(Structure):
    _fields_ = [
        ("agent", c_uint32),
        ("first_matrix", c_uint32),
        ("transform", c_float * 12),
    ]


class RlvCrowdBuffers(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("draws", POINTER(RlvCrowdDraw)),
        ("draw_capacity", c_size_t),
        ("draw_stride", c_size_t),
        ("clusters", c_uint32_p),
        ("instances", POINTER(RlvCrowdInstance)),
        ("instance_capacity", c_size_t),
        ("instance_stride", c_size_t),
        ("matrices", c_float_p),
        ("matrix_capacity", c_size_t),
        ("matrix_stride", c_size_t),
        ("weights", c_float_p),
        ("weight_capacity", c_size_t),
        ("first_weights", c_uint32_p),
        ("blends", c_float_p),
        ("dual_rows", c_float_p),
    ]


class RlvCrowdImpostor(Structure):
    _fields_ = [
        ("agent", c_uint32),
        ("picture", c_uint32),
        ("transform", c_float * 12),
    ]


class RlvCrowdPicture(Structure):
    _fields_ = [
        ("number", c_uint64),
        ("model", c_uint32),
        ("radius", c_float),
        ("center", c_float * 3),
        ("axes", c_float * 9),
    ]


class RlvCrowdTexel(Structure):
    _fields_ = [
        ("cluster", c_uint32),
        ("material", c_uint32),
        ("normal", c_float * 3),
    ]


class RlvCrowdImpostors(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("impostors", POINTER(RlvCrowdImpostor)),
        ("impostor_capacity", c_size_t),
        ("impostor_stride", c_size_t),
        ("pictures", POINTER(RlvCrowdPicture)),
        ("picture_capacity", c_size_t),
        ("picture_stride", c_size_t),
        ("texels", POINTER(RlvCrowdTexel)),
        ("texel_capacity", c_size_t),
    ]


class RlvCrowdStreamFile(Structure):
    _fields_ = [
        ("path", c_char_p),
    ]


class RlvCrowdStreamSettings(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("most_read", c_uint32),
        ("budget", c_uint64),
    ]


class RlvCrowdStreamInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("slot_triangles", c_uint32),
        ("slot_count", c_uint32),
        ("resident", c_uint32),
        ("read", c_uint32),
        ("dropped", c_uint32),
        ("missing", c_uint32),
        ("reserved", c_uint32),
        ("wanted_triangles", c_uint64),
    ]


class RlvCrowdStreamCluster(Structure):
    _fields_ = [
        ("model", c_uint32),
        ("cluster", c_uint32),
        ("slot", c_uint32),
        ("triangle_count", c_uint32),
    ]


RlvStreamRead = ctypes.CFUNCTYPE(c_uint32, c_void_p, c_uint64, c_uint8_p, c_size_t)

RlvStreamWrite = ctypes.CFUNCTYPE(c_uint32, c_void_p, c_uint64, c_uint8_p, c_size_t)

RlvStreamLength = ctypes.CFUNCTYPE(c_uint32, c_void_p, c_uint64_p)

RlvStreamCut = ctypes.CFUNCTYPE(c_uint32, c_void_p, c_uint64)

RlvStreamSync = ctypes.CFUNCTYPE(c_uint32, c_void_p)

RlvStreamClose = ctypes.CFUNCTYPE(None, c_void_p)


class RlvStream(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("user", c_void_p),
        ("read", RlvStreamRead),
        ("write", RlvStreamWrite),
        ("length", RlvStreamLength),
        ("cut", RlvStreamCut),
        ("sync", RlvStreamSync),
        ("close", RlvStreamClose),
    ]


class RlvDocument(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvDocumentInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("is_open", c_uint32),
        ("undo_count", c_size_t),
        ("redo_count", c_size_t),
        ("bytes", c_uint64),
    ]


class RlvDocumentChanges(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("is_done", c_uint32),
        ("layer_count", c_size_t),
        ("block_count", c_size_t),
        ("bytes", c_uint64),
    ]


class RlvTransferOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("from", RlvMesh),
        ("reach", c_double),
    ]


class RlvTransferReport(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("layer_count", c_uint32),
        ("area", c_double),
        ("uncovered_area", c_double),
        ("edited_area", c_double),
        ("lost_area", c_double),
        ("reach", c_double),
    ]


class RlvLayerOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("kind", c_uint32),
        ("blend", c_uint32),
        ("is_visible", c_uint32),
        ("opacity", c_float),
        ("tile_size", c_uint32),
    ]


class RlvLayerInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("id", c_uint32),
        ("kind", c_uint32),
        ("blend", c_uint32),
        ("is_visible", c_uint32),
        ("is_active", c_uint32),
        ("opacity", c_float),
        ("reserved", c_uint32),
        ("tile_count", c_size_t),
        ("name", c_char * 256),
    ]


class RlvDecal(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvDecalPin(Structure):
    _fields_ = [
        ("image", c_double * 2),
        ("position", c_double * 3),
        ("depth", c_double),
    ]


class RlvDecalOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("can_overlap", c_uint32),
        ("outline", c_double_p),
        ("outline_count", c_size_t),
        ("outline_stride", c_size_t),
        ("pose_width", c_double),
        ("pose_up", c_double * 3),
        ("steps", c_uint32),
        ("decrease", c_float),
        ("triangles", c_uint32),
        ("cells", c_uint32),
    ]


class RlvDecalQuality(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("pin_count", c_uint32),
        ("triangle_count", c_size_t),
        ("flip_count", c_size_t),
        ("overlap_count", c_size_t),
        ("l2", c_double),
        ("l_infinity", c_double),
        ("worst_angle", c_double),
        ("area_ratio", c_double),
        ("coverage", c_double),
        ("doubled", c_double),
    ]


class RlvDecalImage(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("channels", c_uint32),
        ("pixels", c_float_p),
        ("pixel_count", c_size_t),
    ]


class RlvDecalInk(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("channel", c_uint32),
        ("blend", c_uint32),
        ("opacity", c_float),
        ("height", c_float),
        ("reserved", c_uint32),
    ]


class RlvDecalTexture(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("channels", c_uint32),
        ("gutter", c_uint32),
        ("reserved", c_uint32),
        ("pixels", c_float_p),
        ("pixel_count", c_size_t),
    ]


class RlvDecalReport(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("changed_tiles", c_uint64),
        ("texels", c_uint64),
        ("refused_tiles", c_uint64),
    ]


class RlvDecalRecipe(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("id", c_uint32),
        ("layer", c_uint32),
        ("pin_count", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("channel", c_uint32),
        ("blend", c_uint32),
        ("opacity", c_float),
        ("relief", c_float),
        ("image_hash", c_uint64),
    ]


class RlvDeviceCrowd(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvDeviceCrowdInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("agent_count", c_uint32),
        ("draw_count", c_uint32),
        ("matrix_count", c_uint32),
        ("weight_count", c_uint32),
        ("impostor_count", c_uint32),
        ("picture_count", c_uint32),
        ("hidden", c_uint32),
        ("hidden_triangles", c_uint64),
        ("occluder_triangles", c_uint64),
        ("hidden_clusters", c_uint32),
        ("reserved", c_uint32),
    ]


class RlvDeviceCrowdVulkan(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("queue_family", c_uint32),
        ("queue_index", c_uint32),
        ("reserved", c_uint32),
        ("instance", c_uint64),
        ("physical_device", c_uint64),
        ("device", c_uint64),
        ("queue", c_uint64),
        ("draws", c_uint64),
        ("clusters", c_uint64),
        ("instances", c_uint64),
        ("counts", c_uint64),
        ("matrices", c_uint64),
        ("weights", c_uint64),
        ("blends", c_uint64),
    ]


class RlvStroke(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvStrokePoint(Structure):
    _fields_ = [
        ("position", c_double * 3),
        ("pressure", c_double),
        ("time", c_double),
    ]


class RlvStrokeReport(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("dabs", c_uint64),
        ("missed_dabs", c_uint64),
        ("tested_tiles", c_uint64),
        ("tested_texels", c_uint64),
        ("changed_tiles", c_uint64),
        ("changed_texels", c_uint64),
        ("allocated_tiles", c_uint64),
        ("freed_tiles", c_uint64),
        ("refused_tiles", c_uint64),
        ("bytes", c_uint64),
    ]


class RlvLevel(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvLevelInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("undo_count", c_uint32),
        ("redo_count", c_uint32),
        ("reserved", c_uint32),
        ("vertex_count", c_size_t),
        ("triangle_count", c_size_t),
    ]


class RlvLevelView(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("eye", c_double * 3),
        ("pixels", c_double),
        ("tolerance", c_double),
        ("outline", c_double),
        ("planes", c_float_p),
        ("plane_count", c_size_t),
        ("plane_stride", c_size_t),
    ]


class RlvLevelRegion(Structure):
    _fields_ = [
        ("center", c_double * 3),
        ("radius", c_float),
        ("falloff", c_uint32),
    ]


class RlvLevelHandle(Structure):
    _fields_ = [
        ("region", RlvLevelRegion),
        ("translation", c_float * 3),
        ("axis", c_float * 3),
        ("angle", c_float),
        ("reserved", c_uint32),
    ]


class RlvLevelEdit(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("handles", POINTER(RlvLevelHandle)),
        ("handle_count", c_size_t),
        ("handle_stride", c_size_t),
        ("anchors", POINTER(RlvLevelRegion)),
        ("anchor_count", c_size_t),
        ("anchor_stride", c_size_t),
    ]


class RlvLevelKey(Structure):
    _fields_ = [
        ("time", c_double),
        ("translation", c_float * 3),
        ("axis", c_float * 3),
        ("angle", c_float),
        ("reserved", c_uint32),
    ]


class RlvLevelTrack(Structure):
    _fields_ = [
        ("region", RlvLevelRegion),
        ("keys", POINTER(RlvLevelKey)),
        ("key_count", c_size_t),
        ("key_stride", c_size_t),
    ]


class RlvLevelMotion(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("tracks", POINTER(RlvLevelTrack)),
        ("track_count", c_size_t),
        ("track_stride", c_size_t),
        ("anchors", POINTER(RlvLevelRegion)),
        ("anchor_count", c_size_t),
        ("anchor_stride", c_size_t),
    ]


class RlvLevelSculpted(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("dabs", c_uint64),
        ("missed_dabs", c_uint64),
        ("vertices", c_uint64),
    ]


class RlvLevelBuffers(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("is_whole", c_uint32),
        ("points", c_float_p),
        ("point_stride", c_size_t),
        ("normals", c_float_p),
        ("normal_stride", c_size_t),
        ("vertex_capacity", c_size_t),
        ("triangles", c_uint32_p),
        ("triangle_stride", c_size_t),
        ("triangle_capacity", c_size_t),
        ("wedges", c_uint32_p),
        ("wedge_stride", c_size_t),
        ("wedge_values", c_float_p),
        ("wedge_value_stride", c_size_t),
        ("wedge_capacity", c_size_t),
        ("face_values", c_uint32_p),
        ("face_value_stride", c_size_t),
    ]


class RlvLevelUpdate(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("vertex_count", c_size_t),
        ("triangle_count", c_size_t),
        ("first_vertex", c_size_t),
        ("changed_vertex_count", c_size_t),
        ("first_triangle", c_size_t),
        ("changed_triangle_count", c_size_t),
        ("wedge_count", c_size_t),
        ("first_wedge", c_size_t),
        ("changed_wedge_count", c_size_t),
    ]


class RlvLevelMisplaced(Structure):
    _fields_ = [
        ("point", c_float * 3),
        ("told", c_float),
        ("now", c_float),
    ]


class RlvDeviceLevel(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvDeviceLevelInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("undo_count", c_uint32),
        ("redo_count", c_uint32),
        ("reserved", c_uint32),
        ("vertex_count", c_size_t),
        ("triangle_count", c_size_t),
        ("wedge_count", c_size_t),
    ]


class RlvDeviceLevelVulkan(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("queue_family", c_uint32),
        ("queue_index", c_uint32),
        ("reserved", c_uint32),
        ("instance", c_uint64),
        ("physical_device", c_uint64),
        ("device", c_uint64),
        ("queue", c_uint64),
        ("vertices", c_uint64),
        ("triangles", c_uint64),
        ("arguments", c_uint64),
        ("wedges", c_uint64),
        ("wedge_values", c_uint64),
        ("face_values", c_uint64),
    ]


class RlvDiffuse(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvDiffuseOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("spacing", c_float),
        ("gravity", c_float * 3),
        ("has_bounds", c_uint32),
        ("low", c_double * 3),
        ("high", c_double * 3),
    ]


class RlvDiffuseSettings(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("air_min", c_float),
        ("air_max", c_float),
        ("crest_min", c_float),
        ("crest_max", c_float),
        ("energy_min", c_float),
        ("energy_max", c_float),
        ("air_rate", c_float),
        ("crest_rate", c_float),
        ("lifetime_min", c_float),
        ("lifetime_max", c_float),
        ("spray_below", c_uint32),
        ("bubbles_above", c_uint32),
        ("buoyancy", c_float),
        ("drag", c_float),
        ("steps", c_uint32),
        ("most", c_uint32),
        ("seed", c_uint32),
    ]


class RlvDiffuseFluid(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("count", c_size_t),
        ("positions", c_float_p),
        ("position_stride", c_size_t),
        ("velocities", c_float_p),
        ("velocity_stride", c_size_t),
    ]


class RlvDiffuseInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("count", c_size_t),
        ("frames", c_uint64),
        ("births", c_uint64),
    ]


class RlvDiffuseReport(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("born", c_uint64),
        ("gone", c_uint64),
        ("refused", c_uint64),
    ]


class RlvDiffusePotentials(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("capacity", c_size_t),
        ("air", c_float_p),
        ("crests", c_float_p),
        ("energies", c_float_p),
    ]


class RlvDiffuseArrays(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("capacity", c_size_t),
        ("positions", c_float_p),
        ("velocities", c_float_p),
        ("ids", c_uint32_p),
        ("kinds", c_uint32_p),
        ("ages", c_float_p),
        ("lifetimes", c_float_p),
        ("lives", c_float_p),
    ]


class RlvFluid(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvFluidOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("kernels", c_uint32),
        ("spacing", c_float),
        ("density", c_float),
        ("viscosity", c_float),
        ("friction", c_float),
        ("cohesion", c_float),
        ("gravity", c_float * 3),
        ("max_excess", c_float),
        ("mean_excess", c_float),
        ("min_corrections", c_uint32),
        ("max_corrections", c_uint32),
        ("steps", c_uint32),
        ("courant", c_float),
        ("step", c_float),
        ("solver", c_uint32),
        ("tension", c_float),
    ]


class RlvFluidInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("channel_count", c_uint32),
        ("particle_count", c_size_t),
        ("wall_count", c_size_t),
        ("seconds", c_double),
        ("mass", c_float),
        ("time_step", c_float),
        ("momentum", c_float * 3),
        ("kinetic_energy", c_float),
    ]


class RlvFluidParticles(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("lifetime", c_float),
        ("count", c_size_t),
        ("points", c_float_p),
        ("point_stride", c_size_t),
        ("velocities", c_float_p),
        ("velocity_stride", c_size_t),
        ("velocity", c_float * 3),
        ("reserved", c_uint32),
        ("channels", POINTER(RlvAttributeArrays)),
        ("channel_count", c_size_t),
        ("channel_stride", c_size_t),
    ]


class RlvFluidArrays(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("capacity", c_size_t),
        ("points", c_float_p),
        ("point_stride", c_size_t),
        ("velocities", c_float_p),
        ("velocity_stride", c_size_t),
        ("numbers", c_uint32_p),
        ("number_stride", c_size_t),
        ("pressures", c_float_p),
        ("pressure_stride", c_size_t),
        ("densities", c_float_p),
        ("density_stride", c_size_t),
        ("births", c_double_p),
        ("birth_stride", c_size_t),
    ]


class RlvFluidColliderOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("contact", c_uint32),
        ("friction", c_float),
        ("is_container", c_uint32),
    ]


class RlvFluidForce(Structure):
    _fields_ = [
        ("kind", c_uint32),
        ("seed", c_uint32),
        ("vector", c_float * 3),
        ("strength", c_float),
        ("place", c_double * 3),
        ("radius", c_float),
        ("rate", c_float),
    ]


class RlvFluidEmitterOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("shape", c_uint32),
        ("center", c_double * 3),
        ("u", c_float * 3),
        ("v", c_float * 3),
        ("radius", c_float),
        ("speed", c_float),
        ("lifetime", c_float),
        ("reserved", c_uint32),
        ("begin", c_double),
        ("end", c_double),
        ("channels", POINTER(RlvAttributeArrays)),
        ("channel_count", c_size_t),
        ("channel_stride", c_size_t),
    ]


class RlvFluidReport(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("seconds", c_double),
        ("steps", c_uint64),
        ("corrections", c_uint64),
        ("max_excess", c_float),
        ("mean_excess", c_float),
        ("gravity", c_double * 3),
        ("host", c_double * 3),
        ("forces", c_double * 3),
        ("walls", c_double * 3),
        ("added", c_uint64),
        ("removed", c_uint64),
        ("divergence_corrections", c_uint64),
    ]


class RlvFoam(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvFoamSettings(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("radius", c_float),
        ("near_depth", c_float),
        ("spray_n", c_float),
        ("spray_m", c_float),
        ("foam_n", c_float),
        ("foam_m", c_float),
        ("bubble_n", c_float),
        ("bubble_m", c_float),
        ("lifetime_n", c_float),
        ("lifetime_m", c_float),
        ("eta_max", c_float),
        ("eta_n", c_float),
        ("eta_m", c_float),
        ("rho_mod", c_float),
        ("rho_exp", c_float),
        ("ao_init_sr_fac", c_float),
        ("ao_sr_inc_fac", c_float),
        ("ao_passes", c_uint32),
        ("ao_s_dens", c_float),
        ("ao_min_samp", c_uint32),
        ("ao_max_samp", c_uint32),
        ("ao_max_occl_dist", c_float),
        ("ao_fluid_opacity", c_float),
        ("ao_solid_opacity", c_float),
        ("ao_hemisphere", c_uint32),
        ("ao_sh_scale", c_float),
        ("ao_sh_exp", c_float),
        ("ao_sh_offset", c_float),
        ("shadow_red", c_float),
        ("shadow_green", c_float),
        ("shadow_blue", c_float),
        ("irradiance_map", c_uint32),
        ("irr_scale", c_float),
        ("filter", c_float),
        ("aperture", c_float),
        ("focus", c_float),
        ("shutter", c_float),
        ("shutter_samples", c_uint32),
    ]


class RlvFoamView(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("reserved", c_uint32),
        ("eye", c_double * 3),
        ("target", c_double * 3),
        ("up", c_double * 3),
        ("fov", c_double),
        ("orthographic", c_double),
        ("solids", c_float_p),
        ("fluid", c_float_p),
    ]


class RlvFoamParticles(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("count", c_size_t),
        ("positions", c_float_p),
        ("position_stride", c_size_t),
        ("ids", c_uint32_p),
        ("id_stride", c_size_t),
        ("kinds", c_uint32_p),
        ("kind_stride", c_size_t),
        ("lives", c_float_p),
        ("life_stride", c_size_t),
        ("velocities", c_float_p),
        ("velocity_stride", c_size_t),
    ]


class RlvFoamLight(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("up", c_float * 3),
        ("radiance", c_float_p),
    ]


class RlvFoamLayers(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("intensity", c_float_p),
        ("thickness", c_float_p),
        ("depth", c_float_p),
        ("normal", c_float_p),
        ("occlusion", c_float_p),
        ("irradiance", c_float_p),
    ]


class RlvGrid(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvGridSettings(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("voxel", c_float),
        ("band", c_float),
        ("radius", c_float),
        ("value", c_float),
        ("adaptivity", c_float),
        ("distance", c_float),
        ("width", c_uint32),
        ("iterations", c_uint32),
    ]


class RlvGridInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("kind", c_uint32),
        ("grid_class", c_uint32),
        ("is_half", c_uint32),
        ("is_linear", c_uint32),
        ("is_empty", c_uint32),
        ("matrix", c_double * 12),
        ("voxel_size", c_double * 3),
        ("low", c_int32 * 3),
        ("high", c_int32 * 3),
        ("active_voxels", c_uint64),
        ("leaf_count", c_uint64),
        ("memory_bytes", c_uint64),
        ("name", c_char * 256),
    ]


class RlvImprintSettings(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("voxels", c_uint32),
        ("jitter", c_float),
        ("seed", c_uint32),
        ("max_displacement", c_float),
        ("share", c_float),
        ("depth_limit", c_float),
        ("smoothing", c_float),
        ("smoothing_passes", c_uint32),
        ("sub_steps", c_uint32),
        ("culling", c_uint32),
        ("compaction", c_uint32),
        ("rim", c_float),
        ("rim_width", c_float),
        ("repose", c_float),
    ]


class RlvImprintMoment(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("pair", c_uint32),
        ("frame", c_uint64),
        ("step", c_uint32),
        ("reserved", c_uint32),
    ]


class RlvImprintReport(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("steps", c_uint64),
        ("wanted_steps", c_uint64),
        ("tested_tiles", c_uint64),
        ("tested_coefficients", c_uint64),
        ("changed_tiles", c_uint64),
        ("changed_coefficients", c_uint64),
        ("allocated_tiles", c_uint64),
        ("refused_tiles", c_uint64),
        ("clamped_rays", c_uint64),
        ("triangles", c_uint64),
        ("bytes", c_uint64),
        ("voxel_diagonal", c_double),
        ("pushed_volume", c_double),
        ("raised_volume", c_double),
        ("open_edges", c_uint64),
    ]


class RlvPicture(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvPictureInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("format", c_uint32),
        ("image_count", c_uint32),
        ("face_count", c_uint32),
        ("tile_count", c_uint32),
        ("meta_count", c_uint32),
    ]


class RlvPictureImage(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("content", c_uint32),
        ("type", c_uint32),
        ("channels", c_uint32),
        ("alpha", c_uint32),
        ("width", c_uint32),
        ("height", c_uint32),
        ("level_count", c_uint32),
        ("face", c_uint32),
        ("columns", c_uint32),
        ("cell", c_uint32),
        ("side", c_uint32),
        ("gutter", c_uint32),
        ("is_layer", c_uint32),
        ("blend", c_uint32),
        ("is_visible", c_uint32),
        ("opacity", c_float),
        ("reserved", c_uint32),
        ("name", c_char * 264),
    ]


class RlvPictureMeta(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("type", c_uint32),
        ("count", c_size_t),
        ("name", c_char_p),
        ("values", c_void_p),
    ]


class RlvProcedural(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvProceduralOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("coarse", c_uint32),
        ("fine", c_uint32),
        ("reserved", c_uint32),
    ]


class RlvProceduralInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("primitive_count", c_uint32),
        ("time_step_count", c_uint32),
        ("step", c_float),
        ("cell_count", c_uint64),
        ("bytes", c_uint64),
        ("low", c_float * 3),
        ("high", c_float * 3),
    ]


RlvProceduralBounds = ctypes.CFUNCTYPE(None, c_void_p, c_uint32, c_uint32, c_float_p)

RlvProceduralIntersect = ctypes.CFUNCTYPE(None, c_void_p, c_int32_p, c_uint32, c_uint32, c_uint32, c_void_p, c_uint32)

RlvProceduralOccluded = ctypes.CFUNCTYPE(None, c_void_p, c_int32_p, c_uint32, c_void_p, c_uint32)


class RlvProceduralTable(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("primitive_count", c_uint32),
        ("time_step_count", c_uint32),
        ("reserved", c_uint32),
        ("data", c_void_p),
        ("tiles", c_uint32_p),
        ("bounds", RlvProceduralBounds),
        ("intersect", RlvProceduralIntersect),
        ("occluded", RlvProceduralOccluded),
    ]


class RlvProceduralHits(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("count", c_size_t),
        ("primitives", c_uint32_p),
        ("primitive_stride", c_size_t),
        ("uvs", c_float_p),
        ("uv_stride", c_size_t),
        ("times", c_float_p),
        ("time_stride", c_size_t),
        ("tiles", c_uint32_p),
        ("tile_stride", c_size_t),
        ("positions", c_float_p),
        ("position_stride", c_size_t),
        ("normals", c_float_p),
        ("normal_stride", c_size_t),
        ("colors", c_float_p),
        ("color_stride", c_size_t),
    ]


class RlvPtexOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("kind", c_uint32),
        ("budget", c_uint64),
    ]


class RlvPtexReport(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("channel", c_uint32),
        ("face_count", c_size_t),
        ("constant_count", c_size_t),
        ("squared_count", c_size_t),
        ("reduced_count", c_size_t),
        ("enlarged_count", c_size_t),
        ("ignored_numbers", c_size_t),
        ("deviation", c_float),
        ("reserved", c_uint32),
    ]


class RlvRepairSettings(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("weld", c_uint32),
        ("tolerance", c_float),
        ("degenerate", c_uint32),
        ("duplicates", c_uint32),
        ("orient", c_uint32),
        ("split", c_uint32),
        ("fill", c_uint32),
        ("hole_edges", c_uint32),
        ("hole_area", c_float),
        ("refine", c_uint32),
        ("fair", c_uint32),
        ("unused", c_uint32),
        ("listed", c_uint32),
    ]


class RlvRepairFinding(Structure):
    _fields_ = [
        ("count", c_size_t),
        ("first", c_uint32 * 16),
    ]


class RlvRepairTopology(Structure):
    _fields_ = [
        ("points", c_size_t),
        ("faces", c_size_t),
        ("edges", c_size_t),
        ("boundary_edges", c_size_t),
        ("boundary_loops", c_size_t),
        ("non_manifold_edges", c_size_t),
        ("components", c_size_t),
        ("closed_components", c_size_t),
        ("euler", c_int32),
        ("reserved", c_uint32),
        ("area", c_double),
        ("volume", c_double),
    ]


class RlvRepairReport(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("is_solid", c_uint32),
        ("invalid_faces", RlvRepairFinding),
        ("coincident_points", RlvRepairFinding),
        ("unused_points", RlvRepairFinding),
        ("degenerate_faces", RlvRepairFinding),
        ("flat_faces", RlvRepairFinding),
        ("duplicate_faces", RlvRepairFinding),
        ("non_manifold_edges", RlvRepairFinding),
        ("non_manifold_points", RlvRepairFinding),
        ("misoriented_edges", RlvRepairFinding),
        ("one_sided_edges", RlvRepairFinding),
        ("inverted_components", RlvRepairFinding),
        ("holes", RlvRepairFinding),
        ("open_holes", RlvRepairFinding),
        ("before", RlvRepairTopology),
        ("after", RlvRepairTopology),
        ("turned_faces", c_size_t),
        ("split_points", c_size_t),
        ("filled_holes", c_size_t),
        ("filling_points", c_size_t),
        ("filling_faces", c_size_t),
        ("seam_attributes", c_size_t),
    ]


class RlvTissue(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvTissueSimulation(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvTissueMaterial(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("density", c_float),
        ("name", c_char_p),
        ("library", c_char_p),
        ("young", c_float),
        ("poisson", c_float),
    ]


class RlvTissueVolume(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("level", c_uint32),
        ("name", c_char_p),
        ("mesh", RlvMesh),
        ("material", c_uint32),
        ("has_layers", c_uint32),
        ("is_muscle", c_uint32),
        ("stiffness", c_float),
        ("strength", c_float),
        ("ring_size", c_uint32),
        ("direction", c_double * 3),
        ("rings", c_double_p),
        ("ring_count", c_size_t),
    ]


class RlvTissueLayer(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("material", c_uint32),
        ("start", c_float),
        ("thickness", c_float),
    ]


class RlvTissueSurface(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("purpose", c_uint32),
        ("name", c_char_p),
        ("mesh", RlvMesh),
        ("is_internal", c_uint32),
        ("angle", c_float),
    ]


class RlvTissueDescription(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("samples", c_uint32),
        ("cell", c_float * 3),
        ("share", c_float),
        ("materials", POINTER(RlvTissueMaterial)),
        ("material_count", c_size_t),
        ("material_stride", c_size_t),
        ("volumes", POINTER(RlvTissueVolume)),
        ("volume_count", c_size_t),
        ("volume_stride", c_size_t),
        ("surfaces", POINTER(RlvTissueSurface)),
        ("surface_count", c_size_t),
        ("surface_stride", c_size_t),
        ("skin", RlvMesh),
        ("layers", POINTER(RlvTissueLayer)),
        ("layer_count", c_size_t),
        ("layer_stride", c_size_t),
        ("epidermis_material", c_uint32),
        ("epidermis_thickness", c_float),
        ("bend", c_double * 2),
    ]


class RlvTissueLabel(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("material", c_uint32),
        ("low", c_float),
        ("high", c_float),
    ]


class RlvTissueLabels(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("block", c_uint32),
        ("share", c_float),
        ("reserved", c_uint32),
        ("materials", POINTER(RlvTissueMaterial)),
        ("material_count", c_size_t),
        ("material_stride", c_size_t),
        ("labels", POINTER(RlvTissueLabel)),
        ("label_count", c_size_t),
        ("label_stride", c_size_t),
    ]


class RlvTissueReport(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("voxels", c_uint32 * 3),
        ("volume", c_double),
    ]


class RlvTissueInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("has_cells", c_uint32),
        ("node_count", c_size_t),
        ("element_count", c_size_t),
        ("cell", c_float * 3),
        ("low", c_float * 3),
        ("high", c_float * 3),
        ("material_count", c_uint32),
        ("muscle_count", c_uint32),
        ("set_count", c_uint32),
        ("bound_count", c_uint32),
        ("checksum", c_uint32),
    ]


class RlvTissueMuscle(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("stiffness", c_float),
        ("strength", c_float),
        ("name", c_char * 48),
    ]


class RlvTissueSet(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("count", c_size_t),
        ("name", c_char * 48),
    ]


class RlvTissueOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("halvings", c_uint32),
        ("gravity", c_float * 3),
        ("damping", c_float),
        ("step", c_float),
        ("safety", c_float),
        ("hourglass", c_float),
        ("mass_scaling", c_float),
        ("self_friction", c_float),
    ]


class RlvTissueSimulationInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("stiffest_element", c_uint32),
        ("step", c_float),
        ("stable_step", c_float),
        ("added_mass", c_float),
        ("reserved", c_uint32),
        ("steps", c_uint64),
        ("seconds", c_double),
        ("halved", c_uint64),
    ]


class RlvTissueEnergies(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("kinetic", c_double),
        ("elastic", c_double),
        ("potential", c_double),
    ]


class RlvTissueRelaxation(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("is_at_rest", c_uint32),
        ("steps", c_uint64),
        ("unbalanced", c_float),
        ("largest", c_float),
    ]


class RlvTissueCollider(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("body", c_uint32),
        ("mesh", RlvMesh),
        ("radius", c_float),
        ("friction", c_float),
        ("times", c_double_p),
        ("translations", c_float_p),
        ("rotations", c_float_p),
        ("key_count", c_size_t),
    ]


class RlvTissueArrays(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("node_count", c_size_t),
        ("positions", c_float_p),
        ("velocities", c_float_p),
        ("element_count", c_size_t),
        ("stresses", c_float_p),
        ("principal_stresses", c_float_p),
        ("von_mises", c_float_p),
        ("volumes", c_float_p),
        ("fibre_stretches", c_float_p),
        ("strains", c_float_p),
        ("principal_strains", c_float_p),
        ("contact_pressures", c_float_p),
    ]


class RlvJob(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvJobInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("state", c_uint32),
        ("result", RlvResult),
        ("fraction", c_float),
        ("stage", c_char * 48),
        ("kind", c_uint32),
    ]


RlvJobDone = ctypes.CFUNCTYPE(None, c_void_p)


class RlvObjectInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("is_busy", c_uint32),
        ("noun", c_char * 48),
        ("worker", c_char * 48),
    ]


class RlvShader(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvShaderOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("language", c_uint32),
        ("stage", c_uint32),
        ("reserved", c_uint32),
        ("name", c_char_p),
    ]


class RlvShaderVariable(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("components", c_uint32),
        ("declared", c_uint32),
        ("is_initialized", c_uint32),
        ("line", c_uint32),
        ("column", c_uint32),
        ("scope_start", c_uint64),
        ("scope_end", c_uint64),
        ("name", c_char * 48),
        ("label", c_char * 48),
        ("function", c_char * 48),
        ("description", c_char * 256),
    ]


class RlvShaderLayout(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("group", c_uint32),
        ("examples_binding", c_uint32),
        ("log_binding", c_uint32),
        ("feature_count", c_uint32),
        ("accumulation", c_uint32),
        ("site_count", c_uint32),
        ("uses_confidence", c_uint32),
        ("examples_head", c_uint32),
        ("log_head", c_uint32),
    ]


class RlvShaderFeature(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("name", c_char * 256),
        ("expression", c_char * 256),
        ("description", c_char * 256),
    ]


class RlvShaderExamples(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("feature_count", c_uint32),
        ("count", c_size_t),
        ("classes", c_uint32_p),
        ("class_stride", c_size_t),
        ("vectors", c_float_p),
        ("vector_stride", c_size_t),
        ("exponent", c_float),
        ("is_scaled", c_uint32),
    ]


class RlvSubdivision(Structure):
    _fields_ = [
        ("id", c_uint64),
    ]


class RlvSubdivisionOptions(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("scheme", c_uint32),
        ("boundary", c_uint32),
        ("face_varying", c_uint32),
        ("creasing", c_uint32),
        ("triangle_rule", c_uint32),
        ("isolation", c_uint32),
        ("reserved", c_uint32),
    ]


class RlvSubdivisionInfo(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("scheme", c_uint32),
        ("point_count", c_size_t),
        ("face_count", c_size_t),
        ("tile_count", c_size_t),
    ]


class RlvSubdivisionArrays(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("point_rule", c_uint32),
        ("count", c_size_t),
        ("tiles", c_uint32_p),
        ("tile_stride", c_size_t),
        ("uvs", c_float_p),
        ("uv_stride", c_size_t),
        ("values", c_float_p),
        ("value_stride", c_size_t),
        ("du", c_float_p),
        ("du_stride", c_size_t),
        ("dv", c_float_p),
        ("dv_stride", c_size_t),
        ("duu", c_float_p),
        ("duu_stride", c_size_t),
        ("duv", c_float_p),
        ("duv_stride", c_size_t),
        ("dvv", c_float_p),
        ("dvv_stride", c_size_t),
    ]


RlvVulkanLoader = ctypes.CFUNCTYPE(c_void_p, c_void_p, c_char_p)

RlvVulkanNotice = ctypes.CFUNCTYPE(None, c_void_p)


class RlvVulkanDevice(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("api_version", c_uint32),
        ("queue_family", c_uint32),
        ("queue_index", c_uint32),
        ("instance", c_uint64),
        ("physical_device", c_uint64),
        ("device", c_uint64),
        ("loader", RlvVulkanLoader),
        ("features", c_void_p),
        ("lock", RlvVulkanNotice),
        ("unlock", RlvVulkanNotice),
        ("released", RlvVulkanNotice),
        ("user", c_void_p),
    ]


class RlvVulkanBuffers(Structure):
    _fields_ = [
        ("struct_size", c_uint32),
        ("reserved", c_uint32),
        ("points", c_uint64),
        ("point_bytes", c_uint64),
        ("triangles", c_uint64),
        ("triangle_bytes", c_uint64),
    ]


INIT = {
    RlvError: (ctypes.sizeof(RlvError), 0, None, None, None, None, 0, 0, 0,),
    RlvContextOptions: (ctypes.sizeof(RlvContextOptions), 0, 0, 0, 0, 0, None, (0,), None, None, None,),
    RlvContextInfo: (ctypes.sizeof(RlvContextInfo), 0, 0, 0, 0, (0,), 0, 0, (0,), (0,),),
    RlvAllocator: (ctypes.sizeof(RlvAllocator), 0, None, None, None,),
    RlvAllocatorInfo: (ctypes.sizeof(RlvAllocatorInfo), 0, 0, 0,),
    RlvMeshArrays: (ctypes.sizeof(RlvMeshArrays), 0, None, 0, 0, None, 0, 0, None, 0, 0, None, None, 0, 0, 0, None, None, 0, 0, 0, None, 0, 0,),
    RlvMeshInfo: (ctypes.sizeof(RlvMeshInfo), 0, 0, 0, 0, 0, 0, 0, 0, (0,), (0,),),
    RlvAttributeArrays: (ctypes.sizeof(RlvAttributeArrays), 0, 0, 0, None, None, 0, 0, None, 0, 0,),
    RlvAttributeInfo: (ctypes.sizeof(RlvAttributeInfo), 0, 0, 0, 0, 0, (0,),),
    RlvSimplifyOptions: (ctypes.sizeof(RlvSimplifyOptions), -1.0, 0, None, 0, 0, None, 0, 0, None, 0, 0, -1.0, 0,),
    RlvProgressiveOptions: (ctypes.sizeof(RlvProgressiveOptions), 0, 100, None, 0, 0, None, 0, 0,),
    RlvProgressiveInfo: (ctypes.sizeof(RlvProgressiveInfo), 0, 0, 0, 0, 0, 0, 0, 0, 0,),
    RlvArrivalInfo: (ctypes.sizeof(RlvArrivalInfo), 0, 0,),
    RlvSurfaceOptions: (ctypes.sizeof(RlvSurfaceOptions), 0, 0, 0, 0, 0,),
    RlvSurfaceInfo: (ctypes.sizeof(RlvSurfaceInfo), 0, 0, 0, 0, 0, 0, (0,), (0,), 0, 0,),
    RlvTileInfo: (ctypes.sizeof(RlvTileInfo), 0, 0, 0, 0, (0,), (0,),),
    RlvDetailOptions: (ctypes.sizeof(RlvDetailOptions), 0, 0, None, 0, 0,),
    RlvDetailInfo: (ctypes.sizeof(RlvDetailInfo), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.0, 0,),
    RlvChannelInfo: (ctypes.sizeof(RlvChannelInfo), 0, 0, 0, 0, 0, 0, 0,),
    RlvDetailFolds: (ctypes.sizeof(RlvDetailFolds), 0, 0, 0,),
    RlvPaintOptions: (ctypes.sizeof(RlvPaintOptions), 0, 0, (1.0, 1.0, 1.0, 1.0,), 0, 0,),
    RlvVectorOptions: (ctypes.sizeof(RlvVectorOptions), 0, 0,),
    RlvDecayOptions: (ctypes.sizeof(RlvDecayOptions), 0.0, 10.0, 0, 0,),
    RlvDetailChanges: (ctypes.sizeof(RlvDetailChanges), 0, 0, 0, (0,), (0,),),
    RlvDetailTileInfo: (ctypes.sizeof(RlvDetailTileInfo), 0, 0, 0, 0, 0, (0,), (0,),),
    RlvBakeOptions: (ctypes.sizeof(RlvBakeOptions), 0, 2048, 2048, 0, 16, 1, 0, 0, 0, 0.0, 0.0, None,),
    RlvBakeReport: (ctypes.sizeof(RlvBakeReport), 0, 0, 0, 0, 0, 0, 0.0, 0.0,),
    RlvEvaluateArrays: (ctypes.sizeof(RlvEvaluateArrays), 0, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0,),
    RlvBezierArrays: (ctypes.sizeof(RlvBezierArrays), 0, None, 0, 0, None, 0, None, 0, 0,),
    RlvBezierInfo: (ctypes.sizeof(RlvBezierInfo), 0, 0, 0, (0,), (0,),),
    RlvBezierView: (ctypes.sizeof(RlvBezierView), 8, (0.0,), (0.0, 0.0, -1.0,), 1000.0, 1.0, 0.5,),
    RlvBezierLevels: (ctypes.sizeof(RlvBezierLevels), 4, None, 0, 0,),
    RlvBezierTriangles: (ctypes.sizeof(RlvBezierTriangles), 0, None, 0, None, 0, 0, None, 0, 0,),
    RlvBrushOptions: (ctypes.sizeof(RlvBrushOptions), 0, 0, 2, (1.0, 1.0, 1.0, 1.0,), 0.1, 0,),
    RlvBrushSettings: (ctypes.sizeof(RlvBrushSettings), 0.1, 1.0, 0.25, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0, 0.0, 0.0, 0, 0, 0, 2.0, 0,),
    RlvStampOptions: (ctypes.sizeof(RlvStampOptions), 0, 0, 0, 0, 0, None,),
    RlvStampSettings: (ctypes.sizeof(RlvStampSettings), 0.0, 1.0, 0, 0, 0.5, 2.0,),
    RlvTessellateOptions: (ctypes.sizeof(RlvTessellateOptions), 0, 0, 0, 0, 0,),
    RlvTessellationInfo: (ctypes.sizeof(RlvTessellationInfo), 0, 0, 0, 0,),
    RlvTessellationChanges: (ctypes.sizeof(RlvTessellationChanges), 0, 0, 0, (0,), (0,),),
    RlvBufferInfo: (ctypes.sizeof(RlvBufferInfo), 0, 0, 0, 0, 0,),
    RlvBufferVulkan: (ctypes.sizeof(RlvBufferVulkan), 0, 0, 0, 0, 0, 0, 0, 0, 0,),
    RlvCapability: (ctypes.sizeof(RlvCapability), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, (0,),),
    RlvRayArrays: (ctypes.sizeof(RlvRayArrays), 0, 0, None, 0, None, 0, None, 0, 0, 0, None, 0, None, 0, None, 0, None, 0,),
    RlvIsosurfaceOptions: (ctypes.sizeof(RlvIsosurfaceOptions), 1, 0.01, 0.0, 8.0, 0.6, 0.9, 0.0, 0.0, 12.0,),
    RlvIsosurfaceParticles: (ctypes.sizeof(RlvIsosurfaceParticles), 0, 0, None, 0, None, 0, None, 0,),
    RlvIsosurfaceInfo: (ctypes.sizeof(RlvIsosurfaceInfo), 0, 0, 0.0, 0.0, 0.0, 0.0,),
    RlvIsosurfaceMeshOptions: (ctypes.sizeof(RlvIsosurfaceMeshOptions), 0, 0.0, 0.5, 0.53, 0, None, 0, 0,),
    RlvIsosurfaceClasses: (ctypes.sizeof(RlvIsosurfaceClasses), 0, 0, 0, 0, 0.0,),
    RlvIsosurfaceTable: (ctypes.sizeof(RlvIsosurfaceTable), 0, None, None, (0,), (0,),),
    RlvParticlesArrays: (ctypes.sizeof(RlvParticlesArrays), 0, 0.0, 0.0, 0, 0, None, 0, None, 0, None, 0, 0,),
    RlvParticlesInfo: (ctypes.sizeof(RlvParticlesInfo), 0, 0, 0, 0, 0.0, 0.0, 0,),
    RlvClientOptions: (ctypes.sizeof(RlvClientOptions), 0, None, None, None, 60.0, 30.0,),
    RlvClientStatus: (ctypes.sizeof(RlvClientStatus), 0, 0, 0, 0, -1.0, 0.0, 0, (0,),),
    RlvClientInfo: (ctypes.sizeof(RlvClientInfo), (0, 0,), 0, (0,), (0,), (0,),),
    RlvClientScene: (ctypes.sizeof(RlvClientScene), 0, None, None, None, None, 0,),
    RlvClientFetch: (ctypes.sizeof(RlvClientFetch), 0, 0, 0, None,),
    RlvColliderInfo: (ctypes.sizeof(RlvColliderInfo), 0, 0, 0, (0,), 0,),
    RlvToolSettings: (ctypes.sizeof(RlvToolSettings), 1.0, 1.0,),
    RlvColorBufferInfo: (ctypes.sizeof(RlvColorBufferInfo), 0, 0, 0, 0, 0, 0, 0, (0,),),
    RlvColorBufferVulkan: (ctypes.sizeof(RlvColorBufferVulkan), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,),
    RlvCrowdBuildSettings: (ctypes.sizeof(RlvCrowdBuildSettings), 0.15, 100, 16, 30.0,),
    RlvCrowdRefitReport: (ctypes.sizeof(RlvCrowdRefitReport), 0, 0.0, 0, 0,),
    RlvCrowdModelInfo: (ctypes.sizeof(RlvCrowdModelInfo), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.0, 0, 0, (0.0,), (0.0,), 0, 0, 0, 0,),
    RlvCrowdClip: (ctypes.sizeof(RlvCrowdClip), 0, 0.0, (0,),),
    RlvCrowdMaterial: (ctypes.sizeof(RlvCrowdMaterial), (0,),),
    RlvCrowdVertices: (ctypes.sizeof(RlvCrowdVertices), 0, 0, None, None, None, None, None,),
    RlvCrowdView: (ctypes.sizeof(RlvCrowdView), 0, 0, 0.5, (0.0,), (0.0, 0.0, -1.0,), (0.0, 1.0, 0.0,), 0.6, 0.0, 0, 0, 0, 0, None, 0, 0.0,),
    RlvCrowdFrame: (ctypes.sizeof(RlvCrowdFrame), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,),
    RlvCrowdBuffers: (ctypes.sizeof(RlvCrowdBuffers), 0, None, 0, 0, None, None, 0, 0, None, 0, 0, None, 0, None, None, None,),
    RlvCrowdImpostors: (ctypes.sizeof(RlvCrowdImpostors), 0, None, 0, 0, None, 0, 0, None, 0,),
    RlvCrowdStreamSettings: (ctypes.sizeof(RlvCrowdStreamSettings), 1024, 67108864,),
    RlvCrowdStreamInfo: (ctypes.sizeof(RlvCrowdStreamInfo), 0, 0, 0, 0, 0, 0, 0, 0,),
    RlvStream: (ctypes.sizeof(RlvStream), 0, None, None, None, None, None, None, None,),
    RlvDocumentInfo: (ctypes.sizeof(RlvDocumentInfo), 0, 0, 0, 0,),
    RlvDocumentChanges: (ctypes.sizeof(RlvDocumentChanges), 0, 0, 0, 0,),
    RlvTransferOptions: (ctypes.sizeof(RlvTransferOptions), 0, (0,), 0.0,),
    RlvTransferReport: (ctypes.sizeof(RlvTransferReport), 0, 0.0, 0.0, 0.0, 0.0, 0.0,),
    RlvLayerOptions: (ctypes.sizeof(RlvLayerOptions), 0, 1, 1, 1.0, 0,),
    RlvLayerInfo: (ctypes.sizeof(RlvLayerInfo), 0, 0, 0, 0, 0, 0.0, 0, 0, (0,),),
    RlvDecalOptions: (ctypes.sizeof(RlvDecalOptions), 0, 0, 0, None, 0, 0, 0.0, (0.0, 1.0, 0.0,), 30, 0.0001, 4000000, 8,),
    RlvDecalQuality: (ctypes.sizeof(RlvDecalQuality), 0, 0, 0, 0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,),
    RlvDecalImage: (ctypes.sizeof(RlvDecalImage), 4, None, 0,),
    RlvDecalInk: (ctypes.sizeof(RlvDecalInk), 1, 0, 1.0, 0.0, 0,),
    RlvDecalTexture: (ctypes.sizeof(RlvDecalTexture), 0, 0, 3, 8, 0, None, 0,),
    RlvDecalReport: (ctypes.sizeof(RlvDecalReport), 0, 0, 0, 0,),
    RlvDecalRecipe: (ctypes.sizeof(RlvDecalRecipe), 0, 0, 0, 0, 0, 0, 0, 0.0, 0.0, 0,),
    RlvDeviceCrowdInfo: (ctypes.sizeof(RlvDeviceCrowdInfo), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,),
    RlvDeviceCrowdVulkan: (ctypes.sizeof(RlvDeviceCrowdVulkan), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,),
    RlvStrokeReport: (ctypes.sizeof(RlvStrokeReport), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,),
    RlvLevelInfo: (ctypes.sizeof(RlvLevelInfo), 0, 0, 0, 0, 0,),
    RlvLevelView: (ctypes.sizeof(RlvLevelView), 0, (0.0,), 1000.0, 1.0, 1.0, None, 0, 0,),
    RlvLevelEdit: (ctypes.sizeof(RlvLevelEdit), 0, None, 0, 0, None, 0, 0,),
    RlvLevelMotion: (ctypes.sizeof(RlvLevelMotion), 0, None, 0, 0, None, 0, 0,),
    RlvLevelSculpted: (ctypes.sizeof(RlvLevelSculpted), 0, 0, 0, 0,),
    RlvLevelBuffers: (ctypes.sizeof(RlvLevelBuffers), 0, None, 0, None, 0, 0, None, 0, 0, None, 0, None, 0, 0, None, 0,),
    RlvLevelUpdate: (ctypes.sizeof(RlvLevelUpdate), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,),
    RlvDeviceLevelInfo: (ctypes.sizeof(RlvDeviceLevelInfo), 0, 0, 0, 0, 0, 0,),
    RlvDeviceLevelVulkan: (ctypes.sizeof(RlvDeviceLevelVulkan), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,),
    RlvDiffuseOptions: (ctypes.sizeof(RlvDiffuseOptions), 0.02, (0.0, 0.0, -9.81,), 0, (0.0, 0.0, 0.0,), (0.0, 0.0, 0.0,),),
    RlvDiffuseSettings: (ctypes.sizeof(RlvDiffuseSettings), 5.0, 20.0, 2.0, 8.0, 5.0, 50.0, 4000.0, 4000.0, 2.0, 5.0, 6, 20, 2.0, 0.8, 2, 100000000, 1,),
    RlvDiffuseFluid: (ctypes.sizeof(RlvDiffuseFluid), 0, 0, None, 0, None, 0,),
    RlvDiffuseInfo: (ctypes.sizeof(RlvDiffuseInfo), 0, 0, 0, 0,),
    RlvDiffuseReport: (ctypes.sizeof(RlvDiffuseReport), 0, 0, 0, 0,),
    RlvDiffusePotentials: (ctypes.sizeof(RlvDiffusePotentials), 0, 0, None, None, None,),
    RlvDiffuseArrays: (ctypes.sizeof(RlvDiffuseArrays), 0, 0, None, None, None, None, None, None, None,),
    RlvFluidOptions: (ctypes.sizeof(RlvFluidOptions), 0, 0.02, 1000.0, 0.001, 0.001, 0.0, (0.0, 0.0, -9.81,), 0.01, 0.001, 3, 100, 0, 0.4, 0.005, 0, 0.0,),
    RlvFluidInfo: (ctypes.sizeof(RlvFluidInfo), 0, 0, 0, 0.0, 0.0, 0.0, (0.0, 0.0, 0.0,), 0.0,),
    RlvFluidParticles: (ctypes.sizeof(RlvFluidParticles), 0.0, 0, None, 0, None, 0, (0.0, 0.0, 0.0,), 0, None, 0, 0,),
    RlvFluidArrays: (ctypes.sizeof(RlvFluidArrays), 0, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0,),
    RlvFluidColliderOptions: (ctypes.sizeof(RlvFluidColliderOptions), 0, 0.0, 0,),
    RlvFluidEmitterOptions: (ctypes.sizeof(RlvFluidEmitterOptions), 0, (0.0, 0.0, 0.0,), (0.0, 0.0, 1.0,), (0.0, 0.0, 0.0,), 0.1, 1.0, 0.0, 0, 0.0, 0.0, None, 0, 0,),
    RlvFluidReport: (ctypes.sizeof(RlvFluidReport), 0, 0.0, 0, 0, 0.0, 0.0, (0.0, 0.0, 0.0,), (0.0, 0.0, 0.0,), (0.0, 0.0, 0.0,), (0.0, 0.0, 0.0,), 0, 0, 0,),
    RlvFoamSettings: (ctypes.sizeof(RlvFoamSettings), 0.01, 0.05, 1.5, 1.0, 2.25, 1.0, 2.0, 1.0, 2.0, 0.4, 0.5, 1.0, 2.0, 3.0, 1.25, 1.0, 7.0, 3, 0.5, 16, 512, 5.0, 0.5, 1.0, 1, 1.0, 1.5, -0.05, 0.0, 0.0, 0.2, 1, 1.0, 1.5, 0.0, 10.0, 0.0, 8,),
    RlvFoamView: (ctypes.sizeof(RlvFoamView), 0, 0, 0, (0, 0, 0,), (0, 0, 0,), (0, 0, 1,), 0.6, 0, None, None,),
    RlvFoamParticles: (ctypes.sizeof(RlvFoamParticles), 0, 0, None, 0, None, 0, None, 0, None, 0, None, 0,),
    RlvFoamLight: (ctypes.sizeof(RlvFoamLight), 0, 0, (0, 0, 1,), None,),
    RlvFoamLayers: (ctypes.sizeof(RlvFoamLayers), 0, None, None, None, None, None, None,),
    RlvGridSettings: (ctypes.sizeof(RlvGridSettings), 0.1, 3.0, 0.0, 0.0, 0.0, 0.0, 1, 1,),
    RlvGridInfo: (ctypes.sizeof(RlvGridInfo), 0, 0, 0, 0, 0, (0,), (0,), (0,), (0,), 0, 0, 0, (0,),),
    RlvImprintSettings: (ctypes.sizeof(RlvImprintSettings), 16777216, 0.09817477, 0, 1.0, 1.0, 60000.0, 0.0, 1, 256, 1, 1, 0.0, 0.1, 0.6,),
    RlvImprintMoment: (ctypes.sizeof(RlvImprintMoment), 0, 0, 0, 0,),
    RlvImprintReport: (ctypes.sizeof(RlvImprintReport), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0,),
    RlvPictureInfo: (ctypes.sizeof(RlvPictureInfo), 0, 0, 0, 0, 0,),
    RlvPictureImage: (ctypes.sizeof(RlvPictureImage), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1.0, 0, (0,),),
    RlvPictureMeta: (ctypes.sizeof(RlvPictureMeta), 0, 0, None, None,),
    RlvProceduralOptions: (ctypes.sizeof(RlvProceduralOptions), 0, 0, 0,),
    RlvProceduralInfo: (ctypes.sizeof(RlvProceduralInfo), 0, 0, 0.0, 0, 0, (0,), (0,),),
    RlvProceduralTable: (ctypes.sizeof(RlvProceduralTable), 0, 0, 0, None, None, None, None, None,),
    RlvProceduralHits: (ctypes.sizeof(RlvProceduralHits), 0, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0,),
    RlvPtexOptions: (ctypes.sizeof(RlvPtexOptions), 0, 0,),
    RlvPtexReport: (ctypes.sizeof(RlvPtexReport), 0, 0, 0, 0, 0, 0, 0, 0.0, 0,),
    RlvRepairSettings: (ctypes.sizeof(RlvRepairSettings), 1, 0.0, 1, 1, 1, 1, 1, 0, 0.75, 1, 1, 1, 8,),
    RlvRepairReport: (ctypes.sizeof(RlvRepairReport), 0, (0, (0,),), (0, (0,),), (0, (0,),), (0, (0,),), (0, (0,),), (0, (0,),), (0, (0,),), (0, (0,),), (0, (0,),), (0, (0,),), (0, (0,),), (0, (0,),), (0, (0,),), (0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.0, 0.0,), (0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.0, 0.0,), 0, 0, 0, 0, 0, 0,),
    RlvTissueMaterial: (ctypes.sizeof(RlvTissueMaterial), 0, None, None, 0, 0.49,),
    RlvTissueVolume: (ctypes.sizeof(RlvTissueVolume), 0, None, (0,), 0, 0, 0, 0, 0, 0, (0, 0, 0,), None, 0,),
    RlvTissueLayer: (ctypes.sizeof(RlvTissueLayer), 0, 0, 0,),
    RlvTissueSurface: (ctypes.sizeof(RlvTissueSurface), 0, None, (0,), 0, 1.55334303,),
    RlvTissueDescription: (ctypes.sizeof(RlvTissueDescription), 4, (0, 0, 0,), 0.5, None, 0, 0, None, 0, 0, None, 0, 0, (0,), None, 0, 0, 0, 0, (0, 0,),),
    RlvTissueLabel: (ctypes.sizeof(RlvTissueLabel), 0, 0, 0,),
    RlvTissueLabels: (ctypes.sizeof(RlvTissueLabels), 1, 0.5, 0, None, 0, 0, None, 0, 0,),
    RlvTissueReport: (ctypes.sizeof(RlvTissueReport), (0, 0, 0,), 0,),
    RlvTissueInfo: (ctypes.sizeof(RlvTissueInfo), 0, 0, 0, (0, 0, 0,), (0, 0, 0,), (0, 0, 0,), 0, 0, 0, 0, 0,),
    RlvTissueMuscle: (ctypes.sizeof(RlvTissueMuscle), 0, 0, 0, (0,),),
    RlvTissueSet: (ctypes.sizeof(RlvTissueSet), 0, 0, (0,),),
    RlvTissueOptions: (ctypes.sizeof(RlvTissueOptions), 0, (0, 0, -9.81,), 0, 0, 0.7, 1, 0, -1,),
    RlvTissueSimulationInfo: (ctypes.sizeof(RlvTissueSimulationInfo), 0, 0, 0, 0, 0, 0, 0, 0,),
    RlvTissueEnergies: (ctypes.sizeof(RlvTissueEnergies), 0, 0, 0, 0,),
    RlvTissueRelaxation: (ctypes.sizeof(RlvTissueRelaxation), 0, 0, 0, 0,),
    RlvTissueCollider: (ctypes.sizeof(RlvTissueCollider), 0, (0,), 0, 0, None, None, None, 0,),
    RlvTissueArrays: (ctypes.sizeof(RlvTissueArrays), 0, 0, None, None, 0, None, None, None, None, None, None, None, None,),
    RlvJobInfo: (ctypes.sizeof(RlvJobInfo), 0, 0, 0.0, (0,), 0,),
    RlvObjectInfo: (ctypes.sizeof(RlvObjectInfo), 0, (0,), (0,),),
    RlvShaderOptions: (ctypes.sizeof(RlvShaderOptions), 0, 1, 0, None,),
    RlvShaderVariable: (ctypes.sizeof(RlvShaderVariable), 0, 0, 0, 0, 0, 0, 0, (0,), (0,), (0,), (0,),),
    RlvShaderLayout: (ctypes.sizeof(RlvShaderLayout), 0, 0, 0, 0, 0, 0, 0, 0, 0,),
    RlvShaderFeature: (ctypes.sizeof(RlvShaderFeature), 0, (0,), (0,), (0,),),
    RlvShaderExamples: (ctypes.sizeof(RlvShaderExamples), 0, 0, None, 0, None, 0, 2.0, 0,),
    RlvSubdivisionOptions: (ctypes.sizeof(RlvSubdivisionOptions), 0, 0, 1, 0, 0, 0, 0,),
    RlvSubdivisionInfo: (ctypes.sizeof(RlvSubdivisionInfo), 0, 0, 0, 0,),
    RlvSubdivisionArrays: (ctypes.sizeof(RlvSubdivisionArrays), 0, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0, None, 0,),
    RlvVulkanDevice: (ctypes.sizeof(RlvVulkanDevice), 0, 0, 0, 0, 0, 0, None, None, None, None, None, None,),
    RlvVulkanBuffers: (ctypes.sizeof(RlvVulkanBuffers), 0, 0, 0, 0, 0,),
}

# Every function: what it returns, and the names and types of what it takes.
FUNCTIONS = {
    "rlv_version": (c_uint32, []),
    "rlv_error_last": (c_char_p, []),
    "rlv_error_get": (RlvResult, [("out", POINTER(RlvError))]),
    "rlv_context_create": (RlvResult, [("options", POINTER(RlvContextOptions)), ("out", POINTER(RlvContext))]),
    "rlv_context_retain": (RlvResult, [("context", RlvContext)]),
    "rlv_context_release": (RlvResult, [("context", RlvContext)]),
    "rlv_context_info": (RlvResult, [("context", RlvContext), ("out", POINTER(RlvContextInfo))]),
    "rlv_context_close_device": (RlvResult, [("context", RlvContext)]),
    "rlv_context_set_log": (RlvResult, [("context", RlvContext), ("callback", RlvLog), ("user", c_void_p)]),
    "rlv_context_set_memory_monitor": (RlvResult, [("context", RlvContext), ("callback", RlvMemoryMonitor), ("user", c_void_p)]),
    "rlv_context_stats": (RlvResult, [("context", RlvContext), ("stats", POINTER(RlvContextStat)), ("capacity", c_size_t), ("count", c_size_t_p)]),
    "rlv_context_reset_stats": (RlvResult, [("context", RlvContext)]),
    "rlv_adapter_list": (RlvResult, [("adapters", POINTER(RlvAdapterInfo)), ("capacity", c_size_t), ("count", c_size_t_p)]),
    "rlv_allocator_set": (RlvResult, [("allocator", POINTER(RlvAllocator))]),
    "rlv_allocator_info": (RlvResult, [("out", POINTER(RlvAllocatorInfo))]),
    "rlv_allocator_set_limit": (RlvResult, [("bytes", c_uint64)]),
    "rlv_bytes_retain": (RlvResult, [("bytes", RlvBytes)]),
    "rlv_bytes_release": (RlvResult, [("bytes", RlvBytes)]),
    "rlv_bytes_get": (RlvResult, [("bytes", RlvBytes), ("data", POINTER(c_uint8_p)), ("size", c_size_t_p)]),
    "rlv_mesh_create": (RlvResult, [("context", RlvContext), ("arrays", POINTER(RlvMeshArrays)), ("out", POINTER(RlvMesh))]),
    "rlv_mesh_create_borrowed": (RlvResult, [("context", RlvContext), ("arrays", POINTER(RlvMeshArrays)), ("released", RlvMeshReleased), ("user", c_void_p), ("out", POINTER(RlvMesh))]),
    "rlv_mesh_read": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("out", POINTER(RlvMesh))]),
    "rlv_mesh_write": (RlvResult, [("mesh", RlvMesh), ("path", c_char_p)]),
    "rlv_mesh_read_bytes": (RlvResult, [("context", RlvContext), ("format", c_char_p), ("bytes", c_uint8_p), ("size", c_size_t), ("out", POINTER(RlvMesh))]),
    "rlv_mesh_write_bytes": (RlvResult, [("mesh", RlvMesh), ("format", c_char_p), ("out", POINTER(RlvBytes))]),
    "rlv_mesh_split": (RlvResult, [("mesh", RlvMesh), ("longest_edge", c_double), ("out", POINTER(RlvMesh))]),
    "rlv_mesh_retain": (RlvResult, [("mesh", RlvMesh)]),
    "rlv_mesh_release": (RlvResult, [("mesh", RlvMesh)]),
    "rlv_mesh_info": (RlvResult, [("mesh", RlvMesh), ("out", POINTER(RlvMeshInfo))]),
    "rlv_mesh_set_points": (RlvResult, [("mesh", RlvMesh), ("points", c_float_p), ("count", c_size_t), ("stride", c_size_t)]),
    "rlv_mesh_add_attribute": (RlvResult, [("mesh", RlvMesh), ("arrays", POINTER(RlvAttributeArrays))]),
    "rlv_mesh_get_points": (RlvResult, [("mesh", RlvMesh), ("points", c_float_p), ("capacity", c_size_t), ("stride", c_size_t)]),
    "rlv_mesh_get_faces": (RlvResult, [("mesh", RlvMesh), ("face_sizes", c_uint32_p), ("face_capacity", c_size_t), ("corners", c_uint32_p), ("corner_capacity", c_size_t)]),
    "rlv_mesh_get_triangles": (RlvResult, [("mesh", RlvMesh), ("triangles", c_uint32_p), ("capacity", c_size_t), ("stride", c_size_t)]),
    "rlv_mesh_find_attribute": (RlvResult, [("mesh", RlvMesh), ("name", c_char_p), ("out", c_uint32_p)]),
    "rlv_mesh_attribute_info": (RlvResult, [("mesh", RlvMesh), ("index", c_uint32), ("out", POINTER(RlvAttributeInfo))]),
    "rlv_mesh_get_attribute": (RlvResult, [("mesh", RlvMesh), ("index", c_uint32), ("values", c_void_p), ("number_capacity", c_size_t), ("indices", c_uint32_p), ("index_capacity", c_size_t)]),
    "rlv_simplify_mesh": (RlvResult, [("mesh", RlvMesh), ("options", POINTER(RlvSimplifyOptions)), ("progress", RlvProgress), ("user", c_void_p), ("error", c_float_p), ("out", POINTER(RlvMesh))]),
    "rlv_progressive_create": (RlvResult, [("mesh", RlvMesh), ("options", POINTER(RlvProgressiveOptions)), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvProgressive))]),
    "rlv_progressive_read": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("triangles", c_size_t), ("out", POINTER(RlvProgressive))]),
    "rlv_progressive_write": (RlvResult, [("progressive", RlvProgressive), ("path", c_char_p)]),
    "rlv_progressive_read_bytes": (RlvResult, [("context", RlvContext), ("bytes", c_uint8_p), ("size", c_size_t), ("triangles", c_size_t), ("out", POINTER(RlvProgressive))]),
    "rlv_progressive_write_bytes": (RlvResult, [("progressive", RlvProgressive), ("out", POINTER(RlvBytes))]),
    "rlv_progressive_retain": (RlvResult, [("progressive", RlvProgressive)]),
    "rlv_progressive_release": (RlvResult, [("progressive", RlvProgressive)]),
    "rlv_progressive_info": (RlvResult, [("progressive", RlvProgressive), ("out", POINTER(RlvProgressiveInfo))]),
    "rlv_progressive_attribute_info": (RlvResult, [("progressive", RlvProgressive), ("index", c_uint32), ("out", POINTER(RlvAttributeInfo))]),
    "rlv_arrival_create": (RlvResult, [("context", RlvContext), ("out", POINTER(RlvArrival))]),
    "rlv_arrival_retain": (RlvResult, [("arrival", RlvArrival)]),
    "rlv_arrival_release": (RlvResult, [("arrival", RlvArrival)]),
    "rlv_arrival_push": (RlvResult, [("arrival", RlvArrival), ("bytes", c_void_p), ("byte_count", c_size_t), ("out", POINTER(RlvArrivalInfo))]),
    "rlv_arrival_progressive": (RlvResult, [("arrival", RlvArrival), ("out", POINTER(RlvProgressive))]),
    "rlv_surface_create": (RlvResult, [("context", RlvContext), ("cage", RlvMesh), ("options", POINTER(RlvSurfaceOptions)), ("out", POINTER(RlvSurface))]),
    "rlv_surface_retain": (RlvResult, [("surface", RlvSurface)]),
    "rlv_surface_release": (RlvResult, [("surface", RlvSurface)]),
    "rlv_surface_info": (RlvResult, [("surface", RlvSurface), ("out", POINTER(RlvSurfaceInfo))]),
    "rlv_surface_set_points": (RlvResult, [("surface", RlvSurface), ("points", c_float_p), ("count", c_size_t), ("stride", c_size_t)]),
    "rlv_surface_tile_info": (RlvResult, [("surface", RlvSurface), ("tile", c_uint32), ("out", POINTER(RlvTileInfo))]),
    "rlv_surface_face_tiles": (RlvResult, [("surface", RlvSurface), ("face", c_uint32), ("first", c_uint32_p), ("count", c_uint32_p)]),
    "rlv_detail_create": (RlvResult, [("surface", RlvSurface), ("options", POINTER(RlvDetailOptions)), ("matrix", c_double_p), ("out", POINTER(RlvDetail))]),
    "rlv_detail_retain": (RlvResult, [("detail", RlvDetail)]),
    "rlv_detail_release": (RlvResult, [("detail", RlvDetail)]),
    "rlv_detail_info": (RlvResult, [("detail", RlvDetail), ("out", POINTER(RlvDetailInfo))]),
    "rlv_detail_device_fault": (RlvResult, [("detail", RlvDetail)]),
    "rlv_detail_set_budget": (RlvResult, [("detail", RlvDetail), ("budget", c_uint64)]),
    "rlv_detail_set_paging": (RlvResult, [("detail", RlvDetail), ("page", c_uint32), ("folder", c_char_p)]),
    "rlv_detail_add_paint": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvPaintOptions))]),
    "rlv_detail_add_vectors": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvVectorOptions))]),
    "rlv_detail_add_traces": (RlvResult, [("detail", RlvDetail), ("budget", c_uint64)]),
    "rlv_detail_set_decay": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvDecayOptions))]),
    "rlv_detail_advance": (RlvResult, [("detail", RlvDetail), ("time", c_double)]),
    "rlv_detail_channel_info": (RlvResult, [("detail", RlvDetail), ("channel", c_uint32), ("out", POINTER(RlvChannelInfo))]),
    "rlv_detail_folds": (RlvResult, [("detail", RlvDetail), ("out", POINTER(RlvDetailFolds))]),
    "rlv_detail_set_face_sizes": (RlvResult, [("detail", RlvDetail), ("face_sizes", c_uint32_p), ("count", c_size_t), ("stride", c_size_t)]),
    "rlv_detail_set_transform": (RlvResult, [("detail", RlvDetail), ("matrix", c_double_p)]),
    "rlv_detail_set_points": (RlvResult, [("detail", RlvDetail), ("points", c_float_p), ("count", c_size_t), ("stride", c_size_t)]),
    "rlv_detail_commit": (RlvResult, [("detail", RlvDetail), ("out", POINTER(RlvDetailChanges))]),
    "rlv_detail_changed_tiles": (RlvResult, [("detail", RlvDetail), ("tiles", c_uint32_p), ("capacity", c_size_t), ("count", c_size_t_p)]),
    "rlv_detail_refused_faces": (RlvResult, [("detail", RlvDetail), ("faces", c_uint32_p), ("capacity", c_size_t), ("count", c_size_t_p)]),
    "rlv_detail_tile_info": (RlvResult, [("detail", RlvDetail), ("channel", c_uint32), ("tile", c_uint32), ("out", POINTER(RlvDetailTileInfo))]),
    "rlv_detail_read_block": (RlvResult, [("detail", RlvDetail), ("channel", c_uint32), ("tile", c_uint32), ("bytes", c_void_p), ("capacity", c_size_t), ("size", c_size_t_p)]),
    "rlv_detail_write_block": (RlvResult, [("detail", RlvDetail), ("channel", c_uint32), ("tile", c_uint32), ("bytes", c_void_p), ("size", c_size_t)]),
    "rlv_bake_run": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvBakeOptions)), ("receive", RlvBakeReceiver), ("progress", RlvProgress), ("user", c_void_p), ("report", POINTER(RlvBakeReport))]),
    "rlv_bake_write": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvBakeOptions)), ("path", c_char_p), ("progress", RlvProgress), ("user", c_void_p), ("report", POINTER(RlvBakeReport))]),
    "rlv_evaluate_surface": (RlvResult, [("surface", RlvSurface), ("arrays", POINTER(RlvEvaluateArrays))]),
    "rlv_evaluate_detail": (RlvResult, [("detail", RlvDetail), ("arrays", POINTER(RlvEvaluateArrays))]),
    "rlv_bezier_create": (RlvResult, [("context", RlvContext), ("arrays", POINTER(RlvBezierArrays)), ("out", POINTER(RlvBezier))]),
    "rlv_bezier_read": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("out", POINTER(RlvBezier))]),
    "rlv_bezier_retain": (RlvResult, [("bezier", RlvBezier)]),
    "rlv_bezier_release": (RlvResult, [("bezier", RlvBezier)]),
    "rlv_bezier_info": (RlvResult, [("bezier", RlvBezier), ("out", POINTER(RlvBezierInfo))]),
    "rlv_bezier_get_controls": (RlvResult, [("bezier", RlvBezier), ("patch", c_size_t), ("controls", c_float_p), ("stride", c_size_t)]),
    "rlv_bezier_evaluate": (RlvResult, [("bezier", RlvBezier), ("arrays", POINTER(RlvEvaluateArrays))]),
    "rlv_bezier_levels": (RlvResult, [("bezier", RlvBezier), ("view", POINTER(RlvBezierView)), ("levels", c_uint32_p), ("capacity", c_size_t)]),
    "rlv_bezier_count": (RlvResult, [("bezier", RlvBezier), ("levels", POINTER(RlvBezierLevels)), ("points", c_size_t_p), ("triangles", c_size_t_p)]),
    "rlv_bezier_tessellate": (RlvResult, [("bezier", RlvBezier), ("levels", POINTER(RlvBezierLevels)), ("triangles", POINTER(RlvBezierTriangles))]),
    "rlv_bezier_mesh": (RlvResult, [("bezier", RlvBezier), ("levels", POINTER(RlvBezierLevels)), ("out", POINTER(RlvMesh))]),
    "rlv_brush_params": (RlvResult, [("params", POINTER(POINTER(RlvParameter))), ("count", c_size_t_p)]),
    "rlv_brush_stamp_params": (RlvResult, [("params", POINTER(POINTER(RlvParameter))), ("count", c_size_t_p)]),
    "rlv_brush_create": (RlvResult, [("context", RlvContext), ("options", POINTER(RlvBrushOptions)), ("settings", POINTER(RlvBrushSettings)), ("out", POINTER(RlvBrush))]),
    "rlv_brush_retain": (RlvResult, [("brush", RlvBrush)]),
    "rlv_brush_release": (RlvResult, [("brush", RlvBrush)]),
    "rlv_brush_set": (RlvResult, [("brush", RlvBrush), ("options", POINTER(RlvBrushOptions)), ("settings", POINTER(RlvBrushSettings))]),
    "rlv_brush_set_curve": (RlvResult, [("brush", RlvBrush), ("curve", c_uint32), ("points", c_double_p), ("count", c_size_t)]),
    "rlv_brush_set_stamp": (RlvResult, [("brush", RlvBrush), ("options", POINTER(RlvStampOptions)), ("settings", POINTER(RlvStampSettings))]),
    "rlv_tessellate_surface": (RlvResult, [("surface", RlvSurface), ("options", POINTER(RlvTessellateOptions)), ("out", POINTER(RlvMesh))]),
    "rlv_tessellate_detail": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvTessellateOptions)), ("out", POINTER(RlvMesh))]),
    "rlv_tessellation_create": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvTessellateOptions)), ("out", POINTER(RlvTessellation))]),
    "rlv_tessellation_retain": (RlvResult, [("tessellation", RlvTessellation)]),
    "rlv_tessellation_release": (RlvResult, [("tessellation", RlvTessellation)]),
    "rlv_tessellation_info": (RlvResult, [("tessellation", RlvTessellation), ("out", POINTER(RlvTessellationInfo))]),
    "rlv_tessellation_update": (RlvResult, [("tessellation", RlvTessellation), ("out", POINTER(RlvTessellationChanges))]),
    "rlv_tessellation_changed_ranges": (RlvResult, [("tessellation", RlvTessellation), ("ranges", c_uint32_p), ("capacity", c_size_t), ("count", c_size_t_p)]),
    "rlv_tessellation_get_points": (RlvResult, [("tessellation", RlvTessellation), ("first", c_size_t), ("count", c_size_t), ("positions", c_float_p), ("position_stride", c_size_t), ("normals", c_float_p), ("normal_stride", c_size_t)]),
    "rlv_tessellation_get_colors": (RlvResult, [("tessellation", RlvTessellation), ("first", c_size_t), ("count", c_size_t), ("colors", c_float_p), ("stride", c_size_t)]),
    "rlv_tessellation_get_traces": (RlvResult, [("tessellation", RlvTessellation), ("first", c_size_t), ("count", c_size_t), ("traces", c_float_p), ("stride", c_size_t)]),
    "rlv_tessellation_mesh": (RlvResult, [("tessellation", RlvTessellation), ("out", POINTER(RlvMesh))]),
    "rlv_buffer_create": (RlvResult, [("tessellation", RlvTessellation), ("out", POINTER(RlvBuffer))]),
    "rlv_buffer_retain": (RlvResult, [("buffer", RlvBuffer)]),
    "rlv_buffer_release": (RlvResult, [("buffer", RlvBuffer)]),
    "rlv_buffer_update": (RlvResult, [("buffer", RlvBuffer), ("out", POINTER(RlvBufferInfo))]),
    "rlv_buffer_info": (RlvResult, [("buffer", RlvBuffer), ("out", POINTER(RlvBufferInfo))]),
    "rlv_buffer_vulkan": (RlvResult, [("buffer", RlvBuffer), ("out", POINTER(RlvBufferVulkan))]),
    "rlv_buffer_read": (RlvResult, [("buffer", RlvBuffer), ("first", c_size_t), ("count", c_size_t), ("points", c_float_p), ("stride", c_size_t)]),
    "rlv_capability_get": (RlvResult, [("out", POINTER(RlvCapability))]),
    "rlv_capability_list": (RlvResult, [("formats", POINTER(RlvCapabilityFormat)), ("capacity", c_size_t), ("count", c_size_t_p)]),
    "rlv_caster_create_mesh": (RlvResult, [("context", RlvContext), ("mesh", RlvMesh), ("out", POINTER(RlvCaster))]),
    "rlv_caster_create_detail": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvTessellateOptions)), ("out", POINTER(RlvCaster))]),
    "rlv_caster_create_tessellation": (RlvResult, [("tessellation", RlvTessellation), ("out", POINTER(RlvCaster))]),
    "rlv_caster_update": (RlvResult, [("caster", RlvCaster)]),
    "rlv_caster_retain": (RlvResult, [("caster", RlvCaster)]),
    "rlv_caster_release": (RlvResult, [("caster", RlvCaster)]),
    "rlv_caster_set_mask": (RlvResult, [("caster", RlvCaster), ("mask", c_uint32)]),
    "rlv_caster_cast": (RlvResult, [("caster", RlvCaster), ("arrays", POINTER(RlvRayArrays))]),
    "rlv_caster_occluded": (RlvResult, [("caster", RlvCaster), ("arrays", POINTER(RlvRayArrays)), ("occluded", c_uint8_p), ("stride", c_size_t)]),
    "rlv_isosurface_create": (RlvResult, [("context", RlvContext), ("particles", POINTER(RlvIsosurfaceParticles)), ("options", POINTER(RlvIsosurfaceOptions)), ("out", POINTER(RlvIsosurface))]),
    "rlv_isosurface_retain": (RlvResult, [("isosurface", RlvIsosurface)]),
    "rlv_isosurface_release": (RlvResult, [("isosurface", RlvIsosurface)]),
    "rlv_isosurface_info": (RlvResult, [("isosurface", RlvIsosurface), ("out", POINTER(RlvIsosurfaceInfo))]),
    "rlv_isosurface_mesh": (RlvResult, [("isosurface", RlvIsosurface), ("options", POINTER(RlvIsosurfaceMeshOptions)), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvMesh))]),
    "rlv_isosurface_classify": (RlvResult, [("isosurface", RlvIsosurface), ("threshold", c_float), ("classes", c_uint8_p), ("capacity", c_size_t), ("stride", c_size_t), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvIsosurfaceClasses))]),
    "rlv_isosurface_cast": (RlvResult, [("isosurface", RlvIsosurface), ("rays", POINTER(RlvRayArrays)), ("hits", POINTER(RlvIsosurfaceHit)), ("hit_stride", c_size_t)]),
    "rlv_isosurface_table": (RlvResult, [("isosurface", RlvIsosurface), ("out", POINTER(RlvIsosurfaceTable))]),
    "rlv_particles_create": (RlvResult, [("context", RlvContext), ("arrays", POINTER(RlvParticlesArrays)), ("out", POINTER(RlvParticles))]),
    "rlv_particles_read": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("out", POINTER(RlvParticles))]),
    "rlv_particles_write": (RlvResult, [("particles", RlvParticles), ("path", c_char_p)]),
    "rlv_particles_retain": (RlvResult, [("particles", RlvParticles)]),
    "rlv_particles_release": (RlvResult, [("particles", RlvParticles)]),
    "rlv_particles_info": (RlvResult, [("particles", RlvParticles), ("out", POINTER(RlvParticlesInfo))]),
    "rlv_particles_get_points": (RlvResult, [("particles", RlvParticles), ("points", c_float_p), ("capacity", c_size_t), ("stride", c_size_t)]),
    "rlv_particles_get_numbers": (RlvResult, [("particles", RlvParticles), ("numbers", c_uint32_p), ("capacity", c_size_t), ("stride", c_size_t)]),
    "rlv_particles_find_channel": (RlvResult, [("particles", RlvParticles), ("name", c_char_p), ("out", c_uint32_p)]),
    "rlv_particles_channel_info": (RlvResult, [("particles", RlvParticles), ("index", c_uint32), ("out", POINTER(RlvAttributeInfo))]),
    "rlv_particles_get_channel": (RlvResult, [("particles", RlvParticles), ("index", c_uint32), ("values", c_float_p), ("capacity", c_size_t), ("stride", c_size_t)]),
    "rlv_particles_keep": (RlvResult, [("particles", RlvParticles), ("classes", c_uint8_p), ("count", c_size_t), ("stride", c_size_t), ("out", POINTER(RlvParticles))]),
    "rlv_particles_isosurface": (RlvResult, [("particles", RlvParticles), ("options", POINTER(RlvIsosurfaceOptions)), ("out", POINTER(RlvIsosurface))]),
    "rlv_client_connect": (RlvResult, [("context", RlvContext), ("options", POINTER(RlvClientOptions)), ("out", POINTER(RlvClient))]),
    "rlv_client_retain": (RlvResult, [("client", RlvClient)]),
    "rlv_client_release": (RlvResult, [("client", RlvClient)]),
    "rlv_client_info": (RlvResult, [("client", RlvClient), ("out", POINTER(RlvClientInfo))]),
    "rlv_client_submit": (RlvResult, [("client", RlvClient), ("scene", POINTER(RlvClientScene)), ("progress", RlvProgress), ("user", c_void_p), ("status", POINTER(RlvClientStatus))]),
    "rlv_client_poll": (RlvResult, [("client", RlvClient), ("scene", c_char_p), ("out", POINTER(RlvClientStatus))]),
    "rlv_client_wait": (RlvResult, [("client", RlvClient), ("scene", c_char_p), ("frame", c_uint64), ("progress", RlvProgress), ("user", c_void_p), ("status", POINTER(RlvClientStatus))]),
    "rlv_client_steer": (RlvResult, [("client", RlvClient), ("scene", c_char_p), ("frame", c_uint64), ("changes", c_char_p), ("status", POINTER(RlvClientStatus))]),
    "rlv_client_force": (RlvResult, [("client", RlvClient), ("scene", c_char_p), ("frame", c_uint64), ("accelerations", c_float_p), ("count", c_size_t), ("stride", c_size_t), ("status", POINTER(RlvClientStatus))]),
    "rlv_client_control": (RlvResult, [("client", RlvClient), ("scene", c_char_p), ("action", c_uint32)]),
    "rlv_client_fetch": (RlvResult, [("client", RlvClient), ("scene", c_char_p), ("frame", c_uint64), ("fetch", POINTER(RlvClientFetch)), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvParticles))]),
    "rlv_client_fetch_mesh": (RlvResult, [("client", RlvClient), ("scene", c_char_p), ("frame", c_uint64), ("settings", c_char_p), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvMesh))]),
    "rlv_client_save": (RlvResult, [("client", RlvClient), ("scene", c_char_p), ("frame", c_uint64), ("form", c_uint32), ("settings", c_char_p), ("path", c_char_p), ("progress", RlvProgress), ("user", c_void_p)]),
    "rlv_collider_create_mesh": (RlvResult, [("context", RlvContext), ("mesh", RlvMesh), ("matrix", c_double_p), ("out", POINTER(RlvCollider))]),
    "rlv_collider_create_surface": (RlvResult, [("surface", RlvSurface), ("options", POINTER(RlvTessellateOptions)), ("matrix", c_double_p), ("out", POINTER(RlvCollider))]),
    "rlv_collider_create_detail": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvTessellateOptions)), ("out", POINTER(RlvCollider))]),
    "rlv_collider_retain": (RlvResult, [("collider", RlvCollider)]),
    "rlv_collider_release": (RlvResult, [("collider", RlvCollider)]),
    "rlv_collider_info": (RlvResult, [("collider", RlvCollider), ("out", POINTER(RlvColliderInfo))]),
    "rlv_collider_set_transform": (RlvResult, [("collider", RlvCollider), ("matrix", c_double_p)]),
    "rlv_collider_set_points": (RlvResult, [("collider", RlvCollider), ("points", c_float_p), ("count", c_size_t), ("stride", c_size_t)]),
    "rlv_collider_press_params": (RlvResult, [("params", POINTER(POINTER(RlvParameter))), ("count", c_size_t_p)]),
    "rlv_collider_press": (RlvResult, [("collider", RlvCollider), ("place", c_double_p), ("normal", c_double_p), ("force", c_double), ("settings", POINTER(RlvToolSettings))]),
    "rlv_color_buffer_create": (RlvResult, [("detail", RlvDetail), ("out", POINTER(RlvColorBuffer))]),
    "rlv_color_buffer_retain": (RlvResult, [("buffer", RlvColorBuffer)]),
    "rlv_color_buffer_release": (RlvResult, [("buffer", RlvColorBuffer)]),
    "rlv_color_buffer_update": (RlvResult, [("buffer", RlvColorBuffer), ("out", POINTER(RlvColorBufferInfo))]),
    "rlv_color_buffer_info": (RlvResult, [("buffer", RlvColorBuffer), ("out", POINTER(RlvColorBufferInfo))]),
    "rlv_color_buffer_vulkan": (RlvResult, [("buffer", RlvColorBuffer), ("out", POINTER(RlvColorBufferVulkan))]),
    "rlv_color_buffer_read": (RlvResult, [("buffer", RlvColorBuffer), ("tile", c_uint32), ("level", c_uint32), ("bytes", c_void_p), ("capacity", c_size_t), ("size", c_size_t_p)]),
    "rlv_crowd_params": (RlvResult, [("params", POINTER(POINTER(RlvParameter))), ("count", c_size_t_p)]),
    "rlv_crowd_model_build": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("clips", POINTER(RlvCrowdClipName)), ("clip_count", c_size_t), ("settings", POINTER(RlvCrowdBuildSettings)), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvCrowdModel))]),
    "rlv_crowd_model_refit": (RlvResult, [("model", RlvCrowdModel), ("path", c_char_p), ("clips", POINTER(RlvCrowdClipName)), ("clip_count", c_size_t), ("settings", POINTER(RlvCrowdBuildSettings)), ("progress", RlvProgress), ("user", c_void_p), ("report", POINTER(RlvCrowdRefitReport)), ("out", POINTER(RlvCrowdModel))]),
    "rlv_crowd_model_with_blend": (RlvResult, [("model", RlvCrowdModel), ("blend", c_uint32), ("out", POINTER(RlvCrowdModel))]),
    "rlv_crowd_model_read": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("out", POINTER(RlvCrowdModel))]),
    "rlv_crowd_model_write": (RlvResult, [("model", RlvCrowdModel), ("path", c_char_p)]),
    "rlv_crowd_model_read_bytes": (RlvResult, [("context", RlvContext), ("bytes", c_uint8_p), ("size", c_size_t), ("out", POINTER(RlvCrowdModel))]),
    "rlv_crowd_model_write_bytes": (RlvResult, [("model", RlvCrowdModel), ("out", POINTER(RlvBytes))]),
    "rlv_crowd_model_retain": (RlvResult, [("model", RlvCrowdModel)]),
    "rlv_crowd_model_release": (RlvResult, [("model", RlvCrowdModel)]),
    "rlv_crowd_model_info": (RlvResult, [("model", RlvCrowdModel), ("out", POINTER(RlvCrowdModelInfo))]),
    "rlv_crowd_model_clip": (RlvResult, [("model", RlvCrowdModel), ("clip", c_uint32), ("out", POINTER(RlvCrowdClip))]),
    "rlv_crowd_model_material": (RlvResult, [("model", RlvCrowdModel), ("material", c_uint32), ("out", POINTER(RlvCrowdMaterial))]),
    "rlv_crowd_model_get_vertices": (RlvResult, [("model", RlvCrowdModel), ("vertices", POINTER(RlvCrowdVertices))]),
    "rlv_crowd_model_get_collapses": (RlvResult, [("model", RlvCrowdModel), ("collapses", POINTER(RlvCrowdCollapse)), ("capacity", c_size_t), ("stride", c_size_t)]),
    "rlv_crowd_model_get_offsets": (RlvResult, [("model", RlvCrowdModel), ("offsets", POINTER(RlvCrowdOffset)), ("capacity", c_size_t), ("stride", c_size_t)]),
    "rlv_crowd_model_get_triangles": (RlvResult, [("model", RlvCrowdModel), ("triangles", c_uint32_p), ("materials", c_uint32_p), ("capacity", c_size_t)]),
    "rlv_crowd_model_get_clusters": (RlvResult, [("model", RlvCrowdModel), ("clusters", POINTER(RlvCrowdCluster)), ("capacity", c_size_t), ("stride", c_size_t)]),
    "rlv_crowd_model_mesh": (RlvResult, [("model", RlvCrowdModel), ("error", c_float), ("clip", c_uint32), ("pose", c_uint32), ("out", POINTER(RlvMesh))]),
    "rlv_crowd_create": (RlvResult, [("context", RlvContext), ("models", POINTER(RlvCrowdModel)), ("count", c_size_t), ("out", POINTER(RlvCrowd))]),
    "rlv_crowd_retain": (RlvResult, [("crowd", RlvCrowd)]),
    "rlv_crowd_release": (RlvResult, [("crowd", RlvCrowd)]),
    "rlv_crowd_add": (RlvResult, [("crowd", RlvCrowd), ("agents", POINTER(RlvCrowdAgent)), ("count", c_size_t), ("stride", c_size_t), ("first", c_uint32_p)]),
    "rlv_crowd_set": (RlvResult, [("crowd", RlvCrowd), ("first", c_uint32), ("agents", POINTER(RlvCrowdAgent)), ("count", c_size_t), ("stride", c_size_t)]),
    "rlv_crowd_set_weights": (RlvResult, [("crowd", RlvCrowd), ("agent", c_uint32), ("weights", c_float_p), ("count", c_size_t)]),
    "rlv_crowd_cut": (RlvResult, [("crowd", RlvCrowd), ("view", POINTER(RlvCrowdView)), ("out", POINTER(RlvCrowdFrame))]),
    "rlv_crowd_get": (RlvResult, [("crowd", RlvCrowd), ("buffers", POINTER(RlvCrowdBuffers))]),
    "rlv_crowd_get_impostors": (RlvResult, [("crowd", RlvCrowd), ("impostors", POINTER(RlvCrowdImpostors))]),
    "rlv_crowd_stream_open": (RlvResult, [("context", RlvContext), ("files", POINTER(RlvCrowdStreamFile)), ("count", c_size_t), ("settings", POINTER(RlvCrowdStreamSettings)), ("out", POINTER(RlvCrowd))]),
    "rlv_crowd_stream_model": (RlvResult, [("crowd", RlvCrowd), ("model", c_uint32), ("out", POINTER(RlvCrowdModel))]),
    "rlv_crowd_stream_info": (RlvResult, [("crowd", RlvCrowd), ("out", POINTER(RlvCrowdStreamInfo))]),
    "rlv_crowd_stream_get_read": (RlvResult, [("crowd", RlvCrowd), ("clusters", POINTER(RlvCrowdStreamCluster)), ("capacity", c_size_t), ("stride", c_size_t)]),
    "rlv_crowd_stream_get_triangles": (RlvResult, [("crowd", RlvCrowd), ("slot", c_uint32), ("triangles", c_uint32_p), ("materials", c_uint32_p), ("capacity", c_size_t)]),
    "rlv_document_create": (RlvResult, [("detail", RlvDetail), ("path", c_char_p), ("memory", c_uint64), ("out", POINTER(RlvDocument))]),
    "rlv_document_open": (RlvResult, [("detail", RlvDetail), ("path", c_char_p), ("memory", c_uint64), ("out", POINTER(RlvDocument))]),
    "rlv_document_create_stream": (RlvResult, [("detail", RlvDetail), ("stream", POINTER(RlvStream)), ("memory", c_uint64), ("out", POINTER(RlvDocument))]),
    "rlv_document_open_stream": (RlvResult, [("detail", RlvDetail), ("stream", POINTER(RlvStream)), ("memory", c_uint64), ("out", POINTER(RlvDocument))]),
    "rlv_document_open_bytes": (RlvResult, [("detail", RlvDetail), ("bytes", c_uint8_p), ("size", c_size_t), ("memory", c_uint64), ("out", POINTER(RlvDocument))]),
    "rlv_document_retain": (RlvResult, [("document", RlvDocument)]),
    "rlv_document_release": (RlvResult, [("document", RlvDocument)]),
    "rlv_document_info": (RlvResult, [("document", RlvDocument), ("out", POINTER(RlvDocumentInfo))]),
    "rlv_document_begin": (RlvResult, [("document", RlvDocument), ("input", c_char_p)]),
    "rlv_document_end": (RlvResult, [("document", RlvDocument), ("changes", POINTER(RlvDocumentChanges))]),
    "rlv_document_abandon": (RlvResult, [("document", RlvDocument)]),
    "rlv_document_undo": (RlvResult, [("document", RlvDocument), ("changes", POINTER(RlvDocumentChanges))]),
    "rlv_document_redo": (RlvResult, [("document", RlvDocument), ("changes", POINTER(RlvDocumentChanges))]),
    "rlv_document_save": (RlvResult, [("document", RlvDocument), ("path", c_char_p)]),
    "rlv_document_save_stream": (RlvResult, [("document", RlvDocument), ("stream", POINTER(RlvStream))]),
    "rlv_document_save_bytes": (RlvResult, [("document", RlvDocument), ("out", POINTER(RlvBytes))]),
    "rlv_document_sync": (RlvResult, [("document", RlvDocument)]),
    "rlv_document_compact": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("keep", c_size_t)]),
    "rlv_document_mesh": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("out", POINTER(RlvMesh))]),
    "rlv_document_mesh_bytes": (RlvResult, [("context", RlvContext), ("bytes", c_uint8_p), ("size", c_size_t), ("out", POINTER(RlvMesh))]),
    "rlv_document_transfer": (RlvResult, [("context", RlvContext), ("mesh", RlvMesh), ("path", c_char_p), ("to_path", c_char_p), ("options", POINTER(RlvTransferOptions)), ("progress", RlvProgress), ("user", c_void_p), ("report", POINTER(RlvTransferReport))]),
    "rlv_layer_count": (RlvResult, [("detail", RlvDetail), ("count", c_size_t_p)]),
    "rlv_layer_info": (RlvResult, [("detail", RlvDetail), ("index", c_size_t), ("out", POINTER(RlvLayerInfo))]),
    "rlv_layer_add": (RlvResult, [("detail", RlvDetail), ("name", c_char_p), ("options", POINTER(RlvLayerOptions)), ("out", c_uint32_p)]),
    "rlv_layer_set": (RlvResult, [("detail", RlvDetail), ("id", c_uint32), ("options", POINTER(RlvLayerOptions))]),
    "rlv_layer_set_active": (RlvResult, [("detail", RlvDetail), ("id", c_uint32)]),
    "rlv_layer_rename": (RlvResult, [("detail", RlvDetail), ("id", c_uint32), ("name", c_char_p)]),
    "rlv_layer_place": (RlvResult, [("detail", RlvDetail), ("id", c_uint32), ("place", c_size_t)]),
    "rlv_layer_remove": (RlvResult, [("detail", RlvDetail), ("id", c_uint32)]),
    "rlv_layer_merge": (RlvResult, [("detail", RlvDetail), ("id", c_uint32)]),
    "rlv_layer_flatten": (RlvResult, [("detail", RlvDetail)]),
    "rlv_decal_on_mesh": (RlvResult, [("mesh", RlvMesh), ("options", POINTER(RlvDecalOptions)), ("pins", POINTER(RlvDecalPin)), ("count", c_size_t), ("stride", c_size_t), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvDecal))]),
    "rlv_decal_on_detail": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvDecalOptions)), ("pins", POINTER(RlvDecalPin)), ("count", c_size_t), ("stride", c_size_t), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvDecal))]),
    "rlv_decal_retain": (RlvResult, [("decal", RlvDecal)]),
    "rlv_decal_release": (RlvResult, [("decal", RlvDecal)]),
    "rlv_decal_quality": (RlvResult, [("decal", RlvDecal), ("out", POINTER(RlvDecalQuality))]),
    "rlv_decal_mesh": (RlvResult, [("decal", RlvDecal), ("offset", c_double), ("out", POINTER(RlvMesh))]),
    "rlv_decal_drag_pin": (RlvResult, [("decal", RlvDecal), ("pin", c_size_t), ("position", c_double_p)]),
    "rlv_decal_move_image": (RlvResult, [("decal", RlvDecal), ("pin", c_size_t), ("image", c_double_p), ("progress", RlvProgress), ("user", c_void_p)]),
    "rlv_decal_pose": (RlvResult, [("decal", RlvDecal), ("points", c_float_p), ("count", c_size_t), ("stride", c_size_t), ("progress", RlvProgress), ("user", c_void_p)]),
    "rlv_decal_settle": (RlvResult, [("decal", RlvDecal), ("progress", RlvProgress), ("user", c_void_p)]),
    "rlv_decal_paint": (RlvResult, [("decal", RlvDecal), ("image", POINTER(RlvDecalImage)), ("opacity", c_float), ("report", POINTER(RlvDecalReport))]),
    "rlv_decal_emboss": (RlvResult, [("decal", RlvDecal), ("image", POINTER(RlvDecalImage)), ("height", c_float), ("report", POINTER(RlvDecalReport))]),
    "rlv_decal_write": (RlvResult, [("decal", RlvDecal), ("image", POINTER(RlvDecalImage)), ("ink", POINTER(RlvDecalInk)), ("report", POINTER(RlvDecalReport))]),
    "rlv_decal_paint_texture": (RlvResult, [("decal", RlvDecal), ("image", POINTER(RlvDecalImage)), ("opacity", c_float), ("texture", POINTER(RlvDecalTexture)), ("painted", c_size_t_p)]),
    "rlv_decal_contour": (RlvResult, [("image", POINTER(RlvDecalImage)), ("width", c_uint32), ("height", c_uint32), ("level", c_double), ("tolerance", c_double), ("corners", c_double_p), ("capacity", c_size_t), ("count", c_size_t_p)]),
    "rlv_decal_strip_on_mesh": (RlvResult, [("mesh", RlvMesh), ("options", POINTER(RlvDecalOptions)), ("curve", c_double_p), ("count", c_size_t), ("stride", c_size_t), ("pins", POINTER(RlvDecalPin)), ("capacity", c_size_t), ("pin_count", c_size_t_p), ("length", c_double_p)]),
    "rlv_decal_strip_on_detail": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvDecalOptions)), ("curve", c_double_p), ("count", c_size_t), ("stride", c_size_t), ("pins", POINTER(RlvDecalPin)), ("capacity", c_size_t), ("pin_count", c_size_t_p), ("length", c_double_p)]),
    "rlv_decal_pins": (RlvResult, [("decal", RlvDecal), ("pins", POINTER(RlvDecalPin)), ("capacity", c_size_t), ("count", c_size_t_p)]),
    "rlv_decal_count": (RlvResult, [("document", RlvDocument), ("count", c_size_t_p)]),
    "rlv_decal_recipe": (RlvResult, [("document", RlvDocument), ("index", c_size_t), ("out", POINTER(RlvDecalRecipe))]),
    "rlv_decal_apply": (RlvResult, [("decal", RlvDecal), ("document", RlvDocument), ("layer", c_char_p), ("image", POINTER(RlvDecalImage)), ("ink", POINTER(RlvDecalInk)), ("progress", RlvProgress), ("user", c_void_p), ("id", c_uint32_p)]),
    "rlv_decal_take_up": (RlvResult, [("document", RlvDocument), ("id", c_uint32), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvDecal))]),
    "rlv_decal_update": (RlvResult, [("decal", RlvDecal), ("document", RlvDocument), ("id", c_uint32), ("image", POINTER(RlvDecalImage)), ("ink", POINTER(RlvDecalInk)), ("progress", RlvProgress), ("user", c_void_p)]),
    "rlv_decal_remove": (RlvResult, [("document", RlvDocument), ("id", c_uint32)]),
    "rlv_device_crowd_create": (RlvResult, [("crowd", RlvCrowd), ("out", POINTER(RlvDeviceCrowd))]),
    "rlv_device_crowd_retain": (RlvResult, [("crowd", RlvDeviceCrowd)]),
    "rlv_device_crowd_release": (RlvResult, [("crowd", RlvDeviceCrowd)]),
    "rlv_device_crowd_cut": (RlvResult, [("crowd", RlvDeviceCrowd), ("view", POINTER(RlvCrowdView)), ("out", POINTER(RlvDeviceCrowdInfo))]),
    "rlv_device_crowd_get": (RlvResult, [("crowd", RlvDeviceCrowd), ("buffers", POINTER(RlvCrowdBuffers))]),
    "rlv_device_crowd_get_impostors": (RlvResult, [("crowd", RlvDeviceCrowd), ("impostors", POINTER(RlvCrowdImpostors))]),
    "rlv_device_crowd_vulkan": (RlvResult, [("crowd", RlvDeviceCrowd), ("out", POINTER(RlvDeviceCrowdVulkan))]),
    "rlv_stroke_run": (RlvResult, [("detail", RlvDetail), ("brush", RlvBrush), ("points", POINTER(RlvStrokePoint)), ("count", c_size_t), ("stride", c_size_t), ("report", POINTER(RlvStrokeReport))]),
    "rlv_stroke_begin": (RlvResult, [("detail", RlvDetail), ("brush", RlvBrush), ("out", POINTER(RlvStroke))]),
    "rlv_stroke_retain": (RlvResult, [("stroke", RlvStroke)]),
    "rlv_stroke_release": (RlvResult, [("stroke", RlvStroke)]),
    "rlv_stroke_extend": (RlvResult, [("stroke", RlvStroke), ("points", POINTER(RlvStrokePoint)), ("count", c_size_t), ("stride", c_size_t), ("report", POINTER(RlvStrokeReport))]),
    "rlv_stroke_end": (RlvResult, [("stroke", RlvStroke), ("report", POINTER(RlvStrokeReport))]),
    "rlv_level_create": (RlvResult, [("progressive", RlvProgressive), ("out", POINTER(RlvLevel))]),
    "rlv_level_take_up": (RlvResult, [("level", RlvLevel), ("progressive", RlvProgressive)]),
    "rlv_level_retain": (RlvResult, [("level", RlvLevel)]),
    "rlv_level_release": (RlvResult, [("level", RlvLevel)]),
    "rlv_level_info": (RlvResult, [("level", RlvLevel), ("out", POINTER(RlvLevelInfo))]),
    "rlv_level_set_error": (RlvResult, [("level", RlvLevel), ("error", c_float)]),
    "rlv_level_set_bound": (RlvResult, [("level", RlvLevel), ("bound", c_float), ("progress", RlvProgress), ("user", c_void_p), ("distance", c_float_p)]),
    "rlv_level_set_triangles": (RlvResult, [("level", RlvLevel), ("triangles", c_size_t)]),
    "rlv_level_set_view": (RlvResult, [("level", RlvLevel), ("view", POINTER(RlvLevelView))]),
    "rlv_level_edit": (RlvResult, [("level", RlvLevel), ("edit", POINTER(RlvLevelEdit)), ("reached", c_size_t_p)]),
    "rlv_level_sculpt": (RlvResult, [("level", RlvLevel), ("brush", RlvBrush), ("points", POINTER(RlvStrokePoint)), ("count", c_size_t), ("stride", c_size_t), ("out", POINTER(RlvLevelSculpted))]),
    "rlv_level_undo": (RlvResult, [("level", RlvLevel)]),
    "rlv_level_redo": (RlvResult, [("level", RlvLevel)]),
    "rlv_level_add_motion": (RlvResult, [("level", RlvLevel), ("motion", POINTER(RlvLevelMotion))]),
    "rlv_level_set_time": (RlvResult, [("level", RlvLevel), ("time", c_double), ("reached", c_size_t_p)]),
    "rlv_level_clear_motions": (RlvResult, [("level", RlvLevel)]),
    "rlv_level_open_journal": (RlvResult, [("level", RlvLevel), ("path", c_char_p)]),
    "rlv_level_sync_journal": (RlvResult, [("level", RlvLevel)]),
    "rlv_level_close_journal": (RlvResult, [("level", RlvLevel)]),
    "rlv_level_update": (RlvResult, [("level", RlvLevel), ("buffers", POINTER(RlvLevelBuffers)), ("out", POINTER(RlvLevelUpdate))]),
    "rlv_level_changed_ranges": (RlvResult, [("level", RlvLevel), ("domain", c_uint32), ("ranges", c_uint32_p), ("capacity", c_size_t), ("count", c_size_t_p)]),
    "rlv_level_mesh": (RlvResult, [("level", RlvLevel), ("out", POINTER(RlvMesh))]),
    "rlv_level_settle": (RlvResult, [("level", RlvLevel), ("out", POINTER(RlvProgressive))]),
    "rlv_level_misplaced": (RlvResult, [("level", RlvLevel), ("out", POINTER(RlvLevelMisplaced)), ("capacity", c_size_t), ("count", c_size_t_p)]),
    "rlv_level_rebuild": (RlvResult, [("level", RlvLevel), ("options", POINTER(RlvProgressiveOptions)), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvProgressive))]),
    "rlv_device_level_create": (RlvResult, [("progressive", RlvProgressive), ("out", POINTER(RlvDeviceLevel))]),
    "rlv_device_level_retain": (RlvResult, [("level", RlvDeviceLevel)]),
    "rlv_device_level_release": (RlvResult, [("level", RlvDeviceLevel)]),
    "rlv_device_level_info": (RlvResult, [("level", RlvDeviceLevel), ("out", POINTER(RlvDeviceLevelInfo))]),
    "rlv_device_level_set_error": (RlvResult, [("level", RlvDeviceLevel), ("error", c_float)]),
    "rlv_device_level_set_triangles": (RlvResult, [("level", RlvDeviceLevel), ("triangles", c_size_t)]),
    "rlv_device_level_set_view": (RlvResult, [("level", RlvDeviceLevel), ("view", POINTER(RlvLevelView))]),
    "rlv_device_level_edit": (RlvResult, [("level", RlvDeviceLevel), ("edit", POINTER(RlvLevelEdit)), ("reached", c_size_t_p)]),
    "rlv_device_level_undo": (RlvResult, [("level", RlvDeviceLevel)]),
    "rlv_device_level_redo": (RlvResult, [("level", RlvDeviceLevel)]),
    "rlv_device_level_add_motion": (RlvResult, [("level", RlvDeviceLevel), ("motion", POINTER(RlvLevelMotion))]),
    "rlv_device_level_set_time": (RlvResult, [("level", RlvDeviceLevel), ("time", c_double), ("reached", c_size_t_p)]),
    "rlv_device_level_clear_motions": (RlvResult, [("level", RlvDeviceLevel)]),
    "rlv_device_level_read": (RlvResult, [("level", RlvDeviceLevel), ("buffers", POINTER(RlvLevelBuffers)), ("out", POINTER(RlvLevelUpdate))]),
    "rlv_device_level_vulkan": (RlvResult, [("level", RlvDeviceLevel), ("out", POINTER(RlvDeviceLevelVulkan))]),
    "rlv_diffuse_params": (RlvResult, [("params", POINTER(POINTER(RlvParameter))), ("count", c_size_t_p)]),
    "rlv_diffuse_create": (RlvResult, [("context", RlvContext), ("options", POINTER(RlvDiffuseOptions)), ("settings", POINTER(RlvDiffuseSettings)), ("out", POINTER(RlvDiffuse))]),
    "rlv_diffuse_retain": (RlvResult, [("diffuse", RlvDiffuse)]),
    "rlv_diffuse_release": (RlvResult, [("diffuse", RlvDiffuse)]),
    "rlv_diffuse_info": (RlvResult, [("diffuse", RlvDiffuse), ("out", POINTER(RlvDiffuseInfo))]),
    "rlv_diffuse_advance": (RlvResult, [("diffuse", RlvDiffuse), ("fluid", POINTER(RlvDiffuseFluid)), ("seconds", c_float), ("report", POINTER(RlvDiffuseReport)), ("progress", RlvProgress), ("user", c_void_p)]),
    "rlv_diffuse_potentials": (RlvResult, [("diffuse", RlvDiffuse), ("fluid", POINTER(RlvDiffuseFluid)), ("potentials", POINTER(RlvDiffusePotentials))]),
    "rlv_diffuse_get": (RlvResult, [("diffuse", RlvDiffuse), ("arrays", POINTER(RlvDiffuseArrays))]),
    "rlv_diffuse_particles": (RlvResult, [("diffuse", RlvDiffuse), ("time", c_double), ("out", POINTER(RlvParticles))]),
    "rlv_diffuse_save": (RlvResult, [("diffuse", RlvDiffuse), ("path", c_char_p), ("time", c_double)]),
    "rlv_diffuse_restore": (RlvResult, [("diffuse", RlvDiffuse), ("path", c_char_p)]),
    "rlv_fluid_create": (RlvResult, [("context", RlvContext), ("options", POINTER(RlvFluidOptions)), ("out", POINTER(RlvFluid))]),
    "rlv_fluid_retain": (RlvResult, [("fluid", RlvFluid)]),
    "rlv_fluid_release": (RlvResult, [("fluid", RlvFluid)]),
    "rlv_fluid_info": (RlvResult, [("fluid", RlvFluid), ("out", POINTER(RlvFluidInfo))]),
    "rlv_fluid_add": (RlvResult, [("fluid", RlvFluid), ("particles", POINTER(RlvFluidParticles))]),
    "rlv_fluid_add_box": (RlvResult, [("fluid", RlvFluid), ("low", c_double_p), ("high", c_double_p), ("velocity", c_float_p)]),
    "rlv_fluid_fill": (RlvResult, [("fluid", RlvFluid), ("mesh", RlvMesh), ("matrix", c_double_p), ("velocity", c_float_p), ("added", c_size_t_p)]),
    "rlv_fluid_add_emitter": (RlvResult, [("fluid", RlvFluid), ("mesh", RlvMesh), ("matrix", c_double_p), ("options", POINTER(RlvFluidEmitterOptions))]),
    "rlv_fluid_add_sink": (RlvResult, [("fluid", RlvFluid), ("low", c_double_p), ("high", c_double_p), ("is_outside", c_uint32)]),
    "rlv_fluid_add_sink_mesh": (RlvResult, [("fluid", RlvFluid), ("mesh", RlvMesh), ("matrix", c_double_p)]),
    "rlv_fluid_clear_sources": (RlvResult, [("fluid", RlvFluid)]),
    "rlv_fluid_set_budget": (RlvResult, [("fluid", RlvFluid), ("particles", c_size_t), ("stops", c_uint32)]),
    "rlv_fluid_set_forces": (RlvResult, [("fluid", RlvFluid), ("forces", POINTER(RlvFluidForce)), ("count", c_size_t), ("stride", c_size_t)]),
    "rlv_fluid_remove": (RlvResult, [("fluid", RlvFluid), ("numbers", c_uint32_p), ("count", c_size_t), ("stride", c_size_t), ("removed", c_size_t_p)]),
    "rlv_fluid_set_walls": (RlvResult, [("fluid", RlvFluid), ("points", c_float_p), ("count", c_size_t), ("stride", c_size_t)]),
    "rlv_fluid_set_basin": (RlvResult, [("fluid", RlvFluid), ("low", c_double_p), ("high", c_double_p)]),
    "rlv_fluid_set_wall_points": (RlvResult, [("fluid", RlvFluid), ("points", c_float_p), ("count", c_size_t), ("stride", c_size_t), ("velocities", c_float_p), ("velocity_stride", c_size_t)]),
    "rlv_fluid_add_collider": (RlvResult, [("fluid", RlvFluid), ("mesh", RlvMesh), ("matrix", c_double_p), ("options", POINTER(RlvFluidColliderOptions)), ("out", c_uint32_p)]),
    "rlv_fluid_move_collider": (RlvResult, [("fluid", RlvFluid), ("collider", c_uint32), ("from", c_float_p), ("to", c_float_p), ("count", c_size_t), ("stride", c_size_t), ("seconds", c_float)]),
    "rlv_fluid_impulse": (RlvResult, [("fluid", RlvFluid), ("collider", c_uint32), ("linear", c_double_p), ("angular", c_double_p)]),
    "rlv_fluid_accelerate": (RlvResult, [("fluid", RlvFluid), ("accelerations", c_float_p), ("count", c_size_t), ("stride", c_size_t)]),
    "rlv_fluid_step": (RlvResult, [("fluid", RlvFluid), ("seconds", c_float), ("out", POINTER(RlvFluidReport))]),
    "rlv_fluid_advance": (RlvResult, [("fluid", RlvFluid), ("seconds", c_double), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvFluidReport))]),
    "rlv_fluid_get": (RlvResult, [("fluid", RlvFluid), ("arrays", POINTER(RlvFluidArrays))]),
    "rlv_fluid_set_channel": (RlvResult, [("fluid", RlvFluid), ("channel", POINTER(RlvAttributeArrays))]),
    "rlv_fluid_find_channel": (RlvResult, [("fluid", RlvFluid), ("name", c_char_p), ("out", c_uint32_p)]),
    "rlv_fluid_channel_info": (RlvResult, [("fluid", RlvFluid), ("index", c_uint32), ("out", POINTER(RlvAttributeInfo))]),
    "rlv_fluid_get_channel": (RlvResult, [("fluid", RlvFluid), ("index", c_uint32), ("values", c_float_p), ("capacity", c_size_t), ("stride", c_size_t)]),
    "rlv_fluid_save": (RlvResult, [("fluid", RlvFluid), ("path", c_char_p)]),
    "rlv_fluid_restore": (RlvResult, [("fluid", RlvFluid), ("path", c_char_p)]),
    "rlv_fluid_save_bytes": (RlvResult, [("fluid", RlvFluid), ("out", POINTER(RlvBytes))]),
    "rlv_fluid_restore_bytes": (RlvResult, [("fluid", RlvFluid), ("bytes", c_uint8_p), ("size", c_size_t)]),
    "rlv_fluid_particles": (RlvResult, [("fluid", RlvFluid), ("out", POINTER(RlvParticles))]),
    "rlv_fluid_add_particles": (RlvResult, [("fluid", RlvFluid), ("particles", RlvParticles)]),
    "rlv_fluid_isosurface": (RlvResult, [("fluid", RlvFluid), ("options", POINTER(RlvIsosurfaceOptions)), ("out", POINTER(RlvIsosurface))]),
    "rlv_foam_params": (RlvResult, [("params", POINTER(POINTER(RlvParameter))), ("count", c_size_t_p)]),
    "rlv_foam_create": (RlvResult, [("context", RlvContext), ("view", POINTER(RlvFoamView)), ("settings", POINTER(RlvFoamSettings)), ("out", POINTER(RlvFoam))]),
    "rlv_foam_retain": (RlvResult, [("foam", RlvFoam)]),
    "rlv_foam_release": (RlvResult, [("foam", RlvFoam)]),
    "rlv_foam_add": (RlvResult, [("foam", RlvFoam), ("particles", POINTER(RlvFoamParticles))]),
    "rlv_foam_shade": (RlvResult, [("foam", RlvFoam), ("light", POINTER(RlvFoamLight)), ("progress", RlvProgress), ("user", c_void_p)]),
    "rlv_foam_get": (RlvResult, [("foam", RlvFoam), ("layers", POINTER(RlvFoamLayers))]),
    "rlv_foam_composite": (RlvResult, [("foam", RlvFoam), ("background", c_float_p), ("channels", c_uint32), ("picture", c_float_p)]),
    "rlv_grid_params": (RlvResult, [("params", POINTER(POINTER(RlvParameter))), ("count", c_size_t_p)]),
    "rlv_grid_available": (RlvResult, []),
    "rlv_grid_file_count": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("out", c_size_t_p)]),
    "rlv_grid_file_info": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("index", c_size_t), ("out", POINTER(RlvGridInfo))]),
    "rlv_grid_file_metadata": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("name", c_char_p), ("value", c_char_p), ("size", c_size_t)]),
    "rlv_grid_create": (RlvResult, [("context", RlvContext), ("kind", c_uint32), ("background", c_double_p), ("voxel", c_double), ("out", POINTER(RlvGrid))]),
    "rlv_grid_read": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("name", c_char_p), ("bounds", c_double_p), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvGrid))]),
    "rlv_grid_write": (RlvResult, [("grids", POINTER(RlvGrid)), ("count", c_size_t), ("path", c_char_p), ("writing", c_uint32)]),
    "rlv_grid_retain": (RlvResult, [("grid", RlvGrid)]),
    "rlv_grid_release": (RlvResult, [("grid", RlvGrid)]),
    "rlv_grid_info": (RlvResult, [("grid", RlvGrid), ("out", POINTER(RlvGridInfo))]),
    "rlv_grid_set_name": (RlvResult, [("grid", RlvGrid), ("name", c_char_p)]),
    "rlv_grid_set_class": (RlvResult, [("grid", RlvGrid), ("grid_class", c_uint32)]),
    "rlv_grid_set_matrix": (RlvResult, [("grid", RlvGrid), ("matrix", c_double_p)]),
    "rlv_grid_set_frustum": (RlvResult, [("grid", RlvGrid), ("voxels", c_double_p), ("taper", c_double), ("depth", c_double), ("matrix", c_double_p)]),
    "rlv_grid_metadata_count": (RlvResult, [("grid", RlvGrid), ("out", c_size_t_p)]),
    "rlv_grid_metadata_entry": (RlvResult, [("grid", RlvGrid), ("index", c_size_t), ("name", c_char_p), ("name_size", c_size_t), ("type", c_char_p), ("type_size", c_size_t)]),
    "rlv_grid_metadata": (RlvResult, [("grid", RlvGrid), ("name", c_char_p), ("value", c_char_p), ("size", c_size_t)]),
    "rlv_grid_set_metadata": (RlvResult, [("grid", RlvGrid), ("name", c_char_p), ("type", c_char_p), ("value", c_char_p)]),
    "rlv_grid_sample": (RlvResult, [("grid", RlvGrid), ("points", c_double_p), ("count", c_size_t), ("stride", c_size_t), ("is_linear", c_uint32), ("values", c_double_p), ("capacity", c_size_t)]),
    "rlv_grid_get_block": (RlvResult, [("grid", RlvGrid), ("low", c_int32_p), ("size", c_uint32_p), ("values", c_void_p), ("bytes", c_size_t)]),
    "rlv_grid_set_block": (RlvResult, [("grid", RlvGrid), ("low", c_int32_p), ("size", c_uint32_p), ("values", c_void_p), ("bytes", c_size_t), ("tolerance", c_double)]),
    "rlv_grid_from_mesh": (RlvResult, [("mesh", RlvMesh), ("settings", POINTER(RlvGridSettings)), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvGrid))]),
    "rlv_grid_from_particles": (RlvResult, [("particles", RlvParticles), ("settings", POINTER(RlvGridSettings)), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvGrid))]),
    "rlv_grid_mesh": (RlvResult, [("grid", RlvGrid), ("settings", POINTER(RlvGridSettings)), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvMesh))]),
    "rlv_grid_change": (RlvResult, [("grid", RlvGrid), ("change", c_uint32), ("settings", POINTER(RlvGridSettings)), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvGrid))]),
    "rlv_grid_convert": (RlvResult, [("grid", RlvGrid), ("kind", c_uint32), ("out", POINTER(RlvGrid))]),
    "rlv_grid_combine": (RlvResult, [("a", RlvGrid), ("b", RlvGrid), ("operation", c_uint32), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvGrid))]),
    "rlv_grid_labels": (RlvResult, [("level_sets", POINTER(RlvGrid)), ("labels", c_int32_p), ("count", c_size_t), ("out", POINTER(RlvGrid))]),
    "rlv_grid_label_mask": (RlvResult, [("grid", RlvGrid), ("label", c_int64), ("out", POINTER(RlvGrid))]),
    "rlv_imprint_params": (RlvResult, [("params", POINTER(POINTER(RlvParameter))), ("count", c_size_t_p)]),
    "rlv_imprint_run": (RlvResult, [("detail", RlvDetail), ("collider", RlvCollider), ("settings", POINTER(RlvImprintSettings)), ("moment", POINTER(RlvImprintMoment)), ("report", POINTER(RlvImprintReport))]),
    "rlv_imprint_sweep": (RlvResult, [("detail", RlvDetail), ("collider", RlvCollider), ("from", c_double_p), ("to", c_double_p), ("settings", POINTER(RlvImprintSettings)), ("moment", POINTER(RlvImprintMoment)), ("progress", RlvProgress), ("user", c_void_p), ("report", POINTER(RlvImprintReport))]),
    "rlv_imprint_sweep_points": (RlvResult, [("detail", RlvDetail), ("collider", RlvCollider), ("from", c_double_p), ("to", c_double_p), ("from_points", c_float_p), ("to_points", c_float_p), ("count", c_size_t), ("stride", c_size_t), ("settings", POINTER(RlvImprintSettings)), ("moment", POINTER(RlvImprintMoment)), ("progress", RlvProgress), ("user", c_void_p), ("report", POINTER(RlvImprintReport))]),
    "rlv_imprint_collide": (RlvResult, [("first", RlvDetail), ("second", RlvDetail), ("first_settings", POINTER(RlvImprintSettings)), ("second_settings", POINTER(RlvImprintSettings)), ("moment", POINTER(RlvImprintMoment)), ("first_report", POINTER(RlvImprintReport)), ("second_report", POINTER(RlvImprintReport))]),
    "rlv_picture_open": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("out", POINTER(RlvPicture))]),
    "rlv_picture_retain": (RlvResult, [("picture", RlvPicture)]),
    "rlv_picture_release": (RlvResult, [("picture", RlvPicture)]),
    "rlv_picture_info": (RlvResult, [("picture", RlvPicture), ("out", POINTER(RlvPictureInfo))]),
    "rlv_picture_image": (RlvResult, [("picture", RlvPicture), ("image", c_uint32), ("out", POINTER(RlvPictureImage))]),
    "rlv_picture_meta": (RlvResult, [("picture", RlvPicture), ("index", c_uint32), ("out", POINTER(RlvPictureMeta))]),
    "rlv_picture_read": (RlvResult, [("picture", RlvPicture), ("image", c_uint32), ("level", c_uint32), ("x", c_uint32), ("y", c_uint32), ("width", c_uint32), ("height", c_uint32), ("pixels", c_void_p), ("row_stride", c_size_t)]),
    "rlv_procedural_create": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvProceduralOptions)), ("out", POINTER(RlvProcedural))]),
    "rlv_procedural_create_moving": (RlvResult, [("begin", RlvProcedural), ("end", RlvDetail), ("out", POINTER(RlvProcedural))]),
    "rlv_procedural_retain": (RlvResult, [("procedural", RlvProcedural)]),
    "rlv_procedural_release": (RlvResult, [("procedural", RlvProcedural)]),
    "rlv_procedural_info": (RlvResult, [("procedural", RlvProcedural), ("out", POINTER(RlvProceduralInfo))]),
    "rlv_procedural_table": (RlvResult, [("procedural", RlvProcedural), ("out", POINTER(RlvProceduralTable))]),
    "rlv_procedural_evaluate": (RlvResult, [("procedural", RlvProcedural), ("hits", POINTER(RlvProceduralHits))]),
    "rlv_ptex_write": (RlvResult, [("detail", RlvDetail), ("channel", c_uint32), ("path", c_char_p), ("progress", RlvProgress), ("user", c_void_p)]),
    "rlv_ptex_read": (RlvResult, [("detail", RlvDetail), ("path", c_char_p), ("options", POINTER(RlvPtexOptions)), ("progress", RlvProgress), ("user", c_void_p), ("report", POINTER(RlvPtexReport))]),
    "rlv_repair_params": (RlvResult, [("params", POINTER(POINTER(RlvParameter))), ("count", c_size_t_p)]),
    "rlv_repair_check": (RlvResult, [("mesh", RlvMesh), ("settings", POINTER(RlvRepairSettings)), ("progress", RlvProgress), ("user", c_void_p), ("report", POINTER(RlvRepairReport))]),
    "rlv_repair_mesh": (RlvResult, [("mesh", RlvMesh), ("settings", POINTER(RlvRepairSettings)), ("progress", RlvProgress), ("user", c_void_p), ("report", POINTER(RlvRepairReport)), ("out", POINTER(RlvMesh))]),
    "rlv_repair_arrays": (RlvResult, [("context", RlvContext), ("arrays", POINTER(RlvMeshArrays)), ("attributes", POINTER(RlvAttributeArrays)), ("attribute_count", c_size_t), ("settings", POINTER(RlvRepairSettings)), ("progress", RlvProgress), ("user", c_void_p), ("report", POINTER(RlvRepairReport)), ("out", POINTER(RlvMesh))]),
    "rlv_repair_read": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("settings", POINTER(RlvRepairSettings)), ("progress", RlvProgress), ("user", c_void_p), ("report", POINTER(RlvRepairReport)), ("out", POINTER(RlvMesh))]),
    "rlv_tissue_build": (RlvResult, [("context", RlvContext), ("description", POINTER(RlvTissueDescription)), ("progress", RlvProgress), ("user", c_void_p), ("report", POINTER(RlvTissueReport)), ("out", POINTER(RlvTissue))]),
    "rlv_tissue_block": (RlvResult, [("context", RlvContext), ("low", c_double_p), ("cell", c_float_p), ("counts", c_uint32_p), ("material", POINTER(RlvTissueMaterial)), ("out", POINTER(RlvTissue))]),
    "rlv_tissue_scan": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("labels", POINTER(RlvTissueLabels)), ("report", POINTER(RlvTissueReport)), ("out", POINTER(RlvTissue))]),
    "rlv_tissue_from_grid": (RlvResult, [("grid", RlvGrid), ("labels", POINTER(RlvTissueLabels)), ("report", POINTER(RlvTissueReport)), ("out", POINTER(RlvTissue))]),
    "rlv_tissue_read": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("out", POINTER(RlvTissue))]),
    "rlv_tissue_write": (RlvResult, [("tissue", RlvTissue), ("path", c_char_p)]),
    "rlv_tissue_read_bytes": (RlvResult, [("context", RlvContext), ("bytes", c_uint8_p), ("size", c_size_t), ("out", POINTER(RlvTissue))]),
    "rlv_tissue_write_bytes": (RlvResult, [("tissue", RlvTissue), ("out", POINTER(RlvBytes))]),
    "rlv_tissue_retain": (RlvResult, [("tissue", RlvTissue)]),
    "rlv_tissue_release": (RlvResult, [("tissue", RlvTissue)]),
    "rlv_tissue_info": (RlvResult, [("tissue", RlvTissue), ("out", POINTER(RlvTissueInfo))]),
    "rlv_tissue_get_nodes": (RlvResult, [("tissue", RlvTissue), ("nodes", c_float_p), ("count", c_size_t), ("stride", c_size_t)]),
    "rlv_tissue_get_elements": (RlvResult, [("tissue", RlvTissue), ("nodes", c_uint32_p), ("materials", c_uint32_p), ("count", c_size_t)]),
    "rlv_tissue_find_muscle": (RlvResult, [("tissue", RlvTissue), ("name", c_char_p), ("out", c_uint32_p)]),
    "rlv_tissue_muscle": (RlvResult, [("tissue", RlvTissue), ("index", c_uint32), ("out", POINTER(RlvTissueMuscle))]),
    "rlv_tissue_find_set": (RlvResult, [("tissue", RlvTissue), ("name", c_char_p), ("out", c_uint32_p)]),
    "rlv_tissue_set": (RlvResult, [("tissue", RlvTissue), ("index", c_uint32), ("out", POINTER(RlvTissueSet))]),
    "rlv_tissue_get_set": (RlvResult, [("tissue", RlvTissue), ("index", c_uint32), ("nodes", c_uint32_p), ("count", c_size_t)]),
    "rlv_tissue_add_set": (RlvResult, [("tissue", RlvTissue), ("name", c_char_p), ("low", c_double_p), ("high", c_double_p), ("out", c_uint32_p)]),
    "rlv_tissue_hold": (RlvResult, [("tissue", RlvTissue), ("nodes", c_uint32_p), ("count", c_size_t), ("stride", c_size_t), ("axes", c_uint32)]),
    "rlv_tissue_bind": (RlvResult, [("tissue", RlvTissue), ("mesh", RlvMesh), ("name", c_char_p), ("out", c_uint32_p)]),
    "rlv_tissue_simulate": (RlvResult, [("tissue", RlvTissue), ("options", POINTER(RlvTissueOptions)), ("out", POINTER(RlvTissueSimulation))]),
    "rlv_tissue_simulation_retain": (RlvResult, [("simulation", RlvTissueSimulation)]),
    "rlv_tissue_simulation_release": (RlvResult, [("simulation", RlvTissueSimulation)]),
    "rlv_tissue_simulation_info": (RlvResult, [("simulation", RlvTissueSimulation), ("out", POINTER(RlvTissueSimulationInfo))]),
    "rlv_tissue_simulation_energies": (RlvResult, [("simulation", RlvTissueSimulation), ("out", POINTER(RlvTissueEnergies))]),
    "rlv_tissue_simulation_activate": (RlvResult, [("simulation", RlvTissueSimulation), ("muscle", c_uint32), ("times", c_double_p), ("values", c_float_p), ("count", c_size_t)]),
    "rlv_tissue_simulation_drive": (RlvResult, [("simulation", RlvTissueSimulation), ("nodes", c_uint32_p), ("count", c_size_t), ("axes", c_uint32), ("times", c_double_p), ("displacements", c_float_p), ("key_count", c_size_t)]),
    "rlv_tissue_simulation_load": (RlvResult, [("simulation", RlvTissueSimulation), ("forces", c_float_p), ("count", c_size_t), ("stride", c_size_t)]),
    "rlv_tissue_simulation_press": (RlvResult, [("simulation", RlvTissueSimulation), ("nodes", c_uint32_p), ("count", c_size_t), ("times", c_double_p), ("pressures", c_float_p), ("key_count", c_size_t)]),
    "rlv_tissue_simulation_add_collider": (RlvResult, [("simulation", RlvTissueSimulation), ("collider", POINTER(RlvTissueCollider))]),
    "rlv_tissue_simulation_step": (RlvResult, [("simulation", RlvTissueSimulation), ("count", c_uint64)]),
    "rlv_tissue_simulation_advance": (RlvResult, [("simulation", RlvTissueSimulation), ("seconds", c_double), ("progress", RlvProgress), ("user", c_void_p)]),
    "rlv_tissue_simulation_relax": (RlvResult, [("simulation", RlvTissueSimulation), ("tolerance", c_float), ("steps", c_uint64), ("progress", RlvProgress), ("user", c_void_p), ("out", POINTER(RlvTissueRelaxation))]),
    "rlv_tissue_simulation_get": (RlvResult, [("simulation", RlvTissueSimulation), ("arrays", POINTER(RlvTissueArrays))]),
    "rlv_tissue_simulation_get_bound": (RlvResult, [("simulation", RlvTissueSimulation), ("index", c_uint32), ("points", c_float_p), ("count", c_size_t), ("stride", c_size_t)]),
    "rlv_tissue_simulation_mesh": (RlvResult, [("simulation", RlvTissueSimulation), ("index", c_uint32), ("out", POINTER(RlvMesh))]),
    "rlv_tissue_simulation_save": (RlvResult, [("simulation", RlvTissueSimulation), ("path", c_char_p)]),
    "rlv_tissue_simulation_restore": (RlvResult, [("simulation", RlvTissueSimulation), ("path", c_char_p)]),
    "rlv_tissue_simulation_save_bytes": (RlvResult, [("simulation", RlvTissueSimulation), ("out", POINTER(RlvBytes))]),
    "rlv_tissue_simulation_restore_bytes": (RlvResult, [("simulation", RlvTissueSimulation), ("bytes", c_uint8_p), ("size", c_size_t)]),
    "rlv_tissue_simulation_write_vtu": (RlvResult, [("simulation", RlvTissueSimulation), ("path", c_char_p)]),
    "rlv_tissue_simulation_write_vdb": (RlvResult, [("simulation", RlvTissueSimulation), ("path", c_char_p)]),
    "rlv_job_tessellate": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvTessellateOptions)), ("out", POINTER(RlvJob))]),
    "rlv_job_sweep": (RlvResult, [("detail", RlvDetail), ("collider", RlvCollider), ("from", c_double_p), ("to", c_double_p), ("settings", POINTER(RlvImprintSettings)), ("moment", POINTER(RlvImprintMoment)), ("out", POINTER(RlvJob))]),
    "rlv_job_sweep_points": (RlvResult, [("detail", RlvDetail), ("collider", RlvCollider), ("from", c_double_p), ("to", c_double_p), ("from_points", c_float_p), ("to_points", c_float_p), ("count", c_size_t), ("stride", c_size_t), ("settings", POINTER(RlvImprintSettings)), ("moment", POINTER(RlvImprintMoment)), ("out", POINTER(RlvJob))]),
    "rlv_job_bake": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvBakeOptions)), ("path", c_char_p), ("out", POINTER(RlvJob))]),
    "rlv_job_ptex_write": (RlvResult, [("detail", RlvDetail), ("channel", c_uint32), ("path", c_char_p), ("out", POINTER(RlvJob))]),
    "rlv_job_ptex_read": (RlvResult, [("detail", RlvDetail), ("path", c_char_p), ("options", POINTER(RlvPtexOptions)), ("out", POINTER(RlvJob))]),
    "rlv_job_transfer": (RlvResult, [("context", RlvContext), ("mesh", RlvMesh), ("path", c_char_p), ("to_path", c_char_p), ("options", POINTER(RlvTransferOptions)), ("out", POINTER(RlvJob))]),
    "rlv_job_progressive": (RlvResult, [("mesh", RlvMesh), ("options", POINTER(RlvProgressiveOptions)), ("out", POINTER(RlvJob))]),
    "rlv_job_simplify": (RlvResult, [("mesh", RlvMesh), ("options", POINTER(RlvSimplifyOptions)), ("out", POINTER(RlvJob))]),
    "rlv_job_repair": (RlvResult, [("mesh", RlvMesh), ("settings", POINTER(RlvRepairSettings)), ("out", POINTER(RlvJob))]),
    "rlv_job_isosurface": (RlvResult, [("isosurface", RlvIsosurface), ("options", POINTER(RlvIsosurfaceMeshOptions)), ("out", POINTER(RlvJob))]),
    "rlv_job_grid_read": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("name", c_char_p), ("bounds", c_double_p), ("out", POINTER(RlvJob))]),
    "rlv_job_grid_from_mesh": (RlvResult, [("mesh", RlvMesh), ("settings", POINTER(RlvGridSettings)), ("out", POINTER(RlvJob))]),
    "rlv_job_grid_change": (RlvResult, [("grid", RlvGrid), ("change", c_uint32), ("settings", POINTER(RlvGridSettings)), ("out", POINTER(RlvJob))]),
    "rlv_job_grid_mesh": (RlvResult, [("grid", RlvGrid), ("settings", POINTER(RlvGridSettings)), ("out", POINTER(RlvJob))]),
    "rlv_job_decal_on_mesh": (RlvResult, [("mesh", RlvMesh), ("options", POINTER(RlvDecalOptions)), ("pins", POINTER(RlvDecalPin)), ("count", c_size_t), ("stride", c_size_t), ("out", POINTER(RlvJob))]),
    "rlv_job_decal_on_detail": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvDecalOptions)), ("pins", POINTER(RlvDecalPin)), ("count", c_size_t), ("stride", c_size_t), ("out", POINTER(RlvJob))]),
    "rlv_job_crowd": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("clips", POINTER(RlvCrowdClipName)), ("clip_count", c_size_t), ("settings", POINTER(RlvCrowdBuildSettings)), ("out", POINTER(RlvJob))]),
    "rlv_job_crowd_refit": (RlvResult, [("model", RlvCrowdModel), ("path", c_char_p), ("clips", POINTER(RlvCrowdClipName)), ("clip_count", c_size_t), ("settings", POINTER(RlvCrowdBuildSettings)), ("out", POINTER(RlvJob))]),
    "rlv_job_crowd_model_with_blend": (RlvResult, [("model", RlvCrowdModel), ("blend", c_uint32), ("out", POINTER(RlvJob))]),
    "rlv_job_fluid": (RlvResult, [("fluid", RlvFluid), ("seconds", c_double), ("out", POINTER(RlvJob))]),
    "rlv_job_tissue_build": (RlvResult, [("context", RlvContext), ("description", POINTER(RlvTissueDescription)), ("out", POINTER(RlvJob))]),
    "rlv_job_tissue_advance": (RlvResult, [("simulation", RlvTissueSimulation), ("seconds", c_double), ("out", POINTER(RlvJob))]),
    "rlv_job_client_submit": (RlvResult, [("client", RlvClient), ("scene", POINTER(RlvClientScene)), ("out", POINTER(RlvJob))]),
    "rlv_job_client_fetch": (RlvResult, [("client", RlvClient), ("scene", c_char_p), ("frame", c_uint64), ("fetch", POINTER(RlvClientFetch)), ("out", POINTER(RlvJob))]),
    "rlv_job_client_fetch_mesh": (RlvResult, [("client", RlvClient), ("scene", c_char_p), ("frame", c_uint64), ("settings", c_char_p), ("out", POINTER(RlvJob))]),
    "rlv_job_surface_create": (RlvResult, [("context", RlvContext), ("cage", RlvMesh), ("options", POINTER(RlvSurfaceOptions)), ("out", POINTER(RlvJob))]),
    "rlv_job_caster_create_mesh": (RlvResult, [("context", RlvContext), ("mesh", RlvMesh), ("out", POINTER(RlvJob))]),
    "rlv_job_caster_create_detail": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvTessellateOptions)), ("out", POINTER(RlvJob))]),
    "rlv_job_caster_create_tessellation": (RlvResult, [("tessellation", RlvTessellation), ("out", POINTER(RlvJob))]),
    "rlv_job_procedural_create": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvProceduralOptions)), ("out", POINTER(RlvJob))]),
    "rlv_job_procedural_create_moving": (RlvResult, [("begin", RlvProcedural), ("end", RlvDetail), ("out", POINTER(RlvJob))]),
    "rlv_job_collider_create_mesh": (RlvResult, [("context", RlvContext), ("mesh", RlvMesh), ("matrix", c_double_p), ("out", POINTER(RlvJob))]),
    "rlv_job_collider_create_surface": (RlvResult, [("surface", RlvSurface), ("options", POINTER(RlvTessellateOptions)), ("matrix", c_double_p), ("out", POINTER(RlvJob))]),
    "rlv_job_collider_create_detail": (RlvResult, [("detail", RlvDetail), ("options", POINTER(RlvTessellateOptions)), ("out", POINTER(RlvJob))]),
    "rlv_job_mesh_read": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("out", POINTER(RlvJob))]),
    "rlv_job_mesh_write": (RlvResult, [("mesh", RlvMesh), ("path", c_char_p), ("out", POINTER(RlvJob))]),
    "rlv_job_particles_read": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("out", POINTER(RlvJob))]),
    "rlv_job_particles_write": (RlvResult, [("particles", RlvParticles), ("path", c_char_p), ("out", POINTER(RlvJob))]),
    "rlv_job_progressive_read": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("triangles", c_size_t), ("out", POINTER(RlvJob))]),
    "rlv_job_progressive_write": (RlvResult, [("progressive", RlvProgressive), ("path", c_char_p), ("out", POINTER(RlvJob))]),
    "rlv_job_crowd_model_read": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("out", POINTER(RlvJob))]),
    "rlv_job_crowd_model_write": (RlvResult, [("model", RlvCrowdModel), ("path", c_char_p), ("out", POINTER(RlvJob))]),
    "rlv_job_tissue_read": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("out", POINTER(RlvJob))]),
    "rlv_job_tissue_write": (RlvResult, [("tissue", RlvTissue), ("path", c_char_p), ("out", POINTER(RlvJob))]),
    "rlv_job_grid_write": (RlvResult, [("grids", POINTER(RlvGrid)), ("count", c_size_t), ("path", c_char_p), ("writing", c_uint32), ("out", POINTER(RlvJob))]),
    "rlv_job_picture_open": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("out", POINTER(RlvJob))]),
    "rlv_job_document_create": (RlvResult, [("detail", RlvDetail), ("path", c_char_p), ("memory", c_uint64), ("out", POINTER(RlvJob))]),
    "rlv_job_document_open": (RlvResult, [("detail", RlvDetail), ("path", c_char_p), ("memory", c_uint64), ("out", POINTER(RlvJob))]),
    "rlv_job_document_save": (RlvResult, [("document", RlvDocument), ("path", c_char_p), ("out", POINTER(RlvJob))]),
    "rlv_job_document_open_bytes": (RlvResult, [("detail", RlvDetail), ("bytes", c_uint8_p), ("size", c_size_t), ("memory", c_uint64), ("out", POINTER(RlvJob))]),
    "rlv_job_document_save_bytes": (RlvResult, [("document", RlvDocument), ("out", POINTER(RlvJob))]),
    "rlv_job_document_compact": (RlvResult, [("context", RlvContext), ("path", c_char_p), ("keep", c_size_t), ("out", POINTER(RlvJob))]),
    "rlv_job_retain": (RlvResult, [("job", RlvJob)]),
    "rlv_job_release": (RlvResult, [("job", RlvJob)]),
    "rlv_job_poll": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvJobInfo))]),
    "rlv_job_wait": (RlvResult, [("job", RlvJob), ("seconds", c_double), ("out", POINTER(RlvJobInfo))]),
    "rlv_job_notify": (RlvResult, [("job", RlvJob), ("callback", RlvJobDone), ("user", c_void_p)]),
    "rlv_job_cancel": (RlvResult, [("job", RlvJob)]),
    "rlv_job_result": (RlvResult, [("job", RlvJob)]),
    "rlv_job_mesh": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvMesh))]),
    "rlv_job_simplify_error": (RlvResult, [("job", RlvJob), ("out", c_float_p)]),
    "rlv_job_repair_report": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvRepairReport))]),
    "rlv_job_progressive_mesh": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvProgressive))]),
    "rlv_job_grid": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvGrid))]),
    "rlv_job_decal": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvDecal))]),
    "rlv_job_tissue": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvTissue))]),
    "rlv_job_tissue_report": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvTissueReport))]),
    "rlv_job_particles": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvParticles))]),
    "rlv_job_client_status": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvClientStatus))]),
    "rlv_job_surface": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvSurface))]),
    "rlv_job_caster": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvCaster))]),
    "rlv_job_procedural": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvProcedural))]),
    "rlv_job_collider": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvCollider))]),
    "rlv_job_picture": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvPicture))]),
    "rlv_job_document": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvDocument))]),
    "rlv_job_bytes": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvBytes))]),
    "rlv_job_crowd_model": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvCrowdModel))]),
    "rlv_job_crowd_refit_report": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvCrowdRefitReport))]),
    "rlv_job_imprint_report": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvImprintReport))]),
    "rlv_job_bake_report": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvBakeReport))]),
    "rlv_job_fluid_report": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvFluidReport))]),
    "rlv_job_ptex_report": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvPtexReport))]),
    "rlv_job_transfer_report": (RlvResult, [("job", RlvJob), ("out", POINTER(RlvTransferReport))]),
    "rlv_object_wait": (RlvResult, [("id", c_uint64), ("seconds", c_double), ("out", POINTER(RlvObjectInfo))]),
    "rlv_shader_create": (RlvResult, [("source", c_char_p), ("options", POINTER(RlvShaderOptions)), ("out", POINTER(RlvShader))]),
    "rlv_shader_retain": (RlvResult, [("shader", RlvShader)]),
    "rlv_shader_release": (RlvResult, [("shader", RlvShader)]),
    "rlv_shader_variable_count": (RlvResult, [("shader", RlvShader), ("out", c_size_t_p)]),
    "rlv_shader_variable": (RlvResult, [("shader", RlvShader), ("index", c_size_t), ("out", POINTER(RlvShaderVariable))]),
    "rlv_shader_mark": (RlvResult, [("shader", RlvShader), ("variables", c_uint32_p), ("count", c_size_t), ("weight", c_char_p), ("out", POINTER(RlvShader))]),
    "rlv_shader_text": (RlvResult, [("shader", RlvShader), ("kind", c_uint32), ("text", c_char_p), ("size", c_size_t), ("length", c_size_t_p)]),
    "rlv_shader_layout": (RlvResult, [("shader", RlvShader), ("out", POINTER(RlvShaderLayout))]),
    "rlv_shader_feature": (RlvResult, [("shader", RlvShader), ("index", c_size_t), ("out", POINTER(RlvShaderFeature))]),
    "rlv_shader_pack_examples": (RlvResult, [("examples", POINTER(RlvShaderExamples)), ("mode", c_uint32), ("x", c_uint32), ("y", c_uint32), ("words", c_uint32_p), ("capacity", c_size_t), ("count", c_size_t_p)]),
    "rlv_shader_unpack_log": (RlvResult, [("shader", RlvShader), ("words", c_uint32_p), ("count", c_size_t), ("vector", c_float_p), ("capacity", c_size_t), ("taken", c_uint32_p)]),
    "rlv_shader_membership": (RlvResult, [("examples", POINTER(RlvShaderExamples)), ("vectors", c_float_p), ("count", c_size_t), ("stride", c_size_t), ("out", c_float_p)]),
    "rlv_subdivision_create": (RlvResult, [("context", RlvContext), ("cage", RlvMesh), ("options", POINTER(RlvSubdivisionOptions)), ("out", POINTER(RlvSubdivision))]),
    "rlv_subdivision_retain": (RlvResult, [("subdivision", RlvSubdivision)]),
    "rlv_subdivision_release": (RlvResult, [("subdivision", RlvSubdivision)]),
    "rlv_subdivision_info": (RlvResult, [("subdivision", RlvSubdivision), ("out", POINTER(RlvSubdivisionInfo))]),
    "rlv_subdivision_set_points": (RlvResult, [("subdivision", RlvSubdivision), ("points", c_float_p), ("count", c_size_t), ("stride", c_size_t)]),
    "rlv_subdivision_face_tiles": (RlvResult, [("subdivision", RlvSubdivision), ("face", c_uint32), ("first", c_uint32_p), ("count", c_uint32_p)]),
    "rlv_subdivision_evaluate": (RlvResult, [("subdivision", RlvSubdivision), ("attribute", c_char_p), ("arrays", POINTER(RlvSubdivisionArrays))]),
    "rlv_subdivision_refine": (RlvResult, [("subdivision", RlvSubdivision), ("level", c_uint32), ("out", POINTER(RlvMesh))]),
    "rlv_vulkan_create_context": (RlvResult, [("device", POINTER(RlvVulkanDevice)), ("options", POINTER(RlvContextOptions)), ("out", POINTER(RlvContext))]),
    "rlv_vulkan_create_buffer": (RlvResult, [("tessellation", RlvTessellation), ("buffers", POINTER(RlvVulkanBuffers)), ("out", POINTER(RlvBuffer))]),
    "rlv_vulkan_wait": (RlvResult, [("context", RlvContext), ("semaphore", c_uint64), ("value", c_uint64)]),
    "rlv_vulkan_signal": (RlvResult, [("context", RlvContext), ("semaphore", c_uint64), ("value", c_uint64)]),
}
