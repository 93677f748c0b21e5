"""Renders the meshed surface of a fluid by Cycles, for foam to be laid over it: a picture with depths, and the depths of the
solids alone. Runs in Blender 3.4 or later, or as it is where the package bpy is:

    relievo fluid mesh frames/0014.rlvfluid -o water.ply
    blender --background --python water_cycles.py -- water.ply rock.obj water
    relievo foam composite foam/0014.rlvfluid --picture water.exr --solids water_solids.exr \
        --eye=4.1,-2.0,1.5 --target 1.7,0.5,0.5 --fov 34 -o wave.png
"""

import argparse
import math
import sys

import bpy
import mathutils


# The file has z up.
OBJ_AXES = {"forward_axis": "Y", "up_axis": "Z"}


def vector(text):
    return mathutils.Vector([float(part) for part in text.split(",")])


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("water", help="mesh of the fluid, .ply")
    parser.add_argument("solid", help="mesh of what stands in it, .obj or .ply, z up")
    parser.add_argument("output", help="name of the pictures without their extension")
    parser.add_argument("--eye", type=vector, default="4.1,-2.0,1.5")
    parser.add_argument("--target", type=vector, default="1.7,0.5,0.5")
    parser.add_argument("--fov", type=float, default=34.0, help="vertical field of view, degrees")
    parser.add_argument("--size", default="960x540")
    parser.add_argument("--samples", type=int, default=48)
    parser.add_argument("--sun", type=vector, default="-0.55,-0.45,0.7", help="direction to the sun")
    given = sys.argv[1:]
    return parser.parse_args(given[given.index("--") + 1 :] if "--" in given else given)


def read(path):
    """Returns the objects of a mesh file."""
    before = set(bpy.data.objects)
    if path.endswith(".obj"):
        bpy.ops.wm.obj_import(filepath=path, **OBJ_AXES)
    elif hasattr(bpy.types, "WM_OT_ply_import"):
        bpy.ops.wm.ply_import(filepath=path)
    else:
        bpy.ops.import_mesh.ply(filepath=path)
    return [one for one in bpy.data.objects if one not in before]


def material(name, build):
    """Returns a material whose nodes `build` adds."""
    made = bpy.data.materials.new(name)
    if made.node_tree is None:
        made.use_nodes = True
    made.node_tree.nodes.clear()
    build(made.node_tree.nodes, made.node_tree.links, made.node_tree.nodes.new("ShaderNodeOutputMaterial"))
    return made


def water(nodes, links, output):
    """Glass of water's index that lets the sun through, and absorbs 0.45, 0.09 and 0.06 of red, green and blue a metre."""
    glass, clear = nodes.new("ShaderNodeBsdfGlass"), nodes.new("ShaderNodeBsdfTransparent")
    glass.inputs["IOR"].default_value, glass.inputs["Roughness"].default_value = 1.333, 0.0
    clear.inputs["Color"].default_value = (0.85, 0.95, 0.97, 1)
    path, mix = nodes.new("ShaderNodeLightPath"), nodes.new("ShaderNodeMixShader")
    links.new(path.outputs["Is Shadow Ray"], mix.inputs["Fac"])
    links.new(glass.outputs[0], mix.inputs[1])
    links.new(clear.outputs[0], mix.inputs[2])
    links.new(mix.outputs[0], output.inputs["Surface"])
    inside = nodes.new("ShaderNodeVolumeAbsorption")
    inside.inputs["Color"].default_value = (0.1, 0.82, 0.88, 1)
    inside.inputs["Density"].default_value = 0.5
    links.new(inside.outputs[0], output.inputs["Volume"])


def diffuse(color):
    """Returns what builds a material of one colour, or of a chequered floor if it has none."""

    def build(nodes, links, output):
        matte = nodes.new("ShaderNodeBsdfDiffuse")
        if color is None:
            squares, place = nodes.new("ShaderNodeTexChecker"), nodes.new("ShaderNodeTexCoord")
            squares.inputs["Scale"].default_value = 2.0
            squares.inputs["Color1"].default_value, squares.inputs["Color2"].default_value = (0.5,) * 3 + (1,), (0.4,) * 3 + (1,)
            links.new(place.outputs["Object"], squares.inputs["Vector"])
            links.new(squares.outputs["Color"], matte.inputs["Color"])
        else:
            matte.inputs["Color"].default_value = color
        links.new(matte.outputs[0], output.inputs["Surface"])

    return build


def dress(objects, look):
    for one in objects:
        one.data.polygons.foreach_set("use_smooth", [True] * len(one.data.polygons))
        one.data.materials.clear()
        one.data.materials.append(look)


def light(scene, sun):
    """Adds a sun and a sky that is brighter at the horizon."""
    lamp = bpy.data.objects.new("sun", bpy.data.lights.new("sun", "SUN"))
    lamp.data.energy, lamp.data.angle = 3.0, 0.05
    lamp.rotation_euler = sun.to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(lamp)
    scene.world = bpy.data.worlds.new("sky")
    if scene.world.node_tree is None:
        scene.world.use_nodes = True
    nodes, links = scene.world.node_tree.nodes, scene.world.node_tree.links
    nodes.clear()
    place, parts, ramp = (nodes.new(f"ShaderNode{kind}") for kind in ("TexCoord", "SeparateXYZ", "ValToRGB"))
    shine, output = nodes.new("ShaderNodeBackground"), nodes.new("ShaderNodeOutputWorld")
    ramp.color_ramp.elements[0].color, ramp.color_ramp.elements[1].color = (0.62, 0.7, 0.78, 1), (0.2, 0.36, 0.62, 1)
    links.new(place.outputs["Generated"], parts.inputs[0])
    links.new(parts.outputs["Z"], ramp.inputs["Fac"])
    links.new(ramp.outputs["Color"], shine.inputs["Color"])
    links.new(shine.outputs[0], output.inputs["Surface"])


def look_from(scene, eye, target, fov):
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    camera.data.sensor_fit, camera.data.angle_y = "VERTICAL", math.radians(fov)
    camera.location, camera.rotation_euler = eye, (eye - target).to_track_quat("Z", "Y").to_euler()
    camera.data.clip_end = 1000.0
    scene.collection.objects.link(camera)
    scene.camera = camera


def render(scene, path, samples):
    """Renders the picture and its depths into one file."""
    scene.render.engine, scene.cycles.samples = "CYCLES", samples
    try:
        scene.cycles.use_denoising = samples > 1
        scene.cycles.denoiser = "OPENIMAGEDENOISE"
    except TypeError:
        # This build of Blender has no denoiser.
        scene.cycles.use_denoising = False
    scene.view_layers[0].use_pass_z = True
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    scene.render.filepath = path
    bpy.ops.render.render(write_still=True)


def main():
    options = arguments()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.resolution_x, scene.render.resolution_y = map(int, options.size.split("x"))
    fluid = read(options.water)
    dress(fluid, material("water", water))
    dress(read(options.solid), material("rock", diffuse((0.22, 0.2, 0.18, 1))))
    bpy.ops.mesh.primitive_plane_add(size=60, location=(1.5, 0.5, -0.01))
    dress([bpy.context.object], material("floor", diffuse(None)))
    light(scene, options.sun)
    look_from(scene, options.eye, options.target, options.fov)
    # Single bright samples behind the water would stay as dots.
    scene.cycles.sample_clamp_direct, scene.cycles.sample_clamp_indirect = 2.0, 1.0
    scene.cycles.max_bounces, scene.cycles.transmission_bounces = 12, 12
    render(scene, f"{options.output}.exr", options.samples)
    for one in fluid:
        one.hide_render = True
    render(scene, f"{options.output}_solids.exr", 1)


main()
