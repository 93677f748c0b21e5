"""Documents, in which the edits of a detail are kept: undo, redo, and a journal that survives a killed host."""

import contextlib
import ctypes

from . import abi, library, record
from .bytes import given, made
from .handle import Handle, held, path_bytes, text_bytes
from .mesh import Mesh
from .progress import watched
from .stream import Stream


class Document(Handle):
    """Follows a detail. What is done between `begin` and `end` is one edit."""

    noun, kind = "document", abi.RlvDocument
    stream = None

    def __init__(self, detail, path=None, memory=0, file=None):
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
    def open(cls, detail, path, memory=0):
        """Opens a file and gives the detail its layers and its history."""
        return cls.of("rlv_document_open", held(detail, "detail"), path_bytes(path), memory)

    @classmethod
    def open_file(cls, detail, file, memory=0):
        """As `open`, from a file of Python's, to which edits are appended."""
        stream = Stream(file)
        with stream.taken() as table:
            opened = cls.of("rlv_document_open_stream", held(detail, "detail"), table, memory)
        opened.stream = stream
        return opened

    @classmethod
    def open_bytes(cls, detail, data, memory=0):
        """As `open`, from bytes, which are copied."""
        address, size, _kept = given(data)
        return cls.of("rlv_document_open_bytes", held(detail, "detail"), address, size, memory)

    def _call(self, function, *arguments):
        with contextlib.nullcontext() if self.stream is None else self.stream.explained():
            library.call(function, self.handle, *arguments)

    @property
    def info(self):
        """Whether an edit is open, how many can be undone and made again."""
        out = record.empty(abi.RlvDocumentInfo)
        library.call("rlv_document_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def begin(self, text=None):
        """Begins an edit; the text is what the file tells of one that was never ended."""
        self._call("rlv_document_begin", text_bytes(text))

    def end(self):
        """Ends the edit."""
        return self._changes("rlv_document_end")

    def abandon(self):
        """Takes the edit that was begun back."""
        self._call("rlv_document_abandon")

    @contextlib.contextmanager
    def edit(self, text=None):
        """An edit around what is done in a `with`; an exception takes it back."""
        self.begin(text)
        try:
            yield self
        except BaseException:
            self.abandon()
            raise
        self.end()

    def undo(self):
        """Undoes the last edit."""
        return self._changes("rlv_document_undo")

    def redo(self):
        """Makes the edit that was undone last again."""
        return self._changes("rlv_document_redo")

    def _changes(self, function):
        out = record.empty(abi.RlvDocumentChanges)
        self._call(function, ctypes.byref(out))
        return record.read(out)

    def save(self, path):
        """Writes the detail with its history to a file and keeps edits there from now on."""
        self._call("rlv_document_save", path_bytes(path))
        self.stream = None

    def save_file(self, file):
        """As `save`, to a file of Python's, whose bytes are replaced."""
        stream = Stream(file)
        with stream.taken() as table:
            library.call("rlv_document_save_stream", self.handle, table)
        self.stream = stream

    def save_bytes(self):
        """The bytes of the file that `save` would write; edits go on to where they went."""
        return made("rlv_document_save_bytes", self.handle)

    def sync(self):
        """Waits until all edits are on the disk."""
        self._call("rlv_document_sync")


def compact(context, path, keep=0):
    """Folds the history of a file that no document has open into its layers, but for the last edits."""
    library.call("rlv_document_compact", held(context, "context"), path_bytes(path), keep)


def mesh(context, path):
    """The mesh that a document was made on."""
    return Mesh.of("rlv_document_mesh", held(context, "context"), path_bytes(path))


def mesh_of_bytes(context, data):
    """The mesh that the document in bytes was made on."""
    address, size, _kept = given(data)
    return Mesh.of("rlv_document_mesh_bytes", held(context, "context"), address, size)


def transfer_arguments(path, to, to_path, source, reach):
    """What calls that transfer take after the context."""
    options = record.empty(abi.RlvTransferOptions)
    options.reach = reach
    if source is not None:
        setattr(options, "from", held(source, "source"))
    return (path_bytes(path), held(to, "to"), path_bytes(to_path), ctypes.byref(options))


def transfer(context, path, to, to_path, source=None, reach=0.0, progress=None):
    """Takes the layers of a document to another mesh and writes them as another document."""
    report = record.empty(abi.RlvTransferReport)
    files = transfer_arguments(path, to, to_path, source, reach)
    with watched(progress) as callback:
        library.call("rlv_document_transfer", held(context, "context"), *files, callback, None, ctypes.byref(report))
    return record.read(report)
