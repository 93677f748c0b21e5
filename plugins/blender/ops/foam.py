# SPDX-License-Identifier: GPL-3.0-or-later
"""Spray, foam and bubbles of a domain: baked from the cached frames of its fluid, shown as points that Cycles renders, and
composited in screen space over a render. Lengths are metres of the world."""

import os

import bpy
import librelievo as rl
import numpy
from bpy.app.handlers import persistent

from ..core import job, native, settings
from ..core.error import Refused, said
from ..data import cache, frames, mesh, playback, state
from . import fluid, foam_picture

# Kinds by their numbers, and the colours in which they are shown.
KINDS = ("SPRAY", "FOAM", "BUBBLE")
COLORS = numpy.float32([(0.8, 0.9, 1.0, 1.0), (1.0, 1.0, 1.0, 1.0), (0.35, 0.6, 1.0, 1.0)])
# Settings that the panel shows at once.
SETTINGS = ("air_min", "air_max", "crest_min", "crest_max", "energy_min", "energy_max", "air_rate", "crest_rate")
# The names of node groups, materials and modifiers.
NAME = "Relievo foam"

RelievoFoamSettings = settings.group_of("RelievoFoamSettings", rl.diffuse.params())
RelievoFoamLook = settings.group_of("RelievoFoamLook", rl.foam.params())


def changed(options, context):
    """Shows the present frame of a domain as its settings are now."""
    trouble = show(options.id_data, context.scene.frame_current)
    if trouble:
        print(f"Relievo: {trouble}")


class RelievoFoam(bpy.types.PropertyGroup):
    """The foam of a domain."""

    settings: bpy.props.PointerProperty(type=RelievoFoamSettings)
    look: bpy.props.PointerProperty(type=RelievoFoamLook)
    radius: bpy.props.FloatProperty(
        name="Radius",
        description="Radius of the largest particles, as a share of the fluid's spacing",
        min=0.001,
        soft_max=2,
        default=0.5,
        update=changed,
    )
    light: bpy.props.FloatVectorProperty(
        name="Light",
        description="Radiance from all around in composited pictures",
        size=3,
        subtype="COLOR",
        min=0,
        soft_max=1,
        default=(1, 1, 1),
    )
    show: bpy.props.EnumProperty(
        name="Show",
        description="Kinds of particles that are shown",
        items=[(kind, f"{kind.capitalize()}{'' if kind != 'BUBBLE' else 's'}", "", 2**number) for number, kind in enumerate(KINDS)],
        options={"ENUM_FLAG"},
        default=set(KINDS),
        update=changed,
    )
    result: bpy.props.PointerProperty(name="Result", description="What shows the foam", type=bpy.types.Object)
    estimate: bpy.props.StringProperty(description="What a bake is expected to take")


def start_of(scene, domain):
    """Returns a function that makes a run of foam without particles and the seconds of a frame, and its settings. The function
    reads no data of Blender."""
    gravity = tuple(scene.gravity) if scene.use_gravity else (0.0, 0.0, 0.0)
    values, spacing = settings.values(domain.relievo_foam.settings), domain.relievo.fluid.spacing
    seconds = scene.render.fps_base / scene.render.fps
    return lambda: (rl.Diffuse(native.context(), spacing, gravity, **values), seconds), values


class RELIEVO_OT_foam_bake(fluid.OnDomain, job.Steps, bpy.types.Operator):
    """Make spray, foam and bubbles from the cached frames of the active domain, in place of earlier ones. The
    fluid is not simulated again"""

    bl_idname = "relievo.foam_bake"
    bl_label = "Bake foam"

    def steps(self, context):
        scene, domain = context.scene, context.active_object
        options, now = domain.relievo.fluid, scene.frame_current
        folder = source = frames.folder_of(domain)
        if not folder:
            raise Refused(f"{domain.name} has no frames; simulate it first")
        # Other objects play these frames, or undo may bring them back.
        if not cache.is_own(domain, source):
            folder = frames.new_folder(domain)
        span, refused = options.last - options.first + 1, 0
        start, _settings = start_of(scene, domain)
        run, seconds = start()
        for number, frame in enumerate(range(options.first, options.last + 1)):
            before, path = (frames.path_of(place, frames.PARTICLES, frame) for place in (source, folder))

            def work(progress, number=number, frame=frame, before=before, path=path):
                nonlocal refused
                if before != path:
                    frames.share(before, path)
                if number:
                    report = run.advance(*frames.particles(before), seconds, progress)
                    refused += report.refused
                run.save(frames.path_of(folder, frames.FOAM, frame), number * seconds)

            yield number / span, (number + 1) / span, work
        if folder != source:
            frames.begin(domain, folder)
        result_of(domain)
        trouble = show(domain, now)
        if trouble:
            raise Refused(trouble)
        if refused:
            self.warn([f"{refused:,} particles were not made; raise Most, or lower the rates"])
        self.report({"INFO"}, f"{run.info.count:,} particles of foam in the last of {span} frames")


def particles(path):
    """Returns the particles of a frame of foam by the names of their arrays; without Blender's data."""
    with rl.Particles.read(native.context(), path) as kept:
        channels = kept.channels()
        missing = [name for name in ("type", "age", "lifetime", "velocity") if name not in channels]
        if missing:
            raise ValueError(f"its particles have no channel {missing[0]}")
        ages, left = channels["age"].ravel(), numpy.maximum(channels["lifetime"].ravel(), 0)
        kinds = channels["type"].ravel().astype(numpy.uint32)
        if len(kinds) and kinds.max() >= len(KINDS):
            raise ValueError("a particle is of an unknown kind")
        return {
            "positions": kept.points(),
            "ids": kept.numbers(),
            "kinds": kinds,
            "lives": numpy.divide(ages, ages + left, out=numpy.zeros_like(ages), where=ages > 0),
            "velocities": channels["velocity"],
        }


def radii(found, radius):
    """Returns the radii of particles of a greatest radius, as the renderer varies them (Akinci et al. 2013, Section 2.1)."""
    varied = radius / (found["ids"] % 5 + 1).astype(numpy.float32)
    return numpy.where(found["kinds"] == KINDS.index("BUBBLE"), 0.5 * varied, varied)


def shows(domain):
    """Returns whether a domain has an object that shows its foam. That of a copy may still be the one of the original."""
    result = domain.relievo_foam.result
    return state.is_used(result) and result.relievo.fluid.domain == domain


def result_of(domain):
    """Returns the object that shows a domain's foam, made if it is not there."""
    options = domain.relievo_foam
    if not shows(domain):
        name = f"{domain.name} foam"
        options.result = bpy.data.objects.new(name, bpy.data.meshes.new(name))
        for collection in domain.users_collection or [bpy.context.scene.collection]:
            collection.objects.link(options.result)
        options.result.relievo.fluid.domain = domain
        options.result.data.materials.append(material())
        modifier = options.result.modifiers.new(NAME, "NODES")
        modifier.node_group = node_group()
    return options.result


def material():
    """Returns the material of foam, which has the colours of its particles."""
    made = bpy.data.materials.get(NAME)
    if made is None:
        made = bpy.data.materials.new(NAME)
        if made.node_tree is None:
            made.use_nodes = True
        nodes, links = made.node_tree.nodes, made.node_tree.links
        color = nodes.new("ShaderNodeAttribute")
        color.attribute_name = "color"
        surface = next(node for node in nodes if node.type == "BSDF_PRINCIPLED")
        links.new(color.outputs["Color"], surface.inputs["Base Color"])
    return made


def node_group():
    """Returns the geometry nodes that make points of vertices, which Cycles renders as spheres of their radii."""
    made = bpy.data.node_groups.get(NAME)
    if made is not None:
        return made
    made = bpy.data.node_groups.new(NAME, "GeometryNodeTree")
    if hasattr(made, "interface"):
        for direction in ("INPUT", "OUTPUT"):
            made.interface.new_socket("Geometry", in_out=direction, socket_type="NodeSocketGeometry")
    else:
        made.inputs.new("NodeSocketGeometry", "Geometry")
        made.outputs.new("NodeSocketGeometry", "Geometry")
    kinds = ("NodeGroupInput", "GeometryNodeMeshToPoints", "GeometryNodeSetMaterial", "NodeGroupOutput")
    source, points, shaded, output = (made.nodes.new(kind) for kind in kinds)
    radius = made.nodes.new("GeometryNodeInputNamedAttribute")
    radius.data_type = "FLOAT"
    radius.inputs["Name"].default_value = "radius"
    shaded.inputs["Material"].default_value = material()
    value = next(socket for socket in radius.outputs if socket.name == "Attribute" and socket.enabled)
    made.links.new(source.outputs[0], points.inputs["Mesh"])
    made.links.new(value, points.inputs["Radius"])
    made.links.new(points.outputs[0], shaded.inputs["Geometry"])
    made.links.new(shaded.outputs[0], output.inputs[0])
    return made


def put(domain, found):
    """Puts the particles of a frame into the result of a domain."""
    options = domain.relievo_foam
    shown = numpy.isin(found["kinds"], [number for number, kind in enumerate(KINDS) if kind in options.show])
    found = {name: values[shown] for name, values in found.items()}
    data = options.result.data
    data.clear_geometry()
    data.vertices.add(len(found["positions"]))
    mesh.set_points(data, numpy.ascontiguousarray(found["positions"]))
    columns = {
        "velocity": ("FLOAT_VECTOR", "vector", found["velocities"]),
        "radius": ("FLOAT", "value", radii(found, options.radius * domain.relievo.fluid.spacing)),
        "life": ("FLOAT", "value", found["lives"]),
        "kind": ("INT", "value", found["kinds"].astype(numpy.int32)),
        "color": ("FLOAT_COLOR", "color", COLORS[found["kinds"]]),
    }
    for name, (kind, field, values) in columns.items():
        attribute = data.attributes.get(name) or data.attributes.new(name, kind, "POINT")
        attribute.data.foreach_set(field, numpy.ascontiguousarray(values).reshape(-1))


def path_at(domain, frame):
    """Returns the path of the foam of a frame, the first or last one before and after all; "" if there is none."""
    options, folder = domain.relievo.fluid, frames.folder_of(domain)
    if not folder:
        return ""
    path = frames.path_of(folder, frames.FOAM, min(max(frame, options.first), options.last))
    return path if os.path.exists(path) else ""


def show(domain, frame):
    """Shows the foam of a frame of a domain. Says what is wrong, "" if nothing is."""
    if not shows(domain):
        return ""
    path = path_at(domain, frame)
    if not path:
        # The frames of another simulation have no foam yet.
        domain.relievo_foam.result.data.clear_geometry()
        return ""
    try:
        put(domain, particles(path))
    except (OSError, ValueError, rl.RelievoError) as failure:
        return f"The foam of frame {frame} of {domain.name} cannot be shown: {said(failure)}"
    return ""


@persistent
def frame_changed(scene, *_):
    if not playback.may_write(scene):
        return
    for domain in frames.domains(scene.objects):
        trouble = show(domain, scene.frame_current) if domain.library is None else ""
        if trouble:
            print(f"Relievo: {trouble}")


class RELIEVO_OT_foam_composite(fluid.OnDomain, job.FileSteps, bpy.types.Operator):
    """Render the scene without foam, and lay the foam of the active domain over the picture in screen space"""

    bl_idname = "relievo.foam_composite"
    bl_label = "Composite foam"
    filename_ext = ".exr"
    filter_glob: bpy.props.StringProperty(default="*.exr;*.png", options={"HIDDEN"})
    use_animation: bpy.props.BoolProperty(
        name="All frames", description="Composites every frame of the scene; #### in the name is the number", default=False
    )

    def steps(self, context):
        scene, domain = context.scene, context.active_object
        now, target = scene.frame_current, bpy.path.abspath(self.filepath)
        if not target.lower().endswith((".exr", ".png")):
            raise Refused("Give the picture the ending .exr or .png")
        if self.use_animation and "####" not in os.path.basename(target):
            raise Refused("Put #### into the name of the pictures, which stands for their numbers")
        numbers = range(scene.frame_start, scene.frame_end + 1) if self.use_animation else [now]
        try:
            for at, frame in enumerate(numbers):
                if frame != scene.frame_current:
                    scene.frame_set(frame)
                path = path_at(domain, frame)
                if not path:
                    raise Refused(f"{domain.name} has no foam; bake it first")
                fluids = [one.relievo.fluid.result for one in frames.domains(scene.objects) if frames.shows(one)]
                foams = [one.relievo_foam.result for one in frames.domains(scene.objects) if shows(one)]
                look = settings.values(domain.relievo_foam.look)
                look["radius"] = domain.relievo_foam.radius * domain.relievo.fluid.spacing
                picture = foam_picture.Picture(scene, fluids, foams)

                def work(progress, path=path, look=look, picture=picture):
                    picture.composite(particles(path), look, tuple(domain.relievo_foam.light), progress)

                yield at / len(numbers), (at + 1) / len(numbers), work
                picture.write(target.replace("####", f"{frame:04d}"))
        finally:
            if scene.frame_current != now:
                scene.frame_set(now)


CLASSES = [
    RelievoFoamSettings,
    RelievoFoamLook,
    RelievoFoam,
    RELIEVO_OT_foam_bake,
    RELIEVO_OT_foam_composite,
]


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Object.relievo_foam = bpy.props.PointerProperty(type=RelievoFoam)
    bpy.app.handlers.frame_change_post.append(frame_changed)


def unregister():
    bpy.app.handlers.frame_change_post.remove(frame_changed)
    del bpy.types.Object.relievo_foam
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
