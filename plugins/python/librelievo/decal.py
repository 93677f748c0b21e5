"""Decals: stickers cut out of an image that lie on a surface exactly at given points."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, record
from .array import Reading, integer, list_of, number, packed, tupled
from .error import Invalid
from .handle import Handle, held, text_bytes
from .hint import Array, ArrayLike, Progress
from .mesh import Mesh, set_array
from .progress import watched

if TYPE_CHECKING:
    from .detail import Detail
    from .document import Document

PIN = numpy.dtype(abi.RlvDecalPin)
# The most pins of a strip.
STRIP = 512


def pins_of(pins: Any) -> Any:
    """An array of `abi.RlvDecalPin` of pairs or triples: a point of the image (2), a position (3), and the depth, 0 if left
    out."""
    pins = list_of(pins, "pins")
    made = numpy.zeros(len(pins), PIN)
    for at, pin in enumerate(pins):
        parts = list_of(pin, f"pin {at}")
        if len(parts) not in (2, 3):
            raise Invalid(f"pin {at}: an image point, a position and perhaps a depth are needed, not {len(parts)} values")
        try:
            made[at] = (tuple(parts[0]), tuple(parts[1]), parts[2] if len(parts) == 3 else 0.0)
        except (TypeError, ValueError, OverflowError) as problem:
            raise Invalid(f"pin {at}: {problem}") from None
    return made


def arguments(pins: Any, size: Any, outline: Any = None, **options: Any) -> tuple[Any, ...]:
    """What the functions that lay a sticker take after the surface, and what keeps their arrays. `size` is the width and
    the height of the image, `outline` an array (n, 2); options are the fields of `abi.RlvDecalOptions`."""
    width, height = tupled(size, 2, "size")
    made = record.fill(abi.RlvDecalOptions, {"width": width, "height": height, **options})
    corners, pins = Reading(outline, numpy.float64, 2, "outline"), pins_of(pins)
    set_array(made, corners, "outline", "outline_count", "outline_stride")
    first = pins.ctypes.data_as(ctypes.POINTER(abi.RlvDecalPin)) if len(pins) else None
    return (ctypes.byref(made), first, len(pins), 0), (made, corners, pins)


def _numbers(values: Any, count: Any, name: str) -> Any:
    array = packed(values, numpy.float64, name)
    if array.shape != (count,):
        raise Invalid(f"{name}: {count} numbers are needed")
    return array


def _pixels(values: Any, name: str) -> Any:
    pixels = packed(values, numpy.float32, name)
    if pixels.ndim == 2:
        pixels = pixels[:, :, None]
    if pixels.ndim != 3:
        raise Invalid(f"{name}: the shape (height, width, channels) is needed, not {pixels.shape}")
    return pixels


def image_of(values: Any) -> tuple[Any, ...]:
    """An `abi.RlvDecalImage` of an array (height, width, channels), and what keeps its pixels."""
    pixels = _pixels(values, "image")
    given = record.empty(abi.RlvDecalImage)
    given.channels, given.pixel_count = pixels.shape[2], pixels.shape[0] * pixels.shape[1]
    given.pixels = pixels.ctypes.data
    return given, pixels


def contour(image: ArrayLike, level: float = 0.5, tolerance: float = 0.5) -> Array:
    """The outline of an image by its alpha: corners (n, 2), counter-clockwise, in pixels from its lower left corner. `image`
    has the shape (height, width, 4), rows from the top."""
    given, kept = image_of(image)
    height, width = kept.shape[:2]
    count = ctypes.c_size_t()
    wanted = ctypes.byref(given), width, height, number(level, "level"), number(tolerance, "tolerance")
    library.call("rlv_decal_contour", *wanted, None, 0, ctypes.byref(count))
    corners = numpy.empty((count.value, 2))
    library.call("rlv_decal_contour", *wanted, corners.ctypes.data, count.value, ctypes.byref(count))
    return corners


def strip_on_mesh(mesh: Mesh, curve: ArrayLike, size: Sequence[float], outline: ArrayLike | None = None, **options: Any) -> Any:
    """Pins for a strip along a curve through places (n, 3) of a mesh, and the length of the curve; see `arguments`."""
    return _strip("rlv_decal_strip_on_mesh", mesh, curve, size, outline, options)


def strip_on_detail(
    detail: Detail, curve: ArrayLike, size: Sequence[float], outline: ArrayLike | None = None, **options: Any
) -> Any:
    """As `strip_on_mesh`, on the committed surface of a detail."""
    return _strip("rlv_decal_strip_on_detail", detail, curve, size, outline, options)


def _strip(function: str, ground: Any, curve: Any, size: Any, outline: Any, options: Any) -> tuple[Any, ...]:
    (given, *_), kept = arguments([], size, outline, **options)
    curve = Reading(curve, numpy.float64, 3, "curve")
    pins = numpy.zeros(STRIP, PIN)
    count, length = ctypes.c_size_t(), ctypes.c_double()
    first = pins.ctypes.data_as(ctypes.POINTER(abi.RlvDecalPin))
    places = curve.address, curve.count, curve.stride
    library.call(function, held(ground, "ground"), given, *places, first, STRIP, ctypes.byref(count), ctypes.byref(length))
    del kept
    made = [(tuple(pin["image"].tolist()), tuple(pin["position"].tolist())) for pin in pins[: count.value]]
    return made, length.value


def recipes_of(document: Document) -> list[Any]:
    """The decals that a document keeps; see `abi.RlvDecalRecipe`."""
    count = ctypes.c_size_t()
    library.call("rlv_decal_count", held(document, "document"), ctypes.byref(count))
    found = []
    for index in range(count.value):
        out = record.empty(abi.RlvDecalRecipe)
        library.call("rlv_decal_recipe", held(document, "document"), index, ctypes.byref(out))
        found.append(record.read(out))
    return found


def remove(document: Document, number: int) -> None:
    """Removes a decal that a document keeps, with its layer."""
    library.call("rlv_decal_remove", held(document, "document"), number)


class Decal(Handle):
    """A sticker on a surface."""

    noun, kind = "decal", abi.RlvDecal

    @classmethod
    def on_mesh(
        cls,
        mesh: Mesh,
        pins: Sequence[Any],
        size: Sequence[float],
        outline: ArrayLike | None = None,
        progress: Progress | None = None,
        **options: Any,
    ) -> Decal:
        """Lays a sticker on the triangles of a mesh; see `arguments`."""
        return cls._on("rlv_decal_on_mesh", mesh, pins, size, outline, progress, options)

    @classmethod
    def on_detail(
        cls,
        detail: Detail,
        pins: Sequence[Any],
        size: Sequence[float],
        outline: ArrayLike | None = None,
        progress: Progress | None = None,
        **options: Any,
    ) -> Decal:
        """Lays a sticker on the committed surface of a detail; see `arguments`."""
        return cls._on("rlv_decal_on_detail", detail, pins, size, outline, progress, options)

    @classmethod
    def _on(cls, function: str, ground: Any, pins: Any, size: Any, outline: Any, progress: Any, options: Any) -> Decal:
        given, kept = arguments(pins, size, outline, **options)
        with watched(progress) as callback:
            made = cls.of(function, held(ground, "ground"), *given, callback, None)
        del kept
        return made

    @property
    def quality(self) -> Any:
        """Stretch, angles, coverage, flips and overlaps; see `abi.RlvDecalQuality`."""
        out = record.empty(abi.RlvDecalQuality)
        library.call("rlv_decal_quality", self.handle, ctypes.byref(out))
        return record.read(out)

    def mesh(self, offset: float = 0.0) -> Mesh:
        """Makes a mesh of it with `uv` and `normal`, lifted off the surface by an offset."""
        return Mesh.of("rlv_decal_mesh", self.handle, offset)

    def drag_pin(self, pin: int, position: ArrayLike) -> None:
        """Moves a pin to the place of the surface nearest to a position; `settle` ends it."""
        position = _numbers(position, 3, "position")
        library.call("rlv_decal_drag_pin", self.handle, pin, position.ctypes.data)

    def move_image(self, pin: int, image: ArrayLike, progress: Progress | None = None) -> None:
        """Moves the point of the image that a pin belongs to, in pixels."""
        image = _numbers(image, 2, "image")
        with watched(progress) as callback:
            library.call("rlv_decal_move_image", self.handle, pin, image.ctypes.data, callback, None)

    def pose(self, points: ArrayLike, progress: Progress | None = None) -> None:
        """Lays it anew where the points (n, 3) of its mesh moved."""
        points = Reading(points, numpy.float32, 3, "points")
        with watched(progress) as callback:
            library.call("rlv_decal_pose", self.handle, points.address, points.count, points.stride, callback, None)

    def settle(self, progress: Progress | None = None) -> None:
        """Lowers the distortion, and lets it grow and shrink until it covers the sticker."""
        with watched(progress) as callback:
            library.call("rlv_decal_settle", self.handle, callback, None)

    def paint(self, image: ArrayLike, opacity: float = 1.0) -> Any:
        """Paints it over the active layer of colour of its detail. `image` has the shape (height, width, channels), rows
        from the top, linear."""
        return self._write("rlv_decal_paint", image, opacity)

    def emboss(self, image: ArrayLike, height: float) -> Any:
        """Raises the displacement of its detail by a height where the image is white and opaque."""
        return self._write("rlv_decal_emboss", image, height)

    def write(self, image: ArrayLike, **ink: Any) -> Any:
        """Writes it into a channel of its detail, with a blend mode and an opacity; `ink` has the fields of `abi.RlvDecalInk`,
        with channel and blend mode as numbers or names."""
        given = record.fill(abi.RlvDecalInk, ink, channel=abi.RlvChannel, blend=abi.RlvBlend)
        return self._write("rlv_decal_write", image, ctypes.byref(given))

    @property
    def pins(self) -> list[tuple[Any, ...]]:
        """The pins as they are now: points of the image (2), positions (3) and depths."""
        count = ctypes.c_size_t()
        library.call("rlv_decal_pins", self.handle, None, 0, ctypes.byref(count))
        pins = numpy.zeros(count.value, PIN)
        first = pins.ctypes.data_as(ctypes.POINTER(abi.RlvDecalPin))
        library.call("rlv_decal_pins", self.handle, first, len(pins), ctypes.byref(count))
        return [(tuple(pin["image"].tolist()), tuple(pin["position"].tolist()), float(pin["depth"])) for pin in pins]

    def apply(
        self, document: Document, layer: str, image: ArrayLike, progress: Progress | None = None, **ink: Any
    ) -> int:
        """Writes it into a new layer of the detail of a document, which keeps what it is made of; `ink` as for `write`.
        Returns its number in the document."""
        (given, kept), number = image_of(image), ctypes.c_uint32()
        made = record.fill(abi.RlvDecalInk, ink, channel=abi.RlvChannel, blend=abi.RlvBlend)
        with watched(progress) as callback:
            arguments = (text_bytes(layer, "layer"), ctypes.byref(given), ctypes.byref(made), callback, None, ctypes.byref(number))
            library.call("rlv_decal_apply", self.handle, held(document, "document"), *arguments)
        del kept
        return number.value

    @classmethod
    def take_up(cls, document: Document, number: int, progress: Progress | None = None) -> Decal:
        """Lays a decal that a document keeps again, so that its pins can be moved."""
        with watched(progress) as callback:
            return cls.of("rlv_decal_take_up", held(document, "document"), number, callback, None)

    def update(
        self, document: Document, number: int, image: ArrayLike, progress: Progress | None = None, **ink: Any
    ) -> None:
        """Writes a decal of a document anew, with the pins, the sticker and the settings of this one; without `ink` it is seen
        as before."""
        given, kept = image_of(image)
        made = record.fill(abi.RlvDecalInk, ink, channel=abi.RlvChannel, blend=abi.RlvBlend) if ink else None
        first = None if made is None else ctypes.byref(made)
        with watched(progress) as callback:
            arguments = (number, ctypes.byref(given), first, callback, None)
            library.call("rlv_decal_update", self.handle, held(document, "document"), *arguments)
        del kept

    def paint_texture(self, image: ArrayLike, texture: ArrayLike, opacity: float = 1.0, gutter: int = 8) -> tuple[Any, ...]:
        """Paints it over the texture of its mesh with texture coordinates. `image` and `texture` have the shape (height,
        width, channels), rows from the top, linear. Returns the new texture and the number of pixels that it changed."""
        given, kept = image_of(image)
        pixels = _pixels(texture, "texture").copy()
        height, width, channels = pixels.shape
        made = record.empty(abi.RlvDecalTexture)
        made.width, made.height, made.channels, made.gutter = width, height, channels, integer(gutter, "gutter")
        made.pixels, made.pixel_count = pixels.ctypes.data, height * width
        painted = ctypes.c_size_t()
        library.call(
            "rlv_decal_paint_texture", self.handle, ctypes.byref(given), opacity, ctypes.byref(made), ctypes.byref(painted)
        )
        del kept
        return pixels.reshape(numpy.shape(texture)), painted.value

    def _write(self, function: str, image: Any, amount: Any) -> Any:
        given, kept = image_of(image)
        report = record.empty(abi.RlvDecalReport)
        library.call(function, self.handle, ctypes.byref(given), amount, ctypes.byref(report))
        del kept
        return record.read(report)
