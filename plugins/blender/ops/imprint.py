# SPDX-License-Identifier: GPL-3.0-or-later
"""Imprints: selected objects dent the active one over a range of frames, as their animation, armatures and rigid bodies
move them. The whole bake is one edit of the document and one step of undo; its frames are a cache that Blender plays."""

import contextlib

import bpy
import librelievo as rl
import numpy
from librelievo import bake, imprint

from ..core import job, lengths, native, settings
from ..core.error import Refused
from ..data import cache, material, mesh, playback, state, view
from . import presser


# Shares of an imprint that are done when the detail is open, and when the result is there.
OPENED, SEEN = 0.05, 0.1
# Places at which a surface is looked at for clipped displacement.
PLACES = 2**18


class Presser:
    """An object that presses: its collider, and where and how it was posed in the frame before and is in this one."""

    def __init__(self, target, depsgraph):
        self.target = target
        self.collider = self.source = self.topology = None
        self.read(depsgraph)

    def read(self, depsgraph):
        """Where and how it is in this frame."""
        evaluated = self.target.evaluated_get(depsgraph)
        posed = evaluated.to_mesh()
        try:
            if posed is None or not len(posed.polygons):
                raise Refused(f"{self.target.name} has no faces to press with")
            points, topology = mesh.get_points(posed), state.topology_of(posed)
            if topology != self.topology:
                # Another mesh, say of a modifier: it presses where it is, since nothing tells where its points were.
                self.source, self.topology = mesh.Source(posed, attributes=False), topology
                self.points = points
                self.now = mesh.matrix_of(evaluated.matrix_world)
        finally:
            evaluated.to_mesh_clear()
        self.before_points, self.points = self.points, points
        self.before, self.now = self.now, mesh.matrix_of(evaluated.matrix_world)

    def press(self, detail, options, moment, progress, carried=None):
        """Presses it in along its way, without Blender's data. `carried` is how the surface moved meanwhile."""
        if self.source is not None:
            with self.source.build() as made:
                self.collider = rl.Collider(native.context(), made, self.now)
            self.source = None
        before = self.before if carried is None else carried @ self.before
        if numpy.array_equal(self.before_points, self.points):
            return imprint.sweep(detail, self.collider, before, self.now, options, moment, progress)
        places = (before, self.before_points), (self.now, self.points)
        return imprint.sweep_points(detail, self.collider, *places, options, moment, progress)


class Imprint(job.Steps):
    """An operator that makes an imprint."""

    bl_options = {"REGISTER", "UNDO"}

    frame_start: bpy.props.IntProperty(name="First frame", default=-1, description="-1 for that of the scene")
    frame_end: bpy.props.IntProperty(name="Last frame", default=-1, description="-1 for that of the scene")
    cache: bpy.props.BoolProperty(
        name="Cache", description="Write every frame to the cache, which plays without the add-on", default=False
    )
    images: bpy.props.BoolProperty(
        name="Images", description="Write displacement on the texture coordinates for every frame", default=False
    )
    image_size: bpy.props.IntProperty(
        name="Image size", description="Width and height of the images, pixels", default=1024, min=16, max=16384
    )

    failures = (Refused, rl.RelievoError, OSError)

    @classmethod
    def poll(cls, context):
        return state.is_editable(context)

    def steps(self, context):
        scene, target = context.scene, state.source_of(context.active_object)
        pressers = presser.check(context, target)
        first = scene.frame_start if self.frame_start < 0 else self.frame_start
        last = scene.frame_end if self.frame_end < 0 else self.frame_end
        if context.screen is not None and context.screen.is_animation_playing:
            bpy.ops.screen.animation_cancel(restore_frame=False)
        made = yield from job.within(0.0, OPENED, self.opening(target))
        self.warn(made.take_notes())
        lengths.follow(scene, target)
        options = [presser.settings_of(context, target, other) for other in pressers]
        limit, now = max(one["max_displacement"] for one in options), scene.frame_current
        result = yield from job.within(OPENED, SEEN, view.ensuring(target, made))
        bake_path = cache.new(target) if self.cache or self.images else ""
        points = cache.PointCache(f"{bake_path}.pc2", first) if self.cache else None
        pictures = f"{bake_path}_####.exr" if self.images else None
        self.size = self.image_size
        fps = scene.render.fps / scene.render.fps_base
        start, heights = made.revision, []
        yield SEEN, SEEN, lambda _progress: heights.append(heights_of(made))
        kept = playback.pause(target)
        made.document.begin(f"imprint of {', '.join(other.name for other in pressers)}, frames {first} to {last}")
        try:
            for frame in range(simulated_from(scene, first), first):
                # Simulations come to a frame only through those before it.
                scene.frame_set(frame)
                yield SEEN, SEEN, lambda _progress: None
            scene.frame_set(first)
            depsgraph = context.evaluated_depsgraph_get()
            colliders = [Presser(other, depsgraph) for other in pressers]
            before = None
            for frame in range(first, last + 1):
                scene.frame_set(frame)
                depsgraph = context.evaluated_depsgraph_get()
                for collider in colliders:
                    collider.read(depsgraph)
                place = mesh.matrix_of(target.evaluated_get(depsgraph).matrix_world)
                carried = None if before is None else place @ numpy.linalg.inv(before)
                before, pose = place, state.posed_points(target, depsgraph)

                def work(progress, frame=frame, place=place, pose=pose, carried=carried):
                    made.detail.set_transform(place)
                    made.set_pose(pose)
                    self.press(made, colliders, options, (frame, frame / fps, carried), pictures, progress)

                span = (1.0 - SEEN) / (last - first + 1)
                begin = SEEN + (frame - first) * span
                yield begin, begin + 0.9 * span, work
                yield from job.within(begin + 0.9 * span, begin + span, view.refreshing(target, made))
                if points is not None:
                    points.add(made.positions)
            yield 1.0, 1.0, lambda _progress: heights.append(heights_of(made))
            yield 1.0, 1.0, lambda _progress: made.end()
        except BaseException:
            # The end itself may have failed, which takes it back too.
            if made.document.info.is_open:
                made.abandon()
            if points is not None:
                points.abandon()
            scene.frame_set(now)
            view.refresh(target, made)
            playback.resume(target, kept)
            raise
        made.record(target)
        self.tell(target, pressers, start, (first, last), *heights)
        if heights[1].min(initial=0.0) <= -limit * (1.0 - 1e-3):
            self.warn([clipping(target, limit)])
        scene.frame_set(now)
        if points is not None:
            points.close()
            playback.begin(target, points.path)
        if pictures is not None:
            material.displace(target, pictures, (first, last))

    def opening(self, target):
        """Steps that make the state which the imprint begins with; they return it."""
        return state.opening(target)

    def tell(self, target, pressers, start, frames, before, after):
        """Reports what was done, from heights before and after, and has the object keep it."""
        deeper, names = before - after, ", ".join(other.name for other in pressers)
        touched = int((numpy.abs(deeper).max(1, initial=0.0) > 0).sum())
        if not touched:
            self.warn([
                f"{names} touched {target.name} nowhere in frames {frames[0]} to {frames[1]}: look whether they meet, and whether "
                "a sheet faces what it presses into"
            ])
            return
        options = target.relievo_press
        options.is_there, options.start = True, start
        options.first, options.last = frames
        options.report = f"{touched:,} tiles, deepest {max(float(deeper.max()), 0.0):.3g}"
        self.report({"INFO"}, options.report)

    def press(self, made, colliders, options, moment, pictures, progress):
        """One frame, without Blender's data."""
        frame, time, carried = moment
        if made.detail.channel_info("traces").is_there:
            with contextlib.suppress(rl.Invalid):
                made.detail.advance(time)
        parts = len(colliders) + (pictures is not None)
        for index, collider in enumerate(colliders):
            which = {"pair": index, "frame": max(frame, 0)}
            collider.press(made.detail, options[index], which, part_of(progress, index, parts), carried)
        made.detail.commit()
        if pictures is not None:
            path = pictures.replace("####", f"{frame:04d}")
            size = {"width": self.size, "height": self.size}
            bake.write(made.detail, path, part_of(progress, parts - 1, parts), quantity="displacement", **size)


class RELIEVO_OT_imprint(Imprint, bpy.types.Operator):
    """Dent the active object with those of its list, or else with the other selected ones, over the frames of the scene"""

    bl_idname = "relievo.imprint"
    bl_label = "Imprint"


def part_of(progress, index, count):
    """Returns the progress callback of one of several equal parts of the work that `progress` reports, None for
    None."""
    if progress is None:
        return None
    return lambda fraction, stage=None: progress((index + fraction) / count, stage)


def heights_of(made):
    """Returns the displacement of a state (tiles, places), in object units, at the middles of as many cells of each tile as
    `PLACES` allows. Without Blender's data."""
    count = made.detail.info.tile_count
    cells = settings.automatic_cells(count, PLACES)
    steps = (numpy.arange(cells, dtype=numpy.float32) + 0.5) / cells
    grid = numpy.stack(numpy.meshgrid(steps, steps), -1).reshape(-1, 2)
    if made.kind == "TRIANGLES":
        # The upper half of the square is turned over into the triangle.
        beyond = grid.sum(1) > 1
        grid[beyond] = 1 - grid[beyond]
    tiles = numpy.repeat(numpy.arange(count, dtype=numpy.uint32), len(grid))
    found = made.detail.evaluate(tiles, numpy.tile(grid, (count, 1)), ["displacements"])["displacements"]
    return found.reshape(count, len(grid))


def clipping(target, limit):
    """Returns what the user reads where the displacement reaches its limit."""
    return (
        f"{target.name} gives way by {limit:g} at most, and the dent is clipped there; raise Max displacement in the panel "
        "for deeper ones"
    )


def simulated_from(scene, first):
    """The frame at which what leads to `first` begins."""
    world = scene.rigidbody_world
    if world is None or not world.enabled or world.point_cache.is_baked:
        return first
    return min(first, world.point_cache.frame_start)


def register():
    bpy.utils.register_class(RELIEVO_OT_imprint)


def unregister():
    bpy.utils.unregister_class(RELIEVO_OT_imprint)
