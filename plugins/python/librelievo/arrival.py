"""Arrivals: progressive meshes whose files arrive piece by piece."""

import ctypes

from . import abi, library, record
from .handle import Handle, held
from .progressive import Progressive


class Arrival(Handle):
    """A progressive mesh of which more and more is there."""

    noun, kind = "arrival", abi.RlvArrival

    def __init__(self, context):
        super().__init__("rlv_arrival_create", held(context, "context"))

    def push(self, data):
        """Takes the next bytes, and says what is there then: triangles of the finest mesh, and whether that is all."""
        out = record.empty(abi.RlvArrivalInfo)
        data = bytes(data)
        library.call("rlv_arrival_push", self.handle, data, len(data), ctypes.byref(out))
        return record.read(out)

    @property
    def progressive(self):
        """The progressive mesh of what has arrived."""
        return Progressive.of("rlv_arrival_progressive", self.handle)
