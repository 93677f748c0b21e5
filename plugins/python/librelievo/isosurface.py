"""Surfaces of fluids of particles, as meshes and for rays without a mesh."""

from __future__ import annotations

import ctypes
import math
from collections import namedtuple
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, mapped, numbers, writing
from .caster import ray_arrays
from .error import Invalid
from .handle import Handle, held, text_bytes
from .hint import Array, ArrayLike, Progress
from .mesh import Mesh, set_array
from .progress import watched

if TYPE_CHECKING:
    from .context import Context

HIT = numpy.dtype(abi.RlvIsosurfaceHit)

Classified = namedtuple("Classified", ["classes", "surface_count", "blind_count", "hidden_count", "kept"])
Classified.__doc__ = "An RlvIsosurfaceClass for each particle, how many of each there are, and the share that is kept."


def isosurface_options(options: Any) -> Any:
    """`abi.RlvIsosurfaceOptions` of keywords; the function may be given by its name, such as "zhu_bridson"."""
    return record.fill(abi.RlvIsosurfaceOptions, options, function=abi.RlvIsosurfaceFunction)


def mesh_options(channels: Any = None, **options: Any) -> tuple[Any, ...]:
    """`abi.RlvIsosurfaceMeshOptions`, and what keeps their arrays. `channels` are arrays (n, 1 to 4) by their names."""
    made, kept = record.fill(abi.RlvIsosurfaceMeshOptions, options), set_channels(channels)
    made.channels, made.channel_count = kept[0], len(kept[0])
    return made, kept


def set_channels(channels: Any) -> tuple[Any, ...]:
    """An array of `abi.RlvAttributeArrays` of arrays (n, 1 to 4) by their names, and what keeps their numbers."""
    channels = mapped(channels, "channels")
    kept, entries = [], (abi.RlvAttributeArrays * len(channels))()
    for at, (name, values) in enumerate(channels.items()):
        title = text_bytes(name, "channels")
        values = numbers(values, name, numpy.float32)
        values = values.reshape(len(values), math.prod(values.shape[1:])) if values.ndim else values
        width = values.shape[1] if values.ndim == 2 else 0
        reading = Reading(values, numpy.float32, max(width, 1), name)
        told = {"domain": "point", "type": int(abi.RlvType.F32), "width": width, "name": title}
        entries[at] = record.fill(abi.RlvAttributeArrays, told, domain=abi.RlvDomain)
        set_array(entries[at], reading, "values", "value_count", "value_stride")
        kept.append(reading)
    return entries, kept


class Isosurface(Handle):
    """A picture of the surface of particles. It does not change."""

    noun, kind = "isosurface", abi.RlvIsosurface

    def __init__(
        self, context: Context, points: ArrayLike, velocities: ArrayLike | None = None, blind: Any = None, **options: Any
    ) -> None:
        """Of points (n, 3) in metres, with velocities (n, 3) in m/s and flags (n) of blind particles if there are any;
        options are the fields of `abi.RlvIsosurfaceOptions`."""
        points = Reading(points, numpy.float32, 3, "points")
        velocities = Reading(velocities, numpy.float32, 3, "velocities")
        blind = Reading(None if blind is None else numbers(blind, "blind", numpy.uint8), numpy.uint8, 0, "blind")
        for name, given in (("velocities", velocities), ("blind", blind)):
            if given.array is not None and given.count != points.count:
                raise Invalid(f"{name}: there are {given.count} for {points.count} points")
        particles = record.empty(abi.RlvIsosurfaceParticles)
        particles.count = points.count
        particles.points, particles.point_stride = points.address, points.stride
        particles.velocities, particles.velocity_stride = velocities.address, velocities.stride
        particles.blind, particles.blind_stride = blind.address, blind.stride
        told = ctypes.byref(isosurface_options(options))
        super().__init__("rlv_isosurface_create", held(context, "context"), ctypes.byref(particles), told)

    @property
    def info(self) -> Any:
        """Counts and reaches."""
        out = record.empty(abi.RlvIsosurfaceInfo)
        library.call("rlv_isosurface_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def mesh(self, channels: Any = None, progress: Progress | None = None, **options: Any) -> Mesh:
        """The mesh of it; `channels` are arrays of particles by the names of the attributes that vertices get, options the
        fields of `abi.RlvIsosurfaceMeshOptions`."""
        told, _kept = mesh_options(channels, **options)
        with watched(progress) as callback:
            return Mesh.of("rlv_isosurface_mesh", self.handle, ctypes.byref(told), callback, None)

    def classify(self, threshold: float | None = None, progress: Progress | None = None) -> Any:
        """Which particles the surface needs: blind ones are nearer than a threshold, the influence if there is none."""
        count = self.info.particle_count
        classes, place, stride = writing(None, count, numpy.uint8, 0, "classes")
        out = record.empty(abi.RlvIsosurfaceClasses)
        with watched(progress) as callback:
            told = (-1.0 if threshold is None else threshold, place, count, stride, callback, None)
            library.call("rlv_isosurface_classify", self.handle, *told, ctypes.byref(out))
        return Classified(classes, *record.read(out))

    def cast(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        min_distance: ArrayLike = 0.0,
        max_distance: ArrayLike = 0.0,
        times: ArrayLike = 0.0,
        masks: ArrayLike | None = None,
    ) -> Array:
        """The first hit of every ray, an array of the fields of `abi.RlvIsosurfaceHit`: distance, position, normal, velocity,
        enters. Distances, times and masks are one number for all rays, or one for each; a ray whose mask is 0 hits nothing."""
        arrays, _kept = ray_arrays(origins, directions, min_distance, max_distance, masks, times)
        hits = numpy.empty(arrays.count, HIT)
        place = ctypes.cast(hits.__array_interface__["data"][0], ctypes.POINTER(abi.RlvIsosurfaceHit))
        library.call("rlv_isosurface_cast", self.handle, ctypes.byref(arrays), place, 0)
        return hits

    @property
    def table(self) -> Array:
        """The struct `abi.RlvIsosurfaceTable`, for a renderer as long as this object lives."""
        out = record.empty(abi.RlvIsosurfaceTable)
        library.call("rlv_isosurface_table", self.handle, ctypes.byref(out))
        return out
