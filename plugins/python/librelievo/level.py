"""Levels: meshes of a progressive mesh that become finer and coarser in place and are edited at any level."""

from __future__ import annotations

import ctypes
from collections import namedtuple
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, integer, list_of, number, room, tupled, writing
from .error import Invalid
from .handle import Handle, held, path_bytes
from .hint import Array, ArrayLike, FilePath, Progress
from .mesh import Mesh
from .parameter import address_of
from .progress import watched
from .progressive import Progressive, options_of
from .stroke import points_of

if TYPE_CHECKING:
    from .brush import Brush

Region = namedtuple("Region", ["center", "radius", "falloff"], defaults=["smooth"])
Region.__doc__ = "A ball in which something has an influence, and how that falls to its border."
Grip = namedtuple("Grip", ["region", "translation", "axis", "angle"], defaults=[(0, 0, 0), (0, 0, 1), 0.0])
Grip.__doc__ = "What grabs a region, turns it about its middle and moves it; radians."

GripKey = namedtuple("GripKey", ["time", "translation", "axis", "angle"], defaults=[(0, 0, 0), (0, 0, 1), 0.0])
GripKey.__doc__ = "What a handle does at a time in seconds; radians."
GripTrack = namedtuple("GripTrack", ["region", "keys"])
GripTrack.__doc__ = "A handle over time: the region it grabs, and its keys."


def _three(values: Any, name: str) -> list[float]:
    """Three numbers."""
    return [number(value, name) for value in tupled(values, 3, name)]


def _all(things: Any, kind: Any, name: str) -> list[Any]:
    """A list of objects with the fields of a named tuple."""
    found = list_of(things, name)
    for thing in found:
        _has(thing, kind, name)
    return found


def _has(thing: Any, kind: Any, name: str) -> Any:
    """An object with the fields of a named tuple."""
    if not all(hasattr(thing, field) for field in kind._fields):
        raise Invalid(f"{name}: a {kind.__name__} is needed, not {type(thing).__name__}")
    return thing


def _region(region: Any) -> Any:
    made = abi.RlvLevelRegion()
    made.center[:] = _three(region.center, "center")
    made.radius = number(region.radius, "radius")
    made.falloff = record.named(abi.RlvFalloff, region.falloff, "falloff")
    return made


def _grip(grip: Any) -> Any:
    made = abi.RlvLevelHandle()
    made.region = _region(_has(grip.region, Region, "region"))
    made.translation[:] = _three(grip.translation, "translation")
    made.axis[:] = _three(grip.axis, "axis")
    made.angle = number(grip.angle, "angle")
    return made


def _key(key: Any) -> Any:
    made = abi.RlvLevelKey()
    made.time, made.angle = number(key.time, "time"), number(key.angle, "angle")
    made.translation[:] = _three(key.translation, "translation")
    made.axis[:] = _three(key.axis, "axis")
    return made


def _track(track: Any) -> Any:
    entries = _all(track.keys, GripKey, "keys")
    keys = (abi.RlvLevelKey * len(entries))(*map(_key, entries))
    made = abi.RlvLevelTrack()
    made.region, made.keys, made.key_count = _region(_has(track.region, Region, "region")), keys, len(keys)
    return made


def _edit(grips: Any, anchors: Any) -> tuple[Any, ...]:
    """An edit, and what it points to."""
    grips, anchors = _all(grips, Grip, "grips"), _all(anchors, Region, "anchors")
    handles = (abi.RlvLevelHandle * len(grips))(*map(_grip, grips))
    held = (abi.RlvLevelRegion * len(anchors))(*map(_region, anchors))
    edit = record.empty(abi.RlvLevelEdit)
    edit.handles, edit.handle_count = handles, len(grips)
    edit.anchors, edit.anchor_count = held, len(anchors)
    return edit, (handles, held)


def _motion(tracks: Any, anchors: Any) -> tuple[Any, ...]:
    """An edit over time, and what it points to."""
    tracks, anchors = _all(tracks, GripTrack, "tracks"), _all(anchors, Region, "anchors")
    rows = (abi.RlvLevelTrack * len(tracks))(*map(_track, tracks))
    held = (abi.RlvLevelRegion * len(anchors))(*map(_region, anchors))
    motion = record.empty(abi.RlvLevelMotion)
    motion.tracks, motion.track_count = rows, len(rows)
    motion.anchors, motion.anchor_count = held, len(held)
    return motion, (rows, held)


def _view(planes: Any, fields: Any) -> tuple[Any, ...]:
    """A view, and what it points to."""
    made = record.fill(abi.RlvLevelView, fields)
    kept = Reading(planes, numpy.float32, 4, "planes")
    made.planes, made.plane_count, made.plane_stride = kept.address, kept.count, kept.stride
    return made, kept


class _Room:
    """Arrays that a mesh is written to. `points`, `normals` and `triangles` are those of the last time: views of arrays
    that stay where they are. So are `wedges` (n, 3), of every triangle, `wedge_values` and `face_values`, of every wedge
    and triangle the numbers of all attributes; without any these have no columns."""

    def _make_room(self, info: Any) -> None:
        room = self._room = record.empty(abi.RlvLevelBuffers)
        points, room.points, _ = writing(None, info.vertex_count, numpy.float32, 3, "points")
        normals, room.normals, _ = writing(None, info.vertex_count, numpy.float32, 3, "normals")
        triangles, room.triangles, _ = writing(None, info.triangle_count, numpy.uint32, 3, "triangles")
        room.vertex_capacity, room.triangle_capacity = info.vertex_count, info.triangle_count
        self._arrays = (points, normals, triangles)
        self.points, self.normals, self.triangles = points[:0], normals[:0], triangles[:0]
        wedges = numpy.zeros((info.triangle_count if info.attribute_count else 0, 3), numpy.uint32)
        wedge_values = numpy.zeros((info.wedge_count, info.wedge_width), numpy.float32)
        face_values = numpy.zeros((info.triangle_count, info.face_width), numpy.uint32)
        for name, array in [("wedges", wedges), ("wedge_values", wedge_values), ("face_values", face_values)]:
            if array.size:
                setattr(room, name, array.ctypes.data)
        room.wedge_capacity = info.wedge_count
        self._attributes = (wedges, wedge_values, face_values)
        self.wedges, self.wedge_values, self.face_values = wedges[:0], wedge_values[:0], face_values[:0]

    def _show(self, out: Any) -> None:
        """Has the arrays as long as an update says."""
        points, normals, triangles = self._arrays
        self.points, self.normals = points[: out.vertex_count], normals[: out.vertex_count]
        self.triangles = triangles[: out.triangle_count]
        wedges, wedge_values, face_values = self._attributes
        self.wedges, self.wedge_values = wedges[: out.triangle_count], wedge_values[: out.wedge_count]
        self.face_values = face_values[: out.triangle_count]


class Level(_Room, Handle):
    """A mesh of a progressive mesh, at first its base; `update` brings its arrays up to date."""

    noun, kind = "level", abi.RlvLevel

    def __init__(self, whole: Progressive) -> None:
        super().__init__("rlv_level_create", held(whole, "whole"))
        self._make_room(whole.info)

    @property
    def info(self) -> Any:
        """Counts, and edits that can be taken back and made again."""
        out = record.empty(abi.RlvLevelInfo)
        library.call("rlv_level_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def take_up(self, more: Progressive) -> None:
        """Goes on with more of the same progressive mesh, which has arrived since."""
        library.call("rlv_level_take_up", self.handle, held(more, "more"))

    def set_error(self, error: float) -> None:
        """Becomes the coarsest mesh whose estimated deviation is no more."""
        library.call("rlv_level_set_error", self.handle, number(error, "error"))

    def set_bound(self, bound: float, progress: Progress | None = None) -> float:
        """Becomes a coarse mesh whose distance from the finest is measured and at most `bound`. Returns the distance."""
        distance = ctypes.c_float()
        with watched(progress) as callback:
            library.call("rlv_level_set_bound", self.handle, number(bound, "bound"), callback, None, address_of(distance))
        return distance.value

    def set_triangles(self, triangles: int | None = None) -> None:
        """Becomes the finest mesh of at most so many triangles, None for the finest of all."""
        most = ctypes.c_size_t(-1).value if triangles is None else triangles
        library.call("rlv_level_set_triangles", self.handle, most)

    def set_view(self, planes: ArrayLike | None = None, **view: Any) -> None:
        """Becomes as fine as a view needs it, by the fields of `abi.RlvLevelView`; `planes` (n, 4) bound what is seen."""
        made, kept = _view(planes, view)
        library.call("rlv_level_set_view", self.handle, ctypes.byref(made))
        del kept

    def edit(self, grips: Any, anchors: Sequence[Any] = ()) -> float:
        """Moves and turns regions by `Grip`s, anchored in `Region`s. Returns how many vertices were reached."""
        edit, kept = _edit(grips, anchors)
        reached = ctypes.c_size_t()
        library.call("rlv_level_edit", self.handle, ctypes.byref(edit), address_of(reached))
        del kept
        return reached.value

    def sculpt(self, brush: Brush, points: ArrayLike) -> Any:
        """Makes a whole stroke of a brush that sculpts, as one edit; points as strokes over details have them. Returns
        what it did; see `abi.RlvLevelSculpted`."""
        rows, out = points_of(points), record.empty(abi.RlvLevelSculpted)
        place = ctypes.cast(rows.__array_interface__["data"][0], ctypes.POINTER(abi.RlvStrokePoint))
        library.call("rlv_level_sculpt", self.handle, held(brush, "brush"), place, len(rows), 0, ctypes.byref(out))
        return record.read(out)

    def undo(self) -> None:
        """Takes the last edit back."""
        library.call("rlv_level_undo", self.handle)

    def redo(self) -> None:
        """Makes the edit again that was taken back last."""
        library.call("rlv_level_redo", self.handle)

    def add_motion(self, tracks: Any, anchors: Sequence[Any] = ()) -> None:
        """Adds an edit over time by `GripTrack`s, anchored in `Region`s, of the mesh as fine as it is now."""
        motion, kept = _motion(tracks, anchors)
        library.call("rlv_level_add_motion", self.handle, ctypes.byref(motion))
        del kept

    def set_time(self, time: float) -> Any:
        """Makes the edits over time as they are at a time in seconds. Returns how many vertices were reached."""
        reached = ctypes.c_size_t()
        library.call("rlv_level_set_time", self.handle, number(time, "time"), address_of(reached))
        return reached.value

    def clear_motions(self) -> None:
        """Forgets the edits over time, and puts the mesh at rest."""
        library.call("rlv_level_clear_motions", self.handle)

    def open_journal(self, path: FilePath) -> None:
        """Writes the edits that follow down in a file, after making those again that a killed host left there."""
        library.call("rlv_level_open_journal", self.handle, path_bytes(path))

    def sync_journal(self) -> None:
        """Waits until all edits are on the disk."""
        library.call("rlv_level_sync_journal", self.handle)

    def close_journal(self) -> None:
        """Closes the journal: later edits are not written down."""
        library.call("rlv_level_close_journal", self.handle)

    def update(self) -> Any:
        """Brings `points`, `normals`, `triangles` and attributes up to date. Returns what was written; see
        `abi.RlvLevelUpdate`."""
        out = record.empty(abi.RlvLevelUpdate)
        library.call("rlv_level_update", self.handle, ctypes.byref(self._room), ctypes.byref(out))
        self._show(out)
        return record.read(out)

    def changed_ranges(self, domain: str | int = "point") -> Array:
        """The ranges that the last update wrote, (first, count): vertices of "point", triangles of "face", values of wedges of
        "corner"."""
        count, of = ctypes.c_size_t(), record.named(abi.RlvDomain, domain, "domain")
        library.call("rlv_level_changed_ranges", self.handle, of, None, 0, address_of(count))
        out, place, _ = writing(None, count.value, numpy.uint32, 2, "ranges")
        library.call("rlv_level_changed_ranges", self.handle, of, place, len(out), address_of(count))
        return out[: count.value]

    def mesh(self) -> Mesh:
        """A mesh of it as it is now."""
        return Mesh.of("rlv_level_mesh", self.handle)

    def misplaced(self, most: int | None = None) -> tuple[Any, ...]:
        """The splits that are out of order, the worst one first: rows of a point, what it tells that it deviates by, and
        what it does. At most so many of them, None for all; and how many there are."""
        count = ctypes.c_size_t()
        if most is None:
            library.call("rlv_level_misplaced", self.handle, None, 0, address_of(count))
            most = count.value
        rows = room((integer(most, "most"), 5), numpy.float32, "most")
        place = rows.ctypes.data_as(ctypes.POINTER(abi.RlvLevelMisplaced))
        library.call("rlv_level_misplaced", self.handle, place, len(rows), address_of(count))
        return rows[: count.value].copy(), count.value

    def rebuild(
        self, base_triangles: int | None = None, locked: ArrayLike | None = None, progress: Progress | None = None
    ) -> Any:
        """A progressive mesh that is built anew of the finest level with its edits; as `Progressive` is."""
        options, kept = options_of(base_triangles, locked)
        with watched(progress) as callback:
            made = Progressive.of("rlv_level_rebuild", self.handle, ctypes.byref(options), callback, None)
        del kept
        return made

    def settle(self) -> Progressive:
        """A progressive mesh of its own that has the edits at all levels."""
        return Progressive.of("rlv_level_settle", self.handle)


class DeviceLevel(_Room, Handle):
    """A mesh of a progressive mesh on the graphics device of its context, at first its base; `read` copies it back."""

    noun, kind = "device_level", abi.RlvDeviceLevel

    def __init__(self, whole: Progressive) -> None:
        super().__init__("rlv_device_level_create", held(whole, "whole"))
        self._make_room(whole.info)

    @property
    def info(self) -> Any:
        """Counts, and edits that can be taken back and made again."""
        out = record.empty(abi.RlvDeviceLevelInfo)
        library.call("rlv_device_level_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def set_error(self, error: float) -> None:
        """Becomes the coarsest mesh that deviates by no more."""
        library.call("rlv_device_level_set_error", self.handle, number(error, "error"))

    def set_triangles(self, triangles: int | None = None) -> None:
        """Becomes the finest mesh of at most so many triangles, None for the finest of all."""
        most = ctypes.c_size_t(-1).value if triangles is None else triangles
        library.call("rlv_device_level_set_triangles", self.handle, most)

    def set_view(self, planes: ArrayLike | None = None, **view: Any) -> None:
        """Becomes as fine as a view needs it, by the fields of `abi.RlvLevelView`; `planes` (n, 4) bound what is seen."""
        made, kept = _view(planes, view)
        library.call("rlv_device_level_set_view", self.handle, ctypes.byref(made))
        del kept

    def edit(self, grips: Any, anchors: Sequence[Any] = ()) -> float:
        """Moves and turns regions by `Grip`s, anchored in `Region`s. Returns how many vertices were reached."""
        edit, kept = _edit(grips, anchors)
        reached = ctypes.c_size_t()
        library.call("rlv_device_level_edit", self.handle, ctypes.byref(edit), address_of(reached))
        del kept
        return reached.value

    def undo(self) -> None:
        """Takes the last edit back."""
        library.call("rlv_device_level_undo", self.handle)

    def redo(self) -> None:
        """Makes the edit again that was taken back last."""
        library.call("rlv_device_level_redo", self.handle)

    def add_motion(self, tracks: Any, anchors: Sequence[Any] = ()) -> None:
        """Adds an edit over time by `GripTrack`s, anchored in `Region`s, of the mesh as fine as it is now."""
        motion, kept = _motion(tracks, anchors)
        library.call("rlv_device_level_add_motion", self.handle, ctypes.byref(motion))
        del kept

    def set_time(self, time: float) -> Any:
        """Makes the edits over time as they are at a time in seconds. Returns how many vertices were reached."""
        reached = ctypes.c_size_t()
        library.call("rlv_device_level_set_time", self.handle, number(time, "time"), address_of(reached))
        return reached.value

    def clear_motions(self) -> None:
        """Forgets the edits over time, and puts the mesh at rest."""
        library.call("rlv_device_level_clear_motions", self.handle)

    def read(self) -> Any:
        """Copies the mesh to `points`, `normals`, `triangles` and attributes. Returns how much there is; see
        `abi.RlvLevelUpdate`."""
        out = record.empty(abi.RlvLevelUpdate)
        library.call("rlv_device_level_read", self.handle, ctypes.byref(self._room), ctypes.byref(out))
        self._show(out)
        return record.read(out)

    def vulkan(self) -> Any:
        """Its Vulkan objects as numbers; see buffer.h for who may use them when."""
        out = record.empty(abi.RlvDeviceLevelVulkan)
        library.call("rlv_device_level_vulkan", self.handle, ctypes.byref(out))
        return record.read(out)
