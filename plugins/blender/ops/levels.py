# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that build, write, read and clear the levels of the active object."""

import os
import uuid

import bpy
import librelievo as rl

from ..core import job, native
from ..core.error import Refused, said
from ..data import attribute, mesh, progressive


class OnLevels:
    """An operator on the levels of the active object."""

    bl_options = {"REGISTER", "UNDO"}
    failures = progressive.FAILURES

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and progressive.is_there(context.active_object)


class RELIEVO_OT_levels_build(job.Steps, bpy.types.Operator):
    """Build a progressive mesh of the active object, which is then shown and edited as coarse or as fine as wanted. Its
    faces become triangles; texture coordinates, colours and materials stay on them at every level"""

    bl_idname = "relievo.levels_build"
    bl_label = "Build levels"
    bl_options = {"REGISTER", "UNDO"}
    failures = progressive.FAILURES

    base_triangles: bpy.props.IntProperty(
        name="Base", description="Triangles at which the coarsest level is coarse enough", min=4, max=2**31 - 1, default=100
    )

    @classmethod
    def poll(cls, context):
        active = context.active_object
        is_mesh = active is not None and active.type == "MESH"
        return is_mesh and context.mode == "OBJECT" and not progressive.is_there(active)

    def steps(self, context):
        target, base = context.active_object, self.base_triangles
        progressive.check(target)
        original, uid = target.data, uuid.uuid4().hex
        source, path = mesh.Triangles(original), progressive.place_of(uid)
        if not len(source.corners):
            raise Refused(f"{target.name} has no faces")
        source.attributes, layers = attribute.of_triangles(original)
        native.context()
        made = []

        def work(progress):
            with source.build() as triangles:
                weights = {} if source.attributes else None
                whole = rl.Progressive(triangles, base_triangles=base, progress=progress, weights=weights)
            made.extend([progressive.finest(whole), progressive.bytes_of(whole, path)])

        yield 0.0, 1.0, work
        missing = layers + progressive.left_out(target)
        target.data = original.copy()
        target.data.name = f"{original.name} level"
        target.relievo.progressive.original = original
        progressive.adopt(target, uid, *made)
        if missing:
            self.warn([f"Levels of {target.name} have no {' and no '.join(missing)}"])


class RELIEVO_OT_levels_clear(OnLevels, bpy.types.Operator):
    """Forget the levels of the active object and its edits"""

    bl_idname = "relievo.levels_clear"
    bl_label = "Clear levels"

    keep: bpy.props.EnumProperty(
        name="Keep",
        items=[
            ("LEVEL", "Level", "The level that is shown becomes an ordinary mesh"),
            ("ORIGINAL", "Original", "The mesh that the levels were built of returns, without edits"),
        ],
    )

    def execute(self, context):
        target = context.active_object
        original = target.relievo.progressive.original
        try:
            progressive.check_kept(target)
            if self.keep == "ORIGINAL":
                progressive.check(target)
                if original is None:
                    raise Refused(f"The levels of {target.name} were read from a file, and there is no original mesh")
        except Refused as failure:
            self.report({"ERROR"}, said(failure))
            return {"CANCELLED"}
        progressive.clear(target)
        if self.keep == "ORIGINAL":
            level, target.data = target.data, original
            if not level.users:
                bpy.data.meshes.remove(level)
        return {"FINISHED"}


class RELIEVO_OT_levels_write(OnLevels, job.FileSteps, bpy.types.Operator):
    """Write all levels with the edits as a progressive mesh (.rlvpm)"""

    bl_idname = "relievo.levels_write"
    bl_label = "Write levels"
    bl_options = {"REGISTER"}
    filename_ext = ".rlvpm"
    filter_glob: bpy.props.StringProperty(default="*.rlvpm", options={"HIDDEN"})

    def steps(self, context):
        path = bpy.path.abspath(self.filepath)
        target = context.active_object
        shown = yield from progressive.opening(target, progressive.wanted_of(target))

        def work(_progress):
            with shown.level.settle() as settled:
                settled.write(path)

        yield 0.9, 1.0, work


class RELIEVO_OT_levels_read(job.ReadSteps, bpy.types.Operator):
    """Read a progressive mesh (.rlvpm) as a new object"""

    bl_idname = "relievo.levels_read"
    bl_label = "Read levels"
    bl_options = {"REGISTER", "UNDO"}
    failures = progressive.FAILURES
    filename_ext = ".rlvpm"
    filter_glob: bpy.props.StringProperty(default="*.rlvpm", options={"HIDDEN"})

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def steps(self, context):
        path, uid = bpy.path.abspath(self.filepath), uuid.uuid4().hex
        native.context()
        made = []

        def work(_progress):
            shown = progressive.finest(rl.Progressive.read(native.context(), path))
            with open(path, "rb") as file:
                made.extend([shown, progressive.fitting(file.read())])

        yield 0.0, 1.0, work
        name = os.path.splitext(os.path.basename(path))[0]
        target = bpy.data.objects.new(name, bpy.data.meshes.new(f"{name} level"))
        context.collection.objects.link(target)
        for other in context.selected_objects:
            other.select_set(False)
        target.select_set(True)
        context.view_layer.objects.active = target
        progressive.adopt(target, uid, *made)


CLASSES = [RELIEVO_OT_levels_build, RELIEVO_OT_levels_clear, RELIEVO_OT_levels_write, RELIEVO_OT_levels_read]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
