"""Casting of rays against meshes and details."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, integer, number, numbers
from .error import Invalid
from .handle import Handle, held
from .hint import Array, ArrayLike
from .surface import tessellate_options

if TYPE_CHECKING:
    from .context import Context
    from .detail import Detail
    from .mesh import Mesh
    from .tessellation import Tessellation

HIT = numpy.dtype(abi.RlvHit)


class Caster(Handle):
    """A picture of geometry that rays are cast against."""

    noun, kind = "caster", abi.RlvCaster

    def __init__(self, context: Context, mesh: Mesh) -> None:
        super().__init__("rlv_caster_create_mesh", held(context, "context"), held(mesh, "mesh"))

    @classmethod
    def of_detail(cls, detail: Detail, **options: Any) -> Caster:
        """Makes a caster for a detail as it was committed last; options are the fields of `abi.RlvTessellateOptions`."""
        return cls.of("rlv_caster_create_detail", held(detail, "detail"), tessellate_options(options))

    @classmethod
    def of_tessellation(cls, tessellation: Tessellation) -> Caster:
        """Makes a caster that follows a tessellation; see `update`."""
        return cls.of("rlv_caster_create_tessellation", held(tessellation, "tessellation"))

    def update(self) -> None:
        """Goes to the last update of the tessellation."""
        library.call("rlv_caster_update", self.handle)

    def set_mask(self, mask: int) -> None:
        """Has rays that share no bit with a mask of 32 bits hit nothing of it; all bits are set at first."""
        library.call("rlv_caster_set_mask", self.handle, integer(mask, "mask"))

    def cast(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        min_distance: ArrayLike = 0.0,
        max_distance: ArrayLike = 0.0,
        masks: ArrayLike | None = None,
    ) -> Array:
        """The closest hit of every ray, an array of the fields of `abi.RlvHit`: distance, face, tile, u, v, position,
        normal. Distances and masks are one number for all rays, or one for each."""
        arrays, _kept = ray_arrays(origins, directions, min_distance, max_distance, masks)
        hits = numpy.empty(arrays.count, HIT)
        arrays.hits = ctypes.cast(hits.__array_interface__["data"][0], ctypes.POINTER(abi.RlvHit))
        library.call("rlv_caster_cast", self.handle, ctypes.byref(arrays))
        return hits

    def occluded(
        self,
        origins: ArrayLike,
        directions: ArrayLike,
        min_distance: ArrayLike = 0.0,
        max_distance: ArrayLike = 0.0,
        masks: ArrayLike | None = None,
    ) -> Array:
        """Whether each ray hits anything, as bools."""
        arrays, _kept = ray_arrays(origins, directions, min_distance, max_distance, masks)
        found = numpy.empty(arrays.count, numpy.uint8)
        library.call("rlv_caster_occluded", self.handle, ctypes.byref(arrays), found.__array_interface__["data"][0], 0)
        return found.view(bool)


def ray_arrays(
    origins: Any, directions: Any, min_distance: Any = 0.0, max_distance: Any = 0.0, masks: Any = None, times: Any = None
) -> tuple[Any, ...]:
    """`abi.RlvRayArrays` without hits, and the arrays that it points to."""
    arrays, kept = record.empty(abi.RlvRayArrays), []

    def reading(values: Any, kind: Any, width: Any, name: str) -> tuple[Any, ...]:
        kept.append(Reading(values, kind, width, name))
        if kept[-1].count != kept[0].count:
            raise Invalid(f"{name}: there are {kept[-1].count} for {kept[0].count} origins")
        return kept[-1].address, kept[-1].stride

    arrays.origins, arrays.origin_stride = reading(origins, numpy.float32, 3, "origins")
    arrays.directions, arrays.direction_stride = reading(directions, numpy.float32, 3, "directions")
    arrays.count = kept[0].count
    for name, value in (("min_distance", min_distance), ("max_distance", max_distance)):
        if numbers(value, name).ndim == 0:
            setattr(arrays, name, number(value, name))
        else:
            address, stride = reading(value, numpy.float32, 0, f"{name}s")
            setattr(arrays, f"{name}s", address)
            setattr(arrays, f"{name}_stride", stride)
    if masks is not None:
        if numbers(masks, "masks").ndim == 0:
            masks = numpy.full(arrays.count, integer(masks, "masks"), numpy.uint32)
        arrays.masks, arrays.mask_stride = reading(masks, numpy.uint32, 0, "masks")
    if times is not None:
        if numbers(times, "times").ndim == 0:
            times = numpy.full(arrays.count, number(times, "times"), numpy.float32)
        arrays.times, arrays.time_stride = reading(times, numpy.float32, 0, "times")
    return arrays, kept
