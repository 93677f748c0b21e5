"""Structs of the C ABI, filled from keywords and read as named tuples."""

from __future__ import annotations

import ctypes
import operator
from collections import namedtuple
from collections.abc import Mapping
from enum import IntEnum
from typing import Any

from . import abi
from .error import Invalid, shown

_HIDDEN = ("struct_size", "reserved")
_tuples = {}


def fill(struct: Any, values: Any, **enums: Any) -> Any:
    """A struct with its initial values, some replaced by `values`, whose keys are its fields. A field that `enums`
    knows may be given by the name of its value in small letters."""
    made = struct(*_initial(struct))
    if values is not None and not isinstance(values, Mapping):
        raise Invalid(f"a dictionary of {struct.__name__.removeprefix('Rlv')} is needed, not {type(values).__name__}")
    names = {name: kind for name, kind in struct._fields_ if name not in _HIDDEN}
    for name, value in (values or {}).items():
        if name not in names:
            raise Invalid(f"{name}: unknown; there are {', '.join(sorted(names))}")
        if isinstance(value, str) and name in enums:
            value = named(enums[name], value, name)
        try:
            field = getattr(made, name)
            if isinstance(field, ctypes.Array):
                field[:] = list(value)
            elif isinstance(field, int):
                setattr(made, name, fitting(names[name], value))
            elif isinstance(value, int) and (names[name] is ctypes.c_char_p or hasattr(names[name], "target")):
                # ctypes takes a number for an address, at which there is nothing.
                raise TypeError("a number cannot be used here")
            else:
                setattr(made, name, int(value) if isinstance(value, (bool, IntEnum)) else value)
        except (TypeError, ValueError, OverflowError, RuntimeError) as problem:  # ctypes has the last for tuples.
            raise Invalid(f"{name}: {problem}") from None
    return made


def limits(kind: Any) -> tuple[int, int]:
    """The least and the largest number of a type of integers of ctypes."""
    values = 1 << 8 * ctypes.sizeof(kind)
    return (0, values - 1) if kind(-1).value > 0 else (-values // 2, values // 2 - 1)


def fitting(kind: Any, value: Any) -> int:
    """A whole number that a type of integers of ctypes holds; TypeError or ValueError where the value is none."""
    number = operator.index(value)
    if number < 0:
        raise ValueError(f"{shown(number)} is below 0")
    if number > limits(kind)[1]:
        raise ValueError(f"{shown(number)} is above {limits(kind)[1]}")
    return number


def named(enum: Any, name: str, place: str) -> int:
    """The value of an enum that has the name, in small letters, or is the value."""
    try:
        return int(enum[name.upper()]) if isinstance(name, str) else operator.index(name)
    except (KeyError, TypeError):
        known = ", ".join(entry.name.lower() for entry in enum)
        raise Invalid(f"{place}: `{name if isinstance(name, str) else shown(name)}` is unknown; there are {known}") from None


def _initial(struct: Any) -> Any:
    initial = abi.INIT.get(struct, ())
    filled = []
    for value, (_, kind) in zip(initial, struct._fields_):
        if getattr(kind, "_type_", None) is ctypes.c_char:
            value = b""
        elif isinstance(value, tuple) or value is None:
            value = kind(*(value or ()))
        filled.append(value)
    return filled


def empty(struct: Any) -> Any:
    """A struct that a function writes."""
    return struct(*_initial(struct))


def read(struct: Any) -> Any:
    """A struct as a named tuple of numbers, texts, tuples and structs of its own, without its size."""
    kind = type(struct)
    names = [name for name, _ in kind._fields_ if name not in _HIDDEN]
    if kind not in _tuples:
        _tuples[kind] = namedtuple(kind.__name__.removeprefix("Rlv"), names)
    values = []
    for name in names:
        value = getattr(struct, name)
        if isinstance(value, bytes):
            value = value.decode("utf-8", "replace")
        elif isinstance(value, ctypes.Structure):
            value = read(value)
        elif isinstance(value, ctypes.Array):
            value = tuple(value)
        values.append(value)
    return _tuples[kind](*values)
