"""An allocator of the host for all memory of the library, given as addresses of functions in C: the library frees blocks on
threads of its own and at the end of the process, where Python cannot be called."""

from __future__ import annotations

import ctypes
from typing import Any

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


def allocator_info() -> Any:
    """What the library occupies, in bytes, and what it may: is_set, bytes, limit."""
    out = record.empty(abi.RlvAllocatorInfo)
    library.call("rlv_allocator_info", ctypes.byref(out))
    return record.read(out)


def set_memory_limit(size: int) -> None:
    """Bounds what the library's blocks occupy together, in bytes; 0 for no limit."""
    library.call("rlv_allocator_set_limit", size)
