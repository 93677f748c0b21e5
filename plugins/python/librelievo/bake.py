"""Bakes: pictures of a detail on the texture coordinates of its cage."""

from __future__ import annotations

import ctypes
from collections import namedtuple
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .handle import held, path_bytes, text_bytes
from .hint import FilePath, Progress
from .progress import Callback, raising, watched

if TYPE_CHECKING:
    from .detail import Detail

Picture = namedtuple("Picture", ["udim", "pixels", "covered"])
ENUMS = {
    "quantity": abi.RlvBakeQuantity,
    "space": abi.RlvBakeSpace,
    "axes": abi.RlvBakeAxes,
    "handedness": abi.RlvBakeHandedness,
}


def options_of(options: Any) -> Any:
    """`abi.RlvBakeOptions` from keywords."""
    if options.get("uv") is not None:
        options = {**options, "uv": text_bytes(options["uv"], "uv")}
    return ctypes.byref(record.fill(abi.RlvBakeOptions, options, **ENUMS))


def run(detail: Detail, progress: Progress | None = None, **options: Any) -> tuple[Any, ...]:
    """Bakes to memory: pictures (height, width, channels) with the row of the largest t first, and a report. Options
    are the fields of `abi.RlvBakeOptions`."""
    pictures = []

    def keep(place: Any) -> None:
        given = ctypes.cast(place, ctypes.POINTER(abi.RlvBakePicture)).contents
        shape = (given.height, given.width)
        pixels = _copy(given.pixels, numpy.float32, (*shape, given.channels))
        pictures.append(Picture(given.udim, pixels, _copy(given.covered, numpy.uint8, shape)))

    receiver = Callback(abi.RlvBakeReceiver, None)
    receiver.function = abi.RlvBakeReceiver(lambda _user, picture: receiver.answer(keep, picture))
    report = record.empty(abi.RlvBakeReport)
    with watched(progress) as callback, raising(receiver):
        arguments = (options_of(options), receiver.function, callback, None, ctypes.byref(report))
        library.call("rlv_bake_run", held(detail, "detail"), *arguments)
    return pictures, record.read(report)


def _copy(pointer: Any, kind: Any, shape: Any) -> Any:
    size = int(numpy.prod(shape)) * numpy.dtype(kind).itemsize
    buffer = (ctypes.c_uint8 * size).from_address(pointer.value)
    return numpy.frombuffer(buffer, kind).reshape(shape).copy()


def write(detail: Detail, path: FilePath, progress: Progress | None = None, **options: Any) -> Any:
    """Bakes to files, .exr or .png as the extension says."""
    report = record.empty(abi.RlvBakeReport)
    with watched(progress) as callback:
        arguments = (options_of(options), path_bytes(path), callback, None, ctypes.byref(report))
        library.call("rlv_bake_write", held(detail, "detail"), *arguments)
    return record.read(report)
