"""Five first tasks in a real window, by the pointer and the keyboard alone, as somebody does them who opens the add-on for the first
time: tracks in snow, a frog that is dented and painted, a decal on a bottle, a wave with foam, a crowd that sinks into sand.
Operators are found by the search (F3). Each task says how long a person takes for its input, and leaves a strip of pictures,
`task_NAME.png`, in the folder of screenshots. `tests/blender/window.py` says how it is run; names after `--` choose tasks."""

import math
import os
import sys
import tempfile
from pathlib import Path

import bpy
import numpy
from bpy_extras import view3d_utils
from mathutils import Euler, Matrix, Vector

sys.path += [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parents[2] / "examples" / "blender")]

import demo
import events
import host
from events import area, event, only_our_panels, open_tab, override, plain, region, run, screenshot, until, wait

# Seconds of a person for what the input has: a key that is typed, a key that is known, a click that aims, a drag.
TYPED, KEY, CLICK, DRAG = 0.3, 1.0, 2.0, 4.0
# The longest that a task may take, seconds.
LONGEST = 300
KEYS = {" ": "SPACE", "-": "MINUS", ".": "PERIOD", **dict(zip("0123456789", "ZERO ONE TWO THREE FOUR FIVE SIX SEVEN EIGHT NINE".split()))}


class Task:
    """Counts the input of a task, and keeps its pictures."""

    def __init__(self, name):
        self.name, self.seconds, self.pictures = name, 0.0, []

    def key(self, kind, **held):
        """Presses a key over the view."""
        self.seconds += KEY
        for value in ("PRESS", "RELEASE"):
            event(kind, value, x=0.45, y=0.5, **held)
        yield from wait(3)

    def type(self, text):
        """Types a text."""
        for letter in text:
            self.seconds += TYPED
            kind = KEYS.get(letter, letter.upper())
            event(kind, "PRESS", x=0.45, y=0.5, unicode=letter)
            event(kind, "RELEASE", x=0.45, y=0.5)
            yield

    def find(self, text):
        """Calls an operator by the search."""
        event("MOUSEMOVE", x=0.45, y=0.5)
        yield from wait(2)
        yield from self.key("F3")
        yield from self.type(text)
        yield from wait(10)
        yield from self.key("RET")
        yield from self.work()

    def work(self):
        """Waits for what is at work."""
        from relievo.core import job

        yield from wait(5)
        yield from until(lambda: not job.is_busy(), 100_000)
        yield from wait(5)

    def click(self, place, **held):
        """Clicks a place of the world."""
        self.seconds += CLICK
        x, y = spot(place)
        event("MOUSEMOVE", x=x, y=y)
        yield from wait(2)
        for value in ("PRESS", "RELEASE"):
            event("LEFTMOUSE", value, x=x, y=y, **held)
            yield
        yield from wait(5)

    def drag(self, places, **held):
        """Drags the left button along places of the world."""
        self.seconds += DRAG
        path = [spot(place) for place in places]
        event("MOUSEMOVE", x=path[0][0], y=path[0][1])
        yield from wait(2)
        event("LEFTMOUSE", "PRESS", x=path[0][0], y=path[0][1], **held)
        yield
        for (ax, ay), (bx, by) in zip(path, path[1:]):
            for share in (0.25, 0.5, 0.75, 1.0):
                event("MOUSEMOVE", x=ax + share * (bx - ax), y=ay + share * (by - ay), **held)
                yield
        event("LEFTMOUSE", "RELEASE", x=path[-1][0], y=path[-1][1])
        yield from wait(10)

    def shoot(self):
        """Adds a picture of the window, half as large, to the strip."""
        yield from wait(10)
        pixels = screenshot("shot.png")
        height, width = (size // 2 * 2 for size in pixels.shape[:2])
        self.pictures.append(pixels[:height, :width].reshape(height // 2, 2, width // 2, 2, 3).mean((1, 3)))

    def end(self):
        """Writes the strip, and checks how long the task took."""
        rows = numpy.ones((self.pictures[0].shape[0], 4, 3), numpy.float32)
        parts = [part for picture in self.pictures for part in (picture, rows)][:-1]
        strip = numpy.concatenate(parts, 1)
        pixels = numpy.concatenate([strip, numpy.ones((*strip.shape[:2], 1), numpy.float32)], 2)
        image = bpy.data.images.new("strip", strip.shape[1], strip.shape[0])
        image.pixels.foreach_set(pixels.astype(numpy.float32).ravel())
        image.filepath_raw, image.file_format = os.path.join(events.FOLDER, f"task_{self.name}.png"), "PNG"
        image.save()
        bpy.data.images.remove(image)
        print(f"{self.name}: {self.seconds:.0f} s of input")
        assert self.seconds < LONGEST, self.seconds


def spot(place):
    """Returns where a place of the world is in the view, 0 to 1."""
    at = view3d_utils.location_3d_to_region_2d(region(), area().spaces.active.region_3d, Vector(place))
    return at[0] / region().width, at[1] / region().height


def look(center, distance, tilt, turn=0.0):
    """Has the view look at a place, tilted from above and turned, radians."""
    space = area().spaces.active.region_3d
    space.view_perspective, space.view_location, space.view_distance = "PERSP", center, distance
    space.view_rotation = Euler((tilt, 0, turn)).to_quaternion()


def clear(frames):
    """Takes away what the last task had, but not the window."""
    for target in list(bpy.data.objects):
        bpy.data.objects.remove(target)
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, frames
    scene.frame_set(1)
    area().spaces.active.shading.color_type = "MATERIAL"
    with override():
        bpy.ops.wm.tool_set_by_id(name="builtin.select_box")
    return scene.collection


def snow(task):
    """A ball that rolls over snow: both are clicked, the material is chosen, and the imprint is baked."""
    parts, scene = clear(16), bpy.context.scene
    field = demo.add(parts, demo.grid("Snow", 12, 3), color=(0.8, 0.84, 0.9))
    ball = demo.add(parts, demo.ball("Snowball", 0.35), color=(0.8, 0.3, 0.08))
    for frame in range(1, 17):
        x = -1.1 + 2.2 * (frame - 1) / 15
        ball.location = (x, 0.5 * math.sin(3 * x), 0.2)
        ball.keyframe_insert("location", frame=frame)
    scene.frame_set(1)
    scene.relievo.imprint.voxels = 2**19
    look((0.2, 0, 0), 4.6, 0.85)
    yield from wait(10)
    yield from task.click(ball.location)
    yield from task.click((0.5, -0.6, 0), shift=True)
    assert bpy.context.object == field and ball.select_get(), bpy.context.object
    yield from task.shoot()
    yield from task.find("snow")
    assert abs(scene.relievo.imprint.rim - 0.1) < 1e-6, scene.relievo.imprint.rim
    yield from task.find("bake imprint to cache")
    assert field.relievo.cache, "nothing was baked"
    assert host.positions(field.relievo.result)[:, 2].min() < -0.1 or scene.frame_current == 1
    scene.frame_set(8)
    yield from task.shoot()
    yield from task.key("RIGHT_ARROW", shift=True)
    assert scene.frame_current == 16, scene.frame_current
    yield from task.shoot()
    deep = host.evaluated(field.relievo.result)[:, 2].min()
    assert deep < -0.1, deep


def frog_of(parts):
    """A frog of metaballs, as a mesh of triangles."""
    made = bpy.data.metaballs.new("Frog")
    made.resolution = 0.06
    body = [(0, 0.1, 0.42, 0.62, (1, 1.25, 0.8)), (0, -0.62, 0.62, 0.42, (1.15, 0.9, 0.75))]
    for side in (-1, 1):
        body += [
            (0.26 * side, -0.62, 0.98, 0.19, (1, 1, 1)),
            (0.62 * side, 0.5, 0.28, 0.42, (0.75, 1.15, 0.7)),
            (0.8 * side, 0.0, 0.08, 0.3, (0.7, 1.3, 0.45)),
            (0.5 * side, -0.55, 0.12, 0.24, (0.7, 0.9, 1)),
        ]
    for x, y, z, radius, size in body:
        ball = made.elements.new(type="ELLIPSOID")
        ball.co, ball.radius = (x, y, z), 2 * radius
        ball.size_x, ball.size_y, ball.size_z = (axis * 0.9 for axis in size)
    source = bpy.data.objects.new("Frog source", made)
    parts.objects.link(source)
    bpy.context.view_layer.update()
    data = bpy.data.meshes.new_from_object(source.evaluated_get(bpy.context.evaluated_depsgraph_get()))
    data.name = "Frog"
    bpy.data.objects.remove(source)
    return demo.add(parts, data, color=(0.12, 0.4, 0.08))


def frog(task):
    """A frog that is dented with Ctrl and painted with stripes."""
    target = frog_of(clear(1))
    target.relievo.kind = "TRIANGLES"
    target.relievo.segments = "16"
    scene = bpy.context.scene
    look((0, 0, 0.45), 3.6, 0.95, 0.5)
    yield from wait(10)
    yield from task.click((0, 0.1, 0.85))
    assert bpy.context.object == target, bpy.context.object
    yield from task.shoot()
    yield from task.find("relief sculpt tool")
    brush = scene.relievo.brush
    brush.settings.radius, brush.height = 0.22, 0.1
    yield from task.drag([top(-0.15, 0.0), top(0.15, 0.2)], ctrl=True)
    yield from task.drag([top(-0.25, 0.45), top(0.1, 0.6)], ctrl=True)
    assert len(target.relievo.strokes) == 2, len(target.relievo.strokes)
    yield from task.shoot()
    yield from task.find("relief paint tool")
    brush.settings.radius, brush.color = 0.1, (0.85, 0.55, 0.02, 1)
    for side in (-0.3, 0.3):
        yield from task.drag([top(0.4 * side, -0.75), top(side, -0.35), top(1.2 * side, 0.0), top(1.2 * side, 0.4)])
    assert len(target.relievo.strokes) == 4, len(target.relievo.strokes)
    yield from task.shoot()


def top(x, y):
    """Returns the highest place that is seen at x and y."""
    graph = bpy.context.evaluated_depsgraph_get()
    hit, place, *_ = bpy.context.scene.ray_cast(graph, (x, y, 9), (0, 0, -1))
    assert hit, (x, y)
    return place


def picture():
    """A label of 256 pixels: a border, a sun over hills."""
    y, x = numpy.mgrid[0:256, 0:256] / 255.0
    pixels = numpy.ones((256, 256, 4), numpy.float32)
    pixels[..., :3] = (0.92, 0.85, 0.66)
    pixels[numpy.hypot(x - 0.5, y - 0.6) < 0.2, :3] = (0.8, 0.25, 0.05)
    pixels[y < 0.35 + 0.1 * numpy.sin(7 * x), :3] = (0.1, 0.3, 0.18)
    pixels[(numpy.minimum(x, y) < 0.04) | (numpy.maximum(x, y) > 0.96), :3] = (0.35, 0.06, 0.05)
    made = bpy.data.images.new("Label", 256, 256, alpha=True)
    made.pixels.foreach_set(pixels.ravel())
    made.pack()
    return made


def bottle(task):
    """A label that is pinned to a bottle, dragged, and painted into it."""
    side = [(0.4, 0.1 + 0.15 * number) for number in range(7)]
    neck = [(0.38, 1.1), (0.3, 1.25), (0.17, 1.36), (0.14, 1.45), (0.13, 1.6), (0.13, 1.68)]
    profile = [(0.1, 0.0), (0.36, 0.0), (0.4, 0.03), *side, *neck, (0.15, 1.69), (0.15, 1.75), (0.13, 1.76), (0.05, 1.76)]
    target = demo.add(clear(1), demo.turned("Bottle", profile, 32), color=(0.05, 0.25, 0.1))
    target.relievo.decal.image = picture()
    look((0, 0, 0.85), 3.0, 1.35)
    yield from wait(10)
    yield from task.click((0, -0.4, 0.6))
    yield from task.find("pin tool")
    yield from task.click((0.1, -0.39, 0.45), ctrl=True)
    assert len(target.relievo.decal.pins) == 1, len(target.relievo.decal.pins)
    target.relievo.decal.width = 0.75
    yield from task.shoot()
    yield from task.find("decal mesh")
    shown = target.relievo.decal.mesh
    assert shown is not None and len(shown.data.polygons), "there is no decal"
    area().spaces.active.shading.color_type = "TEXTURE"
    yield from task.shoot()
    yield from task.drag([target.relievo.decal.pins[0].position, (-0.02, -0.4, 0.62)])
    yield from task.work()
    assert abs(target.relievo.decal.pins[0].position[2] - 0.62) < 0.05, tuple(target.relievo.decal.pins[0].position)
    yield from task.shoot()
    area().spaces.active.shading.color_type = "MATERIAL"
    yield from task.find("apply to layer")
    assert len(target.relievo_layers.rows), "nothing was painted"
    shown.hide_set(True)
    assert area().spaces.active.shading.color_type == "VERTEX", "the paint is not seen"
    yield from task.shoot()


def wave(task):
    """A dam that breaks, with foam: a fill and a domain from the Add menu, simulated, and its foam baked."""
    clear(20)
    scene = bpy.context.scene
    look((0, 0, 0.5), 4.2, 1.1, 0.5)
    yield from wait(10)
    yield from task.find("fluid fill")
    fill = bpy.context.object
    for key in ("G", "X"):
        yield from task.key(key)
    yield from task.type("-0.6")
    yield from task.key("RET")
    assert abs(fill.location.x + 0.6) < 1e-3 or abs(fill.location.x - fill.location.x) > 1, tuple(fill.location)
    yield from task.find("fluid domain")
    domain = bpy.context.object
    assert domain.relievo.fluid.role == "DOMAIN" and fill.relievo.fluid.role == "FILL"
    domain.relievo.fluid.spacing = 0.045
    yield from task.find("water")
    yield from task.shoot()
    yield from task.find("simulate")
    assert domain.relievo.fluid.last == 20, domain.relievo.fluid.last
    scene.frame_set(9)
    yield from task.shoot()
    settings = domain.relievo_foam.settings
    settings.energy_min, settings.energy_max, settings.air_min, settings.air_max = 1, 8, 2, 10
    settings.air_rate = settings.crest_rate = 200
    domain.relievo.fluid.show = "SURFACE"
    blue = bpy.data.materials.new("Blue")
    blue.diffuse_color = (0.05, 0.22, 0.45, 1)
    domain.relievo.fluid.result.data.materials.append(blue)
    yield from task.find("bake foam")
    foam = domain.relievo_foam.result
    assert foam is not None, "there is no foam"
    for frame in (12, 20):
        scene.frame_set(frame)
        yield from task.shoot()
    assert len(foam.data.vertices) > 1000, len(foam.data.vertices)


def robot(parts):
    """A robot of two legs that walks on the spot, an armature with a mesh, in a collection of its own."""
    own = bpy.data.collections.new("Robots")
    bpy.context.scene.collection.children.link(own)
    rig = bpy.data.objects.new("Rig", bpy.data.armatures.new("Rig"))
    own.objects.link(rig)
    host.select(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    for name, x, low, high in (("Body", 0.0, 0.6, 1.4), ("Left", -0.16, 0.6, 0.0), ("Right", 0.16, 0.6, 0.0)):
        bone = rig.data.edit_bones.new(name)
        bone.head, bone.tail = (x, 0, low), (x, 0, high)
    bpy.ops.object.mode_set(mode="OBJECT")
    for name, turn in (("Left", 0.5), ("Right", -0.5)):
        bone = rig.pose.bones[name]
        bone.rotation_mode = "XYZ"
        for frame, share in ((1, 1), (7, -1), (13, 1)):
            bone.rotation_euler.x = share * turn
            bone.keyframe_insert("rotation_euler", frame=frame)
    rig.animation_data.action.name = "Walk"
    rig.show_in_front = True
    profiles = {
        "Body": [((0, 0), [(0.2, 0.55), (0.3, 0.7), (0.26, 1.15), (0.08, 1.2), (0.2, 1.3), (0.2, 1.45), (0.1, 1.55)])],
        "Left": [((-0.16, 0), [(0.15, 0.0), (0.15, 0.08), (0.09, 0.14), (0.1, 0.6)])],
        "Right": [((0.16, 0), [(0.15, 0.0), (0.15, 0.08), (0.09, 0.14), (0.1, 0.6)])],
    }
    points, faces, groups = [], [], {}
    for name, rings in profiles.items():
        for (x, y), profile in rings:
            part = demo.turned(name, profile, 16)
            first = len(points)
            points += [(one.co.x + x, one.co.y + y, one.co.z) for one in part.vertices]
            faces += [[first + corner for corner in face.vertices] for face in part.polygons]
            groups.setdefault(name, []).extend(range(first, len(points)))
            bpy.data.meshes.remove(part)
    data = bpy.data.meshes.new("Robot")
    data.from_pydata(points, [], faces)
    made = demo.add(own, data, color=(0.75, 0.35, 0.08))
    for name, numbers in groups.items():
        made.vertex_groups.new(name=name).add(numbers, 1.0, "REPLACE")
    made.parent = rig
    made.modifiers.new("Rig", "ARMATURE").object = rig
    rig.location = (0, 2.6, 0.05)
    own.instance_offset = rig.location
    return own, rig


def crowd(task):
    """Robots that sink into sand: a crowd model is built, its instances become meshes, and these press."""
    parts, scene = clear(13), bpy.context.scene
    sand = demo.add(parts, demo.grid("Sand", 16, 5), color=(0.6, 0.45, 0.25))
    own, rig = robot(parts)
    for number in range(6):
        empty = bpy.data.objects.new(f"Walker {number}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", own
        empty["phase"], empty.empty_display_size = 0.08 * number, 0.2
        parts.objects.link(empty)
        x, y = -1.4 + 1.4 * (number % 3), -0.5 - 1.2 * (number // 3)
        for frame, height in ((1, 0.1), (13, -0.2)):
            empty.location = (x + 0.25 * (frame > 1), y, height)
            empty.keyframe_insert("location", frame=frame)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.location, camera.rotation_euler = (0, -60, 30), (1.1, 0, 0)
    parts.objects.link(camera)
    camera.hide_set(True)
    scene.camera, scene.render.resolution_x = camera, 960
    scene.frame_set(1)
    sand.relievo.tile_size = "32"
    scene.relievo.imprint.voxels = 2**18
    look((0, 0, 0.3), 6.5, 1.0)
    yield from wait(10)
    yield from task.click(rig.matrix_world @ rig.pose.bones["Body"].center)
    assert bpy.context.object == rig, bpy.context.object
    yield from task.shoot()
    yield from task.find("build crowd model")
    assert rig.relievo_crowd.path, "there is no crowd model"
    yield from task.find("show far instances")
    from relievo.ops import crowd as crowds

    shown = [child for child in (crowds.child_of(one) for one in bpy.data.objects if one.name.startswith("Walker")) if child]
    assert len(shown) == 6, len(shown)
    yield from task.key("A")
    for _ in range(2):
        yield from task.click((2.2, -2.2, 0), shift=True)
        if bpy.context.object == sand and sand.select_get():
            break
    assert bpy.context.object == sand and all(one.select_get() for one in shown), bpy.context.object
    yield from task.find("sand")
    assert abs(scene.relievo.imprint.rim - 0.8) < 1e-6, scene.relievo.imprint.rim
    yield from task.find("bake imprint to cache")
    assert sand.relievo.cache, "nothing was baked"
    scene.frame_set(6)
    yield from task.shoot()
    yield from task.key("RIGHT_ARROW", shift=True)
    yield from task.shoot()
    assert host.evaluated(sand.relievo.result)[:, 2].min() < -0.1
    # What they leave.
    for one in shown:
        one.hide_set(True)
    yield from task.shoot()


def repair(task):
    """A ball with holes and faces that are turned over, which is repaired."""
    made = demo.ball("Ball", 1.0, rings=16)
    kept = [face for face in (tuple(one.vertices) for one in made.polygons) if face[0] % 37 > 2]
    points = [tuple(one.co) for one in made.vertices]
    made.clear_geometry()
    made.from_pydata(points, [], [face[::-1] if face[0] % 5 == 0 else face for face in kept])
    target = demo.add(clear(1), made, color=(0.3, 0.45, 0.6))
    area().spaces.active.overlay.show_face_orientation = True
    look((0, 0, 0), 4.2, 1.1, 0.4)
    yield from wait(10)
    yield from task.click(top(0.3, -0.3))
    yield from task.shoot()
    yield from task.find("repair mesh")
    assert target.relievo.repair_report, "nothing was repaired"
    yield from task.shoot()
    area().spaces.active.overlay.show_face_orientation = False


def tissue(task):
    """A block of gel that a stamp presses into."""
    parts, scene = clear(8), bpy.context.scene
    made = {}
    for name, low, high in (("Gel", (0, 0, 0), (0.1, 0.1, 0.05)), ("Bone", (-1, -1, 0), (1, 1, 1)), ("Stamp", (0.03, 0.03, 0.055), (0.07, 0.07, 0.08))):
        points = [(x, y, z) for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])]
        faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6)]
        data = bpy.data.meshes.new(name)
        data.from_pydata(points, [], faces)
        made[name] = demo.add(parts, data, color=(0.8, 0.3, 0.1) if name == "Stamp" else (0.8, 0.5, 0.4))
        data.polygons.foreach_set("use_smooth", [False] * len(data.polygons))
    for name, role in (("Gel", "VOLUME"), ("Bone", "HOLD"), ("Stamp", "COLLIDER")):
        made[name].relievo_tissue.role = role
    data = demo.grid("Skin", 24, 0.1)
    data.transform(Matrix.Translation((0.05, 0.05, 0.05)))
    skin = demo.add(parts, data, color=(0.8, 0.5, 0.4))
    skin.relievo_tissue.role = "SKIN"
    made["Bone"].hide_set(True)
    made["Gel"].display_type = "WIRE"
    for frame, z in ((1, 0.0), (8, -0.02)):
        made["Stamp"].location.z = z
        made["Stamp"].keyframe_insert("location", frame=frame)
    model = parts.relievo_tissue
    model.voxel = 0.0125
    scene.frame_set(1)
    look((0.05, 0.05, 0.03), 0.28, 1.0, 0.4)
    yield from wait(10)
    yield from task.click((0.09, 0.01, 0.05))
    assert bpy.context.object == skin, bpy.context.object
    yield from task.shoot()
    yield from task.find("bake tissue")
    assert skin.relievo_tissue.cache, "nothing was baked"
    yield from task.key("RIGHT_ARROW", shift=True)
    made["Stamp"].hide_set(True)
    yield from task.shoot()
    assert host.evaluated(skin)[:, 2].min() < 0.045


def result(task):
    """A sculpted and painted sheet whose colours are baked to an image on its texture coordinates."""
    target = demo.add(clear(1), demo.grid("Sheet", 8, 2), color=(0.7, 0.68, 0.62))
    brush = bpy.context.scene.relievo.brush
    ring = lambda size, z=0.0: [(size * math.cos(turn), size * math.sin(turn), z) for turn in [math.pi * number / 16 for number in range(33)]]
    host.select(target)
    brush.settings.radius, brush.height, brush.color = 0.15, 0.12, (0.02, 0.25, 0.35, 1)
    host.draw(target, ring(0.6))
    host.draw(target, ring(0.6, 0.11), action="PAINT", radius=0.1)
    host.draw(target, ring(0.25), action="PAINT")
    look((0, 0, 0), 3.4, 0.8, 0.3)
    yield from wait(10)
    area().spaces.active.shading.color_type = "VERTEX"
    yield from task.shoot()
    bpy.context.scene.relievo.image_size = 512
    yield from task.find("bake image color")
    assert any(tuple(one.size) == (512, 512) for one in bpy.data.images), "there is no image"
    yield from task.work()
    area().spaces.active.shading.color_type = "TEXTURE"
    yield from task.shoot()


TASKS = {"snow": snow, "frog": frog, "bottle": bottle, "wave": wave, "crowd": crowd}
# Pictures of the manual that no task has.
MORE = {"repair": repair, "tissue": tissue, "result": result}


def play(names):
    """Does tasks one after the other."""
    host.enable()
    only_our_panels()
    with override():
        bpy.ops.screen.screen_full_area()
    yield from wait()
    space = area().spaces.active
    plain(space)
    space.show_region_ui = True
    space.shading.type, space.shading.color_type = "SOLID", "MATERIAL"
    yield from wait(10)
    yield from open_tab()
    with tempfile.TemporaryDirectory() as folder:
        bpy.context.preferences.addons["relievo"].preferences.cache_folder = folder
        for name in names:
            task = Task(name)
            yield from {**TASKS, **MORE}[name](task)
            task.end()
        bpy.context.scene.frame_set(1)


run(play(host.arguments() or [*TASKS, *MORE]), "tasks")
