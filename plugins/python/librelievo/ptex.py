"""Ptex files, to and from a detail."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

from . import abi, library, record
from .detail import number_of
from .handle import held, path_bytes
from .hint import FilePath, Progress
from .progress import watched

if TYPE_CHECKING:
    from .detail import Detail


def write(detail: Detail, channel: Any, path: FilePath, progress: Progress | None = None) -> None:
    """Writes a channel of a detail as it was committed last."""
    with watched(progress) as callback:
        library.call("rlv_ptex_write", held(detail, "detail"), number_of(channel), path_bytes(path), callback, None)


def options_of(options: Any) -> Any:
    """`abi.RlvPtexOptions` from a dictionary."""
    return ctypes.byref(record.fill(abi.RlvPtexOptions, options, kind=abi.RlvPtexKind))


def read(detail: Detail, path: FilePath, progress: Progress | None = None, **options: Any) -> Any:
    """Gives the detail what a file has; options are the fields of `abi.RlvPtexOptions`."""
    options = options_of(options)
    report = record.empty(abi.RlvPtexReport)
    with watched(progress) as callback:
        arguments = (path_bytes(path), options, callback, None, ctypes.byref(report))
        library.call("rlv_ptex_read", held(detail, "detail"), *arguments)
    return record.read(report)
