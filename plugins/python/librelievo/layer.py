"""Layers of details."""

from __future__ import annotations

import ctypes
from typing import TYPE_CHECKING, Any

from . import abi, library, record
from .array import integer, number
from .handle import held, text_bytes
from .parameter import address_of

if TYPE_CHECKING:
    from .detail import Detail

ENUMS = {"kind": abi.RlvLayerKind, "blend": abi.RlvBlend}


class Layers:
    """The layers of a detail: those of displacement from the lowest, then those of colour. Layers have numbers."""

    def __init__(self, detail: Detail) -> None:
        held(detail, "detail", abi.RlvDetail)
        self.detail = detail

    def __len__(self) -> Any:
        count = ctypes.c_size_t()
        library.call("rlv_layer_count", self.detail.handle, address_of(count))
        return count.value

    def __getitem__(self, index: Any) -> Any:
        if not 0 <= number(index, "index") < len(self):
            raise IndexError(index)
        out = record.empty(abi.RlvLayerInfo)
        library.call("rlv_layer_info", self.detail.handle, index, ctypes.byref(out))
        return record.read(out)

    def add(self, name: str, **options: Any) -> Any:
        """Adds a layer above those of its kind, makes it the active one and returns its number. Options are the fields
        of `abi.RlvLayerOptions`."""
        number = ctypes.c_uint32()
        # Colours are covered unless the caller says otherwise; heights are added.
        if record.named(abi.RlvLayerKind, options.get("kind", 0), "kind") == abi.RlvLayerKind.COLOR:
            options = {"blend": "normal", **options}
        options = ctypes.byref(record.fill(abi.RlvLayerOptions, options, **ENUMS))
        library.call("rlv_layer_add", self.detail.handle, text_bytes(name, "name"), options, address_of(number))
        return number.value

    def set(self, number: int, **options: Any) -> None:
        """Changes how a layer is seen: blend, is_visible and opacity; what is not given stays."""
        number = integer(number, "number")
        now = next((layer for layer in self if layer.id == number), None)
        if now is not None:
            options = {"blend": now.blend, "is_visible": now.is_visible, "opacity": now.opacity, **options}
        options = ctypes.byref(record.fill(abi.RlvLayerOptions, options, **ENUMS))
        library.call("rlv_layer_set", self.detail.handle, number, options)

    def set_active(self, number: int) -> None:
        """Makes a layer the one that edits of its kind go to."""
        library.call("rlv_layer_set_active", self.detail.handle, number)

    def rename(self, number: int, name: str) -> None:
        """Gives a layer another name."""
        library.call("rlv_layer_rename", self.detail.handle, number, text_bytes(name, "name"))

    def place(self, number: int, place: Any) -> None:
        """Puts a layer at a place among those of its kind, 0 the lowest."""
        library.call("rlv_layer_place", self.detail.handle, number, place)

    def remove(self, number: int) -> None:
        """Removes a layer with all that is on it."""
        library.call("rlv_layer_remove", self.detail.handle, number)

    def merge(self, number: int) -> None:
        """Puts a layer and the one below it into one."""
        library.call("rlv_layer_merge", self.detail.handle, number)

    def flatten(self) -> None:
        """Makes one layer of displacement and one of colour of all."""
        library.call("rlv_layer_flatten", self.detail.handle)
