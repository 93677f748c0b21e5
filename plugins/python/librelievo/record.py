"""Structs of the C ABI, filled from keywords and read as named tuples."""

from __future__ import annotations

import ctypes
from collections import namedtuple
from collections.abc import Mapping
from enum import IntEnum
from typing import Any

from . import abi
from .error import Invalid

_HIDDEN = ("struct_size", "reserved")
_tuples = {}


def fill(struct: Any, values: Any, **enums: Any) -> Any:
    """A struct with its initial values, some replaced by `values`, whose keys are its fields. A field that `enums`
    knows may be given by the name of its value in small letters."""
    made = struct(*_initial(struct))
    if values is not None and not isinstance(values, Mapping):
        raise Invalid(f"a dictionary of {struct.__name__.removeprefix('Rlv')} is needed, not {type(values).__name__}")
    names = {name for name, _ in struct._fields_ if name not in _HIDDEN}
    for name, value in (values or {}).items():
        if name not in names:
            raise Invalid(f"{name}: unknown; there are {', '.join(sorted(names))}")
        if isinstance(value, str) and name in enums:
            value = named(enums[name], value, name)
        try:
            field = getattr(made, name)
            if isinstance(field, ctypes.Array):
                field[:] = list(value)
            elif isinstance(value, (bool, IntEnum)):
                setattr(made, name, int(value))
            else:
                if isinstance(field, int) and isinstance(value, int) and value < 0:
                    raise ValueError(f"{value} is below 0")
                setattr(made, name, value)
        except (TypeError, ValueError) as problem:
            raise Invalid(f"{name}: {problem}") from None
    return made


def named(enum: Any, name: str, place: str) -> int:
    """The value of an enum that has the name, in small letters, or is the value."""
    if isinstance(name, int):
        return int(name)
    try:
        return int(enum[name.upper()])
    except (KeyError, AttributeError):
        known = ", ".join(entry.name.lower() for entry in enum)
        raise Invalid(f"{place}: `{name}` is unknown; there are {known}") from None


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
