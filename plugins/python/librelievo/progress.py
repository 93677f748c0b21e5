"""Progress of long calls. `progress(fraction, stage)` is called on the thread that made the call; it cancels by
returning False. An exception in it cancels too, and comes out of the call."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import Any

from . import abi
from .error import Cancelled, Invalid, text


class Callback:
    """A Python function as the library calls it; keeps the exception that it raised."""

    def __init__(self, kind: Any, function: str) -> None:
        self.failure = None
        self.function = kind(function) if function else kind()

    def answer(self, call: Any, *arguments: Any) -> Any:
        """The answer to the library after `call`."""
        try:
            going_on = call(*arguments)
        except BaseException as failure:  # Also an interrupt from the keyboard ends the call.
            self.failure = failure
            return abi.RlvProgressAnswer.CANCEL.value
        return (abi.RlvProgressAnswer.CANCEL if going_on is False else abi.RlvProgressAnswer.CONTINUE).value


def function_of(value: Any, name: str) -> Any:
    """A function, or None; Invalid where the value cannot be called."""
    if value is not None and not callable(value):
        raise Invalid(f"{name}: a function is needed, not {type(value).__name__}")
    return value


@contextlib.contextmanager
def watched(progress: Any) -> Iterator[Any]:
    """The callback for a call, NULL for None; raises what `progress` raised."""
    function_of(progress, "progress")
    callback = Callback(abi.RlvProgress, None)
    if progress is not None:
        callback.function = abi.RlvProgress(lambda _user, fraction, stage: callback.answer(progress, fraction, text(stage)))
    with raising(callback):
        yield callback.function


@contextlib.contextmanager
def raising(callback: Any) -> Iterator[Any]:
    """Raises what a callback raised in place of the cancel that it led to."""
    try:
        yield
    except Cancelled:
        if callback.failure is not None:
            raise callback.failure from None
        raise
