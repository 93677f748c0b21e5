"""Objects of the library. Each owns one reference, which it gives back when it is released, leaves a `with`, or is
collected. Objects keep alive what they need, so the order does not matter."""

from __future__ import annotations

import ctypes
import os
from typing import TYPE_CHECKING, Any

from . import abi, library, record
from .error import Invalid

if TYPE_CHECKING:
    from typing_extensions import Self


class Handle:
    """An object of the library. `noun` is what its functions are called after."""

    noun: str = ""
    kind: Any = None

    def __init__(self, function: Any, *arguments: Any) -> None:
        """Makes the object by a function whose last argument receives it."""
        if not isinstance(function, str) or function not in abi.FUNCTIONS:
            raise Invalid(f"{type(self).__name__}: other functions make it, not its constructor")
        self.handle = self.kind()
        library.call(function, *arguments, ctypes.byref(self.handle))

    @classmethod
    def of(cls, function: Any, *arguments: Any) -> Self:
        """The object that another function than the constructor's makes."""
        made = cls.__new__(cls)
        Handle.__init__(made, function, *arguments)
        return made

    def release(self) -> None:
        """Gives the object back; it must not be used afterwards. Does nothing the second time."""
        handle, self.handle = getattr(self, "handle", None), self.kind()
        if handle is not None and handle.id:
            library.call(f"rlv_{self.noun}_release", handle)

    def wait_idle(self, seconds: float | None = None) -> Any:
        """Waits until no call is at work on it, no longer than that: is_busy, noun, and the worker if it is busy."""
        out = record.empty(abi.RlvObjectInfo)
        library.call("rlv_object_wait", self.handle.id, -1.0 if seconds is None else seconds, ctypes.byref(out))
        return record.read(out)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: Any) -> None:
        self.release()

    def __del__(self) -> None:
        try:
            self.release()
        except Exception:  # At the end of the interpreter nothing is left to tell it to.
            pass


def held(thing: Any, name: Any, kind: Any = None) -> Any:
    """The handle of an object of the library, which an argument of that name is to be. The library checks the kind of
    handles that it takes one by one; handles for arrays and structs are of `kind`."""
    handle = getattr(thing, "handle", None)
    if handle is None:
        raise Invalid(f"{name}: an object of the library is needed, not {type(thing).__name__}")
    if kind is not None and not isinstance(handle, kind):
        needed, given = (of.__name__.removeprefix("Rlv") for of in (kind, type(handle)))
        raise Invalid(f"{name}: an object of the kind {needed} is needed, not {given}")
    return handle


def path_bytes(path: Any, name: str = "path") -> bytes:
    """A path as the library takes it: UTF-8."""
    try:
        data = os.fspath(path)
    except TypeError:
        raise Invalid(f"{name}: a text or a path is needed, not {type(path).__name__}") from None
    return encoded(data, "surrogateescape", name) if isinstance(data, str) else whole(data, name)


def whole(data: Any, name: str) -> bytes:
    """Bytes that C sees all of."""
    if b"\0" in data:
        raise Invalid(f"{name}: a NUL in it ends it for the library; leave it out")
    return data


def encoded(text: str, errors: str, name: str) -> bytes:
    """A text in UTF-8; Invalid where it has half of a surrogate pair."""
    try:
        return whole(text.encode("utf-8", errors), name)
    except UnicodeEncodeError as problem:
        raise Invalid(f"{name}: the text is not Unicode: {problem.reason}") from None


def text_bytes(text: Any, name: str = "text") -> bytes | None:
    """A text as the library takes it; None stays None."""
    if text is not None and not isinstance(text, str):
        raise Invalid(f"{name}: a text is needed, not {type(text).__name__}")
    return None if text is None else encoded(text, "strict", name)
