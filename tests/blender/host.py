"""What the tests of the add-on share: enabling it, objects, and strokes. They run in PyPI's bpy and in Blender's own
Python (`blender --background --python FILE`)."""

import os
import subprocess
import sys
import tempfile
import types
import unittest
from pathlib import Path

import bpy
import numpy

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "tests" / "python"))

import shapes


def enable():
    """Enables the add-on that BLENDER_USER_SCRIPTS has."""
    bpy.ops.preferences.addon_enable(module="relievo")
    assert "relievo" in bpy.context.preferences.addons, "the add-on is not there"
    import relievo

    problem = relievo.core.native.problem()
    assert problem is None, problem
    return relievo


def empty():
    """Opens an empty file with the preferences of the factory and enables the add-on anew."""
    if "relievo" in bpy.context.preferences.addons:
        # Its preferences go with it, and Blender's other add-ons, which take long to start, stay.
        bpy.ops.preferences.addon_disable(module="relievo")
        bpy.context.preferences.edit.undo_steps = 32
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    else:
        bpy.ops.wm.read_factory_settings(use_empty=True)
    return enable()


def add(name, points, corners, size, uvs=None):
    """An object of faces with `size` corners."""
    mesh = bpy.data.meshes.new(name)
    faces = numpy.asarray(corners).reshape(-1, size).tolist()
    mesh.from_pydata(points.tolist(), [], faces)
    if uvs is not None:
        layer = mesh.uv_layers.new(name="UVMap")
        layer.data.foreach_set("uv", uvs[numpy.asarray(corners)].astype(numpy.float32).ravel())
    made = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(made)
    bpy.context.view_layer.update()
    return made


def field(cells=4, name="field"):
    points, corners, uvs = shapes.grid(cells)
    return add(name, points, corners, 4, uvs)


def ball(radius=0.3, name="ball", rings=16):
    points, corners = shapes.ball(radius, rings=rings)
    return add(name, points, corners, 3)


def select(active, *others):
    for other in bpy.context.view_layer.objects:
        other.select_set(False)
    for other in [active, *others]:
        other.select_set(True)
    bpy.context.view_layer.objects.active = active


def draw(active, points, action="SCULPT", **settings):
    """Draws a stroke by the operator."""
    import json

    select(active)
    group = bpy.context.scene.relievo.brush
    for name, value in settings.items():
        setattr(group if hasattr(group, name) else group.settings, name, value)
    return bpy.ops.relievo.stroke(action=action, points=json.dumps(points))


def positions(target):
    found = numpy.empty((len(target.data.vertices), 3), numpy.float32)
    target.data.vertices.foreach_get("co", found.ravel())
    return found


def operator(kind, /, **properties):
    """What an operator's steps need of it, for driving them as a window does."""
    made = types.SimpleNamespace(told=[], as_keywords=lambda **_: properties, bl_label=kind.bl_label, effect="NORMAL")
    vars(made).update(properties)
    made.warn, made.report = made.told.extend, lambda _kinds, text: made.told.append(text)
    for name in ("begin", "edit", "given", "keep", "make", "opening", "prepare", "press", "tell", "text"):
        if hasattr(kind, name):
            setattr(made, name, types.MethodType(getattr(kind, name), made))
    made.change, made.stamp, made.is_drawn = getattr(kind, "change", None), None, False
    return kind.steps(made, bpy.context)


def evaluated(target):
    """The points of an object as its modifiers and the handlers have them."""
    made = target.evaluated_get(bpy.context.evaluated_depsgraph_get())
    posed = made.to_mesh()
    found = numpy.empty((len(posed.vertices), 3), numpy.float32)
    posed.vertices.foreach_get("co", found.ravel())
    made.to_mesh_clear()
    return found


def digest(relievo, target):
    """What the detail of an object comes to."""
    state = relievo.data.state.of(target)
    tiles = numpy.repeat(numpy.arange(state.detail.info.tile_count), 9)
    uvs = numpy.tile([[u, v] for u in (0.1, 0.3, 0.5) for v in (0.1, 0.3, 0.5)], (len(tiles) // 9, 1))
    found = state.detail.evaluate(tiles, uvs, ["positions", "colors"])
    return found["positions"].tobytes() + found["colors"].tobytes()


def command(code):
    """Returns the command that runs code in another process of this host."""
    if Path(sys.executable).name.startswith("python") and not bpy.app.binary_path:
        return [sys.executable, "-c", code]
    return [bpy.app.binary_path, "--background", "--factory-startup", "--python-expr", code]


def run(code, wanted="", **environment):
    """Runs code in another process of this host; what it prints must have `wanted`."""
    environment = {**os.environ, **{name: str(value) for name, value in environment.items()}}
    outcome = subprocess.run(command(code), env=environment, capture_output=True, text=True)
    said = outcome.stdout + outcome.stderr
    assert wanted in said, said
    return said


def arguments():
    """Returns the arguments of a script. Those of Blender itself come before `--`."""
    return sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []


def main():
    """Runs the tests of the file that is run."""
    outcome = unittest.main(module="__main__", argv=[sys.argv[0], *arguments()], exit=False)
    end(outcome.result.wasSuccessful())


def end(is_good):
    """Ends the process where tests failed: Blender's own interpreter does not end with the status of SystemExit."""
    sys.stdout.flush()
    sys.stderr.flush()
    if not is_good:
        os._exit(1)


def folder():
    return tempfile.TemporaryDirectory()
