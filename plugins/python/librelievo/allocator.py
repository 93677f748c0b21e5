"""An allocator of the host for all memory of the library, given as addresses of functions in C: the library frees blocks on
threads of its own and at the end of the process, where Python cannot be called."""

from __future__ import annotations

import ctypes

from . import abi, library, record
from .error import Invalid


def set_allocator(allocate: int, free: int, user: int = 0) -> None:
    """Takes all memory from two functions of C, `abi.RlvAllocate` and `abi.RlvFree`; must come before any other call of the library."""
    if not all(isinstance(given, int) and 0 <= given < 1 << 64 for given in (allocate, free, user)):
        raise Invalid("allocator: addresses of functions of C are needed")
    given = record.empty(abi.RlvAllocator)
    given.allocate, given.free = abi.RlvAllocate(allocate), abi.RlvFree(free)
    given.user = user or None
    library.call("rlv_allocator_set", ctypes.byref(given))
