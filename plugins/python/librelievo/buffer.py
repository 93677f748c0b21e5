"""Buffers: triangles of a tessellation in the memory of a graphics device."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import integer, rest, writing
from .handle import Handle, held
from .hint import Array

if TYPE_CHECKING:
    from .tessellation import Tessellation


class Buffer(Handle):
    """The points and triangles of a tessellation on the device of its context; `update` follows it."""

    noun, kind = "buffer", abi.RlvBuffer

    def __init__(self, tessellation: Tessellation, vulkan: Mapping[str, int] | None = None) -> None:
        """`vulkan` are buffers of the host that take them, by the fields of `abi.RlvVulkanBuffers`."""
        triangles = held(tessellation, "tessellation")
        if vulkan is None:
            super().__init__("rlv_buffer_create", triangles)
        else:
            given = record.fill(abi.RlvVulkanBuffers, vulkan)
            super().__init__("rlv_vulkan_create_buffer", triangles, ctypes.byref(given))

    @property
    def info(self) -> Any:
        """Counts and bytes."""
        out = record.empty(abi.RlvBufferInfo)
        library.call("rlv_buffer_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def update(self) -> Any:
        """Brings it to the tessellation's last update and says what was written."""
        out = record.empty(abi.RlvBufferInfo)
        library.call("rlv_buffer_update", self.handle, ctypes.byref(out))
        return record.read(out)

    def vulkan(self) -> Any:
        """Its Vulkan objects as numbers; see buffer.h for who may use them when."""
        out = record.empty(abi.RlvBufferVulkan)
        library.call("rlv_buffer_vulkan", self.handle, ctypes.byref(out))
        return record.read(out)

    def points(self, first: int = 0, count: int | None = None, out: Array | None = None) -> Array:
        """Positions and unit normals (n, 6), copied back from the device."""
        count = rest(self.info.point_count, first) if count is None else integer(count, "count")
        out, place, stride = writing(out, count, numpy.float32, 6, "points")
        library.call("rlv_buffer_read", self.handle, first, count, place, stride)
        return out
