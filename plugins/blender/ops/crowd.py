# SPDX-License-Identifier: GPL-3.0-or-later
"""Crowds: instances of a collection with an armature's character are drawn, where they are far, as meshes of as many
triangles as their pixels deserve, in the viewport and in renders.

Building exports the character and its actions as glTF and makes a crowd model of it, a file beside the caches. Each
empty that instances the collection gets a child with a mesh whose error, in the pose of the frame, is below a number of
pixels of the scene's camera; instances with the same error and pose share their mesh. The custom properties `phase`
(seconds) and `clip` (the name of an action) of an empty give it a pose of its own. The meshes of a frame stay in the file
and are there without the add-on."""

import contextlib
import math
import os
import tempfile

import bpy
import librelievo as rl
import numpy
from bpy.app.handlers import persistent
from mathutils import Matrix

from ..core import job, native
from ..core.error import Refused, said
from ..data import cache, mesh, playback, state

# Ratio of the errors of neighbouring meshes, so that instances share them.
STEP = math.sqrt(2)
# Custom properties: of a mesh, the model, error and pose that it was made for; of a child, that it is one.
KEY, CHILD = "relievo_crowd_mesh", "relievo_crowd_child"

# Models that were read, by the paths of their files, with the times of these.
_models = {}


def model_of(target):
    """Returns the crowd model of an armature, or None. Raises what reading its file raises."""
    options = target.relievo_crowd
    path = options.path and bpy.path.abspath(options.path)
    if not path:
        return None
    stamp = os.stat(path).st_mtime_ns
    if _models.get(path, (None,))[0] != stamp:
        _models[path] = stamp, rl.CrowdModel.read(native.context(), path)
    return _models[path][1]


def parts_of(target):
    """Returns the meshes that an armature deforms."""
    uses = lambda part: any(one.type == "ARMATURE" and one.object == target for one in part.modifiers)
    return [part for part in bpy.data.objects if part.type == "MESH" and state.is_used(part) and uses(part)]


def instances_of(target, scene):
    """Returns the empties of a scene that instance a collection with an armature."""
    collections = set(target.users_collection)
    return [one for one in scene.objects if one.type == "EMPTY" and one.instance_collection in collections]


@contextlib.contextmanager
def selected(objects):
    """Selects objects and nothing else for a while."""
    layer = bpy.context.view_layer
    before, active = [one for one in layer.objects if one.select_get()], layer.objects.active
    try:
        for one in layer.objects:
            one.select_set(one in objects)
        layer.objects.active = objects[0]
        yield
    finally:
        for one in layer.objects:
            one.select_set(one in before)
        layer.objects.active = active


def export(target, parts, path):
    """Writes an armature, its meshes and actions as glTF in Blender's axes."""
    with selected([target, *parts]):
        bpy.ops.export_scene.gltf(
            filepath=path,
            export_format="GLB",
            use_selection=True,
            export_yup=False,
            export_animations=True,
            export_image_format="NONE",
        )


def put(data, made, materials):
    """Puts a mesh of the library into one of Blender, with materials by their names."""
    filling = mesh.Filling.of(made)
    if filling.uvs is not None:
        # They are at points.
        filling.uvs = filling.uvs[filling.corners]
    data.clear_geometry()
    filling.fill(data)
    mesh.set_points(data, made.points())
    data.materials.clear()
    for name in materials:
        data.materials.append(bpy.data.materials.get(name))
    mesh.set_materials(data, made.attribute("material").values.reshape(-1))


class Far:
    """The far instances of one armature in a frame."""

    def __init__(self, target, scene):
        self.target, self.model, self.fps = target, model_of(target), scene.render.fps / scene.render.fps_base
        self.clips = {clip.name: (number, clip) for number, clip in enumerate(self.model.clips)}
        info = self.model.info
        self.size = float(numpy.linalg.norm(numpy.subtract(info.high, info.low)))
        self.finest, self.materials = info.input_triangles, self.model.materials
        self.middle = Matrix.Translation((numpy.add(info.low, info.high) / 2).tolist()).translation
        self.frame = scene.frame_current
        self.meshes = {data[KEY]: data for data in bpy.data.meshes if KEY in data and data.library is None}

    def pose(self, empty):
        """Returns the numbers of the clip and of the pose of an instance."""
        action = self.target.animation_data.action if self.target.animation_data else None
        number, clip = self.clips.get(empty.get("clip", action.name if action else ""), (0, self.model.clips[0]))
        played = bpy.data.actions.get(clip.name)
        start = played.frame_range[0] if played else 0.0
        time = (self.frame - start) / self.fps + float(empty.get("phase", 0.0))
        return number, round(time * clip.rate) % clip.pose_count

    def error(self, empty, camera, pixels):
        """Returns the error that an instance may have, in units of the model, and its step; None where it is full."""
        scale = max(empty.matrix_world.to_scale())
        offset = empty.instance_collection.instance_offset
        distance = (empty.matrix_world @ (self.middle - offset) - camera.translation).length
        near = distance - 0.5 * self.size * scale
        allowed = self.target.relievo_crowd.pixels * near / pixels / max(scale, 1e-9)
        if allowed <= 1e-5 * self.size:
            return None
        step = math.floor(math.log(allowed / self.size, STEP))
        return self.size * STEP**step, step

    def mesh(self, error, step, clip, pose):
        """Returns the mesh of an error in a pose, made if it is not there."""
        key = f"{self.target.name} {step} {clip} {pose} {self.target.relievo_crowd.stamp}"
        if key not in self.meshes:
            data = bpy.data.meshes.new(f"{self.target.name} far")
            with self.model.mesh(error, clip, pose) as made:
                put(data, made, self.materials)
            data[KEY] = key
            self.meshes[key] = data
        return self.meshes[key]


def child_of(empty):
    """Returns the child of an instance that shows its mesh, or None."""
    return next((one for one in empty.children if CHILD in one), None)


def show(target, scene):
    """Shows the instances of an armature in a frame. Returns how many have meshes, and their triangles."""
    if scene.camera is None:
        raise Refused("The scene has no camera, from which the pixels of instances are counted")
    far, camera = Far(target, scene), scene.camera.matrix_world
    width = scene.render.resolution_x * scene.render.resolution_percentage / 100
    # Pixels of what is as long as its distance, for a square sensor fit.
    pixels = 0.5 * max(width, 1) / math.tan(0.5 * scene.camera.data.angle_x)
    count, triangles = 0, 0
    for empty in instances_of(target, scene):
        allowed = far.error(empty, camera, pixels)
        data = far.mesh(*allowed, *far.pose(empty)) if allowed else None
        is_far = data is not None and len(data.polygons) < far.finest
        child = child_of(empty)
        if is_far and child is None:
            child = bpy.data.objects.new(f"{empty.name} far", data)
            child[CHILD] = True
            child.parent = empty
            for collection in empty.users_collection:
                collection.objects.link(child)
        if child is not None:
            child.matrix_local = Matrix.Translation(-empty.instance_collection.instance_offset)
            child.hide_viewport = child.hide_render = not is_far
            if is_far:
                child.data = data
        empty.instance_type = "NONE" if is_far else "COLLECTION"
        count, triangles = count + is_far, triangles + (len(data.polygons) if is_far else far.finest)
    drop(target)
    return count, triangles


def drop(target):
    """Removes the meshes of an armature that nothing shows."""
    for data in [data for data in bpy.data.meshes if data.get(KEY, "").startswith(f"{target.name} ") and not data.users]:
        bpy.data.meshes.remove(data)


def clear(target, scene):
    """Shows the instances of an armature in full again."""
    for empty in instances_of(target, scene):
        child = child_of(empty)
        if child is not None:
            bpy.data.objects.remove(child)
        empty.instance_type = "COLLECTION"
    drop(target)


class Operator(job.Steps):
    """An operator on the active armature."""

    bl_options = {"REGISTER", "UNDO"}
    failures = (Refused, rl.RelievoError, OSError, RuntimeError)

    @classmethod
    def poll(cls, context):
        active = context.active_object
        return context.mode == "OBJECT" and active is not None and active.type == "ARMATURE"


class Modelling(Operator):
    """An operator that makes a crowd model of the active armature, in a file of its own."""

    def make(self, target, source):
        """Returns what makes the model of a glTF file, with a report, on a thread."""
        raise NotImplementedError

    def steps(self, context):
        target = context.active_object
        parts = parts_of(target)
        if not parts:
            raise Refused(f"{target.name} deforms no mesh")
        made = []
        with tempfile.TemporaryDirectory() as folder:
            source = os.path.join(folder, "character.glb")
            make, rate = self.make(target, source), context.scene.render.fps / context.scene.render.fps_base
            export(target, parts, source)
            native.context()
            path = f"{cache.new(target)}.rcrowd"

            def work(progress):
                model, report = make(progress=progress, pose_rate=rate)
                with model:
                    model.write(path)
                    made.extend((model.info, report))

            yield 0.0, 1.0, work
        options = target.relievo_crowd
        options.path, options.stamp = cache.relative(path), os.path.basename(path)
        info, report = made
        options.report = f"{info.input_triangles:,} triangles, {info.clip_count} actions, {info.pose_count} poses"
        if report is not None and report.is_rebuild_due:
            more = f"Far instances have up to {report.growth:.1f} times as many triangles: Build crowd model gives them fewer"
            self.report({"WARNING"}, more)
        self.report({"INFO"}, options.report)


class RELIEVO_OT_crowd_build(Modelling, bpy.types.Operator):
    """Build a crowd model of the active armature, the meshes that it deforms, and its actions"""

    bl_idname = "relievo.crowd_build"
    bl_label = "Build crowd model"

    def make(self, target, source):
        return lambda **given: (rl.CrowdModel.build(native.context(), source, **given), None)


class RELIEVO_OT_crowd_refit(Modelling, bpy.types.Operator):
    """Give the crowd model the places of vertices and the actions that there are now, which is faster than a build"""

    bl_idname = "relievo.crowd_refit"
    bl_label = "Refit crowd model"

    def make(self, target, source):
        before = model_of(target)
        if before is None:
            raise Refused(f"{target.name} has no crowd model; build it first")
        return lambda **given: before.refit(source, **given)


class RELIEVO_OT_crowd_show(Operator, bpy.types.Operator):
    """Show the far instances of the active armature's collections as meshes, and follow the frame from now on"""

    bl_idname = "relievo.crowd_show"
    bl_label = "Show far instances as meshes"

    def steps(self, context):
        target = context.active_object
        if not target.relievo_crowd.path:
            raise Refused(f"{target.name} has no crowd model; build it first")
        if not instances_of(target, context.scene):
            raise Refused(f"No empty instances a collection that {target.name} is in")
        count, triangles = show(target, context.scene)
        target.relievo_crowd.is_shown = True
        self.report({"INFO"}, f"{count} instances as meshes, {triangles:,} triangles in all")
        yield from ()


class RELIEVO_OT_crowd_clear(Operator, bpy.types.Operator):
    """Show all instances in full again"""

    bl_idname = "relievo.crowd_clear"
    bl_label = "Show all instances in full"

    def steps(self, context):
        target = context.active_object
        clear(target, context.scene)
        target.relievo_crowd.is_shown = False
        yield from ()


class RelievoCrowd(bpy.types.PropertyGroup):
    """Crowd settings of an armature."""

    path: bpy.props.StringProperty(name="Crowd model", subtype="FILE_PATH")
    stamp: bpy.props.StringProperty()
    report: bpy.props.StringProperty()
    pixels: bpy.props.FloatProperty(
        name="Error", description="Error that may be seen, in pixels of the render", default=0.5, min=0.05, max=100.0
    )
    is_shown: bpy.props.BoolProperty()


CLASSES = [RelievoCrowd, RELIEVO_OT_crowd_build, RELIEVO_OT_crowd_refit, RELIEVO_OT_crowd_show, RELIEVO_OT_crowd_clear]


@persistent
def frame_changed(scene, *_):
    if not playback.may_write(scene):
        return
    for target in [one for one in scene.objects if one.type == "ARMATURE" and one.relievo_crowd.is_shown]:
        try:
            show(target, scene)
        except Operator.failures as failure:
            print(f"Relievo: the crowd of {target.name} cannot be shown: {said(failure)}")


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Object.relievo_crowd = bpy.props.PointerProperty(type=RelievoCrowd)
    bpy.app.handlers.frame_change_post.append(frame_changed)


def unregister():
    bpy.app.handlers.frame_change_post.remove(frame_changed)
    del bpy.types.Object.relievo_crowd
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
    _models.clear()
