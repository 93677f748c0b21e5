"""Streams: files of Python in which documents live."""

from __future__ import annotations

import contextlib
import ctypes
from collections.abc import Iterator
from typing import Any

from . import abi, record
from .error import FileFailure

# Tables whose callbacks the library may call; `close` takes them out.
_open = set()


class Stream:
    """A binary file of Python that can be read, written, sought and cut off, such as io.BytesIO. It is the caller's to
    close, once the document is released."""

    def __init__(self, file: Any) -> None:
        self.file, self.failure = file, None
        self.table = record.empty(abi.RlvStream)
        fields = dict(abi.RlvStream._fields_)
        for name in ("read", "write", "length", "cut", "sync"):
            setattr(self.table, name, fields[name](self._answering(getattr(self, f"_{name}"))))
        self.table.close = fields["close"](lambda _user: _open.discard(self))

    @contextlib.contextmanager
    def taken(self) -> Iterator[Any]:
        """The table for a call that takes the stream."""
        _open.add(self)
        with self.explained():
            yield ctypes.byref(self.table)

    @contextlib.contextmanager
    def explained(self) -> Iterator[Any]:
        """Raises a failure of the stream because of what the file raised."""
        try:
            yield
        except FileFailure as failure:
            cause, self.failure = self.failure, None
            raise failure from cause

    def _answering(self, work: Any) -> Any:
        def answer(_user: Any, *arguments: Any) -> Any:
            try:
                work(*arguments)
            except BaseException as failure:  # Nothing is to leave a callback.
                self.failure = failure
                return 1
            return 0

        return answer

    def _read(self, place: Any, address: Any, size: Any) -> None:
        self.file.seek(place)
        room = memoryview((ctypes.c_uint8 * size).from_address(address.value)).cast("B")
        read = 0
        while read < size:
            count = self.file.readinto(room[read:])
            if not count:
                raise EOFError(f"the file ends at byte {place + read}")
            read += count

    def _write(self, place: Any, address: Any, size: Any) -> None:
        self.file.seek(place)
        self.file.write(ctypes.string_at(address.value, size))

    def _length(self, out: Any) -> None:
        ctypes.c_uint64.from_address(out.value).value = self.file.seek(0, 2)

    def _cut(self, length: Any) -> None:
        self.file.truncate(length)

    def _sync(self) -> None:
        self.file.flush()
