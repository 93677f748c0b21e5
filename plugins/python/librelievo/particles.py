"""Particles at a time, and their files."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, number, writing
from .channel import find_channel, read_channel
from .error import Invalid
from .handle import Handle, held, path_bytes
from .hint import Array, ArrayLike, FilePath
from .isosurface import Isosurface, isosurface_options, set_channels

if TYPE_CHECKING:
    from .context import Context


CHANNEL = ("rlv_particles_find_channel", "rlv_particles_channel_info", "rlv_particles_get_channel")


class Particles(Handle):
    """Places with named channels, such as `velocity` in m/s and `blind`. They do not change."""

    noun, kind = "particles", abi.RlvParticles

    def __init__(
        self,
        context: Context,
        points: ArrayLike,
        channels: Mapping[str, ArrayLike] | None = None,
        numbers: ArrayLike | None = None,
        time: float | None = None,
        spacing: float = 0.0,
    ) -> None:
        """Of points (n, 3) in metres, with `channels` (n, 1 to 4) by their names, numbers (n), a time in seconds and how far
        particles are apart at rest in metres, if they are known."""
        points = Reading(points, numpy.float32, 3, "points")
        numbers = Reading(numbers, numpy.uint32, 0, "numbers")
        if numbers.array is not None and numbers.count != points.count:
            raise Invalid(f"numbers: there are {numbers.count} for {points.count} points")
        arrays, (entries, _kept) = record.empty(abi.RlvParticlesArrays), set_channels(channels)
        arrays.has_time, arrays.time = int(time is not None), 0.0 if time is None else number(time, "time")
        arrays.spacing = number(spacing, "spacing")
        arrays.count, arrays.points, arrays.point_stride = points.count, points.address, points.stride
        arrays.numbers, arrays.number_stride = numbers.address, numbers.stride
        arrays.channels, arrays.channel_count = entries, len(entries)
        super().__init__("rlv_particles_create", held(context, "context"), ctypes.byref(arrays))

    @classmethod
    def read(cls, context: Context, path: FilePath) -> Particles:
        """Of a file: a frame of a cache, classic .bgeo, legacy VTK, PLY, OpenVDB's points, or the points of a mesh."""
        return cls.of("rlv_particles_read", held(context, "context"), path_bytes(path))

    def write(self, path: FilePath) -> None:
        """Writes .rlvfluid, .bgeo, .vtk, .ply or .vdb."""
        library.call("rlv_particles_write", self.handle, path_bytes(path))

    @property
    def info(self) -> Any:
        """How many there are, and what they have."""
        out = record.empty(abi.RlvParticlesInfo)
        library.call("rlv_particles_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def points(self, out: Array | None = None) -> Array:
        """Their places, (n, 3) in metres."""
        count = self.info.count
        out, place, stride = writing(out, count, numpy.float32, 3, "points")
        library.call("rlv_particles_get_points", self.handle, place, count, stride)
        return out

    def numbers(self) -> Array | None:
        """Their numbers (n), None if they have none."""
        info = self.info
        if not info.has_numbers:
            return None
        out, place, stride = writing(None, info.count, numpy.uint32, 0, "numbers")
        library.call("rlv_particles_get_numbers", self.handle, place, info.count, stride)
        return out

    def channel(self, name: str) -> Array:
        """What they carry by a name, (n, 1 to 4)."""
        return find_channel(self.handle, CHANNEL, name)

    def channels(self) -> dict[str, Array]:
        """All that they carry, (n, 1 to 4) by names."""
        return dict(read_channel(self.handle, CHANNEL, index) for index in range(self.info.channel_count))

    def keep(self, classes: Iterable[int]) -> Particles:
        """The particles that a surface needs, with the channel `blind`, by the classes of `Isosurface.classify`."""
        classes = Reading(classes, numpy.uint8, 0, "classes")
        return Particles.of("rlv_particles_keep", self.handle, classes.address, classes.count, classes.stride)

    def isosurface(self, **options: Any) -> Isosurface:
        """Their surface; options are the fields of `abi.RlvIsosurfaceOptions`, of which the radius is half the spacing if none
        is given and that is known."""
        told = ctypes.byref(isosurface_options(options)) if options else None
        return Isosurface.of("rlv_particles_isosurface", self.handle, told)
