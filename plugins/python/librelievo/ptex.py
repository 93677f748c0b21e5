"""Ptex files, to and from a detail."""

import ctypes

from . import abi, library, record
from .detail import number_of
from .handle import held, path_bytes
from .progress import watched


def write(detail, channel, path, progress=None):
    """Writes a channel of a detail as it was committed last."""
    with watched(progress) as callback:
        library.call("rlv_ptex_write", held(detail, "detail"), number_of(channel), path_bytes(path), callback, None)


def options_of(options):
    """RlvPtexOptions from a dictionary."""
    return ctypes.byref(record.fill(abi.RlvPtexOptions, options, kind=abi.RlvPtexKind))


def read(detail, path, progress=None, **options):
    """Gives the detail what a file has; options are the fields of RlvPtexOptions."""
    options = options_of(options)
    report = record.empty(abi.RlvPtexReport)
    with watched(progress) as callback:
        arguments = (path_bytes(path), options, callback, None, ctypes.byref(report))
        library.call("rlv_ptex_read", held(detail, "detail"), *arguments)
    return record.read(report)
