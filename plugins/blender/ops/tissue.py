# SPDX-License-Identifier: GPL-3.0-or-later
"""Soft tissue: the objects of a collection are volumes, muscles, skins that follow them, surfaces that hold them and bodies
that push. It is simulated over the frames of the scene, and skins get caches that Blender plays without the add-on. Lengths
are metres of the world."""

import os
import time

import bpy
import librelievo as rl
import numpy

from ..core import job, native
from ..core.error import Refused, said
from ..data import cache, mesh
from .fluid import TYPES, Shape

# Settings of a collection that the panel shows at once.
SETTINGS = ("voxel", "dermis", "epidermis", "damping", "relaxes")
# Elements at most: some hundred bytes each, and minutes a frame.
MAX = 20_000_000
LIBRARY = ("stratum corneum", "dermis", "hypodermis", "muscle", "tendon")
MATERIALS = [(name.upper().replace(" ", "_"), name.capitalize(), "") for name in LIBRARY]
MATERIALS.append(("CUSTOM", "Custom", "By its own stiffness"))
ROLES = [
    ("NONE", "None", "It has no part in soft tissue"),
    ("VOLUME", "Volume", "It is full of its material; a closed mesh"),
    ("MUSCLE", "Muscle", "The same, with fibres along its own x axis that contract"),
    ("SKIN", "Skin", "It follows the tissue; its vertices are baked"),
    ("HOLD", "Hold", "Tissue near it does not move; its normals point out of the tissue"),
    ("SLIDE", "Slide", "Tissue near it slides on it"),
    ("COLLIDER", "Collider", "It stands or moves, and tissue does not enter it; a closed mesh"),
]


class RelievoTissue(bpy.types.PropertyGroup):
    """The part that an object has in soft tissue."""

    role: bpy.props.EnumProperty(name="Part", description="What the object is for soft tissue", items=ROLES)
    material: bpy.props.EnumProperty(name="Material", description="What it is full of", items=MATERIALS, default="CUSTOM")
    young: bpy.props.FloatProperty(name="Stiffness", description="Young's modulus, Pa", min=1, soft_max=1e8, default=8000)
    poisson: bpy.props.FloatProperty(
        name="Poisson's ratio",
        description="How much it keeps its volume, 0.5 for all of it; without unit",
        min=-0.9,
        max=0.4999,
        default=0.45,
    )
    density: bpy.props.FloatProperty(
        name="Density", description="Mass of a volume, kg/m³", min=1e-3, soft_max=1e4, default=1000
    )
    level: bpy.props.IntProperty(
        name="Level", description="0 makes tissue; lower levels override those above them within that", min=0, max=63
    )
    strength: bpy.props.FloatProperty(
        name="Strength", description="Stress of the whole muscle at full activation, Pa", min=0, soft_max=1e6, default=3e5
    )
    stiffness: bpy.props.FloatProperty(
        name="Fibre stiffness", description="Stiffness of stretched fibres, Pa", min=0, soft_max=1e6
    )
    activation: bpy.props.FloatProperty(
        name="Activation", description="How much the muscle contracts; keyframe it", min=0, max=1, subtype="FACTOR"
    )
    friction: bpy.props.FloatProperty(
        name="Friction", description="Coulomb's coefficient, without unit", min=0, soft_max=1, default=0.3
    )
    cache: bpy.props.StringProperty(name="Cache", description="The baked frames; the modifier's path comes first")


class RelievoTissueModel(bpy.types.PropertyGroup):
    """How the objects of a collection are simulated."""

    voxel: bpy.props.FloatProperty(
        name="Element size", description="Size of an element, metres", min=1e-6, soft_max=1, default=0.01, precision=4
    )
    samples: bpy.props.IntProperty(name="Samples", description="Along an edge of a voxel", min=1, max=32, default=4)
    dermis: bpy.props.FloatProperty(
        name="Dermis", description="Thickness below the first skin, metres; 0 for none", min=0, soft_max=0.01, precision=5
    )
    epidermis: bpy.props.FloatProperty(
        name="Epidermis", description="Thickness on the first skin, metres; 0 for none", min=0, soft_max=1e-3, precision=6
    )
    damping: bpy.props.FloatProperty(
        name="Damping", description="How fast all motion dies out, 1/s", min=0, soft_max=100, default=10
    )
    safety: bpy.props.FloatProperty(
        name="Safety", description="Share of the longest stable step", min=0.01, max=1, default=0.5
    )
    mass_scaling: bpy.props.FloatProperty(
        name="Mass scaling", description="Microseconds of a step that stiff elements get more mass for; 0 for none", min=0
    )
    halvings: bpy.props.IntProperty(
        name="Halvings", description="How often a step may be halved where an element turns inside out", min=0, max=16, default=4
    )
    touches: bpy.props.BoolProperty(name="Touches itself", description="Whether tissue does not pass through itself")
    relaxes: bpy.props.BoolProperty(name="Begins at rest", description="Whether it hangs at rest in the first frame")
    pace: bpy.props.FloatProperty(description="Seconds that an element took for a step when tissue was baked last")
    estimate: bpy.props.StringProperty(description="What a bake is expected to take")


def collection_of(context):
    """The collection that has the active object and volumes, or None."""
    active = context.active_object
    for collection in active.users_collection if active is not None else ():
        if of_role(collection, "VOLUME"):
            return collection
    return None


def of_role(collection, *roles):
    """The objects of a collection that have a part."""
    return [one for one in collection.objects if one.type in TYPES and one.relievo_tissue.role in roles]


def material_of(target):
    """The fields of an object's material."""
    options = target.relievo_tissue
    if options.material == "CUSTOM":
        own = {"young": options.young, "poisson": options.poisson, "density": options.density}
        return {"name": target.name, **own}
    return {"name": target.name, "library": options.material.lower().replace("_", " ")}


def rotation_vector(matrix):
    """The rotation of a matrix as an axis times an angle."""
    axis, angle = matrix.to_quaternion().to_axis_angle()
    return [component * angle for component in axis]


class Follower:
    """A skin: its vertices in the world, and where the baked ones go."""

    def __init__(self, target):
        if target.type != "MESH":
            raise Refused(f"{target.name} is no mesh; convert it, for its vertices are baked")
        others = [modifier.name for modifier in target.modifiers if modifier.name != cache.MODIFIER]
        if others:
            raise Refused(f"{target.name} has the modifier {others[0]}; apply it, for the vertices below it are baked")
        made = mesh.Triangles(target.data)
        self.target, self.matrix = target, mesh.matrix_of(target.matrix_world)
        self.points = (made.points @ self.matrix[:3, :3].T + self.matrix[:3, 3]).astype(numpy.float32)
        self.corners = made.corners.astype(numpy.uint32)
        self.back, self.index, self.file = numpy.linalg.inv(self.matrix), None, None

    def build(self):
        """A mesh of the library, without Blender's data."""
        return rl.Mesh(native.context(), self.points, self.corners, 3)

    def add(self, simulation):
        """Writes the frame; without Blender's data."""
        with simulation.mesh(self.index) as made:
            points = made.points()
        self.file.add(points @ self.back[:3, :3].T + self.back[:3, 3])


class Simulation:
    """The tissue of a collection, read over the frames of a scene."""

    def __init__(self, scene, collection, depsgraph):
        self.options, self.fps = collection.relievo_tissue, scene.render.fps / scene.render.fps_base
        shapes = lambda *roles: [(one, Shape(one, depsgraph)) for one in of_role(collection, *roles)]
        self.volumes, self.muscles = shapes("VOLUME"), shapes("MUSCLE")
        self.surfaces, self.colliders = shapes("HOLD", "SLIDE"), shapes("COLLIDER")
        self.skins = [Follower(one) for one in of_role(collection, "SKIN")]
        if not self.skins:
            raise Refused(f"Nothing in {collection.name} is a skin; give a mesh that part, and its vertices are baked")
        self.gravity = tuple(scene.gravity) if scene.use_gravity else (0.0, 0.0, 0.0)
        self.activations = [[] for _ in self.muscles]
        self.paths = [[] for _ in self.colliders]
        self.first = [one.matrix_world.copy() for one, _shape in self.colliders]
        self.directions = [tuple(one.matrix_world.to_3x3().col[0]) for one, _shape in self.muscles]
        self.materials = [material_of(one) for one, _shape in self.volumes + self.muscles]
        self.tissue = self.simulation = None
        # Seconds of work on frames.
        self.seconds = 0.0
        # What is read below is of the first frame, and threads do not read Blender's data.
        model = self.options
        self.description = {"cell": model.voxel, "samples": model.samples}
        self.layers = {"dermis": model.dermis, "stratum corneum": model.epidermis}
        self.how = {"gravity": self.gravity, "damping": model.damping, "safety": model.safety, "halvings": model.halvings}
        self.how["mass_scaling"] = 1e-6 * model.mass_scaling
        self.how["self_friction"] = 0.3 if model.touches else -1.0
        self.relaxes = model.relaxes
        self.parts = [(one.name, one.relievo_tissue.level) for one, _shape in self.volumes + self.muscles]
        self.pulls = [(one.relievo_tissue.stiffness, one.relievo_tissue.strength) for one, _shape in self.muscles]
        self.purposes = [(one.name, one.relievo_tissue.role.lower()) for one, _shape in self.surfaces]
        self.frictions = [one.relievo_tissue.friction for one, _shape in self.colliders]

    def expected(self):
        """Returns about how many elements the tissue gets."""
        shapes = [shape for _one, shape in self.volumes]
        # Muscles and volumes of other levels lie in those of level 0.
        making = [shape for shape, (_name, level) in zip(shapes, self.parts) if level == 0]
        return round(sum(shape.volume() for shape in making or shapes) / self.description["cell"] ** 3)

    def check(self):
        """Refuses a tissue of more elements than can be simulated."""
        count = self.expected()
        if count > MAX:
            least = self.description["cell"] * (count / MAX) ** (1 / 3)
            raise Refused(f"There would be {count:,} elements; give Element size {least:.2g} m or more")

    def read(self, time):
        """Reads activations and where colliders are in this frame."""
        for (one, _shape), keys in zip(self.muscles, self.activations):
            keys.append((time, one.relievo_tissue.activation))
        for (one, _shape), first, path in zip(self.colliders, self.first, self.paths):
            moved = one.matrix_world @ first.inverted()
            if any(abs(size - 1.0) > 1e-4 for size in moved.to_scale()):
                raise Refused(f"{one.name} changes its size on the way; a collider keeps it")
            path.append((time, tuple(moved.to_translation()), rotation_vector(moved)))

    def begin(self, progress=None):
        """Builds the model and finds its rest; without Blender's data."""
        shapes = [shape.build() for _one, shape in self.volumes + self.muscles]
        surfaces = [shape.build() for _one, shape in self.surfaces]
        skin = self.skins[0].build()
        kept = [*shapes, *surfaces, skin]
        try:
            volumes, materials = [], list(self.materials)
            for number, ((name, level), made) in enumerate(zip(self.parts, shapes)):
                volume = {"name": name, "mesh": made, "material": number, "level": level}
                if number >= len(self.volumes):
                    at = number - len(self.volumes)
                    stiffness, strength = self.pulls[at]
                    volume |= {"is_muscle": True, "level": max(level, 1), "direction": self.directions[at]}
                    volume |= {"stiffness": stiffness, "strength": strength}
                volumes.append(volume)
            more = {}
            for name, thickness in self.layers.items():
                if thickness > 0:
                    materials.append({"name": f"{name} of the skin", "library": name})
                    layer = {"material": len(materials) - 1, "thickness": thickness}
                    more |= {"layers": [layer]} if name == "dermis" else {"epidermis": layer}
            if more:
                more["skin"] = skin
                volumes = [volume | {"has_layers": not volume.get("is_muscle", False)} for volume in volumes]
            held = [
                {"purpose": purpose, "name": name, "mesh": made}
                for (name, purpose), made in zip(self.purposes, surfaces)
            ]
            self.tissue = rl.Tissue(
                native.context(), materials=materials, volumes=volumes, surfaces=held, progress=progress, **self.description, **more
            )
            for follower in self.skins:
                with follower.build() as made:
                    follower.index = self.tissue.bind(follower.target.name, made)
            self.simulation = self.tissue.simulate(**self.how)
            for number, keys in enumerate(self.activations):
                self.simulation.activate(number, keys)
            for (_one, shape), friction, path in zip(self.colliders, self.frictions, self.paths):
                with shape.build() as made:
                    self.simulation.add_collider(made, friction=friction, keys=path)
            if self.relaxes:
                self.simulation.relax(1e-3, 20_000, progress)
        finally:
            for made in kept:
                made.release()

    def advance(self, progress):
        """Goes on to the next frame and writes it; without Blender's data."""
        began = time.perf_counter()
        self.simulation.advance(1.0 / self.fps, progress)
        self.seconds += time.perf_counter() - began
        self.store()

    def store(self, _progress=None):
        """Writes the frame of all skins; without Blender's data."""
        for follower in self.skins:
            follower.add(self.simulation)


class OnCollection:
    """An operator on the collection of the active object."""

    bl_options = {"REGISTER", "UNDO"}
    failures = (Refused, rl.RelievoError, OSError, ValueError)

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and collection_of(context) is not None


class RELIEVO_OT_tissue_bake(OnCollection, job.Steps, bpy.types.Operator):
    """Simulate the soft tissue of the active object's collection over the frames of the scene, and bake its skins to caches that
    play without the add-on"""

    bl_idname = "relievo.tissue_bake"
    bl_label = "Bake tissue"

    def steps(self, context):
        scene, now = context.scene, context.scene.frame_current
        first, last = scene.frame_start, scene.frame_end
        collection, span = collection_of(context), last - first + 2
        kept = {one: cache.attached(one) for one in of_role(collection, "SKIN")}
        skins = []
        try:
            for one in kept:
                cache.stop(one)
            scene.frame_set(first)
            simulation = Simulation(scene, collection, context.evaluated_depsgraph_get())
            simulation.check()
            for frame in range(first, last + 1):
                scene.frame_set(frame)
                simulation.read((frame - first) / simulation.fps)
            scene.frame_set(now)
            skins = simulation.skins
            for follower in skins:
                follower.file = cache.PointCache(f"{cache.new(follower.target)}.pc2", first)
            yield 0.0, 1.0 / span, simulation.begin
            yield 1.0 / span, 2.0 / span, simulation.store
            for frame in range(first + 1, last + 1):
                yield (frame - first + 1) / span, (frame - first + 2) / span, simulation.advance
            for follower in skins:
                follower.file.close()
                cache.play(follower.target, follower.file.path, first)
                follower.target.relievo_tissue.cache = cache.relative(follower.file.path)
                kept.pop(follower.target)
        finally:
            scene.frame_set(now)
            for follower in skins:
                if follower.file is not None:
                    follower.file.abandon()
            for one, path in kept.items():
                if path and one.relievo_tissue.cache:
                    cache.play(one, bpy.path.abspath(path), first)
        count, steps = simulation.tissue.info.element_count, simulation.simulation.info.steps
        if simulation.seconds > 0 and steps:
            collection.relievo_tissue.pace = simulation.seconds / (count * steps)
        self.report({"INFO"}, f"{collection.name}: {count} elements, {last - first + 1} frames")


class RELIEVO_OT_tissue_clear(OnCollection, bpy.types.Operator):
    """Let the baked skins of the active object's collection go, and remove their files if they are this file's own"""

    bl_idname = "relievo.tissue_clear"
    bl_label = "Clear tissue"
    question = "The baked frames and their files are removed. Undo does not bring files back."

    def invoke(self, context, event):
        return job.ask(self, context, event, self.question)

    def execute(self, context):
        for one in of_role(collection_of(context), "SKIN"):
            path = bpy.path.abspath(cache.attached(one) or one.relievo_tissue.cache)
            cache.stop(one)
            one.relievo_tissue.cache = ""
            is_shared = any(cache.attached(other) and bpy.path.abspath(cache.attached(other)) == path for other in bpy.data.objects)
            try:
                if path and not is_shared and cache.is_own(one, path) and os.path.exists(path):
                    os.remove(path)
            except OSError as failure:
                self.report({"ERROR"}, said(failure))
                return {"CANCELLED"}
        return {"FINISHED"}


CLASSES = [
    RelievoTissue,
    RelievoTissueModel,
    RELIEVO_OT_tissue_bake,
    RELIEVO_OT_tissue_clear,
]


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Object.relievo_tissue = bpy.props.PointerProperty(type=RelievoTissue)
    bpy.types.Collection.relievo_tissue = bpy.props.PointerProperty(type=RelievoTissueModel)


def unregister():
    del bpy.types.Object.relievo_tissue, bpy.types.Collection.relievo_tissue
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
