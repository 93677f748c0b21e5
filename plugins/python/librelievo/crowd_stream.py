"""Crowds whose clusters are read from files while they are drawn, within a budget of memory."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import address, integer, list_of
from .crowd import Crowd, CrowdModel
from .handle import held, path_bytes
from .hint import Array

if TYPE_CHECKING:
    from .context import Context

READ = numpy.dtype(abi.RlvCrowdStreamCluster)


class CrowdStream(Crowd):
    """A crowd whose cuts read clusters of files (.rcrowd), and draw coarser ones where some are not in memory."""

    def __init__(self, context: Context, paths: Any, **settings: Any) -> None:
        """Opens crowd models and makes a crowd of them, without agents; see `abi.RlvCrowdStreamSettings`."""
        names = [path_bytes(path, "paths") for path in list_of(paths, "paths")]
        files = (abi.RlvCrowdStreamFile * len(names))(*((name,) for name in names))
        given = record.fill(abi.RlvCrowdStreamSettings, settings)
        opened = held(context, "context"), files, len(names), ctypes.byref(given)
        super(Crowd, self).__init__("rlv_crowd_stream_open", *opened)

    def model(self, model: int) -> CrowdModel:
        """A model, for its vertices, clips, materials and clusters. It has no triangles."""
        return CrowdModel.of("rlv_crowd_stream_model", self.handle, integer(model, "model"))

    @property
    def info(self) -> Any:
        """Slots, and what the last cut read; see `abi.RlvCrowdStreamInfo`."""
        out = record.empty(abi.RlvCrowdStreamInfo)
        library.call("rlv_crowd_stream_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def read(self) -> Any:
        """An array of `abi.RlvCrowdStreamCluster`: the clusters that the last cut has read, or opening has."""
        clusters = numpy.zeros(self.info.read, READ)
        place = clusters.ctypes.data_as(ctypes.POINTER(abi.RlvCrowdStreamCluster))
        library.call("rlv_crowd_stream_get_read", self.handle, place, len(clusters), 0)
        return clusters

    def triangles(self, slot: int, count: int) -> tuple[Array, Array]:
        """The vertices (count, 3) and the materials (count) of the triangles of a slot, which has so many."""
        count = integer(count, "count")
        triangles, materials = numpy.empty((count, 3), numpy.uint32), numpy.empty(count, numpy.uint32)
        places = address(triangles), address(materials)
        library.call("rlv_crowd_stream_get_triangles", self.handle, integer(slot, "slot"), *places, count)
        return triangles, materials
