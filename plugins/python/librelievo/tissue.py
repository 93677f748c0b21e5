"""Finite-element models of soft tissue, and their simulation."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, chosen, integer, list_of, mapped, number, numbers, packed, tupled, writing
from .error import Invalid
from .bytes import given, made
from .handle import Handle, held, path_bytes, text_bytes
from .hint import Array, ArrayLike, FilePath, Progress
from .mesh import Mesh
from .parameter import address_of
from .progress import watched

if TYPE_CHECKING:
    from .context import Context
    from .grid import Grid

# What `TissueSimulation.get` knows: the fields of `abi.RlvTissueArrays`, whether they are of nodes, and numbers of each.
FIELDS = {
    "positions": (True, 3),
    "velocities": (True, 3),
    "stresses": (False, 6),
    "principal_stresses": (False, 3),
    "von_mises": (False, 0),
    "volumes": (False, 0),
    "fibre_stretches": (False, 0),
    "strains": (False, 6),
    "principal_strains": (False, 3),
    "contact_pressures": (True, 0),
}
AXES = {"x": 1, "y": 2, "z": 4}


def axes_of(axes: Any) -> Any:
    """The bits of axes: a number, or letters such as `xz`."""
    if isinstance(axes, str):
        unknown = set(axes) - AXES.keys()
        if unknown or not axes:
            raise Invalid(f"axes: `{axes}` is not made of x, y and z")
        return sum(AXES[letter] for letter in set(axes))
    return integer(axes, "axes", 7)


def _rows(rows: Any, place: str) -> list[Mapping[str, Any]]:
    """A list of dictionaries."""
    return [mapped(row, place) for row in list_of(rows, place)]


def _entries(struct: Any, rows: Any, place: str, **enums: Any) -> tuple[Any, ...]:
    """An array of structs of dictionaries of their fields; texts become bytes and meshes handles."""
    rows = _rows(rows, place)
    made = (struct * len(rows))()
    kept = []
    for at, row in enumerate(rows):
        values = {}
        for name, value in row.items():
            if isinstance(value, Handle):
                value = value.handle
            elif isinstance(value, str) and name not in enums:
                value = text_bytes(value, name)
                kept.append(value)
            values[name] = value
        made[at] = record.fill(struct, values, **enums)
    return made, kept


def _set(struct: Any, name: str, entries: Any) -> None:
    setattr(struct, f"{name}s", entries)
    setattr(struct, f"{name}_count", len(entries))


class _Materials:
    """Materials, which volumes, layers and labels name."""

    def __init__(self, materials: Any) -> None:
        materials = _rows(materials, "materials")
        self.names = [material.get("name") for material in materials]
        self.entries, self.kept = _entries(abi.RlvTissueMaterial, materials, "materials")

    def index(self, row: Any) -> Any:
        """The fields of what has a material, with its index."""
        material = row.get("material", 0)
        if isinstance(material, str):
            if material not in self.names:
                raise Invalid(f"there is no material `{material}`; there are {', '.join(map(str, self.names))}")
            material = self.names.index(material)
        return {**row, "material": material}


def description_of(
    cell: Any,
    materials: Any,
    volumes: Any,
    surfaces: Any = (),
    skin: Any = None,
    layers: Any = (),
    epidermis: Any = None,
    bend: Any = None,
    **options: Any,
) -> tuple[Any, ...]:
    """`abi.RlvTissueDescription`, and what keeps its arrays; see `Tissue`."""
    known = _Materials(materials)
    rows, kept, places = [], [known], []
    for volume in map(known.index, _rows(volumes, "volumes")):
        rings = volume.pop("rings", None)
        if rings is not None:
            rings = numbers(rings, "rings", numpy.float64)
            if rings.ndim != 3 or rings.shape[2] not in (3, 4):
                raise Invalid(f"rings: the shape (rings, points, 3 or 4) is needed, not {rings.shape}")
            if rings.shape[2] == 3:
                rings = numpy.concatenate([rings, numpy.ones((*rings.shape[:2], 1))], 2)
            rings = numpy.ascontiguousarray(rings)
            volume |= {"ring_count": rings.shape[0], "ring_size": rings.shape[1]}
            kept.append(rings)
        places.append(None if rings is None else rings.ctypes.data)
        rows.append(volume)
    made = record.fill(abi.RlvTissueDescription, options)
    made.cell[:] = _edges(cell).tolist()
    volumes, texts = _entries(abi.RlvTissueVolume, rows, "volumes")
    for volume, place in zip(volumes, places):
        volume.rings = place
    surfaces, names = _entries(abi.RlvTissueSurface, surfaces, "surfaces", purpose=abi.RlvTissuePurpose)
    layers, _ = _entries(abi.RlvTissueLayer, [known.index(layer) for layer in _rows(layers, "layers")], "layers")
    _set(made, "material", known.entries)
    _set(made, "volume", volumes)
    _set(made, "surface", surfaces)
    _set(made, "layer", layers)
    if skin is not None:
        made.skin = held(skin, "skin", abi.RlvMesh)
    if epidermis is not None:
        given = known.index(mapped(epidermis, "epidermis"))
        made.epidermis_material = integer(given["material"], "material")
        made.epidermis_thickness = number(given.get("thickness"), "thickness")
    if bend is not None:
        made.bend[:] = [number(radius, "bend") for radius in tupled(bend, 2, "bend")]
    return made, (kept, volumes, texts, surfaces, names, layers)


def _edges(cell: Any) -> Array:
    """The three edges of a voxel, of one number or three."""
    edges = numbers(cell, "cell", numpy.float64)
    if edges.shape not in ((), (1,), (3,)):
        raise Invalid(f"cell: one number or three are needed, not the shape {edges.shape}")
    return numpy.broadcast_to(edges, 3)


def labels_of(materials: Any, labels: Any, block: int = 1, share: float = 0.5) -> tuple[Any, ...]:
    """`abi.RlvTissueLabels` of dictionaries with `material`, `low` and `high`, and what keeps its arrays."""
    known = _Materials(materials)
    entries, _ = _entries(abi.RlvTissueLabel, [known.index(label) for label in _rows(labels, "labels")], "labels")
    made = record.fill(abi.RlvTissueLabels, {"block": block, "share": share})
    _set(made, "material", known.entries)
    _set(made, "label", entries)
    return made, (known, entries)


def _curve(keys: Any, width: Any, name: str) -> tuple[Any, ...]:
    """Times and values of keys, pairs of a time and a value."""
    rows = [tupled(key, 2, name) for key in list_of(keys, name)]
    times = Reading(packed([row[0] for row in rows], numpy.float64, name), numpy.float64, 0, name)
    values = Reading(packed([row[1] for row in rows], numpy.float32, name), numpy.float32, width, name)
    if values.count != times.count:
        raise Invalid(f"{name}: there are {values.count} values for {times.count} times")
    return times, values


class Tissue(Handle):
    """A finite-element model of hexahedra."""

    noun, kind = "tissue", abi.RlvTissue
    report = None  # of a model that was built: what from

    def __init__(
        self, context: Context, cell: Any, materials: Any, volumes: Any, progress: Progress | None = None, **description: Any
    ) -> None:
        """Builds a model of voxels of a size in metres, one number or three. Materials, volumes, surfaces and layers are
        dictionaries of the fields of `abi.RlvTissueMaterial`, `abi.RlvTissueVolume`, `abi.RlvTissueSurface` and
        `abi.RlvTissueLayer`, with names or indices of materials, objects of Mesh, and rings as arrays (rings, points, 3 or 4).
        `skin` is a mesh and `epidermis` a dictionary of `material` and `thickness`. `bend` has two radii in metres, across and
        upwards, to which a block whose skin is the plane y = 0 is bent."""
        given, kept = description_of(cell, materials, volumes, **description)
        report = record.empty(abi.RlvTissueReport)
        with watched(progress) as callback:
            arguments = (ctypes.byref(given), callback, None, ctypes.byref(report))
            super().__init__("rlv_tissue_build", held(context, "context"), *arguments)
        self.report = record.read(report)
        del kept

    @classmethod
    def block(cls, context: Context, low: ArrayLike, cell: Any, counts: Any, **material: Any) -> Any:
        """Makes a block of equal boxes; the material has the fields of `abi.RlvTissueMaterial`."""
        (entry,), kept = _entries(abi.RlvTissueMaterial, [{"name": "material", **material}], "material")
        given = [
            Reading(packed(low, numpy.float64, "low"), numpy.float64, 0, "low"),
            Reading(packed(_edges(cell), numpy.float32, "cell"), numpy.float32, 0, "cell"),
            Reading(packed(counts, None, "counts"), numpy.uint32, 0, "counts"),
        ]
        if any(reading.count != 3 for reading in given):
            raise Invalid("low, cell and counts: three numbers each are needed")
        made = cls.of("rlv_tissue_block", held(context, "context"), *(it.address for it in given), ctypes.byref(entry))
        del kept
        return made

    @classmethod
    def scan(cls, context: Context, path: FilePath, materials: Any, labels: Any, block: int = 1, share: float = 0.5) -> Any:
        """Makes a model of a labelled scan, a file of NIfTI-1; labels are dictionaries of `material`, `low` and `high`."""
        given, kept = labels_of(materials, labels, block, share)
        made = cls.of("rlv_tissue_scan", held(context, "context"), path_bytes(path), ctypes.byref(given), None)
        del kept
        return made

    @classmethod
    def from_grid(cls, grid: Grid, materials: Any, labels: Any, block: int = 1, share: float = 0.5) -> Any:
        """Makes a model of the active voxels of a grid: a level set, fog or labels."""
        given, kept = labels_of(materials, labels, block, share)
        made = cls.of("rlv_tissue_from_grid", held(grid, "grid"), ctypes.byref(given), None)
        del kept
        return made

    @classmethod
    def read(cls, context: Context, path: FilePath) -> Tissue:
        """Reads a model, .rtissue or .inp."""
        return cls.of("rlv_tissue_read", held(context, "context"), path_bytes(path))

    def write(self, path: FilePath) -> None:
        """Writes the model, .rtissue or .inp."""
        library.call("rlv_tissue_write", self.handle, path_bytes(path))

    @classmethod
    def read_bytes(cls, context: Context, data: bytes | bytearray | memoryview) -> Tissue:
        """As `read`, from the bytes of a .rtissue."""
        address, size, _kept = given(data)
        return cls.of("rlv_tissue_read_bytes", held(context, "context"), address, size)

    def write_bytes(self) -> bytes:
        """The bytes of the .rtissue that `write` writes."""
        return made("rlv_tissue_write_bytes", self.handle)

    @property
    def info(self) -> Any:
        """Counts, sizes and the checksum; see `abi.RlvTissueInfo`."""
        out = record.empty(abi.RlvTissueInfo)
        library.call("rlv_tissue_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def nodes(self) -> Any:
        """The nodes at rest, (n, 3) in metres."""
        made, place, stride = writing(None, self.info.node_count, numpy.float32, 3, "nodes")
        library.call("rlv_tissue_get_nodes", self.handle, place, len(made), stride)
        return made

    def elements(self) -> tuple[Any, ...]:
        """The nodes of the elements, (n, 8) in VTK's order, and the material of each with the largest share."""
        count = self.info.element_count
        nodes, place, _ = writing(None, count, numpy.uint32, 8, "nodes")
        materials, main, _ = writing(None, count, numpy.uint32, 0, "materials")
        library.call("rlv_tissue_get_elements", self.handle, place, main, count)
        return nodes, materials

    def muscles(self) -> Any:
        """The muscles in order: stiffness, strength and name."""
        found = []
        for index in range(self.info.muscle_count):
            out = record.empty(abi.RlvTissueMuscle)
            library.call("rlv_tissue_muscle", self.handle, index, ctypes.byref(out))
            found.append(record.read(out))
        return found

    def find_muscle(self, name: str) -> int:
        """The index of the muscle of a name."""
        index = ctypes.c_uint32()
        library.call("rlv_tissue_find_muscle", self.handle, text_bytes(name, "name"), address_of(index))
        return index.value

    def set(self, name: str) -> Any:
        """The nodes of the set of a name."""
        index = ctypes.c_uint32()
        library.call("rlv_tissue_find_set", self.handle, text_bytes(name, "name"), address_of(index))
        out = record.empty(abi.RlvTissueSet)
        library.call("rlv_tissue_set", self.handle, index.value, ctypes.byref(out))
        made, place, _ = writing(None, out.count, numpy.uint32, 0, "nodes")
        library.call("rlv_tissue_get_set", self.handle, index.value, place, out.count)
        return made

    def add_set(self, name: str, low: ArrayLike, high: ArrayLike) -> Any:
        """Adds a set of the nodes within a box, and returns its nodes."""
        corners = [packed(low, numpy.float64, "low"), packed(high, numpy.float64, "high")]
        if any(corner.shape != (3,) for corner in corners):
            raise Invalid("low and high: three numbers each are needed")
        index = ctypes.c_uint32()
        places = [corner.ctypes.data for corner in corners]
        library.call("rlv_tissue_add_set", self.handle, text_bytes(name, "name"), *places, address_of(index))
        return self.set(name)

    def hold(self, nodes: Any, axes: str = "xyz") -> None:
        """Holds nodes along axes."""
        nodes = Reading(nodes, numpy.uint32, 0, "nodes")
        library.call("rlv_tissue_hold", self.handle, nodes.address, nodes.count, nodes.stride, axes_of(axes))

    def bind(self, name: str, mesh: Mesh | None) -> int:
        """Binds a mesh to the elements, and returns its index."""
        index = ctypes.c_uint32()
        library.call("rlv_tissue_bind", self.handle, held(mesh, "mesh"), text_bytes(name, "name"), address_of(index))
        return index.value

    def simulate(self, **options: Any) -> TissueSimulation:
        """Makes a simulation at rest; options are the fields of `abi.RlvTissueOptions`."""
        given = record.fill(abi.RlvTissueOptions, options)
        return TissueSimulation.of("rlv_tissue_simulate", self.handle, ctypes.byref(given))._of(self)


class TissueSimulation(Handle):
    """A model in motion."""

    noun, kind = "tissue_simulation", abi.RlvTissueSimulation

    def _of(self, tissue: Any) -> TissueSimulation:
        info = tissue.info
        self._counts = {True: info.node_count, False: info.element_count}
        return self

    @property
    def info(self) -> Any:
        """The step and the time; see `abi.RlvTissueSimulationInfo`."""
        out = record.empty(abi.RlvTissueSimulationInfo)
        library.call("rlv_tissue_simulation_info", self.handle, ctypes.byref(out))
        return record.read(out)

    @property
    def energies(self) -> Any:
        """Kinetic, elastic and potential energy in J."""
        out = record.empty(abi.RlvTissueEnergies)
        library.call("rlv_tissue_simulation_energies", self.handle, ctypes.byref(out))
        return record.read(out)

    def activate(self, muscle: Any, keys: Any) -> None:
        """Sets the activation of a muscle by pairs of time and activation, 0 to 1."""
        times, values = _curve(keys, 0, "keys")
        given = (times.address, values.address, times.count)
        library.call("rlv_tissue_simulation_activate", self.handle, muscle, *given)

    def drive(self, nodes: Any, keys: Any = (), axes: str = "xyz") -> None:
        """Moves nodes along axes by pairs of time and displacement; without keys they stay where they are."""
        nodes = Reading(packed(nodes, None, "nodes"), numpy.uint32, 0, "nodes")
        times, values = _curve(keys, 3, "keys")
        given = (nodes.address, nodes.count, axes_of(axes), times.address, values.address, times.count)
        library.call("rlv_tissue_simulation_drive", self.handle, *given)

    def load(self, forces: Any) -> None:
        """Sets the forces on all nodes, (n, 3) in N."""
        forces = Reading(forces, numpy.float32, 3, "forces")
        library.call("rlv_tissue_simulation_load", self.handle, forces.address, forces.count, forces.stride)

    def press(self, nodes: Any, keys: Any) -> None:
        """Presses on the outer faces of which all nodes are among some, by pairs of time and pressure in Pa."""
        nodes = Reading(packed(nodes, None, "nodes"), numpy.uint32, 0, "nodes")
        times, values = _curve(keys, 0, "keys")
        given = (nodes.address, nodes.count, times.address, values.address, times.count)
        library.call("rlv_tissue_simulation_press", self.handle, *given)

    def add_collider(
        self, mesh: Mesh | None = None, radius: float | None = None, friction: float = 0.0, keys: Any = ()
    ) -> None:
        """Adds a body that nodes do not enter: a closed mesh, a ball of a radius, or a floor. Keys are triples of time,
        translation and rotation vector."""
        body = "mesh" if mesh is not None else "floor" if radius is None else "ball"
        rows = [list_of(key, "keys") for key in list_of(keys, "keys")]
        if any(len(row) not in (2, 3) for row in rows):
            raise Invalid("keys: a time, a translation and perhaps a rotation vector are needed")
        radius = 0.0 if radius is None else number(radius, "radius")
        given = {"body": body, "radius": radius, "friction": friction, "key_count": len(rows)}
        made = record.fill(abi.RlvTissueCollider, given, body=abi.RlvTissueBody)
        times, places = _curve([row[:2] for row in rows], 3, "keys")
        _, turns = _curve([(row[0], row[2] if len(row) > 2 else (0, 0, 0)) for row in rows], 3, "keys")
        made.times, made.translations, made.rotations = times.address, places.address, turns.address
        if mesh is not None:
            made.mesh = held(mesh, "mesh", abi.RlvMesh)
        library.call("rlv_tissue_simulation_add_collider", self.handle, ctypes.byref(made))

    def step(self, count: int = 1) -> None:
        """Takes steps."""
        library.call("rlv_tissue_simulation_step", self.handle, count)

    def advance(self, seconds: float, progress: Progress | None = None) -> None:
        """Takes steps that end at or just after so many seconds more."""
        with watched(progress) as callback:
            library.call("rlv_tissue_simulation_advance", self.handle, seconds, callback, None)

    def relax(self, tolerance: float = 1e-3, steps: int = 20_000, progress: Progress | None = None) -> Any:
        """Goes to rest; returns whether it is, and what forces are left."""
        out = record.empty(abi.RlvTissueRelaxation)
        with watched(progress) as callback:
            given = (tolerance, steps, callback, None, ctypes.byref(out))
            library.call("rlv_tissue_simulation_relax", self.handle, *given)
        return record.read(out)

    def get(self, *names: str, **into: Any) -> dict[str, Array]:
        """What nodes and elements have, by names of arrays of `abi.RlvTissueArrays`: a dictionary. Arrays that are given by
        name are written to."""
        wanted = {name: None for name in names if chosen(FIELDS, name, "names")} | into
        arrays, found = record.empty(abi.RlvTissueArrays), {}
        arrays.node_count, arrays.element_count = self._counts[True], self._counts[False]
        for name, out in wanted.items():
            is_node, width = chosen(FIELDS, name, "names")
            count = self._counts[is_node]
            found[name], place, stride = writing(out, count, numpy.float32, width, name)
            if stride not in (0, 4 * max(width, 1)):
                raise Invalid(f"{name}: a packed array is needed")
            setattr(arrays, name, place)
        library.call("rlv_tissue_simulation_get", self.handle, ctypes.byref(arrays))
        return found

    def mesh(self, index: int = 0) -> Mesh:
        """A bound surface in the present state, with its velocity."""
        return Mesh.of("rlv_tissue_simulation_mesh", self.handle, index)

    def bound_points(self, index: int, out: Array) -> Any:
        """Writes the points of a bound surface into an array (n, 3) of floats, and returns it."""
        if not isinstance(out, numpy.ndarray) or not out.ndim:
            raise Invalid("out: an array of float32 of the shape (n, 3) is needed")
        found, place, stride = writing(out, len(out), numpy.float32, 3, "out")
        library.call("rlv_tissue_simulation_get_bound", self.handle, index, place, len(out), stride)
        return found

    def save(self, path: FilePath) -> None:
        """Writes the state, .rtstate."""
        library.call("rlv_tissue_simulation_save", self.handle, path_bytes(path))

    def restore(self, path: FilePath) -> None:
        """Goes on from such a file of the same model."""
        library.call("rlv_tissue_simulation_restore", self.handle, path_bytes(path))

    def save_bytes(self) -> bytes:
        """The bytes of the file that `save` writes."""
        return made("rlv_tissue_simulation_save_bytes", self.handle)

    def restore_bytes(self, data: bytes | bytearray | memoryview) -> None:
        """As `restore`, from the bytes of a file."""
        address, size, _kept = given(data)
        library.call("rlv_tissue_simulation_restore_bytes", self.handle, address, size)

    def write_vtu(self, path: FilePath) -> None:
        """Writes the state for VTK."""
        library.call("rlv_tissue_simulation_write_vtu", self.handle, path_bytes(path))

    def write_vdb(self, path: FilePath) -> None:
        """Writes grids of materials, stresses and volumes for OpenVDB."""
        library.call("rlv_tissue_simulation_write_vdb", self.handle, path_bytes(path))
