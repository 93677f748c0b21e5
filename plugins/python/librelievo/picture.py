"""Documents and Ptex files as images with reductions."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import integer, room
from .handle import Handle, held, path_bytes
from .hint import Array, FilePath

if TYPE_CHECKING:
    from .context import Context

TYPES = {
    abi.RlvPictureType.U8: numpy.uint8,
    abi.RlvPictureType.U16: numpy.uint16,
    abi.RlvPictureType.F16: numpy.float16,
    abi.RlvPictureType.F32: numpy.float32,
    abi.RlvPictureType.I32: numpy.int32,
    abi.RlvPictureType.F64: numpy.float64,
}


class Picture(Handle):
    """A file with images: a document, or Ptex."""

    noun, kind = "picture", abi.RlvPicture

    def __init__(self, context: Context, path: FilePath) -> None:
        super().__init__("rlv_picture_open", held(context, "context"), path_bytes(path))

    @property
    def info(self) -> Any:
        out = record.empty(abi.RlvPictureInfo)
        library.call("rlv_picture_info", self.handle, ctypes.byref(out))
        return record.read(out)

    def image(self, image: int) -> Any:
        """What an image is."""
        out = record.empty(abi.RlvPictureImage)
        library.call("rlv_picture_image", self.handle, image, ctypes.byref(out))
        return record.read(out)

    def meta(self) -> Any:
        """What is said of the whole file: texts and arrays of numbers by their names."""
        found = {}
        for index in range(self.info.meta_count):
            out = record.empty(abi.RlvPictureMeta)
            library.call("rlv_picture_meta", self.handle, index, ctypes.byref(out))
            is_text = out.type == abi.RlvPictureType.TEXT
            size = out.count * (1 if is_text else numpy.dtype(TYPES[out.type]).itemsize)
            data = ctypes.string_at(out.values, size)
            value = data.decode("utf-8", "replace") if is_text else numpy.frombuffer(data, TYPES[out.type])
            found[out.name.decode("utf-8", "replace")] = value
        return found

    def read(
        self, image: int, level: int = 0, x: int = 0, y: int = 0, width: int | None = None, height: float | None = None
    ) -> Array:
        """Pixels of a level, an array of rows, columns and channels; all of them unless a part is named."""
        info = self.image(image)
        level, x, y = (integer(value, name) for name, value in (("level", level), ("x", x), ("y", y)))
        width = integer(max((info.width >> level) - x, 1) if width is None else width, "width")
        height = integer(max((info.height >> level) - y, 1) if height is None else height, "height")
        pixels = room((height, width, info.channels), TYPES[info.type], "width, height")
        to = pixels.__array_interface__["data"][0]
        library.call("rlv_picture_read", self.handle, image, level, x, y, width, height, to, 0)
        return pixels
