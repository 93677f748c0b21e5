"""Diffuse particles: the spray, foam and bubbles of a fluid, made from its frames."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, address, chosen, tupled
from .error import Invalid
from .handle import Handle, held, path_bytes
from .hint import Array, ArrayLike, FilePath, Progress
from .parameter import table
from .particles import Particles
from .progress import watched

if TYPE_CHECKING:
    from .context import Context
    from .parameter import Parameter

# The fields of `abi.RlvDiffuseArrays`, their types and numbers a particle.
FIELDS = {
    "positions": (numpy.float32, 3),
    "velocities": (numpy.float32, 3),
    "ids": (numpy.uint32, 1),
    "kinds": (numpy.uint32, 1),
    "ages": (numpy.float32, 1),
    "lifetimes": (numpy.float32, 1),
    "lives": (numpy.float32, 1),
}
POTENTIALS = ("air", "crests", "energies")


def params() -> list[Parameter]:
    """The fields of `abi.RlvDiffuseSettings` with ranges, units and help."""
    return table("rlv_diffuse_params")


def _fluid(positions: Any, velocities: Any) -> tuple[Any, ...]:
    """The struct of a fluid's frame, and the arrays that it points to."""
    positions = Reading(positions, numpy.float32, 3, "positions")
    velocities = Reading(velocities, numpy.float32, 3, "velocities")
    if positions.count != velocities.count:
        raise Invalid(f"velocities: there are {velocities.count} for {positions.count} positions")
    fluid = record.fill(abi.RlvDiffuseFluid, {"count": positions.count})
    fluid.positions, fluid.position_stride = positions.address, positions.stride
    fluid.velocities, fluid.velocity_stride = velocities.address, velocities.stride
    return fluid, (positions, velocities)


class Diffuse(Handle):
    """A run of diffuse particles over the frames of a fluid."""

    noun, kind = "diffuse", abi.RlvDiffuse

    def __init__(
        self, context: Context, spacing: float, gravity: ArrayLike = (0, 0, -9.81), bounds: Any = None, **settings: Any
    ) -> None:
        """`spacing` is the distance between the fluid's particles at rest in metres, `bounds` two corners of a box outside of
        which particles are removed; settings are the fields of `abi.RlvDiffuseSettings`."""
        options = {"spacing": spacing, "gravity": gravity}
        if bounds is not None:
            low, high = tupled(bounds, 2, "bounds")
            options.update(has_bounds=1, low=low, high=high)
        options = record.fill(abi.RlvDiffuseOptions, options)
        settings = record.fill(abi.RlvDiffuseSettings, settings)
        super().__init__("rlv_diffuse_create", held(context, "context"), ctypes.byref(options), ctypes.byref(settings))

    @property
    def info(self) -> Any:
        """The number of particles, and of frames and births so far."""
        out = record.empty(abi.RlvDiffuseInfo)
        library.call("rlv_diffuse_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def advance(self, positions: ArrayLike, velocities: ArrayLike, seconds: float, progress: Progress | None = None) -> Any:
        """Moves the particles by so many seconds to the end of a frame of the fluid, of positions and velocities (n, 3), and
        adds the new ones; what the frame did."""
        (fluid, _kept), report = _fluid(positions, velocities), record.empty(abi.RlvDiffuseReport)
        with watched(progress) as callback:
            given = (ctypes.byref(fluid), seconds, ctypes.byref(report), callback, None)
            library.call("rlv_diffuse_advance", self.handle, *given)
        return record.read(report)

    def potentials(self, positions: ArrayLike, velocities: ArrayLike) -> Any:
        """The potentials of a fluid's particles, each (n) from 0 to 1: `air`, `crests` and `energies`."""
        fluid, _kept = _fluid(positions, velocities)
        found = {name: numpy.empty(fluid.count, numpy.float32) for name in POTENTIALS}
        arrays = record.empty(abi.RlvDiffusePotentials)
        arrays.capacity = fluid.count
        for name, values in found.items():
            setattr(arrays, name, address(values))
        library.call("rlv_diffuse_potentials", self.handle, ctypes.byref(fluid), ctypes.byref(arrays))
        return found

    def get(self, *names: str) -> dict[str, Array]:
        """The particles by the names of arrays of `abi.RlvDiffuseArrays`, all of them if none is given. Positions, ids, kinds
        and lives are what `Foam.add` takes."""
        wanted = {name: chosen(FIELDS, name, "names") for name in names or FIELDS}
        arrays, count, found = record.empty(abi.RlvDiffuseArrays), self.info.count, {}
        arrays.capacity = count
        for name, (number, width) in wanted.items():
            found[name] = numpy.empty((count, 3) if width == 3 else count, number)
            setattr(arrays, name, address(found[name]))
        library.call("rlv_diffuse_get", self.handle, ctypes.byref(arrays))
        return found

    def particles(self, time: float = 0.0) -> Particles:
        """A copy of the particles for files, at a time in seconds."""
        return Particles.of("rlv_diffuse_particles", self.handle, time)

    def save(self, path: FilePath, time: float = 0.0) -> None:
        """Writes the particles and what a run continues from to a file."""
        library.call("rlv_diffuse_save", self.handle, path_bytes(path), time)

    def restore(self, path: FilePath) -> None:
        """Continues from such a file, with the options and settings of this run."""
        library.call("rlv_diffuse_restore", self.handle, path_bytes(path))
