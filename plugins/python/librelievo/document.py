"""Documents, in which the edits of a detail are kept: undo, redo, and a journal that survives a killed host."""

import contextlib
import ctypes

from . import abi, library, record
from .handle import Handle, path_bytes, text_bytes
from .mesh import Mesh
from .progress import watched


class Document(Handle):
    """Follows a detail. What is done between `begin` and `end` is one edit."""

    noun, kind = "document", abi.RlvDocument

    def __init__(self, detail, path=None, memory=0):
        """Follows the detail from now on; `path` is the file, which is written at once and replaces what is there."""
        path = None if path is None else path_bytes(path)
        super().__init__("rlv_document_create", detail.handle, path, memory)

    @classmethod
    def open(cls, detail, path, memory=0):
        """Opens a file and gives the detail its layers and its history."""
        return cls.of("rlv_document_open", detail.handle, path_bytes(path), memory)

    @property
    def info(self):
        """Whether an edit is open, how many can be undone and made again."""
        out = record.empty(abi.RlvDocumentInfo)
        library.call("rlv_document_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def begin(self, text=None):
        """Begins an edit; the text is what the file tells of one that was never ended."""
        library.call("rlv_document_begin", self.handle, text_bytes(text))

    def end(self):
        """Ends the edit."""
        return self._changes("rlv_document_end")

    def abandon(self):
        """Takes the edit that was begun back."""
        library.call("rlv_document_abandon", self.handle)

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
        library.call(function, self.handle, ctypes.byref(out))
        return record.read(out)

    def save(self, path):
        """Writes the detail with its history to a file and keeps edits there from now on."""
        library.call("rlv_document_save", self.handle, path_bytes(path))

    def sync(self):
        """Waits until all edits are on the disk."""
        library.call("rlv_document_sync", self.handle)


def compact(context, path, keep=0):
    """Folds the history of a file that no document has open into its layers, but for the last edits."""
    library.call("rlv_document_compact", context.handle, path_bytes(path), keep)


def mesh(context, path):
    """The mesh that a document was made on."""
    return Mesh.of("rlv_document_mesh", context.handle, path_bytes(path))


def transfer_arguments(path, to, to_path, source, reach):
    """What calls that transfer take after the context."""
    options = record.empty(abi.RlvTransferOptions)
    options.reach = reach
    if source is not None:
        setattr(options, "from", source.handle)
    return (path_bytes(path), to.handle, path_bytes(to_path), ctypes.byref(options))


def transfer(context, path, to, to_path, source=None, reach=0.0, progress=None):
    """Takes the layers of a document to another mesh and writes them as another document."""
    report = record.empty(abi.RlvTransferReport)
    files = transfer_arguments(path, to, to_path, source, reach)
    with watched(progress) as callback:
        library.call("rlv_document_transfer", context.handle, *files, callback, None, ctypes.byref(report))
    return record.read(report)
