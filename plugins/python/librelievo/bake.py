"""Bakes: pictures of a detail on the texture coordinates of its cage."""

import ctypes
from collections import namedtuple

import numpy

from . import abi, library, record
from .handle import held, path_bytes, text_bytes
from .progress import Callback, raising, watched

Picture = namedtuple("Picture", ["udim", "pixels", "covered"])
ENUMS = {
    "quantity": abi.RlvBakeQuantity,
    "space": abi.RlvBakeSpace,
    "axes": abi.RlvBakeAxes,
    "handedness": abi.RlvBakeHandedness,
}


def options_of(options):
    """RlvBakeOptions from keywords."""
    if options.get("uv") is not None:
        options = {**options, "uv": text_bytes(options["uv"])}
    return ctypes.byref(record.fill(abi.RlvBakeOptions, options, **ENUMS))


def run(detail, progress=None, **options):
    """Bakes to memory: pictures (height, width, channels) with the row of the largest t first, and a report. Options
    are the fields of RlvBakeOptions."""
    pictures = []

    def keep(place):
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


def _copy(pointer, kind, shape):
    size = int(numpy.prod(shape)) * numpy.dtype(kind).itemsize
    buffer = (ctypes.c_uint8 * size).from_address(pointer.value)
    return numpy.frombuffer(buffer, kind).reshape(shape).copy()


def write(detail, path, progress=None, **options):
    """Bakes to files, .exr or .png as the extension says."""
    report = record.empty(abi.RlvBakeReport)
    with watched(progress) as callback:
        arguments = (options_of(options), path_bytes(path), callback, None, ctypes.byref(report))
        library.call("rlv_bake_write", held(detail, "detail"), *arguments)
    return record.read(report)
