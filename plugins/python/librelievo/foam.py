"""Foam of particles over finished pictures, in screen space."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, address, integer, packed, tupled
from .error import Invalid
from .handle import Handle, held
from .hint import ArrayLike, Progress
from .parameter import table
from .progress import watched

if TYPE_CHECKING:
    from .context import Context
    from .fluid import Fluid
    from .parameter import Parameter

LAYERS = {"intensity": 1, "thickness": 1, "depth": 1, "normal": 3, "occlusion": 1, "irradiance": 3}


def params() -> list[Parameter]:
    """The fields of `abi.RlvFoamSettings` with ranges, units and help."""
    return table("rlv_foam_params")


def depths(values: Any, shape: Any, name: str) -> Any:
    """Depths as an array of the picture's shape; None stays None."""
    if values is None:
        return None
    values = packed(values, numpy.float32, name)
    if values.shape != shape:
        raise Invalid(f"{name}: an array of the shape {shape} is needed, not {values.shape}")
    return values


class Foam(Handle):
    """A picture of foam: particles are added, then it is shaded and composited."""

    noun, kind = "foam", abi.RlvFoam

    def __init__(
        self,
        context: Context,
        size: Any,
        eye: ArrayLike,
        target: ArrayLike,
        up: ArrayLike = (0, 0, 1),
        fov: float = 0.6,
        orthographic: int = 0,
        solids: Any = None,
        fluid: Fluid | None = None,
        **settings: Any,
    ) -> None:
        """`size` is (width, height); depths are arrays (height, width) in metres; settings are the fields of
        `abi.RlvFoamSettings`."""
        self.size = tuple(integer(edge, "size") for edge in tupled(size, 2, "size"))
        shape = (self.size[1], self.size[0])
        given = {"width": shape[1], "height": shape[0], "eye": eye, "target": target, "up": up, "fov": fov}
        view = record.fill(abi.RlvFoamView, {**given, "orthographic": orthographic})
        kept = [depths(solids, shape, "solids"), depths(fluid, shape, "fluid")]
        view.solids, view.fluid = (address(array) for array in kept)
        settings = record.fill(abi.RlvFoamSettings, settings)
        super().__init__("rlv_foam_create", held(context, "context"), ctypes.byref(view), ctypes.byref(settings))

    def add(
        self,
        positions: ArrayLike,
        ids: ArrayLike | None = None,
        kinds: ArrayLike | None = None,
        lives: ArrayLike | None = None,
        velocities: ArrayLike | None = None,
    ) -> None:
        """Adds particles at positions (n, 3) in metres, with ids, values of FoamKind, and shares of their lives that have
        passed, each (n) if it is given; velocities (n, 3) in m/s move them while the shutter of the settings is open."""
        readings = {
            "positions": ("position_stride", Reading(positions, numpy.float32, 3, "positions")),
            "ids": ("id_stride", Reading(ids, numpy.uint32, 0, "ids")),
            "kinds": ("kind_stride", Reading(kinds, numpy.uint32, 0, "kinds")),
            "lives": ("life_stride", Reading(lives, numpy.float32, 0, "lives")),
            "velocities": ("velocity_stride", Reading(velocities, numpy.float32, 3, "velocities")),
        }
        particles = record.fill(abi.RlvFoamParticles, {"count": readings["positions"][1].count})
        for name, (stride, reading) in readings.items():
            if reading.array is not None and reading.count != particles.count:
                raise Invalid(f"{name}: there are {reading.count} for {particles.count} positions")
            setattr(particles, name, reading.address)
            setattr(particles, stride, reading.stride)
        library.call("rlv_foam_add", self.handle, ctypes.byref(particles))

    def shade(self, radiance: ArrayLike | None = None, up: ArrayLike = (0, 0, 1), progress: Progress | None = None) -> None:
        """Makes the layers, lit by a picture (height, 2 height, 3) by latitude and longitude, or white from everywhere."""
        light = None
        if radiance is not None:
            radiance = packed(radiance, numpy.float32, "radiance")
            if radiance.ndim != 3 or radiance.shape[2] != 3:
                raise Invalid(f"radiance: an array of the shape (height, width, 3) is needed, not {radiance.shape}")
            light = record.fill(abi.RlvFoamLight, {"width": radiance.shape[1], "height": radiance.shape[0], "up": up})
            light.radiance = address(radiance)
        with watched(progress) as callback:
            library.call("rlv_foam_shade", self.handle, None if light is None else ctypes.byref(light), callback, None)

    def layers(self) -> Any:
        """The layers by their names, arrays (height, width), of normals and irradiance (height, width, 3)."""
        width, height = self.size
        found, arrays = {}, record.fill(abi.RlvFoamLayers, {})
        for name, numbers in LAYERS.items():
            found[name] = numpy.empty((height, width, 3) if numbers == 3 else (height, width), numpy.float32)
            setattr(arrays, name, address(found[name]))
        library.call("rlv_foam_get", self.handle, ctypes.byref(arrays))
        return found

    def composite(self, background: Any) -> Any:
        """The picture (height, width, 3 or 4) with the foam over it."""
        background = packed(background, numpy.float32, "background")
        if background.ndim != 3 or background.shape[:2] != (self.size[1], self.size[0]):
            raise Invalid(f"background: a picture of the size {self.size} is needed, not {background.shape}")
        picture = numpy.empty_like(background)
        library.call("rlv_foam_composite", self.handle, address(background), background.shape[2], address(picture))
        return picture
