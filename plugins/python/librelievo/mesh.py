"""Polygon meshes with attributes and subdivision tags."""

from __future__ import annotations

import ctypes
from collections import namedtuple
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import SIZE, Reading, flag, integer, list_of, mapped, number, numbers, writing
from .bytes import given, made
from .error import Invalid
from .handle import Handle, held, path_bytes, text_bytes
from .hint import Array, ArrayLike, FilePath, Progress
from .parameter import address_of
from .progress import watched

if TYPE_CHECKING:
    from .context import Context

# Functions that the library calls when it uses arrays no more, and those arrays.
_lent: list[list[Any]] = []

Attribute = namedtuple("Attribute", ["name", "domain", "values", "indices"])
TYPES = {abi.RlvType.F32: numpy.float32, abi.RlvType.U32: numpy.uint32}


def set_array(struct: Any, reading: Any, pointer: Any, count: Any, stride: Any) -> None:
    """Puts an array into the three fields that a struct has for it."""
    setattr(struct, pointer, reading.address)
    setattr(struct, count, reading.count)
    setattr(struct, stride, reading.stride)


def weights_of(weights: Any, left_out: Any) -> tuple[Any, ...]:
    """An array of `abi.RlvSimplifyWeight` of weights by names of attributes, and of names that are left out; None for none."""
    names = [] if left_out is None else list_of(left_out, "left_out")
    pairs = [(name, number(weight, "weights"), 0) for name, weight in mapped(weights, "weights").items()]
    pairs += [(name, 0.0, 1) for name in names]
    return (abi.RlvSimplifyWeight * len(pairs))(*((text_bytes(name, "name"), *rest) for name, *rest in pairs))


def simplify_options(
    triangles: int = 0,
    error: Any = None,
    weights: Any = None,
    left_out: Any = (),
    locked: Any = None,
    factors: Any = None,
    bound: Any = None,
    is_border_locked: bool = False,
) -> tuple[Any, ...]:
    """`abi.RlvSimplifyOptions`, and the arrays that it points to."""
    entries = weights_of(weights, left_out)
    options = record.empty(abi.RlvSimplifyOptions)
    options.triangles, options.is_border_locked = integer(triangles, "triangles", SIZE), flag(is_border_locked, "is_border_locked")
    options.error = -1.0 if error is None else number(error, "error")
    options.bound = -1.0 if bound is None else number(bound, "bound")
    options.weights, options.weight_count = entries, len(entries)
    locked = Reading(locked, numpy.uint32, 0, "locked")
    factors = Reading(factors, numpy.float32, 0, "factors")
    set_array(options, locked, "locked", "locked_count", "locked_stride")
    set_array(options, factors, "factors", "factor_count", "factor_stride")
    return options, (entries, locked, factors)


def pair_of(pair: Any, name: str) -> tuple[Any, ...]:
    """Elements and their sharpness, two of None for None."""
    if pair is None:
        return None, None
    try:
        elements, sharpness = pair
    except (TypeError, ValueError):
        raise Invalid(f"{name}: a pair of elements and their sharpness is needed") from None
    return elements, sharpness


def arrays_of(
    points: Any, corners: Any, face_sizes: Any, creases: Any = None, sharp_points: Any = None, holes: Any = None
) -> tuple[Any, ...]:
    """`abi.RlvMeshArrays` as `Mesh` takes them, and the arrays that it points to."""
    arrays = record.empty(abi.RlvMeshArrays)
    corners = numbers(corners, "corners")
    if corners.ndim == 2 and corners.shape[1]:
        # A row is a face.
        face_sizes = corners.shape[1] if face_sizes is None else face_sizes
        corners = corners.reshape(-1)
    corners = Reading(corners, numpy.uint32, 0, "corners")
    points = Reading(points, numpy.float32, 3, "points")
    if isinstance(face_sizes, (int, numpy.integer)):
        sizes = Reading(None, numpy.uint32, 0, "face_sizes")
        arrays.face_size = integer(face_sizes, "face_sizes")
        arrays.face_count = corners.count // max(int(face_sizes), 1)
    else:
        sizes = Reading(face_sizes, numpy.uint32, 0, "face_sizes")
        set_array(arrays, sizes, "face_sizes", "face_count", "face_stride")
    set_array(arrays, points, "points", "point_count", "point_stride")
    set_array(arrays, corners, "corners", "corner_count", "corner_stride")
    edges, edge_sharpness = pair_of(creases, "creases")
    edges = Reading(edges, numpy.uint32, 2, "creases")
    edge_sharpness = Reading(edge_sharpness, numpy.float32, 0, "crease sharpness")
    set_array(arrays, edges, "creases", "crease_count", "crease_stride")
    arrays.crease_sharpness, arrays.crease_sharpness_stride = edge_sharpness.address, edge_sharpness.stride
    tips, tip_sharpness = pair_of(sharp_points, "sharp_points")
    tips = Reading(tips, numpy.uint32, 0, "sharp_points")
    tip_sharpness = Reading(tip_sharpness, numpy.float32, 0, "sharp point sharpness")
    set_array(arrays, tips, "sharp_points", "sharp_point_count", "sharp_point_stride")
    arrays.sharp_point_sharpness, arrays.sharp_point_sharpness_stride = tip_sharpness.address, tip_sharpness.stride
    if edges.count != edge_sharpness.count or tips.count != tip_sharpness.count:
        raise Invalid("creases, sharp_points: each needs its sharpness")
    holes = Reading(holes, numpy.uint32, 0, "holes")
    set_array(arrays, holes, "holes", "hole_count", "hole_stride")
    return arrays, (corners, points, sizes, edges, edge_sharpness, tips, tip_sharpness, holes)


def attribute_arrays(name: str, values: Any, domain: Any, indices: Any = None) -> tuple[Any, ...]:
    """`abi.RlvAttributeArrays` as `Mesh.add_attribute` takes them, and the arrays that it points to."""
    title = text_bytes(name, "name")
    values = numbers(values, name)
    kind = abi.RlvType.U32 if numpy.issubdtype(values.dtype, numpy.integer) else abi.RlvType.F32
    if values.ndim == 1:
        values = values.reshape(-1, 1)
    width = values.shape[1] if values.ndim == 2 else 0
    reading = Reading(values, TYPES[kind], max(width, 1), name)
    choice = Reading(indices, numpy.uint32, 0, f"indices of {name}")
    options = {"domain": domain, "type": int(kind), "width": width, "name": title}
    arrays = record.fill(abi.RlvAttributeArrays, options, domain=abi.RlvDomain)
    set_array(arrays, reading, "values", "value_count", "value_stride")
    set_array(arrays, choice, "indices", "index_count", "index_stride")
    return arrays, (reading, choice)


class Mesh(Handle):
    """A polygon mesh. Front faces are counter-clockwise; lengths are in object units."""

    noun, kind = "mesh", abi.RlvMesh

    def __init__(
        self,
        context: Context,
        points: ArrayLike,
        corners: ArrayLike,
        face_sizes: ArrayLike | None = None,
        creases: tuple[ArrayLike, ArrayLike] | None = None,
        sharp_points: tuple[ArrayLike, ArrayLike] | None = None,
        holes: ArrayLike | None = None,
    ) -> None:
        """Makes a mesh of points (n, 3), the point of every corner, and the size of every face or one number for all. Corners
        may be rows, one for each face, as (n, 4) for quads; face_sizes is the length of the rows then, if it is left out.

        `creases` is a pair of edges (n, 2) and their sharpness, `sharp_points` one of points and their sharpness: 0 to
        10. `holes` are faces that shape their neighbours but have no surface."""
        arrays, _kept = arrays_of(points, corners, face_sizes, creases, sharp_points, holes)
        super().__init__("rlv_mesh_create", held(context, "context"), ctypes.byref(arrays))

    @classmethod
    def borrow(
        cls,
        context: Context,
        points: Array,
        corners: Array,
        face_sizes: Array | int | None = None,
        creases: tuple[ArrayLike, ArrayLike] | None = None,
        sharp_points: tuple[ArrayLike, ArrayLike] | None = None,
        holes: ArrayLike | None = None,
    ) -> Mesh:
        """As `Mesh`, without a copy of points (float32), corners and face_sizes (uint32): the mesh reads the arrays where they
        lie and keeps them alive, and they must not be changed as long as it lives. Arrays of another type or that are not packed are refused."""
        for name, array, kind in (("points", points, numpy.float32), ("corners", corners, numpy.uint32)):
            if not isinstance(array, numpy.ndarray) or array.dtype != kind or not array.flags.c_contiguous:
                raise Invalid(f"{name}: a packed array of {numpy.dtype(kind)} is needed to be borrowed")
        arrays, kept = arrays_of(points, corners, face_sizes, creases, sharp_points, holes)
        # The library may call it when the mesh is gone, so it lives until a later call finds that it was made.
        _lent[:] = [lent for lent in _lent if lent[1] is not None]
        lent: list[Any] = [None, kept]

        def release(_user: Any) -> None:
            lent[1] = None

        lent[0] = abi.RlvMeshReleased(release)
        made = cls.of("rlv_mesh_create_borrowed", held(context, "context"), ctypes.byref(arrays), lent[0], None)
        _lent.append(lent)
        made._lent = lent
        return made

    @classmethod
    def read(cls, context: Context, path: FilePath) -> Mesh:
        """Reads OBJ, PLY, glTF, GLB, USD, STL or OFF."""
        return cls.of("rlv_mesh_read", held(context, "context"), path_bytes(path))

    def write(self, path: FilePath) -> None:
        """Writes OBJ, PLY, GLB or USD, as the extension says."""
        library.call("rlv_mesh_write", self.handle, path_bytes(path))

    @classmethod
    def read_bytes(cls, context: Context, data: bytes | bytearray | memoryview, format: str) -> Mesh:
        """As `read`, from the bytes of a file; `format` is its extension, such as "obj"."""
        address, size, _kept = given(data)
        return cls.of("rlv_mesh_read_bytes", held(context, "context"), text_bytes(format, "format"), address, size)

    def write_bytes(self, format: str) -> bytes:
        """The bytes of the file that `write` writes; `format` is "obj", "ply" or "glb"."""
        return made("rlv_mesh_write_bytes", self.handle, text_bytes(format, "format"))

    def split(self, longest_edge: float) -> Mesh:
        """A mesh of this one's triangles in which no edge is longer."""
        return Mesh.of("rlv_mesh_split", self.handle, number(longest_edge, "longest_edge"))

    def simplify(
        self,
        triangles: int = 0,
        error: float | None = None,
        weights: Mapping[str, float] | None = None,
        left_out: Iterable[str] | None = (),
        locked: ArrayLike | None = None,
        factors: ArrayLike | None = None,
        progress: Progress | None = None,
        bound: float | None = None,
        is_border_locked: bool = False,
    ) -> tuple[Mesh, float]:
        """A mesh of fewer triangles with the attributes of this one, and how far it deviates; see `abi.RlvSimplifyOptions`.

        `error` is an estimate, `bound` a distance that is measured and never exceeded. `weights` are by names of
        attributes, `locked` points stay, `factors` (one a point) multiply what is lost there."""
        options, _kept = simplify_options(triangles, error, weights, left_out, locked, factors, bound, is_border_locked)
        deviation = ctypes.c_float()
        with watched(progress) as callback:
            told = (ctypes.byref(options), callback, None, address_of(deviation))
            made = Mesh.of("rlv_simplify_mesh", self.handle, *told)
        return made, deviation.value

    @property
    def info(self) -> Any:
        """Counts and bounds."""
        out = record.empty(abi.RlvMeshInfo)
        library.call("rlv_mesh_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def set_points(self, points: ArrayLike) -> None:
        """Moves the points."""
        points = Reading(points, numpy.float32, 3, "points")
        library.call("rlv_mesh_set_points", self.handle, points.address, points.count, points.stride)

    def points(self, out: Array | None = None) -> Array:
        """The positions (n, 3), written to `out` if it is given."""
        count = self.info.point_count
        out, place, stride = writing(out, count, numpy.float32, 3, "points")
        library.call("rlv_mesh_get_points", self.handle, place, count, stride)
        return out

    def faces(self) -> tuple[Array, Array]:
        """The size of every face and the point of every corner."""
        info = self.info
        sizes, sizes_at, _ = writing(None, info.face_count, numpy.uint32, 0, "face_sizes")
        corners, corners_at, _ = writing(None, info.corner_count, numpy.uint32, 0, "corners")
        library.call("rlv_mesh_get_faces", self.handle, sizes_at, len(sizes), corners_at, len(corners))
        return sizes, corners

    def triangles(self, out: Array | None = None) -> Array:
        """The faces as triangles (n, 3), fanned from their first corners, without holes."""
        count = self.info.triangle_count
        out, place, stride = writing(out, count, numpy.uint32, 3, "triangles")
        library.call("rlv_mesh_get_triangles", self.handle, place, count, stride)
        return out

    def add_attribute(self, name: str, values: ArrayLike, domain: str | int, indices: ArrayLike | None = None) -> None:
        """Adds an attribute of 1 to 4 floats or integers on "point", "corner" or "face"."""
        arrays, _kept = attribute_arrays(name, values, domain, indices)
        library.call("rlv_mesh_add_attribute", self.handle, ctypes.byref(arrays))

    def attribute_info(self, index: int) -> Any:
        """What the attribute at an index is."""
        out = record.empty(abi.RlvAttributeInfo)
        library.call("rlv_mesh_attribute_info", self.handle, index, ctypes.byref(out))
        return record.read(out)

    def attribute_names(self) -> list[str]:
        """The names of all attributes."""
        return [self.attribute_info(index).name for index in range(self.info.attribute_count)]

    def attribute(self, name: str) -> Attribute:
        """An attribute by its name: its values (n, width) and its indices, None without any."""
        index = ctypes.c_uint32()
        library.call("rlv_mesh_find_attribute", self.handle, text_bytes(name, "name"), address_of(index))
        info = self.attribute_info(index.value)
        kind = TYPES[abi.RlvType(info.type)]
        values, values_at, _ = writing(None, info.value_count, kind, info.width, name)
        indices, indices_at = None, None
        if info.index_count:
            indices, indices_at, _ = writing(None, info.index_count, numpy.uint32, 0, name)
        counts = (values.size, indices_at, info.index_count)
        library.call("rlv_mesh_get_attribute", self.handle, index.value, values_at, *counts)
        return Attribute(info.name, abi.RlvDomain(info.domain), values, indices)
