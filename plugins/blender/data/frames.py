# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of a fluid: a folder with the particles of every frame as the library's .rlvfluid and, where they were made, the
meshes of its surface as NumPy's .npz; and the object that shows them. A frame appears under its name when it is whole, so
that what was simulated before a cancel plays."""

import os
import re
import shutil

import bpy
import librelievo as rl
import numpy
from bpy.app.handlers import persistent

from ..core import native, settings
from ..core.error import said
from . import cache, mesh, playback, state

# What files of frames begin with, by what they have, and their extensions.
PARTICLES, SURFACE, FOAM = "particles", "surface", "foam"
EXTENSIONS = {PARTICLES: "rlvfluid", SURFACE: "npz", FOAM: "rlvfluid"}
# What the name of a file with all that a simulation goes on from begins with; the number of its frame follows.
STATE = "state"
# Version of the files of surfaces; newer ones are refused.
FORMAT = 1


def new_folder(domain):
    """Makes a folder for new frames of a domain. Returns its path."""
    path = f"{cache.new(domain)}_fluid"
    os.makedirs(path)
    return path


def folder_of(domain):
    """Returns the absolute path of the folder of a domain's frames, "" if it has none."""
    options = domain.relievo.fluid
    return options.cache and bpy.path.abspath(cache.attached(options.result) or options.cache)


def begin(domain, folder):
    """Shows the frames of a folder from now on."""
    options = domain.relievo.fluid
    options.cache = cache.relative(folder)
    cache.attach(options.result, folder)


def path_of(folder, kind, frame):
    return os.path.join(bpy.path.abspath(folder), f"{kind}_{frame:06d}.{EXTENSIONS[kind]}")


def clear(folder):
    """Removes all frames that are there, and the folder if nothing else is in it."""
    for name in os.listdir(folder):
        if re.fullmatch(rf"({PARTICLES}|{SURFACE}|{FOAM}|{STATE})_-?\d+\.(npz|rlvfluid|rlvstate)", name):
            os.remove(os.path.join(folder, name))
    if not os.listdir(folder):
        os.rmdir(folder)


def state_path(folder, frame):
    """Returns the path of what a simulation goes on from after a frame."""
    return os.path.join(bpy.path.abspath(folder), f"{STATE}_{frame:06d}.rlvstate")


def has_state(folder, frame):
    """Returns whether a simulation can go on after a frame."""
    return os.path.exists(state_path(folder, frame))


def write_state(folder, frame, state):
    """Writes what a simulation goes on from after a frame, and removes that of other frames. Raises OSError."""
    path = state_path(folder, frame)
    with open(f"{path}.part", "wb") as file:
        file.write(state)
    os.replace(f"{path}.part", path)
    for name in os.listdir(folder):
        if name.startswith(f"{STATE}_") and name != os.path.basename(path):
            os.remove(os.path.join(folder, name))


def has_surfaces(folder):
    """Returns whether a folder has meshes of surfaces."""
    return any(name.startswith(f"{SURFACE}_") for name in os.listdir(folder))


def share(path, other):
    """Gives a frame a second name in another folder; without Blender's data. Frames are replaced, never changed."""
    try:
        os.link(path, other)
    except OSError:
        shutil.copyfile(path, other)


def write(path, **arrays):
    """Writes a frame of a surface, whole or not at all; without Blender's data."""
    part = f"{path}.part"
    try:
        with open(part, "wb") as file:
            numpy.savez(file, format=numpy.uint32(FORMAT), **arrays)
        os.replace(part, path)
    finally:
        if os.path.exists(part):
            os.remove(part)


def read(path, *names):
    """Arrays of a frame of a surface. Raises ValueError where it is damaged or of a newer version."""
    try:
        with open(path, "rb") as file, numpy.load(file, allow_pickle=False) as kept:
            if int(kept["format"]) > FORMAT:
                raise ValueError("it is of a newer add-on; update it")
            found = [kept[name] for name in names]
    except (KeyError, EOFError, TypeError) as failure:
        raise ValueError(f"it is damaged: {said(failure)}") from None
    except Exception as failure:
        # A file that is no .zip any more raises what modules of Python please to.
        if isinstance(failure, (OSError, ValueError)):
            raise
        raise ValueError(f"it is damaged: {said(failure)}") from None
    return found


def particles(path):
    """Places and velocities of a frame's particles; without Blender's data."""
    with rl.Particles.read(native.context(), path) as kept:
        points, velocities = kept.points(), kept.channels().get("velocity")
    if velocities is None or velocities.shape != points.shape:
        raise ValueError("its particles have no velocities")
    return points, velocities


def surface(path):
    """Points, triangles and velocities of a frame's mesh."""
    points, triangles, velocities = read(path, "points", "triangles", "velocities")
    for name, values in (("points", points), ("velocities", velocities)):
        if values.dtype != numpy.float32 or values.shape != (len(points), 3) or not numpy.isfinite(values).all():
            raise ValueError(f"its {name} are no finite vectors")
    if triangles.dtype != numpy.uint32 or triangles.ndim != 2 or triangles.shape[1] != 3:
        raise ValueError("its triangles are not rows of three 32-bit indices")
    if triangles.size and triangles.max() >= len(points):
        raise ValueError("a triangle has a point that is not there")
    return points, triangles, velocities


def options_of(domain):
    """How a domain's surface is made: the options of an isosurface, and those of its mesh. Without Blender's data from
    here on."""
    options = domain.relievo.fluid
    radius = 0.5 * options.spacing
    how = {"cell": options.cell * radius, "iterations": options.smoothing}
    return {"function": options.function.lower(), "radius": radius}, how


def meshed(points, velocities, options, how, progress=None):
    """Points, triangles and velocities of the surface of particles; without Blender's data."""
    with rl.Isosurface(native.context(), points, velocities, **options) as made:
        with made.mesh(progress=progress, **how) as triangles:
            moved = triangles.attribute("velocity").values if len(points) else numpy.empty((0, 3), numpy.float32)
            return triangles.points(), triangles.triangles(), moved


def put(result, points, triangles, velocities):
    """Puts a frame into a result; `triangles` are None for particles."""
    data = result.data
    data.clear_geometry()
    if triangles is None:
        data.vertices.add(len(points))
    else:
        mesh.Filling(triangles.reshape(-1).astype(numpy.int32), len(points)).fill(data)
    mesh.set_points(data, numpy.ascontiguousarray(points))
    attribute = data.attributes.get("velocity") or data.attributes.new("velocity", "FLOAT_VECTOR", "POINT")
    attribute.data.foreach_set("vector", numpy.ascontiguousarray(velocities).reshape(-1))


def result_of(domain):
    """The object that shows a domain's fluid, made if it is not there. What is in it is in the world's space."""
    options = domain.relievo.fluid
    if not shows(domain):
        name = f"{domain.name} fluid"
        options.result = bpy.data.objects.new(name, bpy.data.meshes.new(name))
        for collection in domain.users_collection or [bpy.context.scene.collection]:
            collection.objects.link(options.result)
        domain.display_type = "WIRE"
        domain.hide_render = True
    options.result.relievo.fluid.domain = domain
    return options.result


def shows(domain):
    """Returns whether a domain has a result. That of a copy may still be the one of the original."""
    result = domain.relievo.fluid.result
    return state.is_used(result) and result.relievo.fluid.domain in (None, domain)


def show(domain, frame):
    """Shows a frame of a domain, the first or last one before and after all. Says what is wrong, "" if nothing is."""
    options = domain.relievo.fluid
    folder = folder_of(domain)
    if not folder or not shows(domain):
        return ""
    frame = min(max(frame, options.first), options.last)
    try:
        meshes = path_of(folder, SURFACE, frame)
        if options.show == "SURFACE" and os.path.exists(meshes):
            put(options.result, *surface(meshes))
            return ""
        points, velocities = particles(path_of(folder, PARTICLES, frame))
        if options.show == "SURFACE":
            put(options.result, *meshed(points, velocities, *options_of(domain)))
        else:
            put(options.result, points, None, velocities)
    except (OSError, ValueError, rl.RelievoError) as failure:
        return f"Frame {frame} of {domain.name} cannot be shown: {said(failure)}"
    return ""


def domains(objects):
    """Those of the objects that are domains of fluids and have frames."""
    return [one for one in objects if one.relievo.fluid.role == "DOMAIN" and one.relievo.fluid.cache]


@persistent
def frame_changed(scene, *_):
    if not playback.may_write(scene):
        return
    for domain in domains(scene.objects):
        trouble = show(domain, scene.frame_current) if domain.library is None else ""
        if trouble:
            print(f"Relievo: {trouble}")


def settings_changed(options, context):
    """Shows the present frame of a domain as its settings are now."""
    trouble = show(options.id_data, context.scene.frame_current) if options.role == "DOMAIN" else ""
    if trouble:
        print(f"Relievo: {trouble}")


def register():
    bpy.app.handlers.frame_change_post.append(frame_changed)
    settings.listeners["fluid"].append(settings_changed)


def unregister():
    settings.listeners["fluid"].remove(settings_changed)
    bpy.app.handlers.frame_change_post.remove(frame_changed)
