# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of objects and scenes. Those of brushes, stamps and imprints are made from the library's own tables, so that
they never lag behind it."""

import bpy
import librelievo as rl
from librelievo import abi, brush, imprint, repair

from . import label

SIZES = [(str(2**n), str(2**n), f"{2**n} numbers along an edge of a face") for n in range(3, 9)]
CELLS = [(str(2**n), str(2**n), f"{2**n} cells along an edge of a face") for n in range(0, 9)]
# Files keep the place in the list, so what is new comes last.
CELLS.append(("AUTO", "Automatic", "16 cells along an edge of a face, less where that is more than a million in all"))
MAX_CELLS = 2**20
# What pressure may be taken as, each by a curve of the brush.
CURVES = ("size", "strength", "angle")
CURVE_SAMPLES = 33


def choices(enum):
    """The values of an enum of the library as Blender lists them."""
    return [
        (value.name, value.name.replace("_", " ").capitalize(), label.tip(enum.__name__, value.name)) for value in enum
    ]


def property_of(group, parameter, **more):
    """A property of Blender for a parameter of the library: its type, range, default, unit and help."""
    help_text = parameter.help + (f" ({parameter.unit})" if parameter.unit else "")
    common = {"name": label.of(group, parameter.name), "description": help_text, **more}
    is_switch = parameter.kind == rl.ParameterKind.U32 and (parameter.min, parameter.max) == (0, 1)
    if parameter.kind == rl.ParameterKind.BOOL or is_switch:
        return bpy.props.BoolProperty(default=bool(parameter.value), **common)
    if parameter.kind == rl.ParameterKind.U32:
        # Blender's integers have 31 bits.
        top = min(int(parameter.max), 2**31 - 1)
        return bpy.props.IntProperty(default=int(parameter.value), min=int(parameter.min), max=top, **common)
    extra = {"subtype": "ANGLE"} if parameter.unit == "rad" and abs(parameter.max) <= 1000 else {}
    if parameter.unit in ("m", "world units"):
        extra["unit"] = "LENGTH"
    if (parameter.unit, parameter.min, parameter.max) == ("", 0, 1):
        extra["subtype"] = "FACTOR"
    floats = {"min": parameter.min, "max": parameter.max, "default": parameter.value, "precision": 3}
    return bpy.props.FloatProperty(**floats, **extra, **common)


def group_of(name, table, **more):
    """A class of properties from a table of parameters."""
    annotations = {parameter.name: property_of(name, parameter, **more) for parameter in table}
    return type(name, (bpy.types.PropertyGroup,), {"__annotations__": annotations, "table": table})


def values(group):
    """What a group made from a table holds, as the library takes it."""
    # Switches of the kind U32 are shown as check boxes.
    return {
        parameter.name: int(getattr(group, parameter.name))
        if parameter.kind == rl.ParameterKind.U32
        else getattr(group, parameter.name)
        for parameter in group.table
    }


def curve_nodes(group):
    """The nodes that hold the pressure curves of a brush, by what they are for."""
    nodes = group.curves.nodes if group.curves is not None else {}
    return {name: nodes[name] for name in CURVES if name in nodes and hasattr(nodes[name], "mapping")}


def curves(group):
    """The pressure curves of a brush that are not straight: pairs of a pressure and what it is taken as."""
    found = {}
    for name, node in curve_nodes(group).items():
        node.mapping.initialize()
        curve = node.mapping.curves[0]
        pressures = [number / (CURVE_SAMPLES - 1) for number in range(CURVE_SAMPLES)]
        values = [min(max(node.mapping.evaluate(curve, pressure), 0.0), 1.0) for pressure in pressures]
        if any(abs(value - pressure) > 1e-4 for value, pressure in zip(values, pressures)):
            found[name] = [[pressure, value] for pressure, value in zip(pressures, values)]
    return found


def cells_of(target, tiles):
    """Cells along an edge of a face of the result."""
    if target.relievo.cells in {"AUTO", ""}:
        return automatic_cells(tiles, MAX_CELLS)
    return int(target.relievo.cells)


def automatic_cells(tiles, most):
    """16, or the largest power of two with which so many tiles stay below so many cells."""
    cells = 16
    while cells > 1 and tiles * cells * cells > most:
        cells //= 2
    return cells


# Functions of a group of settings and a context, called when settings of a kind change; those of "recorded" are of an object
# and its state, called when the object has taken what was done. Modules that follow add theirs when they are registered, so that
# this module imports none of them.
listeners = {"imprint": [], "playback": [], "level": [], "fluid": [], "recorded": []}


def _changed(kind):
    """The update callback of a property whose listeners are those of a kind."""

    def tell(group, context):
        for function in listeners[kind]:
            function(group, context)

    return tell


RelievoBrushSettings = group_of("RelievoBrushSettings", brush.params())
RelievoStampSettings = group_of("RelievoStampSettings", brush.stamp_params())
RelievoRepairSettings = group_of("RelievoRepairSettings", [one for one in repair.params() if one.name != "listed"])
RelievoImprintSettings = group_of("RelievoImprintSettings", imprint.params(), update=_changed("imprint"))


class RelievoBrush(bpy.types.PropertyGroup):
    """What the brush tools do."""

    paint_mode: bpy.props.EnumProperty(
        name="Paint", description="What the paint tool does", items=choices(abi.RlvPaintMode)
    )
    sculpt_mode: bpy.props.EnumProperty(
        name="Sculpt", description="What the sculpt tool does", items=choices(abi.RlvSculptMode)
    )
    falloff: bpy.props.EnumProperty(
        name="Falloff", description="How the brush fades to its border", items=choices(abi.RlvFalloff), default="SMOOTH"
    )
    color: bpy.props.FloatVectorProperty(
        name="Colour",
        description="What is painted, scene-linear",
        subtype="COLOR",
        size=4,
        min=0,
        max=10000,
        soft_max=1,
        default=(0.6, 0.03, 0.02, 1),
    )
    height: bpy.props.FloatProperty(
        name="Height", description="What a stroke raises, or a dab if it accumulates, object units", default=0.1
    )
    accumulate: bpy.props.BoolProperty(
        name="Accumulate", description="Let the dabs of a stroke that draws add up, past the height", default=False
    )
    stamp: bpy.props.PointerProperty(name="Stamp", description="Image of the brush", type=bpy.types.Image)
    curves: bpy.props.PointerProperty(
        name="Pressure curves",
        description="What pressure is taken as for size, strength and angle",
        type=bpy.types.NodeTree,
    )
    settings: bpy.props.PointerProperty(type=RelievoBrushSettings)
    stamp_settings: bpy.props.PointerProperty(type=RelievoStampSettings)


class RelievoStroke(bpy.types.PropertyGroup):
    """A stroke that was made: what its brush was and its points, as JSON."""

    text: bpy.props.StringProperty()


class RelievoEdit(bpy.types.PropertyGroup):
    """An edit of a level, as JSON (see `progressive.text_of`)."""

    text: bpy.props.StringProperty()


class RelievoHook(bpy.types.PropertyGroup):
    """An object that moves a region of a level."""

    target: bpy.props.PointerProperty(name="Object", type=bpy.types.Object)
    rest: bpy.props.FloatVectorProperty(description="Where it was when it was made, row by row", size=16)
    radius: bpy.props.FloatProperty(name="Radius", description="How far the region reaches, object units", min=1e-6)
    falloff: bpy.props.EnumProperty(name="Falloff", items=choices(abi.RlvFalloff), default="SMOOTH")
    is_held: bpy.props.BoolProperty(name="Hold", description="Whether it keeps the region where it is")


class RelievoProgressive(bpy.types.PropertyGroup):
    """The levels of an object: which one is shown, and the edits that were made at any."""

    format: bpy.props.IntProperty(description="Version of the stored data")
    uid: bpy.props.StringProperty()
    finest: bpy.props.IntProperty(description="Triangles of the finest level")
    original: bpy.props.PointerProperty(
        name="Original", description="The mesh that the levels were built of", type=bpy.types.Mesh
    )
    edits: bpy.props.CollectionProperty(type=RelievoEdit)
    hooks: bpy.props.CollectionProperty(type=RelievoHook)
    hooked_at: bpy.props.StringProperty(description="The level that hooks act at, as JSON")
    measure: bpy.props.EnumProperty(
        name="Level",
        description="What the level is chosen by",
        items=[
            ("RATIO", "Ratio", "The share of the finest level's triangles"),
            ("TRIANGLES", "Triangles", "The number of triangles"),
            ("ERROR", "Error", "How far the level may be from the finest"),
        ],
        update=_changed("level"),
    )
    ratio: bpy.props.FloatProperty(
        name="Ratio",
        description="Triangles as a share of the finest level's",
        min=0,
        max=1,
        default=1,
        precision=4,
        subtype="FACTOR",
        update=_changed("level"),
    )
    triangles: bpy.props.IntProperty(
        name="Triangles", description="Triangles at most; the coarsest level may have more", min=1, update=_changed("level")
    )
    error: bpy.props.FloatProperty(
        name="Error",
        description="How far the level may be from the finest one, object units",
        min=0,
        precision=5,
        step=0.1,
        update=_changed("level"),
    )


class RelievoHandle(bpy.types.PropertyGroup):
    """The region that is grabbed."""

    radius: bpy.props.FloatProperty(
        name="Radius",
        description="How far the region reaches, object units",
        min=1e-6,
        soft_max=10,
        default=0.5,
        precision=4,
    )
    falloff: bpy.props.EnumProperty(
        name="Falloff",
        description="How the influence falls to the border of the region",
        items=choices(abi.RlvFalloff),
        default="SMOOTH",
    )


class RelievoFluid(bpy.types.PropertyGroup):
    """The part that an object has in a fluid, and what a domain keeps of its frames."""

    role: bpy.props.EnumProperty(
        name="Part",
        description="What the object is for fluids",
        items=[
            ("NONE", "None", "Fluids do not see it"),
            ("DOMAIN", "Domain", "Its box is a basin that is simulated"),
            ("FILL", "Fill", "It is full of fluid in the first frame; a closed mesh"),
            ("EMITTER", "Emitter", "Fluid pours out of it, a closed mesh, along its velocity"),
            ("COLLIDER", "Collider", "Fluid does not pass it; it may move and bend"),
        ],
    )
    spacing: bpy.props.FloatProperty(
        name="Spacing",
        description="Distance between particles at rest, metres; half of it makes eight times as many",
        min=1e-4,
        soft_max=1,
        default=0.05,
        precision=4,
        unit="LENGTH",
    )
    viscosity: bpy.props.FloatProperty(
        name="Viscosity",
        description="Kinematic viscosity, m²/s: water 0.000001, oil 0.0001, honey 0.01",
        min=0,
        soft_max=1,
        default=0.001,
        precision=5,
    )
    friction: bpy.props.FloatProperty(
        name="Wall friction",
        description="Kinematic viscosity between the fluid and walls, m²/s; 0 to slip",
        min=0,
        soft_max=1,
        default=0.001,
        precision=5,
    )
    cohesion: bpy.props.FloatProperty(
        name="Cohesion", description="What pulls particles to each other, m⁵/(kg s²)", min=0, default=0, precision=4
    )
    tension: bpy.props.FloatProperty(
        name="Surface tension", description="N/m; water has 0.072", min=0, soft_max=1, default=0, precision=4
    )
    velocity: bpy.props.FloatVectorProperty(
        name="Velocity",
        description="Of what fills or pours, in the world, m/s",
        size=3,
        subtype="VELOCITY",
        unit="VELOCITY",
    )
    place: bpy.props.EnumProperty(
        name="Simulate on",
        description="Which machine simulates",
        items=[
            ("HERE", "This machine", "Blender's own process"),
            ("SERVER", "Server", "The server that the add-on's preferences name"),
            ("FARM", "Farm", "A render farm, which also makes meshes, foam and pictures of the frames"),
        ],
    )
    farm: bpy.props.EnumProperty(
        name="Engine",
        description="The render farm",
        items=[
            ("SLURM", "Slurm", "By sbatch"),
            ("FLAMENCO", "Flamenco", "Flamenco 3, by curl"),
            ("OPENCUE", "OpenCue", "By PyOutline"),
        ],
    )
    farm_folder: bpy.props.StringProperty(
        name="Folder",
        description="Where the job and its results go, under the same path on all machines of the farm",
        subtype="DIR_PATH",
    )
    farm_make: bpy.props.EnumProperty(
        name="Make",
        description="What is made of the frames",
        items=[
            ("MESH", "Meshes", "Meshes of the surface"),
            ("FOAM", "Foam", "Spray, foam and bubbles"),
            ("RENDER", "Pictures", "Pictures of the fluid, with its foam where there is some"),
        ],
        options={"ANIMATABLE", "ENUM_FLAG"},
        default={"MESH"},
    )
    farm_chunk: bpy.props.IntProperty(
        name="Frames of a task",
        description="Frames of a task at most, in what is made in parallel",
        min=1,
        soft_max=1000,
        default=10,
    )
    contact: bpy.props.EnumProperty(
        name="Contact",
        description="What becomes of particles that meet it",
        items=choices(abi.RlvFluidContact),
        default="SLIP",
    )
    slide: bpy.props.FloatProperty(
        name="Friction",
        description="Coulomb's coefficient of friction, without unit",
        min=0,
        soft_max=1,
        default=0.3,
        precision=3,
    )
    show: bpy.props.EnumProperty(
        name="Show",
        description="What is shown of a frame",
        items=[
            ("PARTICLES", "Particles", "The points of the particles"),
            ("SURFACE", "Surface", "The mesh of the surface, from the cache or made when it is shown"),
        ],
        update=_changed("fluid"),
    )
    function: bpy.props.EnumProperty(
        name="Surface of",
        description="How the surface is made of particles",
        items=choices(abi.RlvIsosurfaceFunction),
        default="ZHU_BRIDSON",
        update=_changed("fluid"),
    )
    cell: bpy.props.FloatProperty(
        name="Cell size",
        description="Size of the mesh's cells, in halves of the spacing",
        min=0.1,
        max=4,
        default=1,
        update=_changed("fluid"),
    )
    smoothing: bpy.props.IntProperty(
        name="Smoothing", description="Steps that smooth the mesh", min=0, max=1000, default=4, update=_changed("fluid")
    )
    result: bpy.props.PointerProperty(name="Result", description="What shows the fluid", type=bpy.types.Object)
    domain: bpy.props.PointerProperty(
        name="Domain", description="The domain whose result this object is", type=bpy.types.Object
    )
    cache: bpy.props.StringProperty(
        name="Cache", description="The folder of the frames; the path that the result has of it comes first"
    )
    pace: bpy.props.FloatProperty(description="Seconds that a particle took for a frame when it was simulated last")
    estimate: bpy.props.StringProperty(description="What a simulation is expected to take")
    first: bpy.props.IntProperty(description="The first frame of the cache")
    last: bpy.props.IntProperty(description="The last frame of the cache")


class RelievoDecalPin(bpy.types.PropertyGroup):
    """A point of the image of a decal and the place of the object that it belongs to."""

    image: bpy.props.FloatVectorProperty(
        name="Image", description="The point of the image, pixels from the lower left corner", size=2
    )
    position: bpy.props.FloatVectorProperty(
        name="Position",
        description="The nearest place of the surface is meant, in the space of the object",
        size=3,
        precision=4,
    )
    depth: bpy.props.FloatProperty(
        name="Depth", description="Where the image overlaps itself, the part near pins of larger depths lies on top"
    )


class RelievoDecal(bpy.types.PropertyGroup):
    """The decal of an object."""

    image: bpy.props.PointerProperty(name="Image", description="The image of the decal", type=bpy.types.Image)
    pins: bpy.props.CollectionProperty(type=RelievoDecalPin)
    active: bpy.props.IntProperty(name="Active pin")
    width: bpy.props.FloatProperty(
        name="Width", description="With one pin: the width of the image, object units", min=1e-6, default=1, precision=4
    )
    up: bpy.props.FloatVectorProperty(
        name="Up",
        description="With one pin: the direction of the object that is up in the image",
        size=3,
        default=(0, 0, 1),
    )
    overlap: bpy.props.BoolProperty(name="Overlap", description="Let the image lie on itself, as around a finger")
    kind: bpy.props.EnumProperty(
        name="Kind",
        description="What is written into the layer",
        items=[
            ("PAINT", "Paint", "Paint the colours of the image"),
            ("RELIEF", "Relief", "Raise the surface where the image is white"),
        ],
    )
    opacity: bpy.props.FloatProperty(
        name="Opacity", description="How much of the image is painted, 0 to 1", min=0, max=1, default=1, subtype="FACTOR"
    )
    height: bpy.props.FloatProperty(
        name="Height", description="How much white raises the surface, object units", default=0.05, precision=4
    )
    offset: bpy.props.FloatProperty(
        name="Offset", description="How far the mesh lies above the surface, object units", default=0.001, precision=5
    )
    mesh: bpy.props.PointerProperty(name="Mesh", description="The mesh of the decal", type=bpy.types.Object)
    owner: bpy.props.PointerProperty(
        name="Owner", description="The object whose decal this mesh is", type=bpy.types.Object
    )


class RelievoObject(bpy.types.PropertyGroup):
    """What an object keeps in the file. `revision` names the state of its detail; Blender's undo brings it back, and
    the detail follows."""

    format: bpy.props.IntProperty(description="Version of the stored data")
    uid: bpy.props.StringProperty()
    revision: bpy.props.IntProperty()
    source: bpy.props.PointerProperty(
        name="Source", description="The object whose result this is", type=bpy.types.Object
    )
    result: bpy.props.PointerProperty(name="Result", description="The displaced mesh", type=bpy.types.Object)
    strokes: bpy.props.CollectionProperty(type=RelievoStroke)
    layers: bpy.props.StringProperty(description="The layers, as JSON, for strokes that are made again")
    playback: bpy.props.EnumProperty(
        name="Playback",
        description="What shows the baked frames",
        items=[
            ("MODIFIER", "Mesh Cache", "Blender's own modifier, also where the add-on is not installed"),
            ("HANDLER", "Add-on", "The add-on, which also shows what is between frames"),
        ],
        update=_changed("playback"),
    )
    cache: bpy.props.StringProperty(
        name="Cache", description="The baked frames; the path that the result has of them comes first"
    )
    repair_report: bpy.props.StringProperty(description="What the last repair found and changed, in lines")
    cache_id: bpy.props.StringProperty(description="What names of this object's bakes have in common")
    ground: bpy.props.FloatVectorProperty(
        description="The colour of what is not painted, linear Rec.709", size=3, default=(0.8, 0.8, 0.8)
    )
    shows_paint: bpy.props.BoolProperty(description="Whether the materials of a result were made to show its paint")
    materials: bpy.props.StringProperty(description="The materials that a result has taken from its object, as JSON")
    faces: bpy.props.StringProperty(description="The checksum of the materials of faces that a result has taken")
    is_preview: bpy.props.BoolProperty(description="Whether the result shows what is not there")
    kind: bpy.props.EnumProperty(
        name="Surface",
        description="What is painted, sculpted and dented",
        items=[
            ("CATMULL_CLARK", "Subdivision surface", "The limit surface with the mesh as its cage"),
            ("TRIANGLES", "Triangles", "The triangles of the mesh as they are"),
        ],
    )
    tile_size: bpy.props.EnumProperty(
        name="Face detail",
        description="Texels along an edge of a face: how fine relief and paint may be",
        items=SIZES,
        default="64",
    )
    segments: bpy.props.EnumProperty(
        name="Face detail",
        description="Segments along an edge of a triangle: how fine relief and paint may be",
        items=SIZES[:4],
        default="16",
    )
    cells: bpy.props.EnumProperty(
        name="Shown cells", description="Cells of the displaced mesh along an edge of a face", items=CELLS, default="AUTO"
    )
    progressive: bpy.props.PointerProperty(type=RelievoProgressive)
    fluid: bpy.props.PointerProperty(type=RelievoFluid)
    decal: bpy.props.PointerProperty(type=RelievoDecal)


class RelievoScene(bpy.types.PropertyGroup):
    """What tools and bakes of a scene use."""

    brush: bpy.props.PointerProperty(type=RelievoBrush)
    imprint: bpy.props.PointerProperty(type=RelievoImprintSettings)
    repair: bpy.props.PointerProperty(type=RelievoRepairSettings)
    image_size: bpy.props.IntProperty(
        name="Image size", description="Width and height of baked images, pixels", min=16, max=16384, default=1024
    )
    traces: bpy.props.BoolProperty(
        name="Traces", description="Keep where and how deep contact was, for bakes", default=False
    )
    handle: bpy.props.PointerProperty(type=RelievoHandle)
    lengths: bpy.props.StringProperty(description="Lengths that follow the size of objects (see `core/lengths.py`), as JSON")


CLASSES = [
    RelievoBrushSettings,
    RelievoStampSettings,
    RelievoImprintSettings,
    RelievoRepairSettings,
    RelievoBrush,
    RelievoStroke,
    RelievoEdit,
    RelievoHook,
    RelievoProgressive,
    RelievoHandle,
    RelievoFluid,
    RelievoDecalPin,
    RelievoDecal,
    RelievoObject,
    RelievoScene,
]


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Object.relievo = bpy.props.PointerProperty(type=RelievoObject)
    bpy.types.Scene.relievo = bpy.props.PointerProperty(type=RelievoScene)


def unregister():
    del bpy.types.Object.relievo, bpy.types.Scene.relievo
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
