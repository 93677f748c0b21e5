# SPDX-License-Identifier: GPL-3.0-or-later
"""Imprints: selected objects dent the active one over a range of frames, as their animation, armatures and rigid bodies
move them. The whole bake is one edit of the document and one step of undo; its frames are a cache that Blender plays."""

import contextlib

import bpy
import librelievo as rl
import numpy
from librelievo import bake, imprint

from . import cache, job, material, mesh, native, settings, state, view


class Presser:
    """An object that presses: its collider, where it was and how it was posed in the frame before."""

    def __init__(self, target, depsgraph):
        self.target = target
        evaluated = target.evaluated_get(depsgraph)
        posed = evaluated.to_mesh()
        if posed is None or not len(posed.polygons):
            raise state.Refused(f"{target.name} has no faces to press with")
        try:
            with mesh.to_native(posed, attributes=False) as made:
                self.collider = rl.Collider(native.context(), made, state.world(target))
            self.points = mesh.get_points(posed)
        finally:
            evaluated.to_mesh_clear()
        self.before = self.now = state.world(target)
        self.posed = self.points

    def read(self, depsgraph):
        """Where and how it is in this frame."""
        evaluated = self.target.evaluated_get(depsgraph)
        posed = evaluated.to_mesh()
        try:
            points = mesh.get_points(posed)
        finally:
            evaluated.to_mesh_clear()
        if len(points) != len(self.points):
            raise state.Refused(f"{self.target.name} has other points than in the first frame, which colliders cannot have")
        self.before, self.now, self.posed = self.now, state.world(self.target), points

    def press(self, detail, options, moment, progress):
        """Presses it in along its way, or where it is if it deforms."""
        if numpy.array_equal(self.points, self.posed):
            return imprint.sweep(detail, self.collider, self.before, self.now, options, moment, progress)
        self.collider.set_points(self.posed)
        self.points = self.posed
        self.collider.set_transform(self.now)
        return imprint.run(detail, self.collider, options, moment)


class RELIEVO_OT_imprint(job.Steps, bpy.types.Operator):
    """Dent the active object with the other selected ones over the frames of the scene"""

    bl_idname = "relievo.imprint"
    bl_label = "Imprint"
    bl_options = {"REGISTER", "UNDO"}

    frame_start: bpy.props.IntProperty(name="First frame", default=-1, description="-1 for that of the scene")
    frame_end: bpy.props.IntProperty(name="Last frame", default=-1, description="-1 for that of the scene")
    cache: bpy.props.BoolProperty(
        name="Cache", description="Write every frame to the cache, which plays without the add-on", default=False
    )
    images: bpy.props.BoolProperty(
        name="Images", description="Write displacement on the texture coordinates for every frame", default=False
    )

    image_size: bpy.props.IntProperty(name="Image size", default=1024, min=16, max=16384)

    failures = (state.Refused, rl.RelievoError, OSError)

    @classmethod
    def poll(cls, context):
        return state.is_editable(context)

    def steps(self, context):
        scene, target = context.scene, state.source_of(context.active_object)
        pressers = [
            other
            for other in context.selected_objects
            if other.type == "MESH" and state.source_of(other) not in (target,) and other.relievo.source is None
        ]
        if not pressers:
            raise state.Refused("Select the objects that press, then the one that they dent as the last")
        first = scene.frame_start if self.frame_start < 0 else self.frame_start
        last = scene.frame_end if self.frame_end < 0 else self.frame_end
        made = state.of(target)
        options, now = settings.values(scene.relievo.imprint), scene.frame_current
        result = view.ensure(target, made)
        cache.stop(result)
        points = cache.PointCache(cache.path_of(target, ".pc2"), first) if self.cache else None
        pictures = cache.path_of(target, "_####.exr") if self.images else None
        fps = scene.render.fps / scene.render.fps_base
        made.document.begin(f"imprint of {', '.join(other.name for other in pressers)}, frames {first} to {last}")
        try:
            scene.frame_set(first)
            colliders = [Presser(other, context.evaluated_depsgraph_get()) for other in pressers]
            for frame in range(first, last + 1):
                scene.frame_set(frame)
                depsgraph = context.evaluated_depsgraph_get()
                for collider in colliders:
                    collider.read(depsgraph)
                state.place(made, target, state.posed_points(target, depsgraph))
                yield (
                    (frame - first) / (last - first + 1),
                    lambda frame=frame: self.press(made, colliders, options, frame, frame / fps, pictures),
                )
                view.refresh(target, made)
                if points is not None:
                    points.add(made.positions)
            made.end(target)
        except BaseException:
            made.document.abandon()
            made.detail.commit()
            if points is not None:
                points.abandon()
            scene.frame_set(now)
            view.refresh(target, made)
            raise
        scene.frame_set(now)
        if points is not None:
            points.close()
            cache.play(result, points.path, first)
        if pictures is not None:
            material.displace(target, pictures, (first, last))

    def press(self, made, colliders, options, frame, time, pictures):
        """One frame, without Blender's data."""
        if made.detail.channel_info("traces").is_there:
            with contextlib.suppress(rl.Invalid):
                made.detail.advance(time)
        for index, collider in enumerate(colliders):
            moment = {"pair": index, "frame": max(frame, 0)}
            collider.press(made.detail, options, moment, None)
        made.detail.commit()
        if pictures is not None:
            size = self.image_size
            path = pictures.replace("####", f"{frame:04d}")
            bake.write(made.detail, path, quantity="displacement", width=size, height=size)


def register():
    bpy.utils.register_class(RELIEVO_OT_imprint)


def unregister():
    bpy.utils.unregister_class(RELIEVO_OT_imprint)
