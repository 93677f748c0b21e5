"""Casting of rays against meshes and details."""

import ctypes

import numpy

from . import abi, library, record
from .array import Reading
from .error import Invalid
from .handle import Handle
from .surface import tessellate_options

HIT = numpy.dtype(abi.RlvHit)


class Caster(Handle):
    """A picture of geometry that rays are cast against."""

    noun, kind = "caster", abi.RlvCaster

    def __init__(self, context, mesh):
        super().__init__("rlv_caster_create_mesh", context.handle, mesh.handle)

    @classmethod
    def of_detail(cls, detail, **options):
        """Makes a caster for a detail as it was committed last; options are the fields of RlvTessellateOptions."""
        return cls.of("rlv_caster_create_detail", detail.handle, tessellate_options(options))

    def cast(self, origins, directions, min_distance=0.0, max_distance=0.0):
        """The closest hit of every ray, an array of the fields of RlvHit: distance, face, tile, u, v, position,
        normal."""
        origins = Reading(origins, numpy.float32, 3, "origins")
        directions = Reading(directions, numpy.float32, 3, "directions")
        if origins.count != directions.count:
            raise Invalid(f"directions: there are {directions.count} for {origins.count} origins")
        hits = numpy.empty(origins.count, HIT)
        arrays = record.fill(abi.RlvRayArrays, {"min_distance": min_distance, "max_distance": max_distance})
        arrays.count = origins.count
        arrays.origins, arrays.origin_stride = origins.address, origins.stride
        arrays.directions, arrays.direction_stride = directions.address, directions.stride
        arrays.hits = ctypes.cast(hits.__array_interface__["data"][0], ctypes.POINTER(abi.RlvHit))
        library.call("rlv_caster_cast", self.handle, ctypes.byref(arrays))
        return hits
