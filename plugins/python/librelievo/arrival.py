"""Arrivals: progressive meshes whose files arrive piece by piece."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

from . import abi, library, record
from .bytes import given
from .handle import Handle, held
from .progressive import Progressive

if TYPE_CHECKING:
    from .context import Context


class Arrival(Handle):
    """A progressive mesh of which more and more is there."""

    noun, kind = "arrival", abi.RlvArrival

    def __init__(self, context: Context) -> None:
        super().__init__("rlv_arrival_create", held(context, "context"))

    def push(self, data: bytes | bytearray | memoryview) -> Any:
        """Takes the next bytes, and says what is there then: triangles of the finest mesh, and whether that is all."""
        out = record.empty(abi.RlvArrivalInfo)
        address, size, _kept = given(data)
        library.call("rlv_arrival_push", self.handle, address, size, ctypes.byref(out))
        return record.read(out)

    @property
    def progressive(self) -> Progressive:
        """The progressive mesh of what has arrived."""
        return Progressive.of("rlv_arrival_progressive", self.handle)
