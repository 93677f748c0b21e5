# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked caches: positions of every frame as PC2, which Blender's Mesh Cache modifier plays without the add-on, and
numbered images in a material. Paths are relative to the .blend file.

A bake is named FILE.OBJECT.ID.NUMBER: the .blend file, the object, an id that no other object of the file has, and a
number that no earlier bake has. So a bake never writes over another one, and undo finds the frames of the earlier one.
A bake belongs to an object if file and id are its own and no other object plays it; only then its files are removed.
"""

import os
import re
import struct
import uuid
import zlib

import bpy
import numpy

from ..core import preferences
from ..core.error import Refused

# name, version, points, first frame, frames per sample, samples
HEADER = struct.Struct("<12siiffi")
# The modifier that has the path of a cache.
MODIFIER = "Relievo cache"
# Bytes of the names of file and object in the name of a bake.
LONGEST = 80
# What follows FILE.OBJECT.ID. in the name of a bake.
NUMBER = re.compile(r"(\d+)(?!\d)")


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


def clean(name):
    """Returns a name with nothing that a path or the name of a bake gives a meaning to."""
    return re.sub(r"[^\w-]", "_", name).encode()[:LONGEST].decode(errors="ignore")


def file_name():
    """Returns what the bakes of this .blend file begin with. Files of the same name may share an absolute folder."""
    path = bpy.data.filepath
    if not path:
        return "untitled"
    name = clean(os.path.splitext(os.path.basename(path))[0])
    is_beside = preferences.get().cache_folder.startswith("//")
    return name if is_beside else f"{name}-{zlib.crc32(os.path.dirname(os.path.abspath(path)).encode()):08x}"


def new(target):
    """Returns the path of a new bake of an object, to which an ending is added. An object whose id another one has too,
    since one is a copy, gets an id of its own."""
    options, there = target.relievo, folder()
    ids = [other.relievo.cache_id for other in bpy.data.objects if other != target]
    if not options.cache_id or options.cache_id in ids:
        options.cache_id = uuid.uuid4().hex[:8]
    numbers = [int(found[2]) for found in map(parts, os.listdir(there)) if found and found[1] == options.cache_id]
    name = f"{file_name()}.{clean(target.name)}.{options.cache_id}.{max(numbers, default=0) + 1:03d}"
    return os.path.join(there, name)


def parts(name):
    """Returns file, id and number of the name of a bake, or None for other names."""
    found = name.split(".", 3)
    number = NUMBER.match(found[3]) if len(found) == 4 else None
    return (found[0], found[2], number[1]) if number and re.fullmatch(r"[0-9a-f]{8}", found[2]) else None


def bake_of(name):
    """Returns what the names of all files of a bake have in common, or None for other names: images are a file a frame."""
    return re.sub(r"_-?\d+\.exr$", ".exr", name) if parts(name) else None


def is_own(target, path):
    """Returns whether the bake at a path belongs to an object, so that its files may be changed and removed."""
    path = os.path.normpath(bpy.path.abspath(path))
    found, there = parts(os.path.basename(path)), os.path.normpath(bpy.path.abspath(preferences.get().cache_folder))
    if found is None or found[:2] != (file_name(), target.relievo.cache_id) or os.path.dirname(path) != there:
        return False
    return not any(path == other for holder, other in played() if holder != target)


def played():
    """Yields the objects that play caches, with the normal absolute paths of these."""
    for target in bpy.data.objects:
        options = target.relievo
        for path, result in ((options.cache, options.result), (options.fluid.cache, options.fluid.result)):
            if path:
                yield target, os.path.normpath(bpy.path.abspath(attached(result) or path))


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


def attach(result, path):
    """Gives a result the path of its cache, in a Mesh Cache modifier that is switched off. Blender brings the paths of
    modifiers along when the file is saved elsewhere or the object is appended, but not those of add-ons' properties."""
    modifier = result.modifiers.get(MODIFIER) or result.modifiers.new(MODIFIER, "MESH_CACHE")
    modifier.show_viewport = modifier.show_render = False
    modifier.cache_format = "PC2"
    modifier.filepath = relative(path)
    return modifier


def attached(result):
    """Returns the path that a result has of its cache, "" if it has none."""
    modifier = result.modifiers.get(MODIFIER) if result else None
    return modifier.filepath if modifier is not None else ""


def attach_all():
    """Attaches the paths of caches that an earlier version of the add-on has baked."""
    for target in bpy.data.objects:
        options = target.relievo
        for path, result in ((options.cache, options.result), (options.fluid.cache, options.fluid.result)):
            if path and result is not None and result.library is None and not attached(result):
                attach(result, bpy.path.abspath(path))


def play(result, path, first):
    """Plays a PC2 file on a result object."""
    modifier = attach(result, path)
    modifier.show_viewport = modifier.show_render = True
    modifier.interpolation = "NONE"
    # The modifier counts samples and does not look at the file's first frame.
    modifier.frame_start = first
    modifier.time_mode, modifier.play_mode = "FRAME", "SCENE"
    modifier.forward_axis, modifier.up_axis = "POS_Y", "POS_Z"


def stop(result):
    """Shows the detail itself again, and no cache."""
    modifier = result.modifiers.get(MODIFIER) if result else None
    if modifier is not None:
        result.modifiers.remove(modifier)
