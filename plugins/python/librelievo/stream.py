"""Streams: files of Python in which documents live."""

import contextlib
import ctypes

from . import abi, record
from .error import FileFailure

# Tables whose callbacks the library may call; `close` takes them out.
_open = set()


class Stream:
    """A binary file of Python that can be read, written, sought and cut off, such as io.BytesIO. It is the caller's to
    close, once the document is released."""

    def __init__(self, file):
        self.file, self.failure = file, None
        self.table = record.empty(abi.RlvStream)
        fields = dict(abi.RlvStream._fields_)
        for name in ("read", "write", "length", "cut", "sync"):
            setattr(self.table, name, fields[name](self._answering(getattr(self, f"_{name}"))))
        self.table.close = fields["close"](lambda _user: _open.discard(self))

    @contextlib.contextmanager
    def taken(self):
        """The table for a call that takes the stream."""
        _open.add(self)
        with self.explained():
            yield ctypes.byref(self.table)

    @contextlib.contextmanager
    def explained(self):
        """Raises a failure of the stream because of what the file raised."""
        try:
            yield
        except FileFailure as failure:
            cause, self.failure = self.failure, None
            raise failure from cause

    def _answering(self, work):
        def answer(_user, *arguments):
            try:
                work(*arguments)
            except BaseException as failure:  # Nothing is to leave a callback.
                self.failure = failure
                return 1
            return 0

        return answer

    def _read(self, place, address, size):
        self.file.seek(place)
        room = memoryview((ctypes.c_uint8 * size).from_address(address.value)).cast("B")
        read = 0
        while read < size:
            count = self.file.readinto(room[read:])
            if not count:
                raise EOFError(f"the file ends at byte {place + read}")
            read += count

    def _write(self, place, address, size):
        self.file.seek(place)
        self.file.write(ctypes.string_at(address.value, size))

    def _length(self, out):
        ctypes.c_uint64.from_address(out.value).value = self.file.seek(0, 2)

    def _cut(self, length):
        self.file.truncate(length)

    def _sync(self):
        self.file.flush()
