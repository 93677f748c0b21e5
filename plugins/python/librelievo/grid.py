"""Sparse grids of OpenVDB: level sets, fog, masks, labels and vectors.

OpenVDB is opened on demand, through the module of the package relievo-openvdb; without it calls raise NotFound.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, parameter, record
from .array import Reading, flag, list_of, number, packed
from .error import Invalid, shown
from .handle import Handle, held, path_bytes, text_bytes
from .hint import Array, ArrayLike, FilePath, Progress
from .mesh import Mesh
from .progress import watched

if TYPE_CHECKING:
    from .context import Context
    from .parameter import Parameter

# The NumPy type of a value, and how many numbers it has.
TYPES = {
    abi.RlvGridKind.FLOAT: (numpy.float32, 1),
    abi.RlvGridKind.DOUBLE: (numpy.float64, 1),
    abi.RlvGridKind.BOOL: (numpy.bool_, 1),
    abi.RlvGridKind.MASK: (numpy.bool_, 1),
    abi.RlvGridKind.INT32: (numpy.int32, 1),
    abi.RlvGridKind.INT64: (numpy.int64, 1),
    abi.RlvGridKind.VEC3S: (numpy.float32, 3),
    abi.RlvGridKind.VEC3D: (numpy.float64, 3),
    abi.RlvGridKind.VEC3I: (numpy.int32, 3),
}

PACKINGS = {"blosc": abi.RlvGridWriting.PACK_BLOSC, "zip": abi.RlvGridWriting.PACK_ZIP, None: abi.RlvGridWriting.PACK_NONE}


def params() -> list[Parameter]:
    """Describes the fields of `abi.RlvGridSettings`."""
    return parameter.table("rlv_grid_params")


def is_available() -> bool:
    """Opens the module of OpenVDB; raises NotFound, with what to install, where there is none."""
    library.call("rlv_grid_available")
    return True


def info(context: Context, path: FilePath) -> Any:
    """Describes the grids of a file, one `abi.RlvGridInfo` each. Needs no module."""
    count = ctypes.c_size_t()
    library.call("rlv_grid_file_count", held(context, "context"), path_bytes(path), parameter.address_of(count))
    found = []
    for index in range(count.value):
        out = record.empty(abi.RlvGridInfo)
        library.call("rlv_grid_file_info", held(context, "context"), path_bytes(path), index, ctypes.byref(out))
        found.append(record.read(out))
    return found


def file_metadata(context: Context, path: FilePath, name: str) -> Any:
    """Returns an entry of the metadata of a file as text. Needs no module."""
    value = ctypes.create_string_buffer(1 << 16)
    library.call("rlv_grid_file_metadata", held(context, "context"), path_bytes(path), text_bytes(name, "name"), value, len(value))
    return value.value.decode("utf-8", "replace")


def settings_of(settings: Any) -> Any:
    """`abi.RlvGridSettings` from keywords."""
    return ctypes.byref(record.fill(abi.RlvGridSettings, settings))


def write(path: FilePath, grids: Any, pack: str | None = "blosc", half: bool = False, stream: bool = False) -> None:
    """Writes grids to a file: packed by "blosc", "zip" or None, with 16 bits a number if `half`."""
    handles, count, writing = writing_of(grids, pack, half, stream)
    library.call("rlv_grid_write", handles, count, path_bytes(path), writing)


def writing_of(grids: Any, pack: str | None = "blosc", half: bool = False, stream: bool = False) -> tuple[Any, int, int]:
    """Returns handles of grids, their number, and how they are written: bits of `abi.RlvGridWriting`."""
    if not isinstance(pack, (str, type(None))) or pack not in PACKINGS:
        raise Invalid(f"pack: {shown(pack)} is unknown; there are 'blosc', 'zip' and None")
    bits = int(PACKINGS[pack])
    bits |= abi.RlvGridWriting.HALF * flag(half, "half") | abi.RlvGridWriting.STREAM * flag(stream, "stream")
    grids = list_of(grids, "grids")
    return (abi.RlvGrid * len(grids))(*(held(grid, "grids", abi.RlvGrid) for grid in grids)), len(grids), int(bits)


def labels(level_sets: Any, numbers: Any) -> Grid:
    """Makes a grid of int32 labels of level sets: inside of each its number, 0 outside of all."""
    numbers, level_sets = packed(numbers, numpy.int32, "numbers"), list_of(level_sets, "level_sets")
    if numbers.shape != (len(level_sets),):
        raise Invalid(f"numbers: there are {numbers.size} for {len(level_sets)} level sets")
    handles = (abi.RlvGrid * len(level_sets))(*(held(grid, "level_sets", abi.RlvGrid) for grid in level_sets))
    return Grid.of("rlv_grid_labels", handles, numbers.ctypes.data, len(level_sets))


def _triple(values: Any, kind: Any, name: str) -> Any:
    array = packed(values, kind, name)
    if array.shape != (3,):
        raise Invalid(f"{name}: three numbers are needed")
    return array


class Grid(Handle):
    """Values at the voxels of a lattice of any extent."""

    noun, kind = "grid", abi.RlvGrid

    def __init__(self, context: Context, kind: Any = "float", background: Any = 0.0, voxel: Any = 1.0) -> None:
        """Makes an empty grid of a kind: "float", "double", "bool", "mask", "int32", "int64", "vec3s", "vec3d", "vec3i"."""
        number = record.named(abi.RlvGridKind, kind, "kind")
        background = packed(background, numpy.float64, "background")
        if background.shape not in ((1,), (3,)):
            raise Invalid(f"background: one number or three are needed, not the shape {background.shape}")
        background = numpy.ascontiguousarray(numpy.broadcast_to(background, 3))
        super().__init__("rlv_grid_create", held(context, "context"), number, background.ctypes.data, voxel)

    @classmethod
    def read(
        cls,
        context: Context,
        path: FilePath,
        name: str | None = None,
        bounds: ArrayLike | None = None,
        progress: Progress | None = None,
    ) -> Grid:
        """Reads a grid of a file: the first, or the one called `name`; of `bounds` (2, 3) only what is in that box."""
        box = None if bounds is None else packed(bounds, numpy.float64, "bounds")
        if box is not None and box.shape != (2, 3):
            raise Invalid("bounds: the lowest and the highest corner are needed")
        place = None if box is None else box.ctypes.data
        with watched(progress) as callback:
            return cls.of("rlv_grid_read", held(context, "context"), path_bytes(path), text_bytes(name, "name"), place, callback, None)

    @classmethod
    def from_mesh(cls, mesh: Mesh, progress: Progress | None = None, **settings: Any) -> Grid:
        """Makes a level set of a closed mesh; settings are `voxel` and `band`."""
        with watched(progress) as callback:
            return cls.of("rlv_grid_from_mesh", held(mesh, "mesh"), settings_of(settings), callback, None)

    @classmethod
    def from_particles(cls, particles: Any, progress: Progress | None = None, **settings: Any) -> Grid:
        """Makes a level set of balls at particles; settings are `voxel`, `band` and `radius`."""
        with watched(progress) as callback:
            return cls.of("rlv_grid_from_particles", held(particles, "particles"), settings_of(settings), callback, None)

    def write(self, path: FilePath, pack: str | None = "blosc", half: bool = False, stream: bool = False) -> None:
        """Writes it as the only grid of a file."""
        write(path, [self], pack, half, stream)

    @property
    def info(self) -> Any:
        """Its kind, class, transform, bounds, counts and name."""
        out = record.empty(abi.RlvGridInfo)
        library.call("rlv_grid_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def set_name(self, name: str) -> None:
        """Names it."""
        library.call("rlv_grid_set_name", self.handle, text_bytes(name, "name"))

    def set_class(self, meaning: Any) -> None:
        """Says what its values mean: "unknown", "level_set", "fog" or "staggered"."""
        number = record.named(abi.RlvGridClass, meaning, "meaning")
        library.call("rlv_grid_set_class", self.handle, number)

    def set_matrix(self, matrix: ArrayLike) -> None:
        """Sets its transform: what the axes of voxels go to and the origin, (4, 3)."""
        matrix = packed(matrix, numpy.float64, "matrix")
        if matrix.shape != (4, 3):
            raise Invalid("matrix: four rows of three numbers are needed")
        library.call("rlv_grid_set_matrix", self.handle, matrix.ctypes.data)

    def set_frustum(
        self, voxels: Any, taper: float, depth: float, matrix: ArrayLike = numpy.vstack([numpy.eye(3), numpy.zeros(3)])
    ) -> None:
        """Makes its transform a camera's frustum: `voxels`, the lowest and highest corner of a box (2, 3), becomes a pyramid
        whose near plane is `taper` times as wide as its far plane and whose depth is `depth` times the width of the near
        plane; `matrix` (4, 3) follows it."""
        voxels = packed(voxels, numpy.float64, "voxels")
        matrix = packed(matrix, numpy.float64, "matrix")
        if voxels.shape != (2, 3) or matrix.shape != (4, 3):
            raise Invalid("voxels: two corners are needed, and matrix: four rows of three numbers")
        library.call(
            "rlv_grid_set_frustum",
            self.handle,
            voxels.ctypes.data,
            number(taper, "taper"),
            number(depth, "depth"),
            matrix.ctypes.data,
        )

    @property
    def metadata_types(self) -> Any:
        """The names of its entries of metadata and their types."""
        count = ctypes.c_size_t()
        library.call("rlv_grid_metadata_count", self.handle, parameter.address_of(count))
        name, kind = (ctypes.create_string_buffer(1024) for _ in range(2))
        types = {}
        for index in range(count.value):
            library.call("rlv_grid_metadata_entry", self.handle, index, name, len(name), kind, len(kind))
            types[name.value.decode("utf-8", "replace")] = kind.value.decode("utf-8", "replace")
        return types

    def metadata(self, name: str) -> Any:
        """Returns an entry of its metadata as text."""
        value = ctypes.create_string_buffer(1 << 16)
        library.call("rlv_grid_metadata", self.handle, text_bytes(name, "name"), value, len(value))
        return value.value.decode("utf-8", "replace")

    def set_metadata(self, name: str, value: Any) -> None:
        """Sets an entry of its metadata to a text, a bool, an int or a float."""
        kinds = {str: "string", bool: "bool", int: "int64", float: "double"}
        if type(value) not in kinds or (isinstance(value, int) and not -(1 << 63) <= value < 1 << 63):
            raise Invalid(f"value: a text, a bool, an int of 64 bits or a float is needed, not {shown(value)}")
        text = str(value).lower() if isinstance(value, bool) else str(value)
        library.call("rlv_grid_set_metadata", self.handle, text_bytes(name, "name"), text_bytes(kinds[type(value)]), text_bytes(text))

    def sample(self, points: ArrayLike, linear: bool = True) -> Array:
        """Returns the values at points (n, 3) of the world, (n) or (n, 3), as doubles."""
        width = TYPES[self.info.kind][1]
        points = Reading(points, numpy.float64, 3, "points")
        out = numpy.empty((points.count, width), numpy.float64)
        library.call(
            "rlv_grid_sample", self.handle, points.address, points.count, points.stride, flag(linear, "linear"), out.ctypes.data, out.size
        )
        return out[:, 0] if width == 1 else out

    def block(self, low: ArrayLike | None = None, size: Sequence[int] | None = None) -> Array:
        """Returns a block of voxels as an array (x, y, z) or (x, y, z, 3); of all active voxels if it is not stated."""
        about = self.info
        kind, width = TYPES[about.kind]
        low = _triple(about.low if low is None else low, numpy.int32, "low")
        if size is None:
            size = numpy.subtract(about.high, low, dtype=numpy.int64) + 1
        size = _triple(size, numpy.int64, "size")
        if (size < 1).any() or (size > 1 << 30).any():
            raise Invalid("size: one voxel at least is needed along each axis")
        shape = tuple(int(edge) for edge in size)
        out = numpy.empty(shape if width == 1 else (*shape, width), kind)
        counts = numpy.array(shape, numpy.uint32)
        library.call("rlv_grid_get_block", self.handle, low.ctypes.data, counts.ctypes.data, out.ctypes.data, out.nbytes)
        return out

    def set_block(self, low: ArrayLike, values: ArrayLike, tolerance: float = 0.0) -> None:
        """Sets a block of voxels from `low` on to an array (x, y, z) or (x, y, z, 3); values within `tolerance` of the
        background become it and are not active."""
        kind, width = TYPES[self.info.kind]
        values = packed(values, kind, "values")
        if values.ndim != (3 if width == 1 else 4) or (width == 3 and values.shape[3] != 3):
            raise Invalid("values: three axes are needed, and three numbers each of vectors")
        low, counts = _triple(low, numpy.int32, "low"), numpy.array(values.shape[:3], numpy.uint32)
        library.call(
            "rlv_grid_set_block",
            self.handle,
            low.ctypes.data,
            counts.ctypes.data,
            values.ctypes.data,
            values.nbytes,
            tolerance,
        )

    def mesh(self, progress: Progress | None = None, **settings: Any) -> Mesh:
        """Meshes the surface where it has a value; settings are `value` and `adaptivity`."""
        with watched(progress) as callback:
            return Mesh.of("rlv_grid_mesh", self.handle, settings_of(settings), callback, None)

    def change(self, change: Any, progress: Progress | None = None, **settings: Any) -> Grid:
        """Makes a grid of it: "offset", "mean", "gaussian", "median", "laplacian", "mean_curvature", "resample", "to_fog" or
        "to_level_set"."""
        number = record.named(abi.RlvGridChange, change, "change")
        with watched(progress) as callback:
            return Grid.of("rlv_grid_change", self.handle, number, settings_of(settings), callback, None)

    def convert(self, kind: Any) -> Grid:
        """Makes a grid of another kind."""
        number = record.named(abi.RlvGridKind, kind, "kind")
        return Grid.of("rlv_grid_convert", self.handle, number)

    def combine(self, other: Grid, operation: str = "union", progress: Progress | None = None) -> Grid:
        """Combines it with another grid: "union", "intersection" or "difference"."""
        number = record.named(abi.RlvGridOperation, operation, "operation")
        with watched(progress) as callback:
            return Grid.of("rlv_grid_combine", self.handle, held(other, "other"), number, callback, None)

    def label_mask(self, label: int) -> Grid:
        """Makes a mask of the voxels with a label."""
        return Grid.of("rlv_grid_label_mask", self.handle, label)
