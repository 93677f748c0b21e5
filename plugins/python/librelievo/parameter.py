"""Tables of parameters, from which a host can make its panels."""

import ctypes
from dataclasses import dataclass

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


def table(function):
    """What rlv_<noun>_params describes, in order."""
    entries, count = ctypes.POINTER(abi.RlvParameter)(), ctypes.c_size_t()
    library.call(function, ctypes.byref(entries), address_of(count))
    return [_read(entries[index]) for index in range(count.value)]


def address_of(number):
    """The address of a number that a function writes."""
    return ctypes.addressof(number)


def _read(entry):
    kind = abi.RlvParameterKind(entry.kind)
    number = float if kind == abi.RlvParameterKind.F32 else int
    names = (text(entry.name), kind, text(entry.unit), text(entry.help))
    return Parameter(*names, number(entry.min), number(entry.max), number(entry.value))
