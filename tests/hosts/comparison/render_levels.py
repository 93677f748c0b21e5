"""Renders levels that the add-on makes by Cycles, in the scenes of `levels.toml`:
`render_levels.py FILE.rlvpm EDITS.toml FOLDER`. The folder has `original`, `level`, `ball` and `result`, each with a script
that `relievo scene export blender` wrote and gets `cycles.exr`: the finest level, the one of the edit without and with its
ball, and the finest level after it. The add-on reads the file and makes the edit by its operators."""

import json
import math
import sys
import tomllib
from pathlib import Path

import bpy

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]
sys.path += [str(HERE), str(ROOT / "plugins"), str(ROOT / "plugins" / "python")]

import blender as addon
import render_cycles


def edit(target, entry):
    """Makes an edit of the list by the operator, at its level."""
    options = target.relievo.progressive
    options.measure, options.triangles = "TRIANGLES", entry["faces"]
    (handle,) = entry["handle"]
    anchors = [[*held["center"], held["radius"]] for held in entry["anchor"]]
    bpy.ops.relievo.levels_edit(
        point=handle["center"],
        radius=handle["radius"],
        falloff=handle["falloff"].upper(),
        move=handle["translation"],
        axis=handle["axis"],
        angle=math.radians(handle["angle"]),
        anchors=json.dumps(anchors),
    )


def showing(level):
    """Puts a mesh in the place of the one that the script brought."""

    def change(scene):
        shown = next(thing for thing in scene.objects if thing.name.startswith("level"))
        level.materials.clear()
        level.materials.append(shown.data.materials[0])
        level.polygons.foreach_set("use_smooth", [False] * len(level.polygons))
        shown.data = level

    return change


file, edits, folder = (Path(name).resolve() for name in render_cycles.arguments())
bpy.ops.wm.read_factory_settings(use_empty=True)
addon.register()
bpy.ops.relievo.levels_read(filepath=str(file))
target = bpy.context.active_object
levels = {"original": target.data.copy()}
edit(target, tomllib.loads(edits.read_text())["edit"][0])
levels["level"] = levels["ball"] = target.data.copy()
target.relievo.progressive.measure = "RATIO"
levels["result"] = target.data.copy()
for name, level in levels.items():
    render_cycles.render(str(folder / name / "scene-000000.py"), str(folder / name / "cycles.exr"), showing(level))
addon.unregister()
