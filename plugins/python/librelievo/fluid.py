"""Fluids of particles."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, address, chosen, flag, list_of, mapped, numbers, packed, writing
from .array import matrix as matrix_of
from .channel import find_channel, read_channel
from .error import Invalid
from .bytes import given, made
from .handle import Handle, held, path_bytes, text_bytes
from .hint import Array, ArrayLike, FilePath, Progress, Settings
from .isosurface import Isosurface, isosurface_options, set_channels
from .parameter import address_of
from .particles import Particles
from .progress import watched

if TYPE_CHECKING:
    from .context import Context
    from .mesh import Mesh

CHANNEL = ("rlv_fluid_find_channel", "rlv_fluid_channel_info", "rlv_fluid_get_channel")
# What `Fluid.get` knows: the fields of `abi.RlvFluidArrays`, their types and numbers a particle.
FIELDS = {
    "points": (numpy.float32, 3),
    "velocities": (numpy.float32, 3),
    "numbers": (numpy.uint32, 0),
    "pressures": (numpy.float32, 0),
    "densities": (numpy.float32, 0),
    "births": (numpy.float64, 0),
}
STRIDES = {name: name.removesuffix("s") + "_stride" for name in FIELDS} | {
    "velocities": "velocity_stride",
    "densities": "density_stride",
}


def _vector(values: Any, name: str) -> Any:
    """Three packed floats."""
    return _three(values, numpy.float32, name)


def _place(values: Any, name: str) -> Any:
    """Three packed doubles."""
    return _three(values, numpy.float64, name)


def _three(values: Any, kind: Any, name: str) -> Any:
    reading = Reading(packed(values, kind, name), kind, 3, name)
    if reading.count != 1:
        raise Invalid(f"{name}: three numbers are needed")
    return reading


class Fluid(Handle):
    """Particles that are simulated. Arrays of all of them are in the order of rising numbers."""

    noun, kind = "fluid", abi.RlvFluid

    def __init__(self, context: Context, **options: Any) -> None:
        """Without particles and walls; options are the fields of `abi.RlvFluidOptions`."""
        told = record.fill(
            abi.RlvFluidOptions, options, kernels=abi.RlvFluidKernels, steps=abi.RlvFluidSteps, solver=abi.RlvFluidSolver
        )
        super().__init__("rlv_fluid_create", held(context, "context"), ctypes.byref(told))

    @property
    def info(self) -> Any:
        """Counts, the time, and how the particles move together."""
        out = record.empty(abi.RlvFluidInfo)
        library.call("rlv_fluid_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def add(
        self,
        points: ArrayLike,
        velocities: ArrayLike = (0, 0, 0),
        lifetime: float = 0.0,
        channels: Mapping[str, ArrayLike] | None = None,
    ) -> None:
        """Adds particles at points (n, 3) in metres with velocities in m/s, one for all or (n, 3); a lifetime of 0
        seconds is unlimited. `channels` are arrays by their names: (n, 1 to 4), or one row for all."""
        points = Reading(points, numpy.float32, 3, "points")
        velocities = Reading(velocities, numpy.float32, 3, "velocities")
        particles = record.fill(abi.RlvFluidParticles, {"lifetime": lifetime})
        particles.count = points.count
        particles.points, particles.point_stride = points.address, points.stride
        if velocities.count == points.count:
            particles.velocities, particles.velocity_stride = velocities.address, velocities.stride
        elif velocities.count == 1:
            particles.velocity[:] = velocities.array[0].tolist()
        else:
            raise Invalid(f"velocities: there are {velocities.count} for {points.count} points")
        entries, _kept = set_channels(channels)
        particles.channels, particles.channel_count = entries, len(entries)
        library.call("rlv_fluid_add", self.handle, ctypes.byref(particles))

    def add_box(self, low: ArrayLike, high: ArrayLike, velocity: ArrayLike = (0, 0, 0)) -> None:
        """Fills a box with particles half a spacing from its sides."""
        given = [_place(low, "low"), _place(high, "high"), _vector(velocity, "velocity")]
        library.call("rlv_fluid_add_box", self.handle, *(vector.address for vector in given))

    def fill(self, mesh: Mesh, matrix: ArrayLike | None = None, velocity: ArrayLike = (0, 0, 0)) -> Any:
        """Fills a closed mesh, and returns how many particles there are in it."""
        placed, velocity, added = matrix_of(matrix), _vector(velocity, "velocity"), ctypes.c_size_t()
        given = (held(mesh, "mesh"), address(placed), velocity.address, address_of(added))
        library.call("rlv_fluid_fill", self.handle, *given)
        return added.value

    def add_emitter(
        self,
        mesh: Mesh | None = None,
        matrix: ArrayLike | None = None,
        channels: Mapping[str, ArrayLike] | None = None,
        **options: Any,
    ) -> None:
        """Adds an emitter: the surface of a mesh, or a disc or rectangle; options are the fields of
        `abi.RlvFluidEmitterOptions`, `channels` what its particles carry: 1 to 4 numbers by names."""
        placed = matrix_of(matrix)
        if mesh is not None:
            options.setdefault("shape", "surface")
        told = record.fill(abi.RlvFluidEmitterOptions, options, shape=abi.RlvFluidEmitterShape)
        handle = abi.RlvMesh() if mesh is None else held(mesh, "mesh")
        rows = {name: numbers(value, "channels").reshape(1, -1) for name, value in mapped(channels, "channels").items()}
        entries, _kept = set_channels(rows)
        told.channels, told.channel_count = entries, len(entries)
        library.call("rlv_fluid_add_emitter", self.handle, handle, address(placed), ctypes.byref(told))

    def add_sink(self, low: ArrayLike, high: ArrayLike, is_outside: bool = False) -> None:
        """Removes particles in a box, or particles outside it."""
        given = [_place(low, "low"), _place(high, "high")]
        library.call("rlv_fluid_add_sink", self.handle, *(vector.address for vector in given), flag(is_outside, "is_outside"))

    def add_sink_mesh(self, mesh: Mesh, matrix: ArrayLike | None = None) -> None:
        """Takes away particles inside of a closed mesh."""
        placed = matrix_of(matrix)
        library.call("rlv_fluid_add_sink_mesh", self.handle, held(mesh, "mesh"), address(placed))

    def clear_sources(self) -> None:
        """Forgets all emitters and sinks."""
        library.call("rlv_fluid_clear_sources", self.handle)

    def set_budget(self, particles: Any = 0, stops: bool = False) -> None:
        """Particles at most for emitters, 0 for no limit; beyond it steps fail, or emitters wait."""
        library.call("rlv_fluid_set_budget", self.handle, particles, flag(stops, "stops"))

    def set_forces(self, forces: Iterable[Settings]) -> None:
        """Has forces act instead of those before: dictionaries of the fields of `abi.RlvFluidForce`."""
        forces = list_of(forces, "forces")
        entries = (abi.RlvFluidForce * len(forces))()
        for at, force in enumerate(forces):
            entries[at] = record.fill(abi.RlvFluidForce, force, kind=abi.RlvFluidForceKind)
        library.call("rlv_fluid_set_forces", self.handle, entries, len(entries), 0)

    def remove(self, numbers: ArrayLike) -> Any:
        """Removes the particles of these numbers, and returns how many there were."""
        numbers, removed = Reading(numbers, numpy.uint32, 0, "numbers"), ctypes.c_size_t()
        given = (numbers.address, numbers.count, numbers.stride, address_of(removed))
        library.call("rlv_fluid_remove", self.handle, *given)
        return removed.value

    def set_walls(self, points: ArrayLike) -> None:
        """Takes particles at points (n, 3) as walls at rest instead of those there were."""
        points = Reading(points, numpy.float32, 3, "points")
        library.call("rlv_fluid_set_walls", self.handle, points.address, points.count, points.stride)

    def set_basin(self, low: ArrayLike, high: ArrayLike) -> None:
        """Takes the six sides of a box as walls instead of those there were."""
        given = [_place(low, "low"), _place(high, "high")]
        library.call("rlv_fluid_set_basin", self.handle, *(vector.address for vector in given))

    def move_walls(self, points: ArrayLike, velocities: ArrayLike) -> None:
        """Has walls be at other places and go on from there, in the order in which they were set."""
        points = Reading(points, numpy.float32, 3, "points")
        velocities = Reading(velocities, numpy.float32, 3, "velocities")
        if points.count != velocities.count:
            raise Invalid(f"velocities: there are {velocities.count} for {points.count} points")
        given = (points.address, points.count, points.stride, velocities.address, velocities.stride)
        library.call("rlv_fluid_set_wall_points", self.handle, *given)

    def add_collider(self, mesh: Mesh, matrix: ArrayLike | None = None, **options: Any) -> Any:
        """Adds a mesh that fluid does not pass, and returns its number; options are the fields of
        `abi.RlvFluidColliderOptions`."""
        number, placed = ctypes.c_uint32(), matrix_of(matrix)
        told = record.fill(abi.RlvFluidColliderOptions, options, contact=abi.RlvFluidContact)
        given = (held(mesh, "mesh"), address(placed), ctypes.byref(told), address_of(number))
        library.call("rlv_fluid_add_collider", self.handle, *given)
        return number.value

    def move_collider(self, collider: Any, to: Any, seconds: float, start: Any = None) -> None:
        """Has a collider go to points (n, 3), in straight lines and within so many seconds, from where it is or from
        `start`."""
        to, start = Reading(to, numpy.float32, 3, "to"), Reading(start, numpy.float32, 3, "start")
        if start.array is not None and (start.count != to.count or start.stride != to.stride):
            start = Reading(numpy.ascontiguousarray(start.array), numpy.float32, 3, "start")
            to = Reading(numpy.ascontiguousarray(to.array), numpy.float32, 3, "to")
            if start.count != to.count:
                raise Invalid(f"start: there are {start.count} points for {to.count}")
        given = (start.address, to.address, to.count, to.stride, seconds)
        library.call("rlv_fluid_move_collider", self.handle, collider, *given)

    def impulse(self, collider: Any = None) -> tuple[Any, ...]:
        """The momentum that a collider, or walls, were given in the last step: linear and angular about the origin."""
        linear, angular = numpy.empty(3), numpy.empty(3)
        number = abi.RLV_FLUID_WALLS if collider is None else collider
        library.call("rlv_fluid_impulse", self.handle, number, address(linear), address(angular))
        return linear, angular

    def accelerate(self, accelerations: ArrayLike) -> None:
        """Has each particle accelerated by so much, (n, 3) in m/s², beside all else, from now on."""
        given = Reading(accelerations, numpy.float32, 3, "accelerations")
        library.call("rlv_fluid_accelerate", self.handle, given.address, given.count, given.stride)

    def step(self, seconds: float) -> Any:
        """Makes one step of seconds, or a shorter one; what it did."""
        out = record.empty(abi.RlvFluidReport)
        library.call("rlv_fluid_step", self.handle, seconds, ctypes.byref(out))
        return record.read(out)

    def advance(self, seconds: float, progress: Progress | None = None) -> Any:
        """Simulates seconds in as many steps as it takes; what they did."""
        out = record.empty(abi.RlvFluidReport)
        with watched(progress) as callback:
            library.call("rlv_fluid_advance", self.handle, seconds, callback, None, ctypes.byref(out))
        return record.read(out)

    def get(self, *names: str, **into: Any) -> dict[str, Array]:
        """What particles have, by names of arrays of `abi.RlvFluidArrays`: a dictionary. Arrays that are given by name are
        written to."""
        wanted = {name: None for name in names if chosen(FIELDS, name, "names")} | into
        fields = {name: chosen(FIELDS, name, "names") for name in wanted}
        arrays, count, found = record.empty(abi.RlvFluidArrays), self.info.particle_count, {}
        arrays.capacity = count
        for name, out in wanted.items():
            number, width = fields[name]
            found[name], place, stride = writing(out, count, number, width, name)
            setattr(arrays, name, place)
            setattr(arrays, STRIDES[name], stride)
        library.call("rlv_fluid_get", self.handle, ctypes.byref(arrays))
        return found

    def set_channel(self, name: str, values: ArrayLike) -> None:
        """Gives each particle a row of values (n, 1 to 4), which it carries from now on."""
        text_bytes(name, "name")
        entries, _kept = set_channels({name: values})
        library.call("rlv_fluid_set_channel", self.handle, entries)

    def channel(self, name: str) -> Array:
        """What particles carry by a name, (n, 1 to 4)."""
        return find_channel(self.handle, CHANNEL, name)

    def channels(self) -> dict[str, Array]:
        """All that particles carry, (n, 1 to 4) by names."""
        return dict(read_channel(self.handle, CHANNEL, index) for index in range(self.info.channel_count))

    def save(self, path: FilePath) -> None:
        """Writes all that it goes on from to a file."""
        library.call("rlv_fluid_save", self.handle, path_bytes(path))

    def restore(self, path: FilePath) -> None:
        """Goes on from such a file, with the same options, walls, colliders and sources."""
        library.call("rlv_fluid_restore", self.handle, path_bytes(path))

    def save_bytes(self) -> bytes:
        """All that it goes on from, as bytes."""
        return made("rlv_fluid_save_bytes", self.handle)

    def restore_bytes(self, state: bytes) -> None:
        """Goes on from such bytes."""
        address, size, _kept = given(state, "state")
        library.call("rlv_fluid_restore_bytes", self.handle, address, size)

    def particles(self) -> Particles:
        """A picture of the particles as they are now, for files."""
        return Particles.of("rlv_fluid_particles", self.handle)

    def add_particles(self, particles: Any) -> None:
        """Adds particles, such as those of a file, with what they carry."""
        library.call("rlv_fluid_add_particles", self.handle, held(particles, "particles"))

    def isosurface(self, **options: Any) -> Isosurface:
        """The surface of the particles where they are now; options are the fields of `abi.RlvIsosurfaceOptions`, of which the
        radius is half the spacing if none is given."""
        told = ctypes.byref(isosurface_options(options)) if options else None
        return Isosurface.of("rlv_fluid_isosurface", self.handle, told)
