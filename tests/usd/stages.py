"""What the tests of USD share: the command, and a scene whose meshes of all frames go to one stage."""

import os
import subprocess
from pathlib import Path

import numpy

# A ball that turns and goes along x presses a track into a plate.
SCENE = """version = 1
up = "{up}"
units = "{units}"
fps = 25
[meshes.plate]
shape = "plane"
size = [2, 2, 1]
faces = 4
[meshes.ball]
shape = "sphere"
radius = 0.4
faces = 4
[surfaces.plate]
mesh = "plate"
[objects.plate]
surface = "plate"
detail = {{ tile_size = 16 }}
[objects.ball]
mesh = "ball"
[bodies.ball]
shape = "none"
keyframes = [
    {{ time = 0, translation = {begin} }},
    {{ time = 0.2, translation = {end}, rotation = [0, 0, 45] }},
]
[colliders.ball]
[output]
frames = 6
pictures = []
mesh = "every"
mesh_formats = ["usda", "ply"]
rate = 4
mesh_rate = 16
"""
FRAMES = 6


def command(*arguments):
    """What the command prints."""
    made = subprocess.run([os.environ["RELIEVO_COMMAND"], *map(str, arguments)], capture_output=True, text=True)
    assert made.returncode == 0, made.stderr
    return made.stdout


def run(folder, up="z", units="m"):
    """Runs the scene; returns the folder of its files."""
    begin, end = [-0.5, 0.0, 0.3], [0.5, 0.0, 0.3]
    if up == "y":
        begin, end = ([x, z, -y] for x, y, z in (begin, end))
    scene = Path(folder) / "scene.toml"
    scene.write_text(SCENE.format(up=up, units=units, begin=begin, end=end))
    command("scene", "run", scene, "--out", Path(folder) / "out")
    return Path(folder) / "out"


def ply_points(path):
    """The positions of a PLY file as the scene writes it: binary, with x, y and z first."""
    data = Path(path).read_bytes()
    header, body = data.split(b"end_header\n", 1)
    lines = header.decode().splitlines()
    count, width, inside = 0, 0, False
    for line in lines:
        words = line.split()
        if words[0] == "element":
            inside = words[1] == "vertex"
            count = int(words[2]) if inside else count
        if words[0] == "property" and inside:
            assert words[1] in ("float", "float32"), line
            width += 1
    rows = numpy.frombuffer(body, numpy.float32, count * width).reshape(count, width)
    return rows[:, :3]


def farthest(points, others):
    """How far the point is from its nearest of the others that is farthest from it."""
    parts = numpy.array_split(points, max(len(points) // 200, 1))
    distances = [numpy.linalg.norm(part[:, None] - others[None], axis=2).min(1).max() for part in parts]
    return max(distances)
