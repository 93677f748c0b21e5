"""Relievo: surfaces that take imprints, paint and sculpting, from Python.

A module per noun of the C ABI: its headers in include/relievo say what everything means, with shapes, units and ranges.
Arrays are NumPy's, failures are exceptions, and options are keywords called as the fields of the structs.
"""

from __future__ import annotations

try:
    import numpy  # noqa: F401
except ImportError:
    raise ImportError("librelievo needs NumPy; install it with `python -m pip install numpy`") from None

from . import abi, bake, brush, caster, collider, crowd, diffuse, document, foam, grid, imprint, job, ptex, repair
from . import shader, stroke, tessellation
from .abi import RlvAdapterKind as AdapterKind
from .abi import RlvBrushAction as BrushAction
from .abi import RlvChannel as Channel
from .abi import RlvClientState as ClientState
from .abi import RlvContent as Content
from .abi import RlvDevice as Device
from .abi import RlvElement as Element
from .abi import RlvFoamKind as FoamKind
from .abi import RlvIsosurfaceClass as IsosurfaceClass
from .abi import RlvJobState as JobState
from .abi import RlvParameterKind as ParameterKind
from .abi import RlvShaderClass as ShaderClass
from .abi import RlvShaderMode as ShaderMode
from .adapter import adapters
from .allocator import allocator_info, set_allocator, set_memory_limit
from .arrival import Arrival
from .bezier import Bezier
from .brush import Brush
from .buffer import Buffer
from .capability import capability, formats
from .caster import Caster
from .collider import Collider
from .color_buffer import ColorBuffer
from .connection import Connection
from .context import Context
from .crowd import Crowd, CrowdModel, DeviceCrowd
from .crowd_stream import CrowdStream
from .decal import Decal
from .detail import Detail
from .diffuse import Diffuse
from .document import Document
from .error import (
    Busy,
    Cancelled,
    DeviceFailure,
    FileFailure,
    Internal,
    Invalid,
    LibraryMissing,
    MemoryLimit,
    NotFound,
    RelievoError,
    Unsupported,
)
from .fluid import Fluid
from .foam import Foam
from .grid import Grid
from .isosurface import Isosurface
from .job import Job
from .level import DeviceLevel, Grip, GripKey, GripTrack, Level, Region
from .library import load, version
from .mesh import Mesh
from .parameter import Parameter
from .particles import Particles
from .picture import Picture
from .procedural import Procedural
from .progressive import Progressive
from .shader import Shader, ShaderExamples
from .stroke import Stroke
from .subdivision import Subdivision
from .surface import Surface
from .tessellation import Tessellation
from .tissue import Tissue, TissueSimulation
