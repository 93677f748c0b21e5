# SPDX-License-Identifier: GPL-3.0-or-later
"""Fluids: the box of a domain is a basin, meshes fill it, pour into it and stand or move in it; it is simulated over the
frames of the scene into a cache. Lengths are metres of the world."""

import os
import time

import bpy
import librelievo as rl
import numpy
from mathutils.bvhtree import BVHTree
from mathutils.kdtree import KDTree

from ..core import job, native
from ..core.error import Refused, said
from ..data import cache, frames, mesh, remote

# Types of objects that have a mesh when they are evaluated.
TYPES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}
# The share of the spacing by which particles of a fill keep away from particles that are there.
APART = 0.9
# The same for the walls of the domain and for colliders: what begins nearer is under pressure and flies off.
CLEAR = 0.499


class Shape:
    """A mesh of a frame in the world: its points and triangles."""

    def __init__(self, target, depsgraph):
        evaluated = target.evaluated_get(depsgraph)
        posed = evaluated.to_mesh()
        try:
            if posed is None or not len(posed.polygons):
                raise Refused(f"{target.name} has no faces")
            made = mesh.Triangles(posed)
        finally:
            evaluated.to_mesh_clear()
        matrix = mesh.matrix_of(evaluated.matrix_world)
        self.name, self.corners = target.name, made.corners
        self.points = (made.points @ matrix[:3, :3].T + matrix[:3, 3]).astype(numpy.float32)
        if numpy.linalg.det(matrix[:3, :3]) < 0:
            self.corners = self.corners.reshape(-1, 3)[:, ::-1].ravel()

    def build(self):
        """A mesh of the library, without Blender's data."""
        return rl.Mesh(native.context(), self.points, self.corners.astype(numpy.uint32), 3)

    def volume(self):
        """Returns the volume of a closed shape, m³; that of its box where it is not closed."""
        a, b, c = (self.points[self.corners.reshape(-1, 3)[:, number]].astype(float) for number in range(3))
        within = abs(float((a * numpy.cross(b, c)).sum())) / 6
        return min(within, float(numpy.ptp(self.points, 0).prod()))

    def inside(self, places):
        """Which places are inside of it, if it is closed; without Blender's data."""
        with self.build() as made, rl.Caster(native.context(), made) as caster:
            # From inside of a closed mesh the first side that a ray meets is a back. The direction runs along no side.
            direction = numpy.float32((0.013, 0.027, 1.0))
            hits = caster.cast(places, numpy.tile(direction, (len(places), 1)))
        return numpy.isfinite(hits["distance"]) & (hits["normal"] @ direction > 0)

    def clear_of(self, places, distance):
        """Returns which places are no nearer to its surface than a distance; without Blender's data."""
        clear = numpy.ones(len(places), bool)
        low, high = self.points.min(0) - distance, self.points.max(0) + distance
        near = numpy.flatnonzero(((places > low) & (places < high)).all(1))
        if len(near):
            tree = BVHTree.FromPolygons(self.points.tolist(), self.corners.reshape(-1, 3).tolist(), all_triangles=True)
            clear[near] = [tree.find_nearest(place, distance)[0] is None for place in places[near].tolist()]
        return clear

    def section(self, direction):
        """Its outline along a direction, as a flat mesh before it that faces there; without Blender's data."""
        points, corners = self.points.astype(float), self.corners.reshape(-1, 3)
        a, b, c = (points[corners[:, number]] for number in range(3))
        along = points @ direction
        flat = points + numpy.outer(along.max() - along, direction)
        facing = numpy.cross(b - a, c - a) @ direction
        seen = corners[facing > 0].ravel()
        if not len(seen):
            # A sheet that faces away pours all the same.
            seen = corners[facing < 0][:, ::-1].ravel()
        if not len(seen):
            raise Refused(f"{self.name} pours along its own faces, which have no outline there; turn it or its velocity")
        return rl.Mesh(native.context(), flat.astype(numpy.float32), seen.astype(numpy.uint32), 3)


class Pouring:
    """An object that pours: where, and how fast."""

    def __init__(self, target):
        options = target.relievo.fluid
        self.target, velocity = target, numpy.array(options.velocity, float)
        self.speed = numpy.linalg.norm(velocity)
        if not self.speed:
            raise Refused(f"{target.name} pours with no velocity; give it one")
        self.name, self.direction, self.shape = target.name, velocity / self.speed, None

    def read(self, depsgraph):
        self.shape = Shape(self.target, depsgraph)

    def add(self, fluid):
        """Makes it an emitter of a fluid; without Blender's data."""
        try:
            with self.shape.section(self.direction) as made:
                fluid.add_emitter(made, speed=self.speed)
        except rl.RelievoError as failure:
            raise Refused(f"{self.name} cannot pour: {said(failure)}") from None


def apart(places, others, distance):
    """Which of the places are no nearer than a distance to others."""
    kept = numpy.ones(len(places), bool)
    if not len(places) or not len(others):
        return kept
    low, high = places.min(0) - distance, places.max(0) + distance
    others = others[((others > low) & (others < high)).all(1)]
    if len(others):
        tree = KDTree(len(others))
        for number, other in enumerate(others.tolist()):
            tree.insert(other, number)
        tree.balance()
        kept[:] = [tree.find(place)[2] >= distance for place in places.tolist()]
    return kept


def of_role(scene, role):
    """The objects of a scene that have a part in a fluid."""
    return [one for one in scene.objects if one.type in TYPES and one.relievo.fluid.role == role]


def hide_fills(scene):
    """Has fills be drawn as wires and left out of renders, since their fluid takes their place."""
    for one in of_role(scene, "FILL"):
        one.display_type, one.hide_render = "WIRE", True


class Simulation:
    """The fluid of a domain, and what is in it."""

    def __init__(self, scene, domain, depsgraph):
        options = domain.relievo.fluid
        self.spacing, self.fps = options.spacing, scene.render.fps / scene.render.fps_base
        box = Shape(domain, depsgraph).points
        self.low, self.high = box.min(0), box.max(0)
        self.options = {name: getattr(options, name) for name in ("spacing", "viscosity", "friction", "cohesion", "tension")}
        self.options["gravity"] = tuple(scene.gravity) if scene.use_gravity else (0.0, 0.0, 0.0)
        self.fills = [(Shape(one, depsgraph), tuple(one.relievo.fluid.velocity)) for one in of_role(scene, "FILL")]
        self.pourings = [Pouring(one) for one in of_role(scene, "EMITTER")]
        self.colliders = []
        for one in of_role(scene, "COLLIDER"):
            told = one.relievo.fluid
            how = {"contact": told.contact.lower(), "friction": told.slide if told.contact == "FRICTION" else 0.0}
            self.colliders.append([one, how, Shape(one, depsgraph)])
        # Where they are in the first frame.
        self.began = [shape for _target, _how, shape in self.colliders]
        if not self.fills and not self.pourings:
            raise Refused("Nothing fills the domain or pours into it; give a mesh object the part of a fill or an emitter")
        self.read(depsgraph)
        self.fluid = self.frame = self.state = None
        # Particles of the frame that has most; seconds of work, and the particles of all frames that they were for.
        self.most, self.seconds, self.worked = 0, 0.0, 0

    def read(self, depsgraph):
        """What emitters and colliders are in this frame."""
        for pouring in self.pourings:
            pouring.read(depsgraph)
        for collider in self.colliders:
            target, _how, before = collider
            shape = Shape(target, depsgraph)
            if not numpy.array_equal(shape.corners, before.corners):
                raise Refused(f"{target.name} got other faces on the way; a collider keeps its faces")
            collider[2] = shape

    def make(self, colliders):
        """Makes the fluid in its basin, without particles; without Blender's data."""
        self.fluid = rl.Fluid(native.context(), **self.options)
        self.fluid.set_basin(self.low, self.high)
        for (_target, how, _shape), shape in zip(self.colliders, colliders):
            with shape.build() as made:
                self.fluid.add_collider(made, **how)

    def resume(self, folder, frame):
        """Makes the fluid as it was at the end of a frame; without Blender's data."""
        self.make([shape for _target, _how, shape in self.colliders])
        self.pour()
        self.fluid.restore(frames.state_path(folder, frame))
        self.frame = frame

    def begin(self, _progress=None):
        """Makes the fluid of the first frame, without Blender's data."""
        self.make(self.began)
        for shape, velocity in self.fills:
            self.fill(shape, velocity)
        if not self.pourings:
            self.check_filled()

    def check_filled(self):
        """Refuses a fluid without a particle."""
        if not self.fluid.info.particle_count:
            names = ", ".join([shape.name for shape, _velocity in self.fills] or [pouring.name for pouring in self.pourings])
            raise Refused(
                f"There is no particle of {names} in the domain: move it into the box, close its mesh, or give the domain a "
                "smaller spacing"
            )

    def fill(self, shape, velocity):
        """Fills a shape in the box, but not what is in or beside colliders, beside the walls of the box, and beside particles
        that are there already."""
        before = self.fluid.get("points")["points"]
        with shape.build() as made:
            self.fluid.fill(made, velocity=velocity)
        found = self.fluid.get("points", "numbers")
        # Numbers rise, and so new particles come last.
        places, numbers = found["points"][len(before) :], found["numbers"][len(before) :]
        distance = CLEAR * self.spacing
        kept = ((places > self.low + distance) & (places < self.high - distance)).all(1)
        for _target, _how, collider in self.colliders:
            kept &= ~collider.inside(places) & collider.clear_of(places, distance)
        kept &= apart(places, before, APART * self.spacing)
        if not kept.all():
            self.fluid.remove(numbers[~kept])

    def pour(self):
        """Has emitters be where they are in this frame."""
        if self.pourings:
            self.fluid.clear_sources()
            # Emitters may reach out of the box.
            self.fluid.add_sink(self.low, self.high, is_outside=True)
            for pouring in self.pourings:
                pouring.add(self.fluid)

    def advance(self, progress):
        """Goes on to the next frame; without Blender's data."""
        for number, (_target, _how, shape) in enumerate(self.colliders):
            self.fluid.move_collider(number, shape.points, 1.0 / self.fps)
        self.pour()
        began = time.perf_counter()
        self.fluid.advance(1.0 / self.fps, progress)
        self.seconds += time.perf_counter() - began
        self.worked += self.fluid.info.particle_count

    def store(self, folder, frame):
        """Writes the particles of a frame, and keeps what goes on from it; without Blender's data."""
        with self.fluid.particles() as made:
            made.write(frames.path_of(folder, frames.PARTICLES, frame))
        self.frame, self.state = frame, self.fluid.save_bytes()
        self.most = max(self.most, self.fluid.info.particle_count)

    def leave(self, folder):
        """Writes what goes on from the last frame, in place of that of earlier ones."""
        if self.state is not None:
            frames.write_state(folder, self.frame, self.state)


class OnDomain:
    """An operator on the domain that is active."""

    bl_options = {"REGISTER", "UNDO"}
    failures = (Refused, rl.RelievoError, OSError, ValueError)

    @classmethod
    def poll(cls, context):
        active = context.active_object
        return active is not None and context.mode == "OBJECT" and active.relievo.fluid.role == "DOMAIN"


class RELIEVO_OT_fluid_simulate(OnDomain, job.Steps, bpy.types.Operator):
    """Simulate the fluid of the active domain over the frames of the scene into the cache. What was simulated before a cancel
    stays and plays"""

    bl_idname = "relievo.fluid_simulate"
    bl_label = "Simulate"

    def steps(self, context):
        scene, domain = context.scene, context.active_object
        options, now = domain.relievo.fluid, scene.frame_current
        if options.place == "FARM":
            raise Refused(f"{domain.name} is simulated on a farm; submit it, or choose another machine")
        first, last = scene.frame_start, scene.frame_end
        if context.screen is not None and context.screen.is_animation_playing:
            bpy.ops.screen.animation_cancel(restore_frame=False)
        scene.frame_set(first)
        simulation = Simulation(scene, domain, context.evaluated_depsgraph_get())
        folder, span = frames.new_folder(domain), last - first + 1
        if options.place == "SERVER":
            result = frames.result_of(domain)
            try:
                yield from remote.steps(scene, domain, simulation, folder, first, last)
            finally:
                scene.frame_set(now)
                if not os.listdir(folder):
                    os.rmdir(folder)
            hide_fills(scene)
            trouble = frames.show(domain, now)
            if trouble:
                raise Refused(trouble)
            self.report({"INFO"}, f"{result.name}: {span} frames of the server")
            return
        try:
            yield 0.0, 1.0 / span, simulation.begin
            yield 1.0 / span, 1.0 / span, lambda _progress: simulation.store(folder, first)
            result = frames.result_of(domain)
            frames.begin(domain, folder)
            hide_fills(scene)
            options.first = options.last = first
            yield from advancing(context, domain, simulation, folder, last)
        finally:
            scene.frame_set(now)
            if not os.listdir(folder):
                os.rmdir(folder)
        trouble = frames.show(domain, now)
        if trouble:
            raise Refused(trouble)
        if not simulation.most:
            simulation.check_filled()
        self.report({"INFO"}, f"{result.name}: {simulation.fluid.info.particle_count} particles, {span} frames")


def advancing(context, domain, simulation, folder, last):
    """Steps that simulate the frames after the last one of a domain, which the simulation is at. However they end, the folder has
    what a simulation goes on from."""
    scene, options = context.scene, domain.relievo.fluid
    span = last - options.first + 1
    try:
        for frame in range(options.last + 1, last + 1):
            scene.frame_set(frame)
            simulation.read(context.evaluated_depsgraph_get())

            def work(progress, frame=frame):
                simulation.advance(progress)
                simulation.store(folder, frame)

            yield (frame - options.first) / span, (frame - options.first + 1) / span, work
            options.last = frame
    finally:
        # A frame may be whole when the steps are closed.
        options.last = simulation.frame
        simulation.leave(folder)
        if simulation.worked:
            options.pace = simulation.seconds / simulation.worked


class RELIEVO_OT_fluid_resume(OnDomain, job.Steps, bpy.types.Operator):
    """Go on simulating where the active domain was cancelled, or where its frames end, up to the last frame of the scene"""

    bl_idname = "relievo.fluid_resume"
    bl_label = "Resume"

    def steps(self, context):
        scene, domain = context.scene, context.active_object
        options, now, last = domain.relievo.fluid, scene.frame_current, scene.frame_end
        folder = frames.folder_of(domain)
        if not folder or not frames.has_state(folder, options.last):
            raise Refused(f"{domain.name} has nothing to go on from; simulate it")
        if not cache.is_own(domain, folder):
            raise Refused(f"The frames of {domain.name} are those of another object or file too; simulate it anew")
        if last <= options.last:
            raise Refused(f"{domain.name} has all frames up to {options.last}; raise the last frame of the scene for more")
        before = options.last
        try:
            scene.frame_set(options.first)
            simulation = Simulation(scene, domain, context.evaluated_depsgraph_get())
            scene.frame_set(before)
            simulation.read(context.evaluated_depsgraph_get())
            yield 0.0, 0.0, lambda _progress: simulation.resume(folder, before)
            yield from advancing(context, domain, simulation, folder, last)
        finally:
            scene.frame_set(now)
        trouble = frames.show(domain, now)
        if trouble:
            raise Refused(trouble)
        self.report({"INFO"}, f"{domain.name}: frames {before + 1} to {last}, {simulation.fluid.info.particle_count} particles")


class RELIEVO_OT_fluid_mesh(OnDomain, job.Steps, bpy.types.Operator):
    """Mesh the surface of all frames in the cache of the active domain, so that they need not be meshed when they are shown"""

    bl_idname = "relievo.fluid_mesh"
    bl_label = "Mesh frames"

    def steps(self, context):
        domain = context.active_object
        options = domain.relievo.fluid
        folder = source = frames.folder_of(domain)
        if not folder:
            raise Refused(f"{domain.name} has no frames; simulate it first")
        how, span = frames.options_of(domain), options.last - options.first + 1
        # Other objects play these frames, or undo may bring them back.
        if not cache.is_own(domain, source) or frames.has_surfaces(source):
            folder = frames.new_folder(domain)
        native.context()
        for number, frame in enumerate(range(options.first, options.last + 1)):
            before, path = (frames.path_of(place, frames.PARTICLES, frame) for place in (source, folder))
            meshed = frames.path_of(folder, frames.SURFACE, frame)

            def work(progress, before=before, path=path, meshed=meshed):
                points, triangles, velocities = frames.meshed(*frames.particles(before), *how, progress)
                if before != path:
                    frames.share(before, path)
                frames.write(meshed, points=points, triangles=triangles, velocities=velocities)

            yield number / span, (number + 1) / span, work
        frames.result_of(domain)
        frames.begin(domain, folder)
        options.show = "SURFACE"
        frames.show(domain, context.scene.frame_current)


class RELIEVO_OT_fluid_clear(OnDomain, bpy.types.Operator):
    """Let the frames of the active domain go, and remove their files if no other object or file has them"""

    bl_idname = "relievo.fluid_clear"
    bl_label = "Clear frames"
    question = "The frames of the active domain and their files are removed. Undo does not bring files back."

    def invoke(self, context, event):
        return job.ask(self, context, event, self.question)

    def execute(self, context):
        domain = context.active_object
        folder, is_shown = frames.folder_of(domain), frames.shows(domain)
        try:
            if folder and cache.is_own(domain, folder):
                frames.clear(folder)
            elif folder:
                self.report({"INFO"}, f"{folder} stays: it is not this object's alone")
        except OSError as failure:
            self.report({"ERROR"}, said(failure))
            return {"CANCELLED"}
        domain.relievo.fluid.cache = ""
        if is_shown:
            cache.stop(domain.relievo.fluid.result)
            domain.relievo.fluid.result.data.clear_geometry()
        return {"FINISHED"}


CLASSES = [RELIEVO_OT_fluid_simulate, RELIEVO_OT_fluid_resume, RELIEVO_OT_fluid_mesh, RELIEVO_OT_fluid_clear]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
