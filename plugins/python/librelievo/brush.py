"""Brushes, which paint or sculpt details."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

import numpy

from . import abi, library, parameter, record
from .array import Reading, packed
from .error import Invalid
from .handle import Handle, held
from .hint import ArrayLike, Settings

if TYPE_CHECKING:
    from .context import Context
    from .parameter import Parameter


def params() -> list[Parameter]:
    """What `abi.RlvBrushSettings` has."""
    return parameter.table("rlv_brush_params")


def stamp_params() -> list[Parameter]:
    """What `abi.RlvStampSettings` has."""
    return parameter.table("rlv_brush_stamp_params")


def options_of(options: Any) -> Any:
    """`abi.RlvBrushOptions` from keywords; a mode by name is that of the action."""
    action = record.named(abi.RlvBrushAction, options.get("action", abi.RlvBrushAction.PAINT), "action")
    mode = abi.RlvSculptMode if action == abi.RlvBrushAction.SCULPT else abi.RlvPaintMode
    enums = {"action": abi.RlvBrushAction, "mode": mode, "falloff": abi.RlvFalloff}
    return ctypes.byref(record.fill(abi.RlvBrushOptions, options, **enums))


class Brush(Handle):
    """A box on the surface, what it does there, and how it follows the points of a stroke."""

    noun, kind = "brush", abi.RlvBrush

    def __init__(self, context: Context, settings: Settings | None = None, **options: Any) -> None:
        """`settings` is a dictionary of fields of `abi.RlvBrushSettings`; options are the fields of `abi.RlvBrushOptions`:
        action ("paint" or "sculpt"), mode ("mix", "draw" and so on), falloff, color, height."""
        settings = ctypes.byref(record.fill(abi.RlvBrushSettings, settings))
        super().__init__("rlv_brush_create", held(context, "context"), options_of(options), settings)

    def set(self, settings: Settings | None = None, **options: Any) -> None:
        """Gives the brush other options and settings; stamp and curves stay."""
        settings = ctypes.byref(record.fill(abi.RlvBrushSettings, settings))
        library.call("rlv_brush_set", self.handle, options_of(options), settings)

    def set_curve(self, curve: str | int, points: ArrayLike) -> None:
        """What pressure is taken as for "size", "strength" or "angle": pairs of a pressure and what it is taken as."""
        number = record.named(abi.RlvCurve, curve, "curve")
        points = Reading(packed(points, numpy.float64, "points"), numpy.float64, 2, "points")
        library.call("rlv_brush_set_curve", self.handle, number, points.address, points.count)

    def set_stamp(self, pixels: ArrayLike | None, settings: Settings | None = None, channel: int = 0) -> None:
        """Gives the brush an image (height, width, channels) from the top row on, or none for None. `settings` are the
        fields of `abi.RlvStampSettings`."""
        settings = ctypes.byref(record.fill(abi.RlvStampSettings, settings))
        if pixels is None:
            return library.call("rlv_brush_set_stamp", self.handle, None, settings)
        pixels = packed(pixels, numpy.float32, "pixels")
        if pixels.ndim == 2:
            pixels = pixels[:, :, None]
        if pixels.ndim != 3:
            raise Invalid(f"pixels: the shape (height, width, channels) is needed, not {pixels.shape}")
        height, width, channels = pixels.shape
        options = {"channel": channel, "width": width, "height": height, "channels": channels}
        options = record.fill(abi.RlvStampOptions, options)
        options.pixels = pixels.__array_interface__["data"][0]
        library.call("rlv_brush_set_stamp", self.handle, ctypes.byref(options), settings)
