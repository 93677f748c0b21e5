# SPDX-License-Identifier: GPL-3.0-or-later
"""Playback of baked frames by the add-on itself, beside Blender's Mesh Cache modifier: at every change of the frame the
points of the result are those of the cache, between frames on the line from one to the next.

A handler of `frame_change_post` may write to what the file owns: Blender evaluates once more what it touched. It runs on
the thread that renders, though, so while a window is open nothing is written unless the interface is locked (Render >
Lock Interface), and the render shows what the Mesh Cache modifier or the last frame has.
"""

import os

import bpy
import numpy
from bpy.app.handlers import persistent

from ..core import settings
from ..core.error import said
from . import cache, mesh, state

_open = {}
_is_rendering = False


def frames_of(path):
    """The frames of a cache file: the number of the first, and an array (frames, points, 3) that is read on demand."""
    path = bpy.path.abspath(path)
    stamp = os.stat(path).st_mtime_ns, os.path.getsize(path)
    if path not in _open or _open[path][0] != stamp:
        with open(path, "rb") as file:
            head = file.read(cache.HEADER.size)
        if len(head) < cache.HEADER.size:
            raise ValueError("it is cut")
        name, version, points, first, _step, count = cache.HEADER.unpack(head)
        if name != b"POINTCACHE2\0" or version != 1 or points < 1 or count < 1:
            raise ValueError("it is no point cache")
        if stamp[1] < cache.HEADER.size + 12 * points * count:
            raise ValueError("it is cut")
        _open[path] = stamp, first, numpy.memmap(path, "<f4", "r", cache.HEADER.size, (count, points, 3))
    return _open[path][1:]


def points_at(path, frame):
    """The points of a cache at a frame, which may lie between two; before the first and after the last it rests."""
    first, frames = frames_of(path)
    place = min(max(frame - first, 0.0), len(frames) - 1.0)
    before = int(place)
    share = place - before
    if share == 0.0:
        return numpy.ascontiguousarray(frames[before], numpy.float32)
    return ((1.0 - share) * frames[before] + share * frames[before + 1]).astype(numpy.float32)


def path_of(target):
    """Returns the path of an object's cache, "" if it has none."""
    return target.relievo.cache and (cache.attached(target.relievo.result) or target.relievo.cache)


def show(target, frame):
    """Shows a frame of the cache of an object, if the add-on is to do so."""
    options = target.relievo
    result = options.result
    if options.playback != "HANDLER" or not options.cache or not state.is_used(result):
        return
    try:
        points = points_at(path_of(target), frame)
    except (OSError, ValueError) as failure:
        print(f"Relievo: the cache of {target.name} cannot be played: {said(failure)}")
        return
    if len(points) != len(result.data.vertices):
        print(f"Relievo: the cache of {target.name} has other points than its result; bake it again")
        return
    mesh.set_points(result.data, points)


def may_write(scene):
    """Whether meshes may be written to at a change of the frame: not under a render that shares them with a window."""
    return not _is_rendering or bpy.app.background or scene.render.use_lock_interface


@persistent
def frame_changed(scene, *_):
    if not may_write(scene):
        return
    for target in scene.objects:
        if target.type == "MESH" and target.relievo.cache and target.library is None:
            show(target, scene.frame_current_final)


@persistent
def render_begins(*_):
    global _is_rendering
    _is_rendering = True


@persistent
def render_ends(*_):
    global _is_rendering
    _is_rendering = False


def begin(target, path):
    """Plays a cache from now on, by what the object asks for."""
    cache.stop(target.relievo.result)
    target.relievo.cache = cache.relative(path)
    changed(target)


def changed(target):
    """Goes over to what the object asks for."""
    options, path = target.relievo, path_of(target)
    if not path or not state.is_used(options.result):
        return
    if options.playback == "HANDLER":
        cache.attach(options.result, bpy.path.abspath(path))
        show(target, bpy.context.scene.frame_current_final)
    else:
        try:
            first, _ = frames_of(path)
        except (OSError, ValueError) as failure:
            print(f"Relievo: the cache of {target.name} cannot be played: {said(failure)}")
            return
        cache.play(options.result, bpy.path.abspath(path), first)


def pause(target):
    """Shows the detail itself, and no cache. Returns what `resume` needs."""
    kept, target.relievo.cache = path_of(target), ""
    cache.stop(target.relievo.result)
    return kept


def resume(target, kept):
    """Plays again what was paused."""
    if kept:
        target.relievo.cache = kept
        changed(target)


def settings_changed(options, _context):
    """Goes over to the playback that an object asks for."""
    changed(options.id_data)


def register():
    settings.listeners["playback"].append(settings_changed)


def unregister():
    settings.listeners["playback"].remove(settings_changed)
