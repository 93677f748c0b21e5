"""Makes a .blend file to try the add-on with: a track in snow, a painted and sculpted ball, a label on a bottle, a wave, and a mesh
with levels, each in a collection of its own, with a camera and a light.

    blender --background --addons relievo --python examples/blender/demo.py -- demo.blend

Caches go to a folder beside the file."""

import json
import math
import os
import sys

import bpy


def grid(name, cells, size, height=lambda x, y: 0.0):
    """A square of quads about the origin, with texture coordinates."""
    step = size / cells
    places = [(column * step - size / 2, row * step - size / 2) for row in range(cells + 1) for column in range(cells + 1)]
    across = cells + 1
    first = [row * across + column for row in range(cells) for column in range(cells)]
    made = bpy.data.meshes.new(name)
    made.from_pydata([(x, y, height(x, y)) for x, y in places], [], [(n, n + 1, n + 1 + across, n + across) for n in first])
    layer = made.uv_layers.new(name="UVMap")
    for loop in made.loops:
        x, y = places[loop.vertex_index]
        layer.data[loop.index].uv = (x / size + 0.5, y / size + 0.5)
    return made


def turned(name, profile, sides):
    """A closed mesh of quads around the z axis, of radii and heights from the bottom up; its ends are faces of all sides."""
    points = [
        (radius * math.cos(2 * math.pi * side / sides), radius * math.sin(2 * math.pi * side / sides), height)
        for radius, height in profile
        for side in range(sides)
    ]
    faces = [
        (row * sides + side, row * sides + (side + 1) % sides, (row + 1) * sides + (side + 1) % sides, (row + 1) * sides + side)
        for row in range(len(profile) - 1)
        for side in range(sides)
    ]
    faces += [tuple(reversed(range(sides))), tuple(range((len(profile) - 1) * sides, len(profile) * sides))]
    made = bpy.data.meshes.new(name)
    made.from_pydata(points, [], faces)
    return made


def ball(name, radius, rings=12):
    """A ball of quads, with faces of many sides at its poles."""
    angles = [math.pi * (row + 0.5) / rings - math.pi / 2 for row in range(rings)]
    return turned(name, [(radius * math.cos(angle), radius * math.sin(angle)) for angle in angles], 2 * rings)


def add(collection, data, place=(0, 0, 0), color=None):
    """An object of a mesh in a collection."""
    made = bpy.data.objects.new(data.name, data)
    made.location = place
    collection.objects.link(made)
    data.polygons.foreach_set("use_smooth", [True] * len(data.polygons))
    if color is not None:
        material = bpy.data.materials.new(data.name)
        material.use_nodes = True
        material.diffuse_color = (*color, 1)
        surface = next(node for node in material.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
        surface.inputs["Base Color"].default_value = (*color, 1)
        data.materials.append(material)
    bpy.context.view_layer.update()
    return made


def collection(name):
    made = bpy.data.collections.new(name)
    bpy.context.scene.collection.children.link(made)
    return made


def choose(active, *others):
    for one in bpy.context.view_layer.objects:
        one.select_set(one == active or one in others)
    bpy.context.view_layer.objects.active = active


def snow(at):
    """A ball that rolls over a field of snow, which the file keeps as what presses; the track is baked to a cache."""
    parts, scene = collection("Track in snow"), bpy.context.scene
    field = add(parts, grid("Snow", 12, 3), (at, 0, 0), (0.85, 0.88, 0.92))
    presser = add(parts, ball("Snowball", 0.35), (at - 1.2, -0.9, 0.2), (0.8, 0.35, 0.1))
    for frame, x in ((scene.frame_start, -1.0), (scene.frame_end, 1.0)):
        presser.location = (at + x, 0.6 * math.sin(2.5 * x), 0.22)
        presser.keyframe_insert("location", frame=frame)
    choose(field, presser)
    bpy.ops.relievo.press_add()
    bpy.ops.relievo.preset_imprint(preset="SNOW")
    scene.relievo.imprint.voxels = 2**20
    choose(field)
    bpy.ops.relievo.imprint(cache=True)


def painted(at):
    """A ball with a ring that is sculpted, and a band of paint on a layer of its own."""
    shell = add(collection("Paint and sculpt"), ball("Shell", 0.9), (at, 0, 0.9), (0.75, 0.68, 0.55))
    brush = bpy.context.scene.relievo.brush
    ring = lambda tilt, size: [
        [at + size * math.cos(turn), size * math.sin(turn), 0.9 + tilt * math.sin(3 * turn)]
        for turn in [2 * math.pi * number / 48 for number in range(49)]
    ]
    choose(shell)
    brush.settings.radius, brush.height, brush.sculpt_mode = 0.14, 0.08, "DRAW"
    bpy.ops.relievo.stroke(action="SCULPT", points=json.dumps(ring(0.25, 0.88)))
    bpy.ops.relievo.layer_add(kind="COLOR", name="Stripe")
    brush.color, brush.settings.radius = (0.02, 0.25, 0.35, 1), 0.1
    bpy.ops.relievo.stroke(action="PAINT", points=json.dumps(ring(0.25, 0.88)))


def label(at):
    """A bottle with a label whose four pins can be dragged."""
    profile = [(0.38, 0.0), (0.4, 0.1), (0.4, 1.0), (0.36, 1.15), (0.15, 1.35), (0.13, 1.7)]
    bottle = add(collection("Decal"), turned("Bottle", profile, 24), (at, 0, 0), (0.06, 0.2, 0.08))
    side = 128
    image = bpy.data.images.new("Label", side, side, alpha=True)
    pixels = []
    for y in range(side):
        for x in range(side):
            inner = min(x, y, side - 1 - x, side - 1 - y) > 8
            is_light = inner and (x // 16 + y // 16) % 2
            pixels += (0.9, 0.82, 0.6, 1.0) if is_light else (0.35, 0.08, 0.06, 1.0)
    image.pixels.foreach_set(pixels)
    image.pack()
    bottle.relievo.decal.image = image
    choose(bottle)
    for u in (16, 112):
        for v in (16, 112):
            angle = 1.6 * (u / side - 0.5)
            bpy.ops.relievo.decal_pin_add(
                image=(u, v), position=(0.4 * math.sin(angle), -0.4 * math.cos(angle), 0.55 + 0.7 * (v / side - 0.5))
            )
    bpy.ops.relievo.decal_mesh()


def wave(at):
    """A dam that breaks against a post, as particles that become a surface."""
    parts, scene = collection("Wave"), bpy.context.scene
    scene.cursor.location = (at, 0, 0)
    bpy.ops.relievo.fluid_add(role="DOMAIN", size=2)
    domain = bpy.context.object
    bpy.ops.relievo.fluid_add(role="FILL", size=2)
    fill = bpy.context.object
    fill.location.x -= 0.65
    post = add(parts, turned("Post", [(0.12, -0.05), (0.12, 1.2)], 16), (at + 0.4, 0.1, 0), (0.5, 0.4, 0.3))
    post.relievo.fluid.role = "COLLIDER"
    for one in (domain, fill):
        for other in one.users_collection:
            other.objects.unlink(one)
        parts.objects.link(one)
    choose(domain)
    bpy.ops.relievo.preset_fluid(preset="WATER")
    domain.relievo.fluid.spacing = 0.07
    bpy.ops.relievo.fluid_estimate()
    bpy.ops.relievo.fluid_simulate()
    domain.relievo.fluid.show = "SURFACE"
    scene.cursor.location = (0, 0, 0)


def levels(at):
    """A hill at a twentieth of its triangles, whose levels are a slider."""
    height = lambda x, y: 0.8 * math.exp(-2 * (x * x + y * y)) + 0.05 * math.sin(9 * x) * math.sin(9 * y)
    hill = add(collection("Levels"), grid("Hill", 48, 2, height), (at, 0, 0), (0.3, 0.45, 0.25))
    choose(hill)
    bpy.ops.relievo.levels_build()
    hill.relievo.progressive.ratio = 0.05


def stage(length):
    """A camera and a light that see all of it."""
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0, -1.35 * length, 0.8 * length), (math.radians(61), 0, 0)
    light = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    light.data.energy, light.rotation_euler = 3.0, (math.radians(50), math.radians(-20), 0)
    for one in (camera, light):
        scene.collection.objects.link(one)
    scene.camera = camera


def build(path):
    """Makes the file at a path."""
    bpy.ops.wm.read_homefile(use_factory_startup=True, use_empty=True)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, 12
    # Caches lie beside a file that is there.
    bpy.ops.wm.save_as_mainfile(filepath=path)
    for number, part in enumerate((snow, painted, label, wave, levels)):
        part(3.2 * (number - 2))
    stage(15)
    scene.frame_set(scene.frame_end)
    bpy.ops.wm.save_as_mainfile(filepath=path)


if __name__ == "__main__":
    build(os.path.abspath(sys.argv[sys.argv.index("--") + 1] if "--" in sys.argv else "demo.blend"))
