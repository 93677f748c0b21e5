"""Bytes: what files would hold, for hosts that keep it in files of their own."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy

from . import abi, library
from .array import Reading
from .error import Invalid
from .handle import Handle
from .parameter import address_of


class Bytes(Handle):
    """Bytes that the library made."""

    noun, kind = "bytes", abi.RlvBytes

    def copy(self) -> bytes:
        """The bytes as Python's own."""
        data, size = abi.c_uint8_p(), ctypes.c_size_t()
        library.call("rlv_bytes_get", self.handle, ctypes.byref(data), address_of(size))
        return ctypes.string_at(data.value, size.value)


def made(function: str, *arguments: Any) -> Any:
    """The bytes that a function makes whose last argument receives them."""
    with Bytes.of(function, *arguments) as held:
        return held.copy()


def given(data: Any, name: str = "data") -> tuple[Any, ...]:
    """Address and size of bytes, and what keeps them there."""
    try:
        array = numpy.frombuffer(data, numpy.uint8)
    except (TypeError, ValueError):
        raise Invalid(f"{name}: bytes are needed, not {type(data).__name__}") from None
    reading = Reading(array, numpy.uint8, 0, name)
    return reading.address, reading.count, reading
