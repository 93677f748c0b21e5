# Written by Relievo. Open with: blender --python <this file>; it adds a scene called Relievo.
import json
import math
from pathlib import Path

import bmesh
import bpy
import numpy
from mathutils import Matrix

SCENE = json.loads(r'''@SCENE@''')
ARRAYS = Path(__file__).with_suffix(".bin")


def array(place, kind="<f4"):
    start, count = place
    return numpy.fromfile(ARRAYS, dtype=kind, count=count, offset=start)


def material(entry, is_painted):
    made = bpy.data.materials.new(entry["name"])
    if made.node_tree is None:
        made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    shader = nodes["Principled BSDF"].inputs
    shader["Base Color"].default_value = (*entry["color"], 1.0)
    shader["Roughness"].default_value = entry["roughness"]
    if "Specular" in shader:
        # Before Blender 4.0.
        shader["Specular"].default_value = entry["specular"] / 0.08
    else:
        root = math.sqrt(min(entry["specular"], 0.9))
        shader["IOR"].default_value = (1 + root) / (1 - root)
    if is_painted:
        colors = nodes.new("ShaderNodeAttribute")
        colors.attribute_name = "Color"
        links.new(colors.outputs["Color"], shader["Base Color"])
    return made


def mesh(entry):
    data = entry["mesh"]
    sizes, corners = array(data["sizes"], "<i4"), array(data["corners"], "<i4")
    points = array(data["points"])
    made = bpy.data.meshes.new(entry["name"])
    made.vertices.add(len(points) // 3)
    made.loops.add(len(corners))
    made.polygons.add(len(sizes))
    made.vertices.foreach_set("co", points)
    made.loops.foreach_set("vertex_index", corners)
    starts = numpy.zeros(len(sizes), "<i4")
    numpy.cumsum(sizes[:-1], out=starts[1:])
    made.polygons.foreach_set("loop_start", starts)
    if bpy.app.version < (4, 0):
        made.polygons.foreach_set("loop_total", sizes)
    is_smooth = "normals" in data or "subdivision" in entry
    made.polygons.foreach_set("use_smooth", numpy.full(len(sizes), is_smooth))
    made.update(calc_edges=True)
    if "uv" in data:
        made.uv_layers.new(name="UVMap").data.foreach_set("uv", array(data["uv"]))
    if "colors" in data:
        rgba = numpy.ones((len(points) // 3, 4), "<f4")
        rgba[:, :3] = array(data["colors"]).reshape(-1, 3)
        made.attributes.new("Color", "FLOAT_COLOR", "POINT").data.foreach_set("color", rgba.ravel())
    if "normals" in data:
        if bpy.app.version >= (4, 5):
            attribute = made.attributes.new("custom_normal", "FLOAT_VECTOR", "POINT")
            attribute.data.foreach_set("vector", array(data["normals"]))
        else:
            made.normals_split_custom_set_from_vertices(array(data["normals"]).reshape(-1, 3))
    if hasattr(made, "use_auto_smooth"):
        # Normals of one's own and sharp edges, before Blender 4.1.
        made.use_auto_smooth, made.auto_smooth_angle = True, math.pi
    return made


def creases(made, data):
    """Blender counts sharpness by its root, from 0 to 1."""
    edges = numpy.sort(array(data["edges"], "<i4").reshape(-1, 2), axis=1)
    sharpness = numpy.clip(array(data["sharpness"]) / 10, 0, 1)
    number = {tuple(edge): index for index, edge in enumerate(edges.tolist())}
    ends = numpy.empty(2 * len(made.edges), "<i4")
    made.edges.foreach_get("vertices", ends)
    found = [number.get(tuple(edge), -1) for edge in numpy.sort(ends.reshape(-1, 2), axis=1).tolist()]
    of_edges = numpy.append(sharpness, 0)[found].astype("<f4")
    made.edges.foreach_set("use_edge_sharp", of_edges >= 1)
    of_points = numpy.zeros(len(made.vertices), "<f4")
    of_points[array(data["points"], "<i4")] = numpy.clip(array(data["point_sharpness"]) / 10, 0, 1)
    if bpy.app.version >= (4, 0):
        made.attributes.new("crease_edge", "FLOAT", "EDGE").data.foreach_set("value", numpy.sqrt(of_edges))
        made.attributes.new("crease_vert", "FLOAT", "POINT").data.foreach_set("value", numpy.sqrt(of_points))
        return
    made.edges.foreach_set("crease", numpy.sqrt(of_edges))
    if of_points.any():
        editable = bmesh.new()
        editable.from_mesh(made)
        layer = editable.verts.layers.crease.verify()
        for vertex, value in zip(editable.verts, numpy.sqrt(of_points).tolist()):
            vertex[layer] = value
        editable.to_mesh(made)
        editable.free()


def add(scene, entry):
    data = mesh(entry)
    data.materials.append(material(entry, "colors" in entry["mesh"]))
    made = bpy.data.objects.new(entry["name"], data)
    scene.collection.objects.link(made)
    made.matrix_world = Matrix(entry["matrix"])
    if "subdivision" in entry:
        how = entry["subdivision"]
        creases(data, how)
        modifier = made.modifiers.new("Subdivision", "SUBSURF")
        modifier.levels = modifier.render_levels = how["levels"]
        modifier.quality = 6
        modifier.use_limit_surface = True
        modifier.boundary_smooth = "PRESERVE_CORNERS" if how["corners"] else "ALL"


def camera(scene):
    entry = SCENE["camera"]
    data = bpy.data.cameras.new("Camera")
    data.sensor_fit = "VERTICAL"
    data.lens = 0.5 * data.sensor_height / math.tan(0.5 * entry["fov"])
    made = bpy.data.objects.new("Camera", data)
    scene.collection.objects.link(made)
    made.matrix_world = Matrix(entry["matrix"])
    scene.camera = made
    # From a thousandth of the way to the farthest object to a thousand times it.
    eye = made.matrix_world.translation
    middles = [Matrix(entry["matrix"]).translation for entry in SCENE["objects"]]
    distance = max([(middle - eye).length for middle in middles], default=1.0) or 1.0
    data.clip_start, data.clip_end = 1e-3 * distance, 1e3 * distance


def sun(scene, entry):
    data = bpy.data.lights.new("Sun", "SUN")
    strength = max(entry["irradiance"]) or 1.0
    data.energy = strength
    data.color = [value / strength for value in entry["irradiance"]]
    data.angle = entry["angle"]
    made = bpy.data.objects.new("Sun", data)
    scene.collection.objects.link(made)
    made.matrix_world = Matrix(entry["matrix"])


def sky(scene):
    """The light of the sky by the sine of the elevation, as a ramp of colours."""
    world = bpy.data.worlds.new("Sky")
    scene.world = world
    if world.node_tree is None:
        world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    background = nodes["Background"]
    background.inputs["Color"].default_value = (0, 0, 0, 1)
    entry = SCENE["sky"]
    if entry is None:
        return
    place = nodes.new("ShaderNodeTexCoord")
    height = nodes.new("ShaderNodeVectorMath")
    height.operation = "DOT_PRODUCT"
    height.inputs[1].default_value = entry["up"]
    share = nodes.new("ShaderNodeMath")
    share.operation = "MULTIPLY_ADD"
    share.inputs[1].default_value = share.inputs[2].default_value = 0.5
    ramp = nodes.new("ShaderNodeValToRGB")
    # A ramp's colours are not brighter than 1.
    brightest = max(max(color) for _, color in entry["stops"]) or 1.0
    background.inputs["Strength"].default_value = brightest
    stops = ramp.color_ramp.elements
    stops.remove(stops[1])
    for index, (at, color) in enumerate(entry["stops"]):
        stop = stops.new(0.5 + 0.5 * at) if index else stops[0]
        stop.position = 0.5 + 0.5 * at
        stop.color = (*[value / brightest for value in color], 1.0)
    links.new(place.outputs["Generated"], height.inputs[0])
    links.new(height.outputs["Value"], share.inputs[0])
    links.new(share.outputs["Value"], ramp.inputs["Fac"])
    links.new(ramp.outputs["Color"], background.inputs["Color"])


def build():
    scene = bpy.data.scenes.new("Relievo")
    scene.render.engine = "CYCLES"
    scene.render.resolution_x, scene.render.resolution_y = SCENE["size"]
    scene.render.resolution_percentage = 100
    scene.render.fps = max(1, round(SCENE["fps"]))
    scene.render.fps_base = scene.render.fps / SCENE["fps"]
    scene.frame_current = SCENE["frame"]
    scene.view_settings.view_transform = "Standard"
    scene.view_settings.exposure = SCENE["exposure"]
    camera(scene)
    for entry in SCENE["suns"]:
        sun(scene, entry)
    sky(scene)
    for entry in SCENE["objects"]:
        add(scene, entry)
    if bpy.context.window is not None:
        bpy.context.window.scene = scene
    return scene


scene = build()
