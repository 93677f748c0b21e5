# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked caches: positions of every frame as PC2, which Blender's Mesh Cache modifier plays without the add-on, and
numbered images in a material. Paths are kept relative to the .blend file."""

import os
import re
import struct

import bpy
import numpy

from . import preferences
from .error import Refused

# name, version, points, first frame, frames per sample, samples
HEADER = struct.Struct("<12siiffi")


def folder():
    """The folder of caches, made if it is not there."""
    path = preferences.get().cache_folder
    if path.startswith("//") and not bpy.data.filepath:
        raise Refused("Save the .blend file first: caches go to a folder beside it (see the add-on's preferences)")
    full = bpy.path.abspath(path)
    try:
        os.makedirs(full, exist_ok=True)
    except OSError as failure:
        raise Refused(f"The cache folder cannot be made: {failure}") from None
    return full


def path_of(target, extension):
    """A file of the cache for an object."""
    return os.path.join(folder(), re.sub(r"[^\w.-]", "_", target.name) + extension)


def relative(path):
    """A path as the file keeps it."""
    return bpy.path.relpath(path) if bpy.data.filepath else path


class PointCache:
    """A PC2 file that grows by a frame at a time; it appears when it is whole."""

    def __init__(self, path, first):
        self.path, self.first, self.count, self.points = path, first, 0, None
        self.part = f"{path}.part"
        self.file = open(self.part, "wb")
        self.file.write(bytes(HEADER.size))

    def add(self, positions):
        if self.points not in (None, len(positions)):
            raise Refused("The result got other triangles on the way; only subdivision surfaces can be baked to a cache")
        self.points = len(positions)
        self.file.write(numpy.ascontiguousarray(positions, "<f4").tobytes())
        self.count += 1

    def close(self):
        self.file.seek(0)
        self.file.write(HEADER.pack(b"POINTCACHE2\0", 1, self.points or 0, float(self.first), 1.0, self.count))
        self.file.close()
        os.replace(self.part, self.path)

    def abandon(self):
        if not self.file.closed:
            self.file.close()
            os.remove(self.part)


def play(result, path, first):
    """Plays a PC2 file on a result object."""
    modifier = result.modifiers.get("Relievo cache") or result.modifiers.new("Relievo cache", "MESH_CACHE")
    modifier.cache_format = "PC2"
    modifier.filepath = relative(path)
    modifier.interpolation = "NONE"
    # The modifier counts samples and does not look at the file's first frame.
    modifier.frame_start = first
    modifier.time_mode, modifier.play_mode = "FRAME", "SCENE"
    modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"


def stop(result):
    """Shows the detail itself again, and no cache."""
    modifier = result.modifiers.get("Relievo cache") if result else None
    if modifier is not None:
        result.modifiers.remove(modifier)
