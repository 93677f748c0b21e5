"""Evaluation of surfaces and details at arrays of places."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy

from . import abi, library, record
from .array import Reading, chosen, list_of, mapped, writing
from .error import Invalid

# What can be wanted: its field of `abi.RlvEvaluateArrays`, that of its stride, and its numbers a place.
OUTPUTS = {
    "positions": ("position_stride", 3),
    "normals": ("normal_stride", 3),
    "du": ("du_stride", 3),
    "dv": ("dv_stride", 3),
    "duu": ("duu_stride", 3),
    "duv": ("duv_stride", 3),
    "dvv": ("dvv_stride", 3),
    "displacements": ("displacement_stride", 0),
    "colors": ("color_stride", 4),
    "vectors": ("vector_stride", 3),
    "traces": ("trace_stride", 3),
}


def evaluate(function: str, handle: Any, tiles: Any, uvs: Any, wanted: Any, footprints: Any = None, out: Any = None) -> Any:
    """What is wanted at the places (tile, u, v): a dictionary of arrays, those of `out` where it has them."""
    arrays = record.empty(abi.RlvEvaluateArrays)
    tiles = Reading(tiles, numpy.uint32, 0, "tiles")
    uvs = Reading(uvs, numpy.float32, 2, "uvs")
    if tiles.count != uvs.count:
        raise Invalid(f"uvs: there are {uvs.count} for {tiles.count} tiles")
    arrays.count = tiles.count
    arrays.tiles, arrays.tile_stride = tiles.address, tiles.stride
    arrays.uvs, arrays.uv_stride = uvs.address, uvs.stride
    steps = Reading(footprints, numpy.float32, 4, "footprints")
    if footprints is not None and steps.count != tiles.count:
        raise Invalid(f"footprints: there are {steps.count} for {tiles.count} places")
    arrays.footprints, arrays.footprint_stride = steps.address, steps.stride
    results, given = {}, mapped(out, "out")
    for name in list_of(wanted, "wanted", OUTPUTS):
        stride_field, width = chosen(OUTPUTS, name, "wanted")
        result, place, stride = writing(given.get(name), tiles.count, numpy.float32, width, name)
        setattr(arrays, name, place)
        setattr(arrays, stride_field, stride)
        results[name] = result
    library.call(function, handle, ctypes.byref(arrays))
    return results
