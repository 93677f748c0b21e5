"""Failures of the library as exceptions, in parts: what went wrong, where, and what can be done about it."""

from __future__ import annotations

import ctypes
import reprlib
from typing import Any

from . import abi


class RelievoError(Exception):
    """A call failed. `str()` is one line for the user; `what`, `place` and `remedy` are its parts, `code` is a number of
    the sentence for tables of translations, and `element` the number of the `element_kind` that it is about."""

    code, element_kind, element = 0, abi.RlvElement.NONE, 0

    def __init__(
        self, message: Any, what: str = "", place: str = "", remedy: str = "", result: Any = abi.RLV_ERROR_INVALID
    ) -> None:
        super().__init__(message)
        self.what, self.place, self.remedy, self.result = what or message, place, remedy, result


class LibraryMissing(RelievoError, ImportError):
    """The shared library, or something that it needs, is not there or does not fit this system."""


class Invalid(RelievoError, ValueError):
    """An argument or data that cannot be used."""


class Unsupported(RelievoError):
    """Valid input that this build or device does not handle."""


class NotFound(RelievoError, LookupError):
    """A file, name or element that does not exist."""


class FileFailure(RelievoError, OSError):
    """The operating system refused to read or write."""


class MemoryLimit(RelievoError, MemoryError):
    """A budget or limit would be exceeded; nothing was changed."""


class Busy(RelievoError):
    """Another call is at work on the object; nothing was changed, call again later."""


class Cancelled(RelievoError):
    """The progress callback asked to stop; nothing was changed."""


class Internal(RelievoError):
    """A fault of the library."""


class DeviceFailure(RelievoError):
    """A graphics device failed or was lost; what was committed is kept."""


KINDS = {
    abi.RLV_ERROR_INVALID: Invalid,
    abi.RLV_ERROR_UNSUPPORTED: Unsupported,
    abi.RLV_ERROR_NOT_FOUND: NotFound,
    abi.RLV_ERROR_IO: FileFailure,
    abi.RLV_ERROR_MEMORY: MemoryLimit,
    abi.RLV_ERROR_BUSY: Busy,
    abi.RLV_ERROR_CANCELLED: Cancelled,
    abi.RLV_ERROR_INTERNAL: Internal,
    abi.RLV_ERROR_DEVICE: DeviceFailure,
}


def shown(value: Any) -> str:
    """A value in short, for a sentence."""
    try:
        return reprlib.repr(value)
    except ValueError:
        return "a number of thousands of digits"  # Python prints none of them.


def text(value: Any) -> str:
    """A string of the library."""
    return (value or b"").decode("utf-8", "replace")


def last(library: Any, result: Any) -> Any:
    """The last failure of this thread as an exception."""
    error = abi.RlvError(*abi.INIT[abi.RlvError])
    library.rlv_error_get(ctypes.byref(error))
    parts = [text(part) for part in (error.message, error.what, error.place, error.remedy)]
    failure = KINDS.get(result, RelievoError)(parts[0] or f"the library answered {result}", *parts[1:], result=result)
    failure.code, failure.element = error.code, error.element
    failure.element_kind = abi.RlvElement(error.element_kind)
    return failure
