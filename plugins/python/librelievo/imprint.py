"""Imprints of colliders on details."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, parameter, record
from .array import Reading, address, matrix, packed, tupled
from .error import Invalid
from .handle import held
from .hint import Progress, Settings
from .progress import watched

if TYPE_CHECKING:
    from .collider import Collider
    from .detail import Detail
    from .parameter import Parameter


def params() -> list[Parameter]:
    """What `abi.RlvImprintSettings` has."""
    return parameter.table("rlv_imprint_params")


def settings_of(settings: Any) -> Any:
    """`abi.RlvImprintSettings` from a dictionary, or None."""
    return ctypes.byref(record.fill(abi.RlvImprintSettings, settings))


def moment_of(moment: Any) -> Any:
    """`abi.RlvImprintMoment` from a dictionary of pair, frame and step, or None."""
    return ctypes.byref(record.fill(abi.RlvImprintMoment, moment))


def run(detail: Detail, collider: Collider, settings: Settings | None = None, moment: Settings | None = None) -> Any:
    """Presses the collider into the detail where both are. Returns what it did; commit to see it."""
    report = record.empty(abi.RlvImprintReport)
    arguments = (settings_of(settings), moment_of(moment), ctypes.byref(report))
    library.call("rlv_imprint_run", held(detail, "detail"), held(collider, "collider"), *arguments)
    return record.read(report)


def sweep(
    detail: Detail,
    collider: Collider,
    before: Any,
    after: Any,
    settings: Settings | None = None,
    moment: Settings | None = None,
    progress: Progress | None = None,
) -> Any:
    """Moves the collider from one place to another, matrices of 4 by 4, and presses it in at sub-steps."""
    report = record.empty(abi.RlvImprintReport)
    before, after = matrix(before), matrix(after)
    options = (address(before), address(after), settings_of(settings), moment_of(moment))
    with watched(progress) as callback:
        arguments = (*options, callback, None, ctypes.byref(report))
        library.call("rlv_imprint_sweep", held(detail, "detail"), held(collider, "collider"), *arguments)
    return record.read(report)


class Deforming:
    """Where a collider that deforms is before and after: pairs of a matrix and all of its points."""

    def __init__(self, before: Any, after: Any) -> None:
        before, before_points = tupled(before, 2, "before")
        after, after_points = tupled(after, 2, "after")
        self._matrices = matrix(before), matrix(after)
        self._points = [
            Reading(packed(points, numpy.float32, "points"), numpy.float32, 3, "points")
            for points in (before_points, after_points)
        ]
        first, last = self._points
        if first.count != last.count:
            raise Invalid(f"points: there are {first.count} before and {last.count} after")

    def arguments(self) -> tuple[Any, ...]:
        """What calls of the library take, valid as long as this lives."""
        first, last = self._points
        return (*map(address, self._matrices), first.address, last.address, first.count, 0)


def sweep_points(
    detail: Detail,
    collider: Collider,
    before: Any,
    after: Any,
    settings: Settings | None = None,
    moment: Settings | None = None,
    progress: Progress | None = None,
) -> Any:
    """The same for a collider that deforms: `before` and `after` are pairs of a matrix and all of its points."""
    report = record.empty(abi.RlvImprintReport)
    path = Deforming(before, after)
    options = (settings_of(settings), moment_of(moment))
    with watched(progress) as callback:
        arguments = (*path.arguments(), *options, callback, None, ctypes.byref(report))
        library.call("rlv_imprint_sweep_points", held(detail, "detail"), held(collider, "collider"), *arguments)
    return record.read(report)


def collide(
    first: Detail,
    second: Detail,
    first_settings: Settings | None = None,
    second_settings: Settings | None = None,
    moment: Settings | None = None,
) -> Any:
    """Presses two details into each other. Returns what it did to each."""
    reports = record.empty(abi.RlvImprintReport), record.empty(abi.RlvImprintReport)
    options = (settings_of(first_settings), settings_of(second_settings), moment_of(moment))
    outputs = [ctypes.byref(report) for report in reports]
    library.call("rlv_imprint_collide", held(first, "first"), held(second, "second"), *options, *outputs)
    return tuple(record.read(report) for report in reports)
