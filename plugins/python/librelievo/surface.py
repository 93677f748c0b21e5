"""Surfaces: Catmull-Clark limit surfaces of cages, and triangle meshes."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading
from .evaluate import evaluate
from .handle import Handle, held
from .hint import Array, ArrayLike
from .mesh import Mesh
from .parameter import address_of

if TYPE_CHECKING:
    from .context import Context


def tessellate_options(options: Any) -> Any:
    """`abi.RlvTessellateOptions` from keywords."""
    return ctypes.byref(record.fill(abi.RlvTessellateOptions, options))


def surface_options(options: Any) -> Any:
    """`abi.RlvSurfaceOptions` from keywords."""
    enums = {"kind": abi.RlvSurfaceKind, "boundary": abi.RlvBoundary}
    return ctypes.byref(record.fill(abi.RlvSurfaceOptions, options, **enums))


class Surface(Handle):
    """What can be evaluated at places (tile, u, v)."""

    noun, kind = "surface", abi.RlvSurface

    def __init__(self, context: Context, cage: Mesh, **options: Any) -> None:
        """Options are the fields of `abi.RlvSurfaceOptions`: kind ("catmull_clark", "triangles" or "bilinear"), boundary, isolation,
        patch_limit."""
        super().__init__("rlv_surface_create", held(context, "context"), held(cage, "cage"), surface_options(options))

    @property
    def info(self) -> Any:
        """Counts, bounds and extent."""
        out = record.empty(abi.RlvSurfaceInfo)
        library.call("rlv_surface_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def set_points(self, points: ArrayLike) -> None:
        """Poses an animated cage."""
        points = Reading(points, numpy.float32, 3, "points")
        library.call("rlv_surface_set_points", self.handle, points.address, points.count, points.stride)

    def tile_info(self, tile: int) -> Any:
        """The face, corner and bounds of a tile."""
        out = record.empty(abi.RlvTileInfo)
        library.call("rlv_surface_tile_info", self.handle, tile, ctypes.byref(out))
        return record.read(out)

    def face_tiles(self, face: int) -> range:
        """The tiles of a face of the cage, as a range."""
        first, count = ctypes.c_uint32(), ctypes.c_uint32()
        library.call("rlv_surface_face_tiles", self.handle, face, address_of(first), address_of(count))
        return range(first.value, first.value + count.value)

    def evaluate(
        self,
        tiles: ArrayLike,
        uvs: ArrayLike,
        wanted: Iterable[str] = ("positions", "normals"),
        out: Mapping[str, Array] | None = None,
    ) -> dict[str, Array]:
        """What is wanted at the places: a dictionary of arrays; see `abi.RlvEvaluateArrays`."""
        return evaluate("rlv_evaluate_surface", self.handle, tiles, uvs, wanted, None, out)

    def tessellate(self, **options: Any) -> Mesh:
        """A triangle mesh; options are the fields of `abi.RlvTessellateOptions`."""
        return Mesh.of("rlv_tessellate_surface", self.handle, tessellate_options(options))
