"""Strokes of brushes over details: at once, or drawn as the points come.

Points are arrays (n, 3) of places, (n, 4) with the pressure, or (n, 5) with the time too, as `abi.RlvStrokePoint` has them.
"""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import numbers
from .error import Invalid
from .handle import Handle, held
from .hint import Array, ArrayLike

if TYPE_CHECKING:
    from .brush import Brush
    from .detail import Detail

POINT_WIDTH = ctypes.sizeof(abi.RlvStrokePoint) // 8


def points_of(points: Any) -> Array:
    """The points of a stroke as rows of five doubles: full pressure and no time where none is given."""
    given = numbers(points, "points", numpy.float64)
    if given.ndim == 1:
        given = given.reshape(1, -1)
    if given.ndim != 2 or not 3 <= given.shape[1] <= POINT_WIDTH:
        raise Invalid(f"points: the shape (n, 3), (n, 4) or (n, 5) is needed, not {given.shape}")
    rows = numpy.empty((len(given), POINT_WIDTH))
    rows[:] = (0, 0, 0, 1, -1)
    rows[:, : given.shape[1]] = given
    return rows


def call(function: str, handle: Any, points: Any, *before: Any) -> Any:
    """Calls a function that takes points and reports."""
    rows = points_of(points)
    report = record.empty(abi.RlvStrokeReport)
    place = ctypes.cast(rows.__array_interface__["data"][0], ctypes.POINTER(abi.RlvStrokePoint))
    library.call(function, handle, *before, place, len(rows), 0, ctypes.byref(report))
    return record.read(report)


def run(detail: Detail, brush: Brush, points: ArrayLike) -> Any:
    """Makes a whole stroke and returns what it did; commit to see it."""
    return call("rlv_stroke_run", held(detail, "detail"), points, held(brush, "brush"))


class Stroke(Handle):
    """A stroke that is drawn."""

    noun, kind = "stroke", abi.RlvStroke

    def __init__(self, detail: Detail, brush: Brush) -> None:
        super().__init__("rlv_stroke_begin", held(detail, "detail"), held(brush, "brush"))

    def extend(self, points: ArrayLike) -> Any:
        """Goes on to the points and makes the dabs on the way."""
        return call("rlv_stroke_extend", self.handle, points)

    def end(self) -> Any:
        """Makes what dabs are left and ends the stroke."""
        report = record.empty(abi.RlvStrokeReport)
        library.call("rlv_stroke_end", self.handle, ctypes.byref(report))
        return record.read(report)
