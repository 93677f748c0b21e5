"""Displaced surfaces as user geometry of a renderer's own Embree scene."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, flag, writing
from .error import Invalid
from .handle import Handle, held
from .hint import Array, ArrayLike

if TYPE_CHECKING:
    from .detail import Detail


class Procedural(Handle):
    """Primitives of a detail as it was committed. Renderers call the functions of `table`, not Python."""

    noun, kind = "procedural", abi.RlvProcedural

    def __init__(self, detail: Detail, **options: Any) -> None:
        """Options are the fields of `abi.RlvProceduralOptions`."""
        options = ctypes.byref(record.fill(abi.RlvProceduralOptions, options))
        super().__init__("rlv_procedural_create", held(detail, "detail"), options)

    def moving(self, end: Any) -> Any:
        """The surface that moves from here to the detail as it was committed last."""
        return self.of("rlv_procedural_create_moving", self.handle, held(end, "end"))

    @property
    def info(self) -> Any:
        out = record.empty(abi.RlvProceduralInfo)
        library.call("rlv_procedural_info", self.handle, ctypes.byref(out))
        return record.read(out)

    @property
    def table(self) -> Array:
        """The struct `abi.RlvProceduralTable`, for a renderer as long as this object lives."""
        out = record.empty(abi.RlvProceduralTable)
        library.call("rlv_procedural_table", self.handle, ctypes.byref(out))
        return out

    def evaluate(self, primitives: ArrayLike, uvs: ArrayLike, times: ArrayLike | None = None, colors: bool = False) -> Any:
        """What is at hits, a dictionary: tiles, positions, normals, and colors if they are wanted."""
        primitives = Reading(primitives, numpy.uint32, 0, "primitives")
        uvs = Reading(uvs, numpy.float32, 2, "uvs")
        times = Reading(times, numpy.float32, 0, "times")
        if uvs.count != primitives.count or times.address and times.count != primitives.count:
            raise Invalid(f"uvs: there are {uvs.count} for {primitives.count} primitives")
        hits = record.empty(abi.RlvProceduralHits)
        hits.count = primitives.count
        for name, given in (("primitives", primitives), ("uvs", uvs), ("times", times)):
            setattr(hits, name, given.address)
            setattr(hits, name.removesuffix("s") + "_stride", given.stride)
        found = {}
        wanted = {"tiles": (numpy.uint32, 0), "positions": (numpy.float32, 3), "normals": (numpy.float32, 3)}
        if flag(colors, "colors"):
            wanted["colors"] = (numpy.float32, 4)
        for name, (number, width) in wanted.items():
            found[name], address, stride = writing(None, primitives.count, number, width, name)
            setattr(hits, name, address)
            setattr(hits, name.removesuffix("s") + "_stride", stride)
        library.call("rlv_procedural_evaluate", self.handle, ctypes.byref(hits))
        return found
