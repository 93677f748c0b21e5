"""Colliders: triangle meshes that imprint themselves on details."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, parameter, record
from .array import Reading, address, matrix, number
from .handle import Handle, held
from .hint import ArrayLike
from .surface import tessellate_options

if TYPE_CHECKING:
    from .context import Context
    from .detail import Detail
    from .mesh import Mesh
    from .parameter import Parameter
    from .surface import Surface


class Collider(Handle):
    """A mesh, surface or detail that presses."""

    noun, kind = "collider", abi.RlvCollider

    def __init__(self, context: Context, mesh: Mesh, matrix_world: ArrayLike | None = None) -> None:
        """Makes a collider of a mesh."""
        place = matrix(matrix_world)
        super().__init__("rlv_collider_create_mesh", held(context, "context"), held(mesh, "mesh"), address(place))

    @classmethod
    def of_surface(cls, surface: Surface, matrix_world: ArrayLike | None = None, **options: Any) -> Collider:
        """Makes a collider of a limit surface in its present pose."""
        place = matrix(matrix_world)
        options = tessellate_options(options)
        return cls.of("rlv_collider_create_surface", held(surface, "surface"), options, address(place))

    @classmethod
    def of_detail(cls, detail: Detail, **options: Any) -> Collider:
        """Makes a collider of a detail as it was committed last."""
        return cls.of("rlv_collider_create_detail", held(detail, "detail"), tessellate_options(options))

    @property
    def info(self) -> Any:
        """Whether it is closed, counts and its matrix."""
        out = record.empty(abi.RlvColliderInfo)
        library.call("rlv_collider_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def set_transform(self, matrix_world: ArrayLike) -> None:
        """Moves the collider."""
        place = matrix(matrix_world)
        library.call("rlv_collider_set_transform", self.handle, address(place))

    def set_points(self, points: ArrayLike) -> None:
        """Deforms the collider."""
        points = Reading(points, numpy.float32, 3, "points")
        library.call("rlv_collider_set_points", self.handle, points.address, points.count, points.stride)

    def press(self, place: ArrayLike, normal: ArrayLike, force: float, **settings: Any) -> None:
        """Places a tool as a pen presses it; settings are the fields of `abi.RlvToolSettings`."""
        place = Reading([place], numpy.float64, 3, "place")
        normal = Reading([normal], numpy.float64, 3, "normal")
        settings = ctypes.byref(record.fill(abi.RlvToolSettings, settings))
        arguments = (place.address, normal.address, number(force, "force"), settings)
        library.call("rlv_collider_press", self.handle, *arguments)


def press_params() -> list[Parameter]:
    """What `abi.RlvToolSettings` has."""
    return parameter.table("rlv_collider_press_params")
