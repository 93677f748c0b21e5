"""Adapters: the graphics devices that a context can be given."""

from __future__ import annotations

import ctypes
from typing import Any

from . import abi, library, record
from .parameter import address_of


def adapters() -> list[Any]:
    """What there is, best first: kind, name, driver, backend and limits. A context takes one by its name."""
    count = ctypes.c_size_t()
    library.call("rlv_adapter_list", None, 0, address_of(count))
    rows = (abi.RlvAdapterInfo * (count.value + 4))()
    library.call("rlv_adapter_list", rows, len(rows), address_of(count))
    return [record.read(rows[index]) for index in range(count.value)]
