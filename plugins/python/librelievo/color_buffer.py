"""Color buffers: colours of a detail and their mips in the memory of a graphics device."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import writing
from .handle import Handle, held
from .parameter import address_of

if TYPE_CHECKING:
    from .detail import Detail


class ColorBuffer(Handle):
    """The colours of a detail on the device of its context; `update` follows its commits."""

    noun, kind = "color_buffer", abi.RlvColorBuffer

    def __init__(self, detail: Detail) -> None:
        super().__init__("rlv_color_buffer_create", held(detail, "detail"))

    @property
    def info(self) -> Any:
        """Counts, bytes, and the colour of tiles without a block."""
        out = record.empty(abi.RlvColorBufferInfo)
        library.call("rlv_color_buffer_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def update(self) -> Any:
        """Brings it to the detail's last commit and says what was written."""
        out = record.empty(abi.RlvColorBufferInfo)
        library.call("rlv_color_buffer_update", self.handle, ctypes.byref(out))
        return record.read(out)

    def vulkan(self) -> Any:
        """Its Vulkan objects as numbers; see buffer.h for who may use them when."""
        out = record.empty(abi.RlvColorBufferVulkan)
        library.call("rlv_color_buffer_vulkan", self.handle, ctypes.byref(out))
        return record.read(out)

    def block(self, tile: int, level: int = 0) -> bytes:
        """The bytes of a tile at a level, 0 for itself, copied back from the device; none if it has none."""
        size = ctypes.c_size_t()
        library.call("rlv_color_buffer_read", self.handle, tile, level, None, 0, address_of(size))
        out, place, _ = writing(None, size.value, numpy.uint8, 0, "block")
        library.call("rlv_color_buffer_read", self.handle, tile, level, place, len(out), address_of(size))
        return out[: size.value].tobytes()
