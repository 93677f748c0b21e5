"""Triangles of a detail that follow its commits."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import integer, rest, writing
from .handle import Handle, held
from .hint import Array, ArrayLike
from .mesh import Mesh
from .parameter import address_of
from .surface import tessellate_options

if TYPE_CHECKING:
    from .detail import Detail


class Tessellation(Handle):
    """Triangles of a detail; `update` renews the points of the tiles that changed, `changed_ranges` says which did."""

    noun, kind = "tessellation", abi.RlvTessellation

    def __init__(self, detail: Detail, **options: Any) -> None:
        """Options are the fields of `abi.RlvTessellateOptions`."""
        super().__init__("rlv_tessellation_create", held(detail, "detail"), tessellate_options(options))

    @property
    def info(self) -> Any:
        """Counts and the revision."""
        out = record.empty(abi.RlvTessellationInfo)
        library.call("rlv_tessellation_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def update(self) -> Any:
        """Brings the points to the detail's last commit and says what was written."""
        out = record.empty(abi.RlvTessellationChanges)
        library.call("rlv_tessellation_update", self.handle, ctypes.byref(out))
        return record.read(out)

    def changed_ranges(self) -> Array:
        """The ranges of points that the last update changed: (first, count)."""
        count = ctypes.c_size_t()
        library.call("rlv_tessellation_changed_ranges", self.handle, None, 0, address_of(count))
        out, place, _ = writing(None, count.value, numpy.uint32, 2, "ranges")
        library.call("rlv_tessellation_changed_ranges", self.handle, place, len(out), address_of(count))
        return out[: count.value]

    def points(
        self, first: int = 0, count: int | None = None, positions: ArrayLike | None = None, normals: ArrayLike | None = None
    ) -> tuple[Array, Array]:
        """Positions and unit normals of count points from first on, written to the arrays if they are given."""
        count = rest(self.info.point_count, first) if count is None else integer(count, "count")
        positions, positions_at, position_stride = writing(positions, count, numpy.float32, 3, "positions")
        normals, normals_at, normal_stride = writing(normals, count, numpy.float32, 3, "normals")
        arrays = (positions_at, position_stride, normals_at, normal_stride)
        library.call("rlv_tessellation_get_points", self.handle, first, count, *arrays)
        return positions, normals

    def positions(self, first: int = 0, count: int | None = None, out: Array | None = None) -> Array:
        """Positions alone."""
        count = rest(self.info.point_count, first) if count is None else integer(count, "count")
        out, place, stride = writing(out, count, numpy.float32, 3, "positions")
        library.call("rlv_tessellation_get_points", self.handle, first, count, place, stride, None, 0)
        return out

    def colors(self, first: int = 0, count: int | None = None, out: Array | None = None) -> Array:
        """Colours, linear Rec.709 (n, 3)."""
        return self._values("rlv_tessellation_get_colors", first, count, out)

    def traces(self, first: int = 0, count: int | None = None, out: Array | None = None) -> Array:
        """Contact, depth and age (n, 3)."""
        return self._values("rlv_tessellation_get_traces", first, count, out)

    def _values(self, function: str, first: Any, count: Any, out: Any) -> Array:
        count = rest(self.info.point_count, first) if count is None else integer(count, "count")
        out, place, stride = writing(out, count, numpy.float32, 3, "values")
        library.call(function, self.handle, first, count, place, stride)
        return out

    def mesh(self) -> Mesh:
        """A copy of all triangles with their attributes."""
        return Mesh.of("rlv_tessellation_mesh", self.handle)
