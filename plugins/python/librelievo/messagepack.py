"""The part of MessagePack that the simulation server speaks: nil, booleans, numbers, texts, bytes, lists and maps.

It is written here because Blender's Python has no msgpack."""

from __future__ import annotations

import struct
from typing import Any

from .error import Invalid

# Lists and maps within each other at most, and bytes of a text at most.
DEPTH, LONGEST = 16, 16 << 20

# What an item begins with beside the short forms: the format of what follows, and how that is read.
NUMBERS = {
    0xCA: ">f", 0xCB: ">d", 0xCC: ">B", 0xCD: ">H", 0xCE: ">I", 0xCF: ">Q", 0xD0: ">b", 0xD1: ">h", 0xD2: ">i", 0xD3: ">q",
}  # fmt: skip
SIZES = {0xC4: ">B", 0xC5: ">H", 0xC6: ">I", 0xD9: ">B", 0xDA: ">H", 0xDB: ">I", 0xDC: ">H", 0xDD: ">I", 0xDE: ">H", 0xDF: ">I"}
CONSTANTS = {0xC0: None, 0xC2: False, 0xC3: True}


def _head(size: Any, short: Any, most: Any, markers: Any) -> bytes:
    """The head of something of a size: in a byte up to `most`, or behind a marker."""
    if size <= most:
        return bytes([short | size])
    for marker, form in zip(markers, (">B", ">H", ">I")):
        if marker is not None and size < 1 << 8 * struct.calcsize(form):
            return bytes([marker]) + struct.pack(form, size)
    raise Invalid(f"{size} items or bytes are too many for a message")


def packed(value: Any) -> Any:
    """Encodes a value. Invalid where it has something that a message cannot have."""
    if value is None or isinstance(value, bool):
        return bytes([{None: 0xC0, False: 0xC2, True: 0xC3}[value]])
    if isinstance(value, int):
        if not -(1 << 63) <= value < 1 << 64:
            raise Invalid("a number has more than 64 bits and cannot be sent")
        if 0 <= value < 128:
            return bytes([value])
        return b"\xcf" + struct.pack(">Q", value) if value >= 0 else b"\xd3" + struct.pack(">q", value)
    if isinstance(value, float):
        return b"\xcb" + struct.pack(">d", value)
    if isinstance(value, str):
        try:
            text = value.encode()
        except UnicodeEncodeError as problem:
            raise Invalid(f"a text is not Unicode and cannot be sent: {problem.reason}") from None
        return _head(len(text), 0xA0, 31, (0xD9, 0xDA, 0xDB)) + text
    if isinstance(value, (bytes, bytearray, memoryview)):
        return _head(len(value), 0, -1, (0xC4, 0xC5, 0xC6)) + bytes(value)
    if isinstance(value, dict):
        items = [part for pair in value.items() for part in pair]
        return _head(len(value), 0x80, 15, (None, 0xDE, 0xDF)) + b"".join(map(packed, items))
    if isinstance(value, (list, tuple)):
        return _head(len(value), 0x90, 15, (None, 0xDC, 0xDD)) + b"".join(map(packed, value))
    raise Invalid(f"{type(value).__name__} cannot be sent; use texts, numbers, bytes, lists and dictionaries")


def read(take: Any, depth: int = 0) -> Any:
    """Decodes a value of the bytes that `take(count)` returns. Fails with ValueError if the bytes encode no value."""
    if depth > DEPTH:
        raise ValueError("a message is too deep")
    (marker,) = take(1)
    if marker < 0x80:
        return marker
    if marker >= 0xE0:
        return marker - 0x100
    if marker in CONSTANTS:
        return CONSTANTS[marker]
    if marker in NUMBERS:
        form = NUMBERS[marker]
        return struct.unpack(form, take(struct.calcsize(form)))[0]
    if marker < 0xC0:
        kind, size = marker & 0xF0 if marker < 0xA0 else 0xA0, marker & (0x0F if marker < 0xA0 else 0x1F)
    elif marker in SIZES:
        form = SIZES[marker]
        (size,) = struct.unpack(form, take(struct.calcsize(form)))
        kind = 0xC4 if marker <= 0xC6 else 0xA0 if marker <= 0xDB else 0x90 if marker <= 0xDD else 0x80
    else:
        raise ValueError(f"the byte {marker:#x} begins nothing that is known")
    if size > LONGEST:
        raise ValueError(f"{size} items or bytes are too many")
    if kind == 0xC4:
        return take(size)
    if kind == 0xA0:
        return take(size).decode()
    if kind == 0x90:
        return [read(take, depth + 1) for _ in range(size)]
    return {read(take, depth + 1): read(take, depth + 1) for _ in range(size)}
