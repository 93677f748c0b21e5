"""Details: surfaces with displacement, colours and traces of contact that can be edited."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, address, flag, matrix, number, writing
from .bytes import given
from .evaluate import evaluate
from .handle import Handle, held, path_bytes
from .hint import Array, ArrayLike, FilePath
from .layer import Layers
from .mesh import Mesh
from .parameter import address_of
from .surface import tessellate_options

if TYPE_CHECKING:
    from .surface import Surface


def listed(function: str, handle: Any) -> Array:
    """The numbers that a function lists when it is asked for their count first."""
    count = ctypes.c_size_t()
    library.call(function, handle, None, 0, address_of(count))
    out, place, _ = writing(None, count.value, numpy.uint32, 0, function)
    library.call(function, handle, place, len(out), address_of(count))
    return out[: count.value]


class Detail(Handle):
    """A surface with channels in tiles. Edits become visible at `commit`."""

    noun, kind = "detail", abi.RlvDetail

    def __init__(
        self, surface: Surface, matrix_world: ArrayLike | None = None, face_sizes: ArrayLike | None = None, **options: Any
    ) -> None:
        """`matrix_world` is 4 by 4 from object space to the world. Options are tile_size and budget; `face_sizes` are
        pairs of a face and its own size."""
        options = record.fill(abi.RlvDetailOptions, options)
        sizes = Reading(face_sizes, numpy.uint32, 2, "face_sizes")
        options.face_sizes, options.face_size_count, options.face_size_stride = sizes.address, sizes.count, sizes.stride
        place = matrix(matrix_world)
        super().__init__("rlv_detail_create", held(surface, "surface"), ctypes.byref(options), address(place))

    @property
    def info(self) -> Any:
        """Counts, bytes and the revision."""
        out = record.empty(abi.RlvDetailInfo)
        library.call("rlv_detail_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def check_device(self) -> None:
        """Raises what went wrong when the processor took over from the graphics device, if it did."""
        library.call("rlv_detail_device_fault", self.handle)

    @property
    def layers(self) -> Layers:
        """The layers of displacement and colour."""
        return Layers(self)

    def set_budget(self, budget: int) -> None:
        """Sets the bytes that tiles may occupy."""
        library.call("rlv_detail_set_budget", self.handle, budget)

    def set_paging(self, page: int, folder: FilePath | None = None) -> None:
        """Lets tiles leave memory for a file when a budget is spent, or brings them back."""
        folder = None if folder is None else path_bytes(folder, "folder")
        library.call("rlv_detail_set_paging", self.handle, flag(page, "page"), folder)

    def add_paint(self, **options: Any) -> None:
        """Gives the detail colours; options are the fields of `abi.RlvPaintOptions`."""
        options = record.fill(abi.RlvPaintOptions, options, format=abi.RlvColorFormat)
        library.call("rlv_detail_add_paint", self.handle, ctypes.byref(options))

    def add_vectors(self, **options: Any) -> None:
        """Gives the detail a vector displacement; options are the fields of `abi.RlvVectorOptions`."""
        options = record.fill(abi.RlvVectorOptions, options)
        library.call("rlv_detail_add_vectors", self.handle, ctypes.byref(options))

    def add_traces(self, budget: int = 0) -> None:
        """Lets imprints leave traces of contact."""
        library.call("rlv_detail_add_traces", self.handle, budget)

    def set_decay(self, **options: Any) -> None:
        """Lets edits fade; options are the fields of `abi.RlvDecayOptions`."""
        options = record.fill(abi.RlvDecayOptions, options)
        library.call("rlv_detail_set_decay", self.handle, ctypes.byref(options))

    def advance(self, time: float) -> None:
        """Comes to a time in seconds."""
        library.call("rlv_detail_advance", self.handle, number(time, "time"))

    def channel_info(self, channel: str | int) -> Any:
        """A channel ("displacement", "color", "vectors", "traces") as it was committed last."""
        out = record.empty(abi.RlvChannelInfo)
        library.call("rlv_detail_channel_info", self.handle, number_of(channel), ctypes.byref(out))
        return record.read(out)

    def folds(self) -> Any:
        """Counts where the displaced surface, as it was committed last, is folded: the fields of `abi.RlvDetailFolds`."""
        out = record.empty(abi.RlvDetailFolds)
        library.call("rlv_detail_folds", self.handle, ctypes.byref(out))
        return record.read(out)

    def set_face_sizes(self, pairs: ArrayLike) -> None:
        """Gives faces another number of coefficients: pairs of a face and its size."""
        pairs = Reading(pairs, numpy.uint32, 2, "face_sizes")
        library.call("rlv_detail_set_face_sizes", self.handle, pairs.address, pairs.count, pairs.stride)

    def set_transform(self, matrix_world: ArrayLike) -> None:
        """Moves the detail."""
        place = matrix(matrix_world)
        library.call("rlv_detail_set_transform", self.handle, address(place))

    def set_points(self, points: ArrayLike) -> None:
        """Poses an animated cage."""
        points = Reading(points, numpy.float32, 3, "points")
        library.call("rlv_detail_set_points", self.handle, points.address, points.count, points.stride)

    def commit(self) -> Any:
        """Makes all edits since the last commit visible, and says what changed."""
        out = record.empty(abi.RlvDetailChanges)
        library.call("rlv_detail_commit", self.handle, ctypes.byref(out))
        return record.read(out)

    def changed_tiles(self) -> Array:
        """The tiles that changed with the last commit, ascending."""
        return listed("rlv_detail_changed_tiles", self.handle)

    def refused_faces(self) -> Array:
        """The faces with tiles that a budget refused at the last edit."""
        return listed("rlv_detail_refused_faces", self.handle)

    def tile_info(self, channel: str | int, tile: int) -> Any:
        """Whether a tile is allocated, its version and bounds."""
        out = record.empty(abi.RlvDetailTileInfo)
        library.call("rlv_detail_tile_info", self.handle, number_of(channel), tile, ctypes.byref(out))
        return record.read(out)

    def read_block(self, channel: str | int, tile: int) -> bytes:
        """The bytes of a tile as it was committed last, none if it is not allocated."""
        channel, size = number_of(channel), ctypes.c_size_t()
        library.call("rlv_detail_read_block", self.handle, channel, tile, None, 0, address_of(size))
        out, place, _ = writing(None, size.value, numpy.uint8, 0, "block")
        library.call("rlv_detail_read_block", self.handle, channel, tile, place, len(out), address_of(size))
        return out[: size.value].tobytes()

    def write_block(self, channel: str | int, tile: int, data: bytes | bytearray | memoryview) -> None:
        """Puts a block back; no bytes free the tile."""
        address, size, _kept = given(data)
        library.call("rlv_detail_write_block", self.handle, number_of(channel), tile, address, size)

    def evaluate(
        self,
        tiles: ArrayLike,
        uvs: ArrayLike,
        wanted: Iterable[str] = ("positions", "normals"),
        footprints: ArrayLike | None = None,
        out: Mapping[str, Array] | None = None,
    ) -> dict[str, Array]:
        """What is wanted at the places, as it was committed last: a dictionary of arrays; see `abi.RlvEvaluateArrays`."""
        return evaluate("rlv_evaluate_detail", self.handle, tiles, uvs, wanted, footprints, out)

    def tessellate(self, **options: Any) -> Mesh:
        """A triangle mesh of the displaced surface; options are the fields of `abi.RlvTessellateOptions`."""
        return Mesh.of("rlv_tessellate_detail", self.handle, tessellate_options(options))


def number_of(channel: Any) -> int:
    """A channel by its name or number."""
    return record.named(abi.RlvChannel, channel, "channel")
