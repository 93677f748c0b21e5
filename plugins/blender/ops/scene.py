# SPDX-License-Identifier: GPL-3.0-or-later
"""Export of a scene file for headless runs with `relievo scene run`: cages as OBJ with their creases, the active object with
its strokes or its document, the other selected objects as colliders that move and deform as they do in Blender."""

import json
import math
import os
import re

import bpy
import librelievo as rl
import mathutils
import numpy

from ..core import job, settings
from ..core.error import Refused
from ..data import mesh, state, stroke
from . import imprint, presser


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


def placement(matrix, near=None):
    """A matrix as scene files have it: scale, then shear, then rotation about x, y and z in degrees, then translation.
    Angles are those nearest to `near`."""
    turn, stretch = numpy.linalg.qr(matrix[:3, :3])
    signs = numpy.where(numpy.diag(stretch) < 0, -1.0, 1.0)
    if numpy.prod(signs) * numpy.linalg.det(turn) < 0:
        # A mirroring goes along x.
        signs[0] = -signs[0]
    turn, stretch = turn * signs, stretch * signs[:, None]
    scale = numpy.diag(stretch)
    if not numpy.all(scale):
        raise Refused("An object has no size along one of its axes")
    shear = stretch / scale
    rotation = mathutils.Matrix(turn.tolist())
    angles = rotation.to_euler("XYZ", near) if near is not None else rotation.to_euler("XYZ")
    made = {
        "translation": matrix[:3, 3].tolist(),
        "rotation": [math.degrees(angle) for angle in angles],
        "scale": scale.tolist(),
    }
    if numpy.abs(shear - numpy.eye(3)).max() > 1e-6:
        made["shear"] = [shear[0, 1], shear[0, 2], shear[1, 2]]
    return made, angles


class Moving:
    """An object over the frames: where it is, and its mesh, in one file or one a frame."""

    def __init__(self, target, is_cage):
        self.target, self.is_cage = target, is_cage
        self.keys, self.angles, self.meshes, self.topology = [], None, [], None

    def read(self, depsgraph, time):
        """Where and how it is at a time."""
        evaluated = self.target.evaluated_get(depsgraph)
        place, self.angles = placement(mesh.matrix_of(evaluated.matrix_world), self.angles)
        self.keys.append({"time": time, **place})
        if self.is_cage:
            # The faces that the detail is on, in their pose.
            source, points = self.target.data, state.posed_points(self.target, depsgraph)
            self._add(source, points)
            return
        posed = evaluated.to_mesh()
        try:
            if posed is None or not len(posed.polygons):
                raise Refused(f"{self.target.name} has no faces to press with")
            self._add(posed, mesh.get_points(posed))
        finally:
            evaluated.to_mesh_clear()

    def _add(self, source, points):
        topology = state.topology_of(source)
        if self.topology not in (None, topology):
            raise Refused(f"{self.target.name} gets other faces on the way, which scene files cannot have")
        self.topology = topology
        if self.meshes and numpy.array_equal(points, self.meshes[-1][1]):
            self.meshes.append(self.meshes[-1])
            return
        made = mesh.Source(source, attributes=self.is_cage)
        made.points = points
        self.meshes.append((made, points))

    @property
    def is_deforming(self):
        return any(entry is not self.meshes[0] for entry in self.meshes)

    def lines(self, base, stem):
        """Writes its files, and the section that names them."""
        name = name_of(self.target)
        if not self.is_deforming:
            with self.meshes[0][0].build() as made:
                made.write(os.path.join(base, f"{stem}_{name}.obj"))
            return ["", f"[meshes.{name}]", f"file = {text(f'{stem}_{name}.obj')}"]
        for number, (source, _points) in enumerate(self.meshes):
            with source.build() as made:
                made.write(os.path.join(base, f"{stem}_{name}_{number:04d}.obj"))
        pattern = f"{stem}_{name}_####.obj"
        return ["", f"[meshes.{name}]", f"sequence = {text(pattern)}", f"count = {len(self.meshes)}"]

    def place_lines(self):
        """Where it is at first."""
        return [f"{key} = {text(value)}" for key, value in self.keys[0].items() if key != "time"]


def table(values):
    return "{ " + ", ".join(f"{key} = {text(value)}" for key, value in values.items()) + " }"


def parameter_lines(table, values):
    """What differs from the defaults of a table of parameters, angles in degrees."""
    lines = []
    for parameter in table:
        value = values.get(parameter.name, parameter.value)
        if value != parameter.value:
            lines.append(f"{parameter.name} = {text(math.degrees(value) if parameter.unit == 'rad' else value)}")
    return lines


def stroke_lines(target, kept, stamp, layers):
    """A stroke that was kept, as `[[strokes]]`, where the object is now."""
    options = kept["options"]
    sculpt = options["action"] == "sculpt"
    lines = ["", "[[strokes]]", f"object = {text(name_of(target))}"]
    lines.append(f"{'sculpt' if sculpt else 'paint'} = {text(options['mode'])}")
    lines.append(f"falloff = {text(options['falloff'])}")
    if sculpt:
        lines.append(f"height = {text(options['height'])}")
    else:
        lines.append(f"colour = {text(options['color'][:3])}")
    if kept.get("layer") in layers:
        lines.append(f"layer = {text(kept['layer'])}")
    if stamp is not None:
        lines.append(f"stamp = {text(stamp)}")
    for name, points in kept.get("curves", {}).items():
        lines.append(f"{name}_curve = {text(points)}")
    lines += parameter_lines(settings.RelievoBrushSettings.table, kept["settings"])
    lines.append("points = [")
    for row in stroke.moved_points(kept, target).tolist():
        point = {"position": row[:3], "pressure": row[3]}
        if row[4] >= 0:
            point["time"] = row[4]
        lines.append(f"    {table(point)},")
    return [*lines, "]"]


class Stamps:
    """Images of brushes as files, one entry for every way in which one is used."""

    def __init__(self, base, stem):
        self.base, self.stem, self.names, self.lines, self.images = base, stem, {}, [], {}

    def add(self, kept, pixels):
        """The name of the entry of a stroke's stamp; the image is written when it is first met."""
        if pixels is None:
            return None
        values, image = kept.get("stamp_settings", {}), kept.get("stamp_key") or kept["stamp"]
        key = image, json.dumps(values, sort_keys=True)
        if key not in self.names:
            if image not in self.images:
                file = f"{self.stem}_stamp_{len(self.images)}.exr"
                self.write(pixels, os.path.join(self.base, file))
                self.images[image] = file
            name = self.names[key] = f"stamp_{len(self.names)}"
            self.lines += ["", f"[stamps.{name}]", f"image = {text(self.images[image])}"]
            self.lines += parameter_lines(settings.RelievoStampSettings.table, values)
        return self.names[key]

    @staticmethod
    def write(pixels, path):
        """The numbers of an image as they are: an EXR file of floats without a view transform."""
        height, width, channels = pixels.shape
        whole = numpy.ones((height, width, 4), numpy.float32)
        whole[:, :, :3] = pixels[::-1, :, :1] if channels < 3 else pixels[::-1, :, :3]
        if channels in {2, 4}:
            whole[:, :, 3] = pixels[::-1, :, -1]
        copy = bpy.data.images.new("Relievo stamp", width, height, alpha=True, float_buffer=True, is_data=True)
        try:
            copy.pixels.foreach_set(whole.ravel())
            copy.filepath_raw, copy.file_format = path, "OPEN_EXR"
            copy.save()
        finally:
            bpy.data.images.remove(copy)


class RELIEVO_OT_export_scene(job.FileSteps, bpy.types.Operator):
    """Write a scene file that `relievo scene run` renders without Blender"""

    bl_idname = "relievo.export_scene"
    bl_label = "Export Relievo scene"
    bl_options = {"REGISTER"}
    filename_ext = ".toml"

    failures = (Refused, rl.RelievoError, OSError)

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

    def steps(self, context):
        scene, target = context.scene, state.source_of(context.active_object)
        made = yield from state.opening(target)
        self.warn(made.take_notes())
        path = bpy.path.abspath(self.filepath)
        base, stem = os.path.dirname(path), os.path.splitext(os.path.basename(path))[0]
        pressers = presser.of(context, target)
        moving = [Moving(target, True), *(Moving(other, False) for other in pressers)]
        names = [name_of(entry.target) for entry in moving]
        if len(set(names)) < len(names):
            raise Refused("Two objects have the same name but for punctuation; rename one")
        first, last = scene.frame_start, scene.frame_end if pressers else scene.frame_start
        fps, now = scene.render.fps / scene.render.fps_base, scene.frame_current
        try:
            for frame in range(imprint.simulated_from(scene, first) if pressers else first, last + 1):
                if pressers:
                    scene.frame_set(frame)
                if frame >= first:
                    depsgraph = context.evaluated_depsgraph_get()
                    for entry in moving:
                        entry.read(depsgraph, (frame - first) / fps)
                yield 0.5 * (frame - first) / (last + 1 - first), 0.5, lambda _progress: None
        finally:
            if pressers:
                scene.frame_set(now)
        lines = ["# Written by the Relievo add-on of Blender. Run it with `relievo scene run`.", "version = 1"]
        lines += [f"fps = {text(fps)}", 'up = "z"']

        def write_meshes(progress):
            for number, entry in enumerate(moving):
                lines.extend(entry.lines(base, stem))
                if progress is not None and not progress(number / len(moving), "meshes"):
                    raise rl.Cancelled("cancelled")

        yield 0.5, 0.9, write_meshes
        options, triangles = target.relievo, made.kind == "TRIANGLES"
        lines += ["", f"[surfaces.{name_of(target)}]", f"mesh = {text(name_of(target))}"]
        lines.append(f"kind = {text('triangles' if triangles else 'catmull_clark')}")
        layers = extra_layers(made) if self.start == "STROKES" else []
        for entry in moving:
            other = entry.target
            lines += ["", f"[objects.{name_of(other)}]"]
            lines.append(f"{'surface' if other == target else 'mesh'} = {text(name_of(other))}")
            lines += entry.place_lines()
            if other == target:
                size = {"segments": made.tile_size} if triangles else {"tile_size": made.tile_size}
                if not triangles:
                    size["paint_size"] = made.tile_size
                lines.append(f"detail = {table(size)}")
                lines.append(f"colour = {text(made.ground)}")
                if layers:
                    lines.append(f"layers = [{', '.join(table(layer) for layer in layers)}]")
                if self.start == "DOCUMENT":
                    with open(os.path.join(base, f"{stem}.relievo"), "wb") as file:
                        file.write(made.data().data)
                    lines.append(f"document = {text(f'{stem}.relievo')}")
        for entry in moving:
            if any({**key, "time": 0} != {**entry.keys[0], "time": 0} for key in entry.keys):
                lines += ["", f"[bodies.{name_of(entry.target)}]", 'shape = "none"', "keyframes = ["]
                lines += [*(f"    {table(row)}," for row in entry.keys), "]"]
        for other in pressers:
            lines += ["", f"[colliders.{name_of(other)}]", f"into = [{text(name_of(target))}]"]
        if pressers:
            group = scene.relievo.imprint
            lines += ["", "[imprints]", *parameter_lines(group.table, settings.values(group))]
        if self.start == "STROKES":
            stamps, strokes = Stamps(base, stem), []
            kept_strokes, lost = stroke.read_all(target)
            for kept, pixels, _pose in kept_strokes:
                strokes += stroke_lines(target, kept, stamps.add(kept, pixels), {layer["name"] for layer in layers})
            lines += stamps.lines + strokes
            if lost:
                self.warn([f"{lost} strokes of {target.name} cannot be written (see the console)"])
        lines += ["", "[output]", f"frames = {last - first + 1}", ""]
        with open(f"{path}.part", "w", encoding="utf-8") as file:
            file.write("\n".join(lines))
        os.replace(f"{path}.part", path)


def extra_layers(made):
    """The layers above the layers that every object has, as scene files have them."""
    found, kinds = [], set()
    for layer in made.detail.layers:
        if layer.kind not in kinds:
            kinds.add(layer.kind)
            continue
        is_color = layer.kind == rl.abi.RlvLayerKind.COLOR
        entry = {"name": layer.name, "kind": "colour" if is_color else "displacement"}
        entry |= {"blend": rl.abi.RlvBlend(layer.blend).name.lower(), "opacity": layer.opacity}
        found.append({**entry, "visible": bool(layer.is_visible)})
    return found


def register():
    bpy.utils.register_class(RELIEVO_OT_export_scene)


def unregister():
    bpy.utils.unregister_class(RELIEVO_OT_export_scene)
