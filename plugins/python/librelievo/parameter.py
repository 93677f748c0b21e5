"""Tables of parameters, from which a host can make its panels."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any

from . import abi, library
from .error import text


@dataclass(frozen=True)
class Parameter:
    """One field of a settings struct."""

    name: str
    kind: abi.RlvParameterKind
    unit: str
    help: str
    min: float
    max: float
    value: float


def table(function: str) -> list[Parameter]:
    """Reads the table of parameters that a function of the library describes, in order."""
    entries, count = ctypes.POINTER(abi.RlvParameter)(), ctypes.c_size_t()
    library.call(function, ctypes.byref(entries), address_of(count))
    return [_read(entries[index]) for index in range(count.value)]


def address_of(number: Any) -> int:
    """The address of a number that a function writes."""
    return ctypes.addressof(number)


def _read(entry: Any) -> Parameter:
    kind = abi.RlvParameterKind(entry.kind)
    number = float if kind == abi.RlvParameterKind.F32 else int
    names = (text(entry.name), kind, text(entry.unit), text(entry.help))
    return Parameter(*names, number(entry.min), number(entry.max), number(entry.value))
