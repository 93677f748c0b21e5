"""Crowds of articulated models, each drawn with as many triangles as its pixels deserve in its pose."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, address, chosen, flag, integer, list_of, number, numbers, packed, tupled
from .error import Invalid
from .bytes import given, made
from .handle import Handle, held, path_bytes, text_bytes
from .hint import Array, ArrayLike, FilePath, Progress
from .mesh import Mesh
from .parameter import address_of, table
from .progress import watched

if TYPE_CHECKING:
    from .context import Context
    from .parameter import Parameter

AGENT = numpy.dtype(abi.RlvCrowdAgent)
CLUSTER = numpy.dtype(abi.RlvCrowdCluster)
COLLAPSE = numpy.dtype(abi.RlvCrowdCollapse)
OFFSET = numpy.dtype(abi.RlvCrowdOffset)
DRAW = numpy.dtype(abi.RlvCrowdDraw)
INSTANCE = numpy.dtype(abi.RlvCrowdInstance)
IMPOSTOR = numpy.dtype(abi.RlvCrowdImpostor)
PICTURE = numpy.dtype(abi.RlvCrowdPicture)
TEXEL = numpy.dtype(abi.RlvCrowdTexel)
VERTICES = {"points": 3, "normals": 3, "uvs": 2, "bones": 4, "weights": 4}


def params() -> list[Parameter]:
    """The fields of `abi.RlvCrowdBuildSettings` with ranges, units and help."""
    return table("rlv_crowd_params")


def arguments(path: Any, clips: Any, settings: Any) -> tuple[Any, ...]:
    """What the functions that build a model take after the context, and what keeps its texts."""
    names = [text_bytes(clip, "clips") for clip in (() if clips is None else list_of(clips, "clips"))]
    entries = (abi.RlvCrowdClipName * len(names))(*((name,) for name in names))
    made = record.fill(abi.RlvCrowdBuildSettings, settings)
    return (path_bytes(path), entries, len(names), ctypes.byref(made)), (names, entries, made)


def agents_of(transforms: Any, clips: int = 0, phases: float = 0.0, models: int = 0) -> Any:
    """An array of `abi.RlvCrowdAgent` of transforms (n, 3, 4) or (n, 4, 4) of rows, with the clip, the phase in seconds and the
    model of each, or one for all."""
    rows = numbers(transforms, "transforms", numpy.float64)
    if rows.ndim != 3 or rows.shape[1:] not in ((3, 4), (4, 4)):
        raise Invalid(f"transforms: the shape (n, 3, 4) or (n, 4, 4) is needed, not {rows.shape}")
    agents = numpy.zeros(len(rows), AGENT)
    agents["transform"] = rows[:, :3].transpose(0, 2, 1).reshape(-1, 12)
    for name, values in (("clips", clips), ("phases", phases), ("models", models)):
        field = name.removesuffix("s")
        if numbers(values, name).ndim == 0:
            agents[field] = number(values, name) if field == "phase" else integer(values, name)
            continue
        each = Reading(values, AGENT[field], 0, name)
        if each.count not in (1, len(rows)):
            raise Invalid(f"{name}: there are {each.count} for {len(rows)} transforms")
        agents[field] = each.array
    return agents


def view_of(size: Sequence[int], eye: Any, target: Any, **given: Any) -> Any:
    """An `abi.RlvCrowdView` of a picture of `size` (width, height) pixels and its other fields; suns are rows of four numbers."""
    switches = {name: flag(given.pop(name), name) for name in ("occlusion", "geomorph", "impostors") if name in given}
    width, height = tupled(size, 2, "size")
    fields = {"width": width, "height": height, "eye": eye, "target": target}
    suns = Reading(list_of(given.pop("suns", ()), "suns") or None, numpy.float64, 4, "suns")
    made = record.fill(abi.RlvCrowdView, fields | switches | given)
    if suns.count:
        # The struct keeps an array of ctypes alive.
        made.suns, made.sun_count = (abi.RlvCrowdSun * suns.count).from_buffer_copy(suns.array.tobytes()), suns.count
    return made


class CrowdModel(Handle):
    """A character or a static model with its clips and its hierarchy of clusters."""

    noun, kind = "crowd_model", abi.RlvCrowdModel

    @classmethod
    def build(
        cls, context: Context, path: FilePath, clips: Any = None, progress: Progress | None = None, **settings: Any
    ) -> CrowdModel:
        """Builds the hierarchy of a file for its clips of these names, or for all; see `abi.RlvCrowdBuildSettings`."""
        given, _kept = arguments(path, clips, settings)
        with watched(progress) as callback:
            return cls.of("rlv_crowd_model_build", held(context, "context"), *given, callback, None)

    def refit(
        self, path: FilePath, clips: Any = None, progress: Progress | None = None, **settings: Any
    ) -> tuple[CrowdModel, Any]:
        """Makes a model with the same clusters of a file that was sculpted or has other clips since. Returns it and
        `abi.RlvCrowdRefitReport`, which says whether a new build is due."""
        report = record.empty(abi.RlvCrowdRefitReport)
        given, _kept = arguments(path, clips, settings)
        with watched(progress) as callback:
            made = self.of("rlv_crowd_model_refit", self.handle, *given, callback, None, ctypes.byref(report))
        return made, record.read(report)

    def with_blend(self, blend: str | int) -> CrowdModel:
        """Makes a model with the same clusters whose bones are blended in another way; see `abi.RlvCrowdBlend`."""
        return self.of("rlv_crowd_model_with_blend", self.handle, record.named(abi.RlvCrowdBlend, blend, "blend"))

    @classmethod
    def read(cls, context: Context, path: FilePath) -> CrowdModel:
        """Reads a model (.rcrowd)."""
        return cls.of("rlv_crowd_model_read", held(context, "context"), path_bytes(path))

    def write(self, path: FilePath) -> None:
        """Writes the model (.rcrowd)."""
        library.call("rlv_crowd_model_write", self.handle, path_bytes(path))

    @classmethod
    def read_bytes(cls, context: Context, data: bytes | bytearray | memoryview) -> CrowdModel:
        """As `read`, from the bytes of a file."""
        address, size, _kept = given(data)
        return cls.of("rlv_crowd_model_read_bytes", held(context, "context"), address, size)

    def write_bytes(self) -> bytes:
        """The bytes of the file that `write` writes."""
        return made("rlv_crowd_model_write_bytes", self.handle)

    @property
    def info(self) -> Any:
        """Counts and bounds; see `abi.RlvCrowdModelInfo`."""
        out = record.empty(abi.RlvCrowdModelInfo)
        library.call("rlv_crowd_model_info", self.handle, ctypes.byref(out))
        return record.read(out)

    @property
    def clips(self) -> Any:
        """Name, rate and number of poses of every clip."""
        found = []
        for clip in range(self.info.clip_count):
            out = record.empty(abi.RlvCrowdClip)
            library.call("rlv_crowd_model_clip", self.handle, clip, ctypes.byref(out))
            found.append(record.read(out))
        return found

    @property
    def materials(self) -> Any:
        """The names of the materials, which the triangles give by their numbers."""
        found = []
        for material in range(self.info.material_count):
            out = record.empty(abi.RlvCrowdMaterial)
            library.call("rlv_crowd_model_material", self.handle, material, ctypes.byref(out))
            found.append(record.read(out).name)
        return found

    def vertices(self, *names: str) -> Any:
        """The arrays of these names: points (n, 3), normals (n, 3), uvs (n, 2), bones (n, 4), weights (n, 4)."""
        count = self.info.vertex_count
        given, arrays = record.fill(abi.RlvCrowdVertices, {"capacity": count}), {}
        for name in names:
            width = chosen(VERTICES, name, "names")
            arrays[name] = numpy.empty((count, width), numpy.uint32 if name == "bones" else numpy.float32)
            setattr(given, name, address(arrays[name]))
        library.call("rlv_crowd_model_get_vertices", self.handle, ctypes.byref(given))
        return arrays

    def triangles(self) -> tuple[Array, Array]:
        """The vertices (n, 3) and the materials (n) of the triangles of all clusters, one cluster after the other."""
        count = self.info.triangle_count
        triangles, materials = numpy.empty((count, 3), numpy.uint32), numpy.empty(count, numpy.uint32)
        places = address(triangles), address(materials)
        library.call("rlv_crowd_model_get_triangles", self.handle, *places, count)
        return triangles, materials

    def collapses(self) -> Any:
        """An array of `abi.RlvCrowdCollapse`: where each vertex goes when its place is removed."""
        collapses = numpy.zeros(self.info.vertex_count, COLLAPSE)
        place = collapses.ctypes.data_as(ctypes.POINTER(abi.RlvCrowdCollapse))
        library.call("rlv_crowd_model_get_collapses", self.handle, place, len(collapses), 0)
        return collapses

    def offsets(self) -> Any:
        """An array of `abi.RlvCrowdOffset`: what morph targets that clips move add to vertices."""
        offsets = numpy.zeros(self.info.offset_count, OFFSET)
        place = offsets.ctypes.data_as(ctypes.POINTER(abi.RlvCrowdOffset))
        library.call("rlv_crowd_model_get_offsets", self.handle, place, len(offsets), 0)
        return offsets

    def clusters(self) -> Any:
        """An array of `abi.RlvCrowdCluster`."""
        clusters = numpy.zeros(self.info.cluster_count, CLUSTER)
        place = clusters.ctypes.data_as(ctypes.POINTER(abi.RlvCrowdCluster))
        library.call("rlv_crowd_model_get_clusters", self.handle, place, len(clusters), 0)
        return clusters

    def mesh(self, error: float = 0.0, clip: int = 0, pose: int = 0) -> Mesh:
        """A mesh of the coarsest clusters within an error, in units of the model, in a pose of a clip."""
        return Mesh.of("rlv_crowd_model_mesh", self.handle, error, clip, pose)


def draws_of(function: str, handle: Any, counts: Any) -> tuple[Any, ...]:
    """Calls a function that copies draws of a cut, which has these counts, and returns them as `Crowd.draws`."""
    draws, clusters = numpy.zeros(counts.draw_count, DRAW), numpy.empty((counts.draw_count, 2), numpy.uint32)
    instances = numpy.zeros(counts.agent_count, INSTANCE)
    matrices = numpy.empty((counts.matrix_count, 3, 4), numpy.float32)
    capacities = {"draw_capacity": len(draws), "instance_capacity": len(instances), "matrix_capacity": len(matrices)}
    buffers = record.fill(abi.RlvCrowdBuffers, capacities)
    buffers.draws = draws.ctypes.data_as(ctypes.POINTER(abi.RlvCrowdDraw))
    buffers.instances = instances.ctypes.data_as(ctypes.POINTER(abi.RlvCrowdInstance))
    buffers.clusters, buffers.matrices = address(clusters), address(matrices)
    library.call(function, handle, ctypes.byref(buffers))
    return draws, clusters, instances, matrices


def dual_rows_of(function: str, handle: Any, counts: Any) -> Array:
    """Calls a function that copies draws of a cut, which has these counts, and returns them as `Crowd.dual_rows`."""
    rows = numpy.empty((counts.matrix_count, 5, 4), numpy.float32)
    buffers = record.fill(abi.RlvCrowdBuffers, {"matrix_capacity": len(rows)})
    buffers.dual_rows = address(rows)
    library.call(function, handle, ctypes.byref(buffers))
    return rows


def impostors_of(function: str, handle: Any, counts: Any) -> tuple[Any, ...]:
    """Calls a function that copies impostors of a cut, which has these counts, and returns them as `Crowd.impostors`."""
    side = abi.RLV_CROWD_PICTURE_SIDE
    impostors, pictures = numpy.zeros(counts.impostor_count, IMPOSTOR), numpy.zeros(counts.picture_count, PICTURE)
    texels = numpy.zeros((len(pictures), side, side), TEXEL)
    room = {"impostor_capacity": len(impostors), "picture_capacity": len(pictures), "texel_capacity": texels.size}
    buffers = record.fill(abi.RlvCrowdImpostors, room)
    buffers.impostors = impostors.ctypes.data_as(ctypes.POINTER(abi.RlvCrowdImpostor))
    buffers.pictures = pictures.ctypes.data_as(ctypes.POINTER(abi.RlvCrowdPicture))
    buffers.texels = texels.ctypes.data_as(ctypes.POINTER(abi.RlvCrowdTexel))
    library.call(function, handle, ctypes.byref(buffers))
    return impostors, pictures, texels


class Crowd(Handle):
    """Agents of some models, and what a view draws of them."""

    noun, kind = "crowd", abi.RlvCrowd

    def __init__(self, context: Context, models: Any) -> None:
        """Makes a crowd of models, without agents."""
        models = list_of(models, "models")
        handles = (abi.RlvCrowdModel * len(models))(*(held(model, "models", abi.RlvCrowdModel) for model in models))
        super().__init__("rlv_crowd_create", held(context, "context"), handles, len(models))

    def add(self, transforms: ArrayLike, clips: Any = 0, phases: ArrayLike = 0.0, models: Any = 0) -> int:
        """Adds agents and returns the number of the first; see `agents_of`."""
        agents, first = agents_of(transforms, clips, phases, models), ctypes.c_uint32()
        place = agents.ctypes.data_as(ctypes.POINTER(abi.RlvCrowdAgent))
        library.call("rlv_crowd_add", self.handle, place, len(agents), 0, address_of(first))
        return first.value

    def set(self, first: int, transforms: ArrayLike, clips: Any = 0, phases: ArrayLike = 0.0, models: Any = 0) -> None:
        """Moves the agents from number `first` on, or gives them other clips."""
        agents = agents_of(transforms, clips, phases, models)
        place = agents.ctypes.data_as(ctypes.POINTER(abi.RlvCrowdAgent))
        library.call("rlv_crowd_set", self.handle, first, place, len(agents), 0)

    def set_weights(self, agent: int, weights: ArrayLike | None) -> None:
        """Gives an agent weights of its own for the morph targets of its model; None gives it those of its clip again."""
        if weights is None:
            library.call("rlv_crowd_set_weights", self.handle, agent, None, 0)
            return
        given = packed(weights, numpy.float32, "weights").reshape(-1)
        library.call("rlv_crowd_set_weights", self.handle, agent, address(given), len(given))

    def blends(self) -> Array:
        """How far the vertices of each draw of the last cut are on the way to their targets, 0 to 1."""
        frame = getattr(self, "_frame", None) or record.empty(abi.RlvCrowdFrame)
        blends = numpy.empty(frame.draw_count, numpy.float32)
        buffers = record.fill(abi.RlvCrowdBuffers, {"draw_capacity": len(blends)})
        buffers.blends = address(blends)
        library.call("rlv_crowd_get", self.handle, ctypes.byref(buffers))
        return blends

    def weights(self) -> tuple[Array, Array]:
        """Weights of morph targets in the last cut: of all poses that are shown, and the first of the pose of each instance."""
        frame = getattr(self, "_frame", None) or record.empty(abi.RlvCrowdFrame)
        weights = numpy.empty(frame.weight_count, numpy.float32)
        firsts = numpy.empty(frame.agent_count, numpy.uint32)
        counts = {"weight_capacity": len(weights), "instance_capacity": len(firsts)}
        buffers = record.fill(abi.RlvCrowdBuffers, counts)
        buffers.weights, buffers.first_weights = address(weights), address(firsts)
        library.call("rlv_crowd_get", self.handle, ctypes.byref(buffers))
        return weights, firsts

    def cut(
        self,
        size: Sequence[int],
        eye: ArrayLike | Sequence[Any],
        target: ArrayLike | Sequence[Any],
        up: ArrayLike | Sequence[Any] = (0, 1, 0),
        fov: float = 0.6,
        tolerance: float = 0.5,
        time: float = 0.0,
        occlusion: bool = False,
        geomorph: bool = False,
        impostors: bool = False,
        suns: ArrayLike | Sequence[Any] = (),
        around: float = 0.0,
    ) -> Any:
        """Finds what a view draws, and returns counts; see `abi.RlvCrowdFrame`. `size` is (width, height) in pixels,
        `tolerance` the error that may be seen, in pixels; `occlusion` leaves out agents that others hide; `geomorph` moves
        vertices from cut to cut; `impostors` makes agents of a few pixels quads, see `impostors`. `suns` has a row for each sun
        whose shadows are drawn, the direction towards it and half its angular diameter in radians: agents out of sight that
        may throw shadows into the view are found too, and all within `around` of it."""
        given = {"tolerance": tolerance, "up": up, "fov": fov, "time": time, "suns": suns, "around": around}
        view = view_of(size, eye, target, **given, occlusion=occlusion, geomorph=geomorph, impostors=impostors)
        self._frame = record.empty(abi.RlvCrowdFrame)
        library.call("rlv_crowd_cut", self.handle, ctypes.byref(view), ctypes.byref(self._frame))
        return record.read(self._frame)

    def draws(self) -> tuple[Any, ...]:
        """What the last cut found: arrays of `abi.RlvCrowdDraw`, of model and cluster (n, 2) of each draw, of
        `abi.RlvCrowdInstance`, and of skin matrices (n, 3, 4)."""
        frame = getattr(self, "_frame", None) or record.empty(abi.RlvCrowdFrame)
        return draws_of("rlv_crowd_get", self.handle, frame)

    def dual_rows(self) -> Array:
        """The matrices of the last cut as they are blended by dual quaternions (n, 5, 4): three rows of stretch, a rotation and a
        dual part; see `abi.RlvCrowdBuffers`."""
        frame = getattr(self, "_frame", None) or record.empty(abi.RlvCrowdFrame)
        return dual_rows_of("rlv_crowd_get", self.handle, frame)

    def impostors(self) -> tuple[Any, ...]:
        """The quads of the last cut: arrays of `abi.RlvCrowdImpostor`, of `abi.RlvCrowdPicture`, and of `abi.RlvCrowdTexel`
        (pictures, rows, columns), the lowest row first."""
        frame = getattr(self, "_frame", None) or record.empty(abi.RlvCrowdFrame)
        return impostors_of("rlv_crowd_get_impostors", self.handle, frame)


class DeviceCrowd(Handle):
    """The agents of a crowd on the graphics device of its context, which makes the same draws."""

    noun, kind = "device_crowd", abi.RlvDeviceCrowd

    def __init__(self, crowd: Crowd) -> None:
        """Sends the models of a crowd to the device."""
        super().__init__("rlv_device_crowd_create", held(crowd, "crowd"))

    def cut(self, size: Sequence[int], eye: ArrayLike, target: ArrayLike, **view: Any) -> Any:
        """Finds what a view draws, and returns counts; see `Crowd.cut` and `abi.RlvDeviceCrowdInfo`."""
        given = view_of(size, eye, target, **view)
        self._info = record.empty(abi.RlvDeviceCrowdInfo)
        library.call("rlv_device_crowd_cut", self.handle, ctypes.byref(given), ctypes.byref(self._info))
        return record.read(self._info)

    def draws(self) -> tuple[Any, ...]:
        """What the last cut found, copied back, as `Crowd.draws`; the matrices are those of all poses."""
        info = getattr(self, "_info", None) or record.empty(abi.RlvDeviceCrowdInfo)
        return draws_of("rlv_device_crowd_get", self.handle, info)

    def dual_rows(self) -> Array:
        """As `Crowd.dual_rows`, of all poses."""
        info = getattr(self, "_info", None) or record.empty(abi.RlvDeviceCrowdInfo)
        return dual_rows_of("rlv_device_crowd_get", self.handle, info)

    def impostors(self) -> tuple[Any, ...]:
        """The quads of the last cut, as `Crowd.impostors`."""
        info = getattr(self, "_info", None) or record.empty(abi.RlvDeviceCrowdInfo)
        return impostors_of("rlv_device_crowd_get_impostors", self.handle, info)

    def vulkan(self) -> Any:
        """Its Vulkan objects as numbers; see buffer.h for who may use them when."""
        out = record.empty(abi.RlvDeviceCrowdVulkan)
        library.call("rlv_device_crowd_vulkan", self.handle, ctypes.byref(out))
        return record.read(out)
