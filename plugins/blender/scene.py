# SPDX-License-Identifier: GPL-3.0-or-later
"""Export of a scene file for headless runs with `relievo run`: cages as OBJ with their creases, the active object with
its strokes or its document, the other selected objects as colliders that move as they do in Blender."""

import json
import math
import os
import re

import bpy
import librelievo as rl
from bpy_extras.io_utils import ExportHelper

from . import mesh, settings, state


def name_of(target):
    """A name that scene files take."""
    return re.sub(r"\W", "_", target.name)


def text(value):
    """A value as TOML has it."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(text(item) for item in value)}]"
    if isinstance(value, float):
        return repr(round(value, 9))
    return json.dumps(value, ensure_ascii=False) if isinstance(value, str) else str(value)


def placement(matrix):
    """Translation, rotation about x, y and z in degrees, and scale."""
    place, turn, scale = matrix.decompose()
    angles = turn.to_euler("XYZ")
    return list(place), [math.degrees(angle) for angle in angles], list(scale)


def keys(scene, targets, first, last):
    """Where objects are in every frame: rows of keyframes each, angles without jumps."""
    rows = {target.name: [] for target in targets}
    now, before = scene.frame_current, {}
    fps = scene.render.fps / scene.render.fps_base
    for frame in range(first, last + 1):
        scene.frame_set(frame)
        for target in targets:
            place, turn, scale = target.matrix_world.decompose()
            angles = turn.to_euler("XYZ", before[target.name]) if target.name in before else turn.to_euler("XYZ")
            before[target.name] = angles
            degrees = [math.degrees(angle) for angle in angles]
            entry = {"time": (frame - first) / fps, "translation": list(place), "rotation": degrees, "scale": list(scale)}
            rows[target.name].append(entry)
    scene.frame_set(now)
    return rows


def table(values):
    return "{ " + ", ".join(f"{key} = {text(value)}" for key, value in values.items()) + " }"


def stroke_lines(target, entry):
    """A stroke that was kept, as `[[strokes]]`."""
    kept = json.loads(entry.text)
    options, values = kept["options"], kept["settings"]
    sculpt = options["action"] == "sculpt"
    lines = ["", "[[strokes]]", f"object = {text(name_of(target))}"]
    lines.append(f"{'sculpt' if sculpt else 'paint'} = {text(options['mode'])}")
    lines.append(f"falloff = {text(options['falloff'])}")
    if sculpt:
        lines.append(f"height = {text(options['height'])}")
    else:
        lines.append(f"colour = {text(options['color'][:3])}")
    for parameter in settings.RelievoBrushSettings.table:
        value = values[parameter.name]
        if value == parameter.value:
            continue
        degrees = parameter.unit == "rad"
        lines.append(f"{parameter.name} = {text(math.degrees(value) if degrees else value)}")
    lines.append("points = [")
    for row in kept["points"]:
        point = {"position": row[:3], "pressure": row[3]}
        if row[4] >= 0:
            point["time"] = row[4]
        lines.append(f"    {table(point)},")
    return [*lines, "]"]


class RELIEVO_OT_export_scene(bpy.types.Operator, ExportHelper):
    """Write a scene file that `relievo run` renders without Blender"""

    bl_idname = "relievo.export_scene"
    bl_label = "Export Relievo scene"
    filename_ext = ".toml"

    start: bpy.props.EnumProperty(
        name="Start from",
        items=[
            ("STROKES", "Strokes", "The strokes that were made, to be made again"),
            ("DOCUMENT", "Document", "The detail as it is, imprints included"),
        ],
    )

    @classmethod
    def poll(cls, context):
        return state.has_detail(state.source_of(context.active_object))

    def execute(self, context):
        try:
            self.write(context)
        except (state.Refused, rl.RelievoError, OSError) as failure:
            self.report({"ERROR"}, str(failure))
            return {"CANCELLED"}
        return {"FINISHED"}

    def write(self, context):
        scene, target = context.scene, state.source_of(context.active_object)
        made = state.of(target)
        path = bpy.path.abspath(self.filepath)
        base, stem = os.path.dirname(path), os.path.splitext(os.path.basename(path))[0]
        pressers = [
            other
            for other in context.selected_objects
            if other.type == "MESH" and other != target and other.relievo.source is None
        ]
        fps = scene.render.fps / scene.render.fps_base
        lines = ["# Written by the Relievo add-on of Blender. Run it with `relievo run`.", "version = 1"]
        lines += [f"fps = {text(fps)}", 'up = "z"']
        for other in [target, *pressers]:
            file = f"{stem}_{name_of(other)}.obj"
            with mesh.to_native(other.data) as native_mesh:
                native_mesh.write(os.path.join(base, file))
            lines += ["", f"[meshes.{name_of(other)}]", f"file = {text(file)}"]
        options = target.relievo
        triangles = options.kind == "TRIANGLES"
        lines += ["", f"[surfaces.{name_of(target)}]", f"mesh = {text(name_of(target))}"]
        lines.append(f"kind = {text('triangles' if triangles else 'catmull_clark')}")
        for other in [target, *pressers]:
            place, turn, scale = placement(other.matrix_world)
            lines += ["", f"[objects.{name_of(other)}]"]
            lines.append(f"{'surface' if other == target else 'mesh'} = {text(name_of(other))}")
            lines += [f"translation = {text(place)}", f"rotation = {text(turn)}", f"scale = {text(scale)}"]
            if other == target:
                size = {"segments": int(options.segments)} if triangles else {"tile_size": int(options.tile_size)}
                if not triangles:
                    size["paint_size"] = int(options.tile_size)
                lines.append(f"detail = {table(size)}")
                lines.append("colour = [0.8, 0.8, 0.8]")
                if self.start == "DOCUMENT":
                    packed, _history = made.data()
                    with open(os.path.join(base, f"{stem}.relievo"), "wb") as file:
                        file.write(packed)
                    lines.append(f"document = {text(f'{stem}.relievo')}")
        if pressers:
            self.colliders(scene, target, pressers, lines)
        if self.start == "STROKES":
            for entry in options.strokes:
                lines += stroke_lines(target, entry)
        frames = scene.frame_end - scene.frame_start + 1 if pressers else 1
        lines += ["", "[output]", f"frames = {frames}", ""]
        with open(f"{path}.part", "w", encoding="utf-8") as file:
            file.write("\n".join(lines))
        os.replace(f"{path}.part", path)

    def colliders(self, scene, target, pressers, lines):
        """Colliders with a keyframe per frame, and how they imprint."""
        rows = keys(scene, pressers, scene.frame_start, scene.frame_end)
        for other in pressers:
            lines += ["", f"[bodies.{name_of(other)}]", "keyframes = ["]
            lines += [f"    {table(row)}," for row in rows[other.name]]
            lines += ["]", "", f"[colliders.{name_of(other)}]", f"into = [{text(name_of(target))}]"]
        lines += ["", "[imprints]"]
        group = scene.relievo.imprint
        for parameter in group.table:
            value = getattr(group, parameter.name)
            if value != parameter.value:
                value = math.degrees(value) if parameter.unit == "rad" else value
                lines.append(f"{parameter.name} = {text(value)}")


def register():
    bpy.utils.register_class(RELIEVO_OT_export_scene)


def unregister():
    bpy.utils.unregister_class(RELIEVO_OT_export_scene)
