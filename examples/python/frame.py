"""Renders a frame that a scene wrote for Blender in Cycles, and on it a decal that is a mesh, if one is given:

    relievo scene run bottle/bare.toml --out bare
    relievo decal mesh bare/mesh-000000-bottle.ply -o decal.obj --image bottle/sticker.png --contour 0.5 --offset 0.004 $(cat bottle/pins.txt)
    python frame.py bare/scene-000000.py -o mesh.png --decal decal.obj --image bottle/sticker.png

Needs bpy from PyPI, or runs as `blender --background --python frame.py -- ...`."""

import argparse
import pathlib
import runpy
import sys

import bpy


def read_obj(path):
    """Returns points, triangles, and texture coordinates of the corners."""
    points, places, triangles, uvs = [], [], [], []
    for line in pathlib.Path(path).read_text().splitlines():
        word, *values = line.split() or [""]
        if word == "v":
            points.append([float(value) for value in values[:3]])
        elif word == "vt":
            places.append([float(value) for value in values[:2]])
        elif word == "f":
            corners = [corner.split("/") for corner in values]
            triangles.append([int(corner[0]) - 1 for corner in corners])
            uvs.extend(places[int(corner[1]) - 1] for corner in corners)
    return points, triangles, uvs


def material(image):
    """Returns a material that shows an image with its alpha, and nothing beyond it."""
    made = bpy.data.materials.new("decal")
    if made.node_tree is None:
        made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    texture = nodes.new("ShaderNodeTexImage")
    texture.image, texture.extension = bpy.data.images.load(str(pathlib.Path(image).resolve())), "CLIP"
    shader = nodes["Principled BSDF"].inputs
    shader["Roughness"].default_value = 0.4
    links.new(texture.outputs["Color"], shader["Base Color"])
    links.new(texture.outputs["Alpha"], shader["Alpha"])
    return made


parser = argparse.ArgumentParser()
parser.add_argument("script", help="scene-000000.py of the frame")
parser.add_argument("-o", "--output", required=True, help="the picture, PNG")
parser.add_argument("--decal", help="a mesh of `relievo decal mesh`, OBJ")
parser.add_argument("--image", help="the image of the decal")
parser.add_argument("--samples", type=int, default=64)
arguments = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else None)
if arguments.decal and not arguments.image:
    parser.error("--decal needs --image")

scene = runpy.run_path(arguments.script)["scene"]
if arguments.decal:
    points, triangles, uvs = read_obj(arguments.decal)
    mesh = bpy.data.meshes.new("decal")
    mesh.from_pydata(points, [], triangles)
    mesh.polygons.foreach_set("use_smooth", [True] * len(triangles))
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", [value for uv in uvs for value in uv])
    mesh.materials.append(material(arguments.image))
    scene.collection.objects.link(bpy.data.objects.new("decal", mesh))
scene.cycles.samples = arguments.samples
scene.cycles.use_denoising = True
scene.render.image_settings.file_format = "PNG"
scene.render.filepath = str(pathlib.Path(arguments.output).resolve())
bpy.ops.render.render(write_still=True, scene=scene.name)
