"""Bézier patches: bicubic and rational, evaluated and tessellated."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, integer, numbers, writing
from .evaluate import evaluate
from .handle import Handle, held, path_bytes
from .hint import Array, ArrayLike, FilePath
from .mesh import Mesh
from .parameter import address_of

if TYPE_CHECKING:
    from .context import Context


class Bezier(Handle):
    """Patches of 16 control points."""

    noun, kind = "bezier", abi.RlvBezier

    def __init__(
        self, context: Context, points: ArrayLike, indices: ArrayLike | None = None, weights: ArrayLike | None = None
    ) -> None:
        """Points (n, 3), of which `indices` (patches, 16) names those of every patch; a weight for every point."""
        points = Reading(points, numpy.float32, 3, "points")
        weights = Reading(weights, numpy.float32, 0, "weights")
        named = Reading(None if indices is None else numbers(indices, "indices").ravel(), numpy.uint32, 0, "indices")
        arrays = record.empty(abi.RlvBezierArrays)
        arrays.points, arrays.point_count, arrays.point_stride = points.address, points.count, points.stride
        arrays.weights, arrays.weight_stride = weights.address, weights.stride
        arrays.indices, arrays.index_count, arrays.index_stride = named.address, named.count, named.stride
        super().__init__("rlv_bezier_create", held(context, "context"), ctypes.byref(arrays))

    @classmethod
    def read(cls, context: Context, path: FilePath) -> Bezier:
        """The patches of a file."""
        return cls.of("rlv_bezier_read", held(context, "context"), path_bytes(path))

    @property
    def info(self) -> Any:
        """Counts and bounds."""
        out = record.empty(abi.RlvBezierInfo)
        library.call("rlv_bezier_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def controls(self, patch: int) -> Array:
        """Its control points (16, 4): x, y, z and weight."""
        out, place, stride = writing(None, 16, numpy.float32, 4, "controls")
        library.call("rlv_bezier_get_controls", self.handle, patch, place, stride)
        return out

    def evaluate(
        self,
        patches: ArrayLike,
        uvs: ArrayLike,
        wanted: Iterable[str] = ("positions", "normals"),
        out: Mapping[str, Array] | None = None,
    ) -> dict[str, Array]:
        """What is wanted at the places: a dictionary of arrays; see `abi.RlvEvaluateArrays`."""
        return evaluate("rlv_bezier_evaluate", self.handle, patches, uvs, wanted, None, out)

    def levels(self, **view: Any) -> Array:
        """A level for every patch, by the fields of `abi.RlvBezierView`."""
        view = record.fill(abi.RlvBezierView, view)
        out, place, _ = writing(None, self.info.patch_count, numpy.uint32, 0, "levels")
        library.call("rlv_bezier_levels", self.handle, ctypes.byref(view), place, len(out))
        return out

    def tessellate(self, levels: int | ArrayLike = 4) -> tuple[Array, Array, Array]:
        """Positions, normals and triangles at a level, or at one for every patch."""
        levels, kept = _levels(levels)
        points, triangles = ctypes.c_size_t(), ctypes.c_size_t()
        library.call("rlv_bezier_count", self.handle, levels, address_of(points), address_of(triangles))
        room = record.empty(abi.RlvBezierTriangles)
        positions, room.positions, _ = writing(None, points.value, numpy.float32, 3, "positions")
        normals, room.normals, _ = writing(None, points.value, numpy.float32, 3, "normals")
        corners, room.corners, _ = writing(None, triangles.value, numpy.uint32, 3, "corners")
        room.point_capacity, room.triangle_capacity = points.value, triangles.value
        library.call("rlv_bezier_tessellate", self.handle, levels, ctypes.byref(room))
        del kept
        return positions, normals, corners

    def mesh(self, levels: int | ArrayLike = 4) -> Mesh:
        """The same as a mesh whose patches share points."""
        levels, kept = _levels(levels)
        made = Mesh.of("rlv_bezier_mesh", self.handle, levels)
        del kept
        return made


def _levels(levels: Any) -> tuple[Any, ...]:
    """`abi.RlvBezierLevels` of one number or one for every patch, and what keeps their array."""
    made = record.empty(abi.RlvBezierLevels)
    if numbers(levels, "levels").ndim == 0:
        made.level = integer(levels, "levels")
        return ctypes.byref(made), None
    each = Reading(levels, numpy.uint32, 0, "levels")
    made.levels, made.level_count, made.level_stride = each.address, each.count, each.stride
    return ctypes.byref(made), each
