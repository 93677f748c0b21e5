"""What particles carry: arrays by names."""

from __future__ import annotations

import ctypes
from typing import Any

import numpy

from . import abi, library, record
from .array import writing
from .handle import text_bytes
from .parameter import address_of


def read_channel(handle: Any, functions: Any, index: Any) -> tuple[Any, ...]:
    """The name and values (n, 1 to 4) of a channel by its index. Functions find a channel, tell of it and get it."""
    _find, tell, get = functions
    out = record.empty(abi.RlvAttributeInfo)
    library.call(tell, handle, index, ctypes.byref(out))
    values, place, stride = writing(None, out.value_count, numpy.float32, out.width, "values")
    library.call(get, handle, index, place, out.value_count, stride)
    return bytes(out.name).decode(), values


def find_channel(handle: Any, functions: Any, name: str) -> Any:
    """The values of a channel by its name."""
    index = ctypes.c_uint32()
    library.call(functions[0], handle, text_bytes(name, "name"), address_of(index))
    return read_channel(handle, functions, index.value)[1]
