"""Documents, in which the edits of a detail are kept: undo, redo, and a journal that survives a killed host."""

from __future__ import annotations

import contextlib
import ctypes
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from . import abi, library, record
from .array import number
from .bytes import given, made
from .handle import Handle, held, path_bytes, text_bytes
from .hint import FilePath, Progress
from .mesh import Mesh
from .progress import watched
from .stream import Stream

if TYPE_CHECKING:
    from .context import Context
    from .detail import Detail


class Document(Handle):
    """Follows a detail. What is done between `begin` and `end` is one edit."""

    noun, kind = "document", abi.RlvDocument
    stream = None

    def __init__(self, detail: Detail, path: FilePath | None = None, memory: int = 0, file: Any = None) -> None:
        """Follows the detail from now on; `path` is the file, which is written at once and replaces what is there, or
        `file` one of Python's, such as io.BytesIO."""
        if file is not None:
            stream = Stream(file)
            with stream.taken() as table:
                super().__init__("rlv_document_create_stream", held(detail, "detail"), table, memory)
            self.stream = stream
            return
        path = None if path is None else path_bytes(path)
        super().__init__("rlv_document_create", held(detail, "detail"), path, memory)

    @classmethod
    def open(cls, detail: Detail, path: FilePath, memory: int = 0) -> Document:
        """Opens a file and gives the detail its layers and its history."""
        return cls.of("rlv_document_open", held(detail, "detail"), path_bytes(path), memory)

    @classmethod
    def open_file(cls, detail: Detail, file: Any, memory: int = 0) -> Document:
        """As `open`, from a file of Python's, to which edits are appended."""
        stream = Stream(file)
        with stream.taken() as table:
            opened = cls.of("rlv_document_open_stream", held(detail, "detail"), table, memory)
        opened.stream = stream
        return opened

    @classmethod
    def open_bytes(cls, detail: Detail, data: bytes | bytearray | memoryview, memory: int = 0) -> Document:
        """As `open`, from bytes, which are copied."""
        address, size, _kept = given(data)
        return cls.of("rlv_document_open_bytes", held(detail, "detail"), address, size, memory)

    def _call(self, function: str, *arguments: Any) -> None:
        with contextlib.nullcontext() if self.stream is None else self.stream.explained():
            library.call(function, self.handle, *arguments)

    @property
    def info(self) -> Any:
        """Whether an edit is open, how many can be undone and made again."""
        out = record.empty(abi.RlvDocumentInfo)
        library.call("rlv_document_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def begin(self, text: str | None = None) -> None:
        """Begins an edit; the text is what the file tells of one that was never ended."""
        self._call("rlv_document_begin", text_bytes(text))

    def end(self) -> Any:
        """Ends the edit."""
        return self._changes("rlv_document_end")

    def abandon(self) -> None:
        """Takes the edit that was begun back."""
        self._call("rlv_document_abandon")

    @contextlib.contextmanager
    def edit(self, text: str | None = None) -> Iterator[Any]:
        """An edit around what is done in a `with`; an exception takes it back."""
        self.begin(text)
        try:
            yield self
        except BaseException:
            self.abandon()
            raise
        self.end()

    def undo(self) -> Any:
        """Undoes the last edit."""
        return self._changes("rlv_document_undo")

    def redo(self) -> Any:
        """Makes the edit that was undone last again."""
        return self._changes("rlv_document_redo")

    def _changes(self, function: str) -> Any:
        out = record.empty(abi.RlvDocumentChanges)
        self._call(function, ctypes.byref(out))
        return record.read(out)

    def save(self, path: FilePath) -> None:
        """Writes the detail with its history to a file and keeps edits there from now on."""
        self._call("rlv_document_save", path_bytes(path))
        self.stream = None

    def save_file(self, file: Any) -> None:
        """As `save`, to a file of Python's, whose bytes are replaced."""
        stream = Stream(file)
        with stream.taken() as table:
            library.call("rlv_document_save_stream", self.handle, table)
        self.stream = stream

    def save_bytes(self) -> bytes:
        """The bytes of the file that `save` would write; edits go on to where they went."""
        return made("rlv_document_save_bytes", self.handle)

    def sync(self) -> None:
        """Waits until all edits are on the disk."""
        self._call("rlv_document_sync")


def compact(context: Context, path: FilePath, keep: int = 0) -> None:
    """Folds the history of a file that no document has open into its layers, but for the last edits."""
    library.call("rlv_document_compact", held(context, "context"), path_bytes(path), keep)


def mesh(context: Context, path: FilePath) -> Mesh:
    """The mesh that a document was made on."""
    return Mesh.of("rlv_document_mesh", held(context, "context"), path_bytes(path))


def mesh_of_bytes(context: Context, data: bytes | bytearray | memoryview) -> Mesh:
    """The mesh that the document in bytes was made on."""
    address, size, _kept = given(data)
    return Mesh.of("rlv_document_mesh_bytes", held(context, "context"), address, size)


def transfer_arguments(path: Any, to: Any, to_path: Any, source: Any, reach: Any) -> tuple[Any, ...]:
    """What calls that transfer take after the context."""
    options = record.empty(abi.RlvTransferOptions)
    options.reach = number(reach, "reach")
    if source is not None:
        setattr(options, "from", held(source, "source", abi.RlvMesh))
    return (held(to, "to"), path_bytes(path), path_bytes(to_path, "to_path"), ctypes.byref(options))


def transfer(
    context: Context,
    path: FilePath,
    to: Mesh,
    to_path: FilePath,
    source: Mesh | None = None,
    reach: float = 0.0,
    progress: Progress | None = None,
) -> Any:
    """Takes the layers of a document to another mesh and writes them as another document."""
    report = record.empty(abi.RlvTransferReport)
    files = transfer_arguments(path, to, to_path, source, reach)
    with watched(progress) as callback:
        library.call("rlv_document_transfer", held(context, "context"), *files, callback, None, ctypes.byref(report))
    return record.read(report)
