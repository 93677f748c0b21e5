# SPDX-License-Identifier: GPL-3.0-or-later
"""Strokes as an object keeps them: what the brush was, where the object was, and the points, as JSON with every digit,
so that strokes that are made again are the same to the bit."""

import json
import struct
import zlib

import bpy
import librelievo as rl
import numpy

from ..core import native, settings
from ..core.error import said
from . import mesh

# Modes that move surfaces along all three axes, which needs a channel of its own.
BENDING = {"pinch", "vector"}
# What keys that are held at the press make of a brush.
EFFECTS = [
    ("NORMAL", "Normal", "What the brush does"),
    ("INVERT", "Invert", "Sink in place of raise; take paint away"),
    ("SMOOTH", "Smooth", "Smooth the relief; blend neighbouring colours"),
]
# Distance between the dabs of strokes that do not accumulate, at most, as a share of the radius.
SPACING = 0.125
# What objects keep of stamps and poses: three sizes, then the packed numbers, under a name with their checksum.
ARRAYS, SHAPE = "relievo_array_", struct.Struct("<III")


def mode_of(scene, action, effect="NORMAL"):
    """The mode of the brush that the scene's settings say, as an effect changes it."""
    group = scene.relievo.brush
    if action == "PAINT":
        return {"SMOOTH": "blur", "INVERT": "erase"}.get(effect, group.paint_mode.lower())
    return "smooth" if effect == "SMOOTH" else group.sculpt_mode.lower()


def describe(scene, action, effect="NORMAL"):
    """The brush that the scene's settings say, as a stroke keeps it, and the pixels of its stamp or None."""
    group, mode = scene.relievo.brush, mode_of(scene, action, effect)
    height = -group.height if effect == "INVERT" else group.height
    brush_settings = settings.values(group.settings)
    if action == "SCULPT" and mode == "draw" and not group.accumulate:
        # The dabs of a layer reach its height together. They do not add up, so that gaps between them would show.
        mode = "layer"
        brush_settings["spacing"] = min(brush_settings["spacing"], SPACING)
    kept = {
        "options": {
            "action": action.lower(),
            "mode": mode,
            "falloff": group.falloff.lower(),
            "color": list(group.color),
            "height": height,
        },
        "settings": brush_settings,
        "stamp": None,
        "curves": settings.curves(group),
    }
    pixels = None
    if group.stamp is not None and group.stamp.size[0]:
        kept["stamp"] = group.stamp.name
        kept["stamp_settings"] = settings.values(group.stamp_settings)
        pixels = pixels_of(group.stamp)
    return kept, pixels


def pixels_of(image):
    """An image (height, width, channels) from the top row on."""
    width, height = image.size
    pixels = numpy.empty(width * height * image.channels, numpy.float32)
    image.pixels.foreach_get(pixels)
    # Blender has the lowest row first.
    return pixels.reshape(height, width, image.channels)[::-1]


def brush(kept, pixels):
    """The brush of a stroke."""
    made = rl.Brush(native.context(), kept["settings"], **kept["options"])
    if pixels is not None:
        made.set_stamp(pixels, kept.get("stamp_settings"))
    for name, points in kept.get("curves", {}).items():
        made.set_curve(name, points)
    return made


def bends(kept):
    """Whether the stroke needs vector displacement."""
    return kept["options"]["action"] == "sculpt" and kept["options"]["mode"] in BENDING


def keep(target, kept, pixels, pose, points, revision):
    """Keeps a stroke that was made in an object, with the pixels of its stamp, since the image may change or go, and the
    points of the pose that the object was drawn on, None for its mesh's own."""
    kept["stamp_key"] = None if pixels is None else keep_array(target, *pack_array(pixels))
    kept["pose_key"] = None if pose is None else keep_array(target, *pack_array(pose))
    rows = [[float(number) for number in row] for row in points]
    target.relievo.strokes.add().text = json.dumps({**kept, "revision": revision, "points": rows})


def pack_array(values, prefix=ARRAYS):
    """An array of numbers as an object keeps it: the name it has there, by what it is, and its bytes."""
    values = numpy.ascontiguousarray(values, numpy.float32)
    shape = (*values.shape, *(1 for _ in range(3 - values.ndim)))
    data = SHAPE.pack(*shape) + zlib.compress(values.tobytes(), 1)
    return f"{prefix}{zlib.crc32(data):08x}", data


def keep_array(target, name, data):
    """Keeps a packed array in an object, once however often it is used, and returns its name."""
    if name not in target:
        target[name] = data
    return name


def kept_array(target, name):
    """An array that an object keeps, of three dimensions; ValueError if it is gone or damaged."""
    data = target.get(name)
    if not isinstance(data, bytes) or len(data) < SHAPE.size:
        raise ValueError(f"{name} is gone")
    shape = SHAPE.unpack_from(data)
    size = 4 * shape[0] * shape[1] * shape[2]
    unpack = zlib.decompressobj()
    try:
        values = unpack.decompress(data[SHAPE.size :], size)
    except zlib.error as failure:
        raise ValueError(f"{name} is damaged: {failure}") from None
    if len(values) != size or not size:
        raise ValueError(f"{name} is damaged")
    return numpy.frombuffer(values, numpy.float32).reshape(shape)


def stamp_of(target, kept):
    """The pixels of the stamp of a stroke, None for none; ValueError if they are gone."""
    name = kept.get("stamp")
    if not name:
        return None
    if kept.get("stamp_key"):
        return kept_array(target, kept["stamp_key"])
    image = bpy.data.images.get(name)
    if image is None or not image.size[0]:
        raise ValueError(f"its stamp {name} is gone")
    return pixels_of(image)


def pose_of(target, kept):
    """The points of the pose that a stroke was drawn on, None for the mesh's own; ValueError if they are gone."""
    if not kept.get("pose_key"):
        return None
    points = kept_array(target, kept["pose_key"]).reshape(-1, 3)
    if len(points) != len(target.data.vertices) or not numpy.isfinite(points).all():
        raise ValueError("its pose has other points")
    return points


def forget(target):
    """Lets all strokes of an object go."""
    for name in [name for name in target.keys() if name.startswith(ARRAYS)]:
        del target[name]
    target.relievo.strokes.clear()


def read(entry):
    """A stroke that an object keeps; ValueError if it cannot be understood."""
    try:
        kept = json.loads(entry.text)
        check(kept)
        if "matrix" in kept and numpy.asarray(kept["matrix"], numpy.float64).shape != (4, 4):
            raise ValueError("no place")
        checked_layers(kept.get("layers", []))
    except (KeyError, TypeError, AttributeError):
        raise ValueError("a value is missing or of another kind") from None
    return kept


def check(kept):
    """Checks the brush and the points of a stroke that was kept; ValueError, KeyError, TypeError or AttributeError if they
    cannot be understood."""
    places = numpy.asarray(kept["points"], numpy.float64)
    if not isinstance(kept["options"], dict) or not isinstance(kept["settings"], dict):
        raise ValueError("no brush")
    if places.ndim != 2 or places.shape[1] != 5 or not len(places):
        raise ValueError("no points")
    kept["options"]["action"], kept["options"]["mode"]


def checked_layers(layers):
    """Layers that were kept; ValueError if they cannot be understood."""
    kinds = {kind.name.lower() for kind in rl.abi.RlvLayerKind}
    blends = {blend.name.lower() for blend in rl.abi.RlvBlend}
    try:
        for layer in layers:
            if not isinstance(layer["name"], str) or layer["kind"] not in kinds or layer["blend"] not in blends:
                raise ValueError("an unknown layer")
            layer["opacity"], layer["is_visible"] = float(layer["opacity"]), int(layer["is_visible"])
            layer["is_active"] = int(layer["is_active"])
    except (KeyError, TypeError):
        raise ValueError("a value is missing or of another kind") from None
    return layers


def read_all(target):
    """The strokes of an object, each as what was kept, the pixels of its stamp and the points of its pose, and how many
    cannot be used."""
    found, lost = [], 0
    for entry in target.relievo.strokes:
        try:
            kept = read(entry)
            found.append((kept, stamp_of(target, kept), pose_of(target, kept)))
        except ValueError as failure:
            lost += 1
            print(f"Relievo: a stroke of {target.name} cannot be made again: {said(failure)}")
    return found, lost


def moved_points(kept, target):
    """The points of a stroke where they are now that the object may have moved."""
    points = numpy.asarray(kept["points"], numpy.float64)
    if "matrix" in kept:
        way = mesh.matrix_of(target.matrix_world) @ numpy.linalg.inv(numpy.asarray(kept["matrix"], numpy.float64))
        places = points[:, :3] @ way[:3, :3].T + way[:3, 3]
        points = numpy.column_stack([places, points[:, 3:]])
    return points
