"""NumPy arrays as the C ABI takes them: an address, a count and a stride in bytes.

What is read is passed as it lies where its type fits and its numbers are packed within a value; it is converted
otherwise. What is written must fit.
"""

from __future__ import annotations

import operator
from collections.abc import Mapping
from typing import Any

import numpy

from .error import Invalid, MemoryLimit, shown
from .hint import Array

# The largest count and the largest address.
SIZE = (1 << 64) - 1


def numbers(values: Any, name: str, kind: Any = None) -> Array:
    """An array of values, of a type if one is given. Invalid where they are not numbers in rows of one length."""
    try:
        return numpy.asarray(values, kind)
    except (TypeError, ValueError, OverflowError) as problem:
        raise Invalid(f"{name}: an array of numbers is needed: {problem}") from None


def packed(values: Any, kind: Any, name: str) -> Array:
    """As `numbers`, without gaps and of one dimension at least."""
    return numpy.ascontiguousarray(numbers(values, name, kind))


def number(value: Any, name: str) -> float:
    """A float; Invalid where the value is none."""
    try:
        return float(None if isinstance(value, (str, bytes)) else value)
    except (TypeError, ValueError, OverflowError):
        raise Invalid(f"{name}: a number is needed, not {shown(value)}") from None


def integer(value: Any, name: str, most: int = 0xFFFFFFFF) -> int:
    """A whole number from 0 to `most`; Invalid where the value is none."""
    if value.__class__ is int and 0 <= value <= most:
        return value
    try:
        whole = operator.index(value)
    except TypeError:
        whole = -1
    if not 0 <= whole <= most:
        raise Invalid(f"{name}: a whole number from 0 to {most} is needed, not {shown(value)}")
    return whole


def flag(value: Any, name: str) -> int:
    """1 for true and 0 for false; Invalid where the value is neither a bool nor one of these numbers."""
    if not isinstance(value, (int, numpy.integer, numpy.bool_)) or value not in (0, 1):
        raise Invalid(f"{name}: True or False is needed, not {shown(value)}")
    return int(value)


def rest(total: int, first: Any) -> int:
    """How many entries out of a total there are from the first on."""
    return max(total - integer(first, "first"), 0)


def list_of(values: Any, name: str, table: Any = None) -> list[Any]:
    """A list of what an iterable has; Invalid where the value is a text, a mapping or no iterable. Of names it may state the
    table in which they are sought."""
    try:
        entries = None if isinstance(values, (str, bytes, Mapping)) else iter(values)
    except TypeError:
        entries = None
    if entries is None:
        kind = "a list" if table is None else f"a list of names ({', '.join(table)})"
        raise Invalid(f"{name}: {kind} is needed, not {type(values).__name__}")
    return list(entries)


def tupled(values: Any, count: int, name: str) -> list[Any]:
    """A list of so many values; Invalid where there are more or fewer."""
    entries = list_of(values, name)
    if len(entries) != count:
        raise Invalid(f"{name}: {count} values are needed, not {len(entries)}")
    return entries


def mapped(values: Any, name: str) -> Mapping[Any, Any]:
    """A mapping, empty for None; Invalid where the value is none."""
    if values is not None and not isinstance(values, Mapping):
        raise Invalid(f"{name}: a dictionary is needed, not {type(values).__name__}")
    return {} if values is None else values


def chosen(table: Any, name: Any, place: str) -> Any:
    """The entry of a table by its name; Invalid, with all names, where none has it."""
    if not isinstance(name, str) or name not in table:
        raise Invalid(f"{place}: {shown(name)} is unknown; there are {', '.join(table)}")
    return table[name]


class Reading:
    """An array that the library reads; it lives as long as this."""

    __slots__ = ("array", "address", "count", "stride")

    def __init__(self, values: Any, kind: Any, width: Any, name: str) -> None:
        """`width` is the numbers of a value, 0 for values of one number in an array of one dimension."""
        if values is None:
            self.array, self.address, self.count, self.stride = None, None, 0, 0
            return
        array = numbers(values, name)
        if array.dtype != kind:
            integers = numpy.issubdtype(kind, numpy.integer)
            if integers and array.size and not numpy.issubdtype(array.dtype, numpy.integer):
                raise Invalid(f"{name}: integers are needed, not {array.dtype}")
            if integers and array.size and (array.min() < 0 or array.max() > numpy.iinfo(kind).max):
                raise Invalid(f"{name}: numbers from 0 to {numpy.iinfo(kind).max} are needed")
            array = numbers(array, name, kind)
        if width and array.ndim == 1 and array.size % width == 0:
            array = array.reshape(-1, width)
        if array.ndim != (2 if width else 1) or (width and array.shape[1] != width):
            raise Invalid(
                f"{name}: the shape {(len(array) if array.ndim else 1, width) if width else ('n',)} is needed, not {array.shape}"
            )
        packed = not width or width == 1 or array.strides[1] == array.itemsize
        if not packed or (len(array) > 1 and array.strides[0] < array.itemsize * max(width, 1)):
            array = numpy.ascontiguousarray(array)
        self.array, self.count = array, len(array)
        self.address = array.__array_interface__["data"][0] if len(array) else None
        self.stride = array.strides[0] if len(array) > 1 else 0


def room(shape: Any, kind: Any, name: str) -> Array:
    """A new array that is not filled; MemoryLimit where it does not fit into memory."""
    try:
        return numpy.empty(shape, kind)
    except (MemoryError, ValueError):
        raise MemoryLimit(f"{name}: there is no memory for an array of the shape {shape}; ask for less") from None


def writing(out: Any, count: Any, kind: Any, width: Any, name: str) -> tuple[Array, int, int]:
    """The array that the library writes: `out`, or a new one. Returns it with its address and stride."""
    shape = (count, width) if width else (count,)
    if out is None:
        out = room(shape, kind, name)
    flat = isinstance(out, numpy.ndarray) and width and out.ndim == 1 and out.size == count * width
    if flat and out.flags.c_contiguous:
        view = out.reshape(shape)
    else:
        view = out
    if not isinstance(view, numpy.ndarray) or view.dtype != kind or view.shape != shape:
        raise Invalid(f"{name}: an array of {numpy.dtype(kind)} of the shape {shape} is needed")
    # NumPy gives empty arrays no strides.
    inner = width < 2 or not count or view.strides[1] == view.itemsize
    if not view.flags.writeable or not inner or (count > 1 and view.strides[0] < view.itemsize * max(width, 1)):
        raise Invalid(f"{name}: the array must be writable and packed within a value")
    return out, view.__array_interface__["data"][0], view.strides[0] if count > 1 else 0


def matrix(values: Any) -> Array | None:
    """An affine map as twelve doubles in columns, from a 4 by 4 or 3 by 4 matrix of rows; None stays None."""
    if values is None:
        return None
    rows = numbers(values, "matrix", numpy.float64)
    if rows.shape not in ((4, 4), (3, 4)):
        raise Invalid(f"matrix: 4 by 4 or 3 by 4 numbers are needed, not {rows.shape}")
    return numpy.ascontiguousarray(rows[:3].T)


def address(array: Any) -> int | None:
    """The address of a packed array, None for None."""
    return None if array is None else array.__array_interface__["data"][0]
