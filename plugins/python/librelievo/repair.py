"""Checks and repairs of meshes as users import them."""

from __future__ import annotations

import ctypes
from collections import namedtuple
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from . import abi, library, parameter, record
from .array import list_of
from .error import Invalid
from .handle import held, path_bytes
from .hint import ArrayLike, FilePath, Progress
from .mesh import Mesh, arrays_of, attribute_arrays
from .progress import watched

if TYPE_CHECKING:
    from .context import Context
    from .parameter import Parameter

Finding = namedtuple("Finding", ["count", "first"])
_NONE = 0xFFFFFFFF


def params() -> list[Parameter]:
    """The fields of `abi.RlvRepairSettings`."""
    return parameter.table("rlv_repair_params")


def settings_of(settings: Any) -> Any:
    """`abi.RlvRepairSettings` from a dictionary, or None."""
    return ctypes.byref(record.fill(abi.RlvRepairSettings, settings))


def report_of(report: Any) -> Any:
    """`abi.RlvRepairReport` as a named tuple whose findings have a count and the first elements: numbers of points or faces,
    or pairs of the points of edges."""
    made = record.read(report)
    fields = {name: _finding(value) for name, value in made._asdict().items() if hasattr(value, "first")}
    return made._replace(**fields)


def _finding(value: Any) -> Any:
    pairs = zip(value.first[::2], value.first[1::2])
    return Finding(value.count, [a if b == _NONE else (a, b) for a, b in pairs if a != _NONE])


def check(mesh: Mesh, progress: Progress | None = None, **settings: Any) -> Any:
    """Reports holes, non-manifold, misoriented, degenerate and doubled elements; see `abi.RlvRepairReport`."""
    report = record.empty(abi.RlvRepairReport)
    with watched(progress) as callback:
        library.call("rlv_repair_check", held(mesh, "mesh"), settings_of(settings), callback, None, ctypes.byref(report))
    return report_of(report)


def mesh(mesh: Mesh, progress: Progress | None = None, **settings: Any) -> Any:
    """Makes a repaired mesh of a mesh. Returns it and the report."""
    return _made("rlv_repair_mesh", progress, settings, held(mesh, "mesh"))


def read(context: Context, path: FilePath, progress: Progress | None = None, **settings: Any) -> Any:
    """Makes a repaired mesh of a file, also of one that `Mesh.read` refuses. Returns it and the report."""
    return _made("rlv_repair_read", progress, settings, held(context, "context"), path_bytes(path))


def arrays(
    context: Context,
    points: ArrayLike,
    corners: ArrayLike,
    face_sizes: ArrayLike,
    attributes: Iterable[Any] = (),
    progress: Progress | None = None,
    **settings: Any,
) -> Any:
    """Makes a repaired mesh of arrays as `Mesh` takes them, also of arrays that it refuses. Returns it and the report.

    `attributes` are tuples as `Mesh.add_attribute` takes them: name, values, domain, and indices or nothing."""
    given, kept = arrays_of(points, corners, face_sizes)
    structs, values = _attributes(attributes)
    told = (held(context, "context"), ctypes.byref(given), structs, len(structs))
    made = _made("rlv_repair_arrays", progress, settings, *told)
    del kept, values
    return made


def _made(function: str, progress: Any, settings: Any, *arguments: Any) -> tuple[Any, ...]:
    report = record.empty(abi.RlvRepairReport)
    with watched(progress) as callback:
        made = Mesh.of(function, *arguments, settings_of(settings), callback, None, ctypes.byref(report))
    return made, report_of(report)


def _attributes(attributes: Any) -> tuple[Any, ...]:
    """An array of `abi.RlvAttributeArrays`, and the arrays that they point to."""
    made = []
    for attribute in list_of(attributes, "attributes"):
        parts = list_of(attribute, "attributes")
        if len(parts) not in (3, 4):
            raise Invalid(f"attributes: a name, values, a domain and perhaps indices are needed, not {len(parts)} values")
        made.append(attribute_arrays(*parts))
    return (abi.RlvAttributeArrays * len(made))(*(arrays for arrays, _ in made)), made
