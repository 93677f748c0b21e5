"""What the loaded library can do on this machine."""

from __future__ import annotations

import ctypes
from typing import Any

from . import abi, library, record
from .parameter import address_of


def capability() -> Any:
    """Versions of Embree, OpenSubdiv and OpenVDB (0 for what is missing), graphics devices, instruction level, limits."""
    out = record.empty(abi.RlvCapability)
    library.call("rlv_capability_get", ctypes.byref(out))
    return record.read(out)


def formats() -> list[Any]:
    """Formats of files: rows of content (an `abi.RlvContent`), can_read, can_write, can_write_bytes and extension."""
    count = ctypes.c_size_t()
    library.call("rlv_capability_list", None, 0, address_of(count))
    rows = (abi.RlvCapabilityFormat * (count.value + 4))()
    library.call("rlv_capability_list", rows, len(rows), address_of(count))
    return [record.read(rows[index]) for index in range(count.value)]
