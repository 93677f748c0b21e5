"""Progressive meshes: triangle meshes that are taken as coarse or as fine as they are needed."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import SIZE, Reading, integer
from .bytes import given, made
from .handle import Handle, held, path_bytes
from .hint import ArrayLike, FilePath, Progress
from .mesh import weights_of
from .progress import watched

if TYPE_CHECKING:
    from .context import Context
    from .mesh import Mesh


def options_of(base_triangles: Any, locked: Any, weights: Any = None, left_out: Any = None) -> tuple[Any, ...]:
    """`abi.RlvProgressiveOptions`, and what keeps their arrays. Attributes are kept if `weights` or `left_out` is no None."""
    options = record.empty(abi.RlvProgressiveOptions)
    if base_triangles is not None:
        options.base_triangles = integer(base_triangles, "base_triangles", SIZE)
    locked = Reading(locked, numpy.uint32, 0, "locked")
    options.locked, options.locked_count, options.locked_stride = locked.address, locked.count, locked.stride
    options.keeps_attributes = int(weights is not None or left_out is not None)
    entries = weights_of(weights, left_out)
    options.weights, options.weight_count = entries, len(entries)
    return options, (locked, entries)


class Progressive(Handle):
    """A coarse base mesh and the splits that make it fine again. It does not change."""

    noun, kind = "progressive", abi.RlvProgressive

    def __init__(
        self,
        mesh: Mesh,
        base_triangles: int | None = None,
        locked: ArrayLike | None = None,
        progress: Progress | None = None,
        weights: Mapping[str, float] | None = None,
        left_out: Iterable[str] | None = None,
    ) -> None:
        """Builds one of a mesh's triangles, down to a base of so many; `locked` points stay at all levels. With `weights`
        by names of attributes, which may be {}, or names that are `left_out` it has the attributes of the mesh."""
        options, kept = options_of(base_triangles, locked, weights, left_out)
        with watched(progress) as callback:
            super().__init__("rlv_progressive_create", held(mesh, "mesh"), ctypes.byref(options), callback, None)
        del kept

    @classmethod
    def read(cls, context: Context, path: FilePath, triangles: int | None = None) -> Progressive:
        """Reads a file, or as much of it as so many triangles need."""
        most = ctypes.c_size_t(-1).value if triangles is None else triangles
        return cls.of("rlv_progressive_read", held(context, "context"), path_bytes(path), most)

    def write(self, path: FilePath) -> None:
        """Writes a file (.rlvpm)."""
        library.call("rlv_progressive_write", self.handle, path_bytes(path))

    @classmethod
    def read_bytes(cls, context: Context, data: bytes | bytearray | memoryview, triangles: int | None = None) -> Progressive:
        """As `read`, from the bytes of a file."""
        address, size, _kept = given(data)
        most = ctypes.c_size_t(-1).value if triangles is None else triangles
        return cls.of("rlv_progressive_read_bytes", held(context, "context"), address, size, most)

    def write_bytes(self) -> bytes:
        """The bytes of the file that `write` writes."""
        return made("rlv_progressive_write_bytes", self.handle)

    @property
    def info(self) -> Any:
        """Counts of its finest and coarsest meshes, and bytes."""
        out = record.empty(abi.RlvProgressiveInfo)
        library.call("rlv_progressive_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def attributes(self) -> Any:
        """What its attributes are, those of wedges first; see `abi.RlvAttributeInfo`."""
        found = []
        for index in range(self.info.attribute_count):
            out = record.empty(abi.RlvAttributeInfo)
            library.call("rlv_progressive_attribute_info", self.handle, index, ctypes.byref(out))
            found.append(record.read(out))
        return found
