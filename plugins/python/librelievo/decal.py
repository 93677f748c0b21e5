"""Decals: stickers cut out of an image that lie on a surface exactly at given points."""

import ctypes

import numpy

from . import abi, library, record
from .array import Reading
from .error import Invalid
from .handle import Handle
from .mesh import Mesh, set_array
from .progress import watched

PIN = numpy.dtype(abi.RlvDecalPin)


def pins_of(pins):
    """An array of RlvDecalPin of pairs or triples: a point of the image (2), a position (3), and the depth, 0 if left out."""
    made = numpy.zeros(len(pins), PIN)
    for at, pin in enumerate(pins):
        if len(pin) not in (2, 3):
            raise Invalid(f"pin {at}: an image point, a position and perhaps a depth are needed, not {len(pin)} values")
        try:
            made[at] = (tuple(pin[0]), tuple(pin[1]), pin[2] if len(pin) == 3 else 0.0)
        except (TypeError, ValueError) as problem:
            raise Invalid(f"pin {at}: {problem}") from None
    return made


def arguments(pins, size, outline=None, **options):
    """What the functions that lay a sticker take after the surface, and what keeps their arrays. `size` is the width and
    the height of the image, `outline` an array (n, 2); options are the fields of RlvDecalOptions."""
    width, height = size
    made = record.fill(abi.RlvDecalOptions, {"width": width, "height": height, **options})
    corners, pins = Reading(outline, numpy.float64, 2, "outline"), pins_of(pins)
    set_array(made, corners, "outline", "outline_count", "outline_stride")
    first = pins.ctypes.data_as(ctypes.POINTER(abi.RlvDecalPin)) if len(pins) else None
    return (ctypes.byref(made), first, len(pins), 0), (made, corners, pins)


def _numbers(values, count, name):
    array = numpy.ascontiguousarray(values, numpy.float64)
    if array.shape != (count,):
        raise Invalid(f"{name}: {count} numbers are needed")
    return array


class Decal(Handle):
    """A sticker on a surface."""

    noun, kind = "decal", abi.RlvDecal

    @classmethod
    def on_mesh(cls, mesh, pins, size, outline=None, progress=None, **options):
        """Lays a sticker on the triangles of a mesh; see `arguments`."""
        return cls._on("rlv_decal_on_mesh", mesh, pins, size, outline, progress, options)

    @classmethod
    def on_detail(cls, detail, pins, size, outline=None, progress=None, **options):
        """Lays a sticker on the committed surface of a detail; see `arguments`."""
        return cls._on("rlv_decal_on_detail", detail, pins, size, outline, progress, options)

    @classmethod
    def _on(cls, function, ground, pins, size, outline, progress, options):
        given, kept = arguments(pins, size, outline, **options)
        with watched(progress) as callback:
            made = cls.of(function, ground.handle, *given, callback, None)
        del kept
        return made

    @property
    def quality(self):
        """Stretch, angles, coverage, flips and overlaps; see RlvDecalQuality."""
        out = record.empty(abi.RlvDecalQuality)
        library.call("rlv_decal_quality", self.handle, ctypes.byref(out))
        return record.read(out)

    def mesh(self, offset=0.0):
        """Makes a mesh of it with `uv` and `normal`, lifted off the surface by an offset."""
        return Mesh.of("rlv_decal_mesh", self.handle, offset)

    def drag_pin(self, pin, position):
        """Moves a pin to the place of the surface nearest to a position; `settle` ends it."""
        position = _numbers(position, 3, "position")
        library.call("rlv_decal_drag_pin", self.handle, pin, position.ctypes.data)

    def move_image(self, pin, image, progress=None):
        """Moves the point of the image that a pin belongs to, in pixels."""
        image = _numbers(image, 2, "image")
        with watched(progress) as callback:
            library.call("rlv_decal_move_image", self.handle, pin, image.ctypes.data, callback, None)

    def pose(self, points, progress=None):
        """Lays it anew where the points (n, 3) of its mesh moved."""
        points = Reading(points, numpy.float32, 3, "points")
        with watched(progress) as callback:
            library.call("rlv_decal_pose", self.handle, points.address, points.count, points.stride, callback, None)

    def settle(self, progress=None):
        """Lowers the distortion, and lets it grow and shrink until it covers the sticker."""
        with watched(progress) as callback:
            library.call("rlv_decal_settle", self.handle, callback, None)

    def paint(self, image, opacity=1.0):
        """Paints it over the active layer of colour of its detail. `image` has the shape (height, width, channels), rows
        from the top, linear."""
        return self._write("rlv_decal_paint", image, opacity)

    def emboss(self, image, height):
        """Raises the displacement of its detail by a height where the image is white and opaque."""
        return self._write("rlv_decal_emboss", image, height)

    def _write(self, function, image, amount):
        pixels = numpy.ascontiguousarray(image, numpy.float32)
        if pixels.ndim == 2:
            pixels = pixels[:, :, None]
        if pixels.ndim != 3:
            raise Invalid(f"image: the shape (height, width, channels) is needed, not {pixels.shape}")
        given = record.empty(abi.RlvDecalImage)
        given.channels, given.pixel_count = pixels.shape[2], pixels.shape[0] * pixels.shape[1]
        given.pixels = pixels.ctypes.data
        report = record.empty(abi.RlvDecalReport)
        library.call(function, self.handle, ctypes.byref(given), amount, ctypes.byref(report))
        return record.read(report)
