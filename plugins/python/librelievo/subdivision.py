"""Subdivision surfaces as OpenSubdiv has them: all schemes, and attributes as primvars."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, chosen, list_of, writing
from .error import Invalid
from .handle import Handle, held, text_bytes
from .hint import Array, ArrayLike
from .mesh import Mesh
from .parameter import address_of

if TYPE_CHECKING:
    from .context import Context

# What can be evaluated, and the field of its stride in `abi.RlvSubdivisionArrays`.
OUTPUTS = {
    "values": "value_stride",
    "du": "du_stride",
    "dv": "dv_stride",
    "duu": "duu_stride",
    "duv": "duv_stride",
    "dvv": "dvv_stride",
}


class Subdivision(Handle):
    """A cage under a scheme, with its attributes."""

    noun, kind = "subdivision", abi.RlvSubdivision

    def __init__(self, context: Context, cage: Mesh, **options: Any) -> None:
        """Options are the fields of `abi.RlvSubdivisionOptions`: scheme ("catmull_clark", "loop" or "bilinear"), boundary,
        face_varying, creasing, triangle_rule, isolation."""
        enums = {
            "scheme": abi.RlvScheme,
            "boundary": abi.RlvBoundary,
            "face_varying": abi.RlvFaceVarying,
            "creasing": abi.RlvCreasing,
            "triangle_rule": abi.RlvTriangleRule,
        }
        options = record.fill(abi.RlvSubdivisionOptions, options, **enums)
        super().__init__("rlv_subdivision_create", held(context, "context"), held(cage, "cage"), ctypes.byref(options))
        # The numbers of each attribute, which are those of the cage it was made from.
        attributes = (cage.attribute_info(index) for index in range(cage.info.attribute_count))
        self._widths = {attribute.name: attribute.width for attribute in attributes}

    @property
    def info(self) -> Any:
        """Scheme and counts."""
        out = record.empty(abi.RlvSubdivisionInfo)
        library.call("rlv_subdivision_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def set_points(self, points: ArrayLike) -> None:
        """Poses an animated cage."""
        points = Reading(points, numpy.float32, 3, "points")
        library.call("rlv_subdivision_set_points", self.handle, points.address, points.count, points.stride)

    def face_tiles(self, face: int) -> range:
        """The tiles of a face of the cage, as a range."""
        first, count = ctypes.c_uint32(), ctypes.c_uint32()
        library.call("rlv_subdivision_face_tiles", self.handle, face, address_of(first), address_of(count))
        return range(first.value, first.value + count.value)

    def evaluate(
        self,
        tiles: ArrayLike,
        uvs: ArrayLike,
        wanted: Iterable[str] = ("values",),
        attribute: str | None = None,
        rule: str = "vertex",
    ) -> dict[str, Array]:
        """Evaluates the points, or an attribute, at the places (tile, u, v): a dictionary of arrays.

        wanted are names of "values", "du", "dv", "duu", "duv", "dvv"; rule is "vertex" or "varying", of attributes of points.
        """
        tiles = Reading(tiles, numpy.uint32, 0, "tiles")
        uvs = Reading(uvs, numpy.float32, 2, "uvs")
        if tiles.count != uvs.count:
            raise Invalid(f"uvs: there are {uvs.count} for {tiles.count} tiles")
        arrays = record.fill(abi.RlvSubdivisionArrays, {"point_rule": rule}, point_rule=abi.RlvPointRule)
        arrays.count = tiles.count
        arrays.tiles, arrays.tile_stride = tiles.address, tiles.stride
        arrays.uvs, arrays.uv_stride = uvs.address, uvs.stride
        # An unknown attribute is refused by the call.
        called = text_bytes(attribute, "attribute")
        width = 3 if attribute is None else self._widths.get(attribute, 1)
        results = {}
        for name in list_of(wanted, "wanted", OUTPUTS):
            stride_field = chosen(OUTPUTS, name, "wanted")
            results[name], place, stride = writing(None, tiles.count, numpy.float32, width, name)
            setattr(arrays, name, place)
            setattr(arrays, stride_field, stride)
        library.call("rlv_subdivision_evaluate", self.handle, called, ctypes.byref(arrays))
        return results

    def refine(self, level: int) -> Mesh:
        """Makes a mesh of the cage in its present pose, refined `level` times, on the limit surface."""
        return Mesh.of("rlv_subdivision_refine", self.handle, level)
