"""Writes what examples/crowds/march.toml shows, beside it: a mannequin that walks, and two lists of agents. Run it once:

    python examples/crowds/march.py
    relievo scene run examples/crowds/march.toml --out out/march

The mannequin is made of capsules, each of which one bone moves; its clip of a second swings arms and legs."""

import base64
import json
import math
import random
import struct
from pathlib import Path

FOLDER = Path(__file__).resolve().parent
SIDES, RINGS = 14, 10
POSES = 25  # of a second
SWING = 27  # degrees of the legs to either side
STEP = 0.9 * math.sin(math.radians(SWING)) * 4  # metres a second that the feet go back by
# Bones: name, parent, and where they are at binding, in metres with y up; the mannequin looks along z.
BONES = [
    ("hips", None, (0, 0.92, 0)),
    ("chest", 0, (0, 1.0, 0)),
    ("head", 1, (0, 1.46, 0)),
    ("left thigh", 0, (0.1, 0.9, 0)),
    ("left shin", 3, (0.1, 0.48, 0)),
    ("right thigh", 0, (-0.1, 0.9, 0)),
    ("right shin", 5, (-0.1, 0.48, 0)),
    ("left arm", 1, (0.22, 1.4, 0)),
    ("right arm", 1, (-0.22, 1.4, 0)),
]
# Capsules: the bone that moves it, from where to where, the radius, and how much wider it is along x than along z.
CAPSULES = [
    (0, (0, 0.9, 0), (0, 0.98, 0), 0.11, 1.4),
    (1, (0, 1.06, 0), (0, 1.36, 0), 0.12, 1.45),
    (2, (0, 1.56, 0), (0, 1.64, 0), 0.1, 0.9),
    (3, (0.1, 0.84, 0), (0.1, 0.54, 0), 0.08, 1.0),
    (4, (0.1, 0.44, 0), (0.1, 0.12, 0), 0.06, 1.0),
    (4, (0.1, 0.05, 0), (0.1, 0.05, 0.14), 0.05, 1.0),
    (5, (-0.1, 0.84, 0), (-0.1, 0.54, 0), 0.08, 1.0),
    (6, (-0.1, 0.44, 0), (-0.1, 0.12, 0), 0.06, 1.0),
    (6, (-0.1, 0.05, 0), (-0.1, 0.05, 0.14), 0.05, 1.0),
    (7, (0.24, 1.36, 0), (0.27, 0.86, 0.05), 0.05, 1.0),
    (8, (-0.24, 1.36, 0), (-0.27, 0.86, 0.05), 0.05, 1.0),
]


def capsule(start, end, radius, width):
    """Points, normals and triangles of a capsule."""
    axis = [b - a for a, b in zip(start, end)]
    length = math.hypot(*axis)
    axis = [value / length for value in axis]
    side = (1, 0, 0) if abs(axis[0]) < 0.5 else (0, 1, 0)
    along = sum(a * b for a, b in zip(axis, side))
    u = [s - along * a for a, s in zip(axis, side)]
    scale = math.hypot(*u)
    u = [value / scale for value in u]
    v = [axis[1] * u[2] - axis[2] * u[1], axis[2] * u[0] - axis[0] * u[2], axis[0] * u[1] - axis[1] * u[0]]
    points, normals, triangles = [], [], []
    for ring in range(RINGS):
        # From pole to pole, half of the rings around each end.
        angle = math.pi * ring / (RINGS - 1)
        middle = start if ring < RINGS // 2 else end
        out, along = radius * math.sin(angle), -radius * math.cos(angle)
        count = 1 if ring in (0, RINGS - 1) else SIDES
        for place in range(count):
            turn = 2 * math.pi * place / SIDES
            x, y = width * out * math.cos(turn), out * math.sin(turn)
            points.append([m + along * a + x * p + y * q for m, a, p, q in zip(middle, axis, u, v)])
            # Those of an ellipsoid.
            normal = [along * a + x / width**2 * p + y * q for a, p, q in zip(axis, u, v)]
            normals.append([value / math.hypot(*normal) for value in normal])
    rings = [0] + [1 + SIDES * ring for ring in range(RINGS - 1)]
    for place in range(SIDES):
        after = (place + 1) % SIDES
        triangles.append((0, rings[1] + after, rings[1] + place))
        for low, high in zip(rings[1:-2], rings[2:-1]):
            triangles.append((low + place, low + after, high + after))
            triangles.append((low + place, high + after, high + place))
        triangles.append((rings[-1], rings[-2] + place, rings[-2] + after))
    return points, normals, triangles


def turned(degrees):
    """A rotation about x as a quaternion."""
    half = math.radians(degrees) / 2
    return math.sin(half), 0.0, 0.0, math.cos(half)


def pose(share):
    """Rotations of bones in degrees about x at a share of the clip, and how high the hips are."""
    phase = 2 * math.pi * share
    left, right = math.sin(phase), math.sin(phase + math.pi)
    bend = lambda at: 8 + 32 * max(0.0, math.cos(at))
    angles = {3: -SWING * left, 5: -SWING * right, 4: bend(phase), 6: bend(phase + math.pi)}
    angles |= {7: 24 * left, 8: 24 * right, 1: 3.0, 2: -3.0}
    return angles, 0.02 * math.cos(2 * phase)


def mannequin():
    """The walking mannequin as glTF."""
    points, normals, joints, indices = [], [], [], []
    for bone, start, end, radius, width in CAPSULES:
        made, outwards, triangles = capsule(start, end, radius, width)
        indices += [len(points) + corner for triangle in triangles for corner in triangle]
        points += made
        normals += outwards
        joints += [(bone, 0, 0, 0)] * len(made)
    buffer, views, accessors = bytearray(), [], []

    def store(form, rows, component, kind, **more):
        values = [value for row in rows for value in (row if isinstance(row, (tuple, list)) else (row,))]
        packed = struct.pack(f"<{len(values)}{form}", *values)
        views.append({"buffer": 0, "byteOffset": len(buffer), "byteLength": len(packed)})
        accessors.append({"bufferView": len(views) - 1, "componentType": component, "count": len(rows), "type": kind, **more})
        buffer.extend(packed)
        buffer.extend(bytes(-len(buffer) % 4))
        return len(accessors) - 1

    low, high = ([pick(point[axis] for point in points) for axis in range(3)] for pick in (min, max))
    attributes = {
        "POSITION": store("f", points, 5126, "VEC3", min=low, max=high),
        "NORMAL": store("f", normals, 5126, "VEC3"),
        "JOINTS_0": store("B", joints, 5121, "VEC4"),
        "WEIGHTS_0": store("f", [(1, 0, 0, 0)] * len(points), 5126, "VEC4"),
    }
    triangles = store("I", indices, 5125, "SCALAR")
    nodes = [{"name": "mannequin", "mesh": 0, "skin": 0}]
    for number, (name, parent, place) in enumerate(BONES):
        base = BONES[parent][2] if parent is not None else (0, 0, 0)
        children = [1 + child for child, other in enumerate(BONES) if other[1] == number]
        node = {"name": name, "translation": [a - b for a, b in zip(place, base)]}
        nodes.append({**node, "children": children} if children else node)
    inverse = [(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *(-value for value in place), 1) for _, _, place in BONES]
    skin = {"joints": list(range(1, 1 + len(BONES))), "inverseBindMatrices": store("f", inverse, 5126, "MAT4")}
    times = [step / (POSES - 1) for step in range(POSES)]
    time = store("f", times, 5126, "SCALAR", min=[0.0], max=[1.0])
    moved = [pose(share) for share in times]
    samplers, channels = [], []
    for bone in sorted(moved[0][0]):
        turns = store("f", [turned(angles[bone]) for angles, _ in moved], 5126, "VEC4")
        channels.append({"sampler": len(samplers), "target": {"node": 1 + bone, "path": "rotation"}})
        samplers.append({"input": time, "output": turns})
    places = store("f", [(0, BONES[0][2][1] + height, 0) for _, height in moved], 5126, "VEC3")
    channels.append({"sampler": len(samplers), "target": {"node": 1, "path": "translation"}})
    samplers.append({"input": time, "output": places})
    data = base64.b64encode(buffer).decode()
    return {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0, 1]}],
        "nodes": nodes,
        "meshes": [{"primitives": [{"attributes": attributes, "indices": triangles}]}],
        "skins": [skin],
        "animations": [{"name": "walk", "channels": channels, "samplers": samplers}],
        "buffers": [{"uri": f"data:application/octet-stream;base64,{data}", "byteLength": len(buffer)}],
        "bufferViews": views,
        "accessors": accessors,
    }


def ranks(generator, x, heading, rows):
    """Lines of agents in rows of four that follow one another along z, the first row at the origin."""
    away = 1 if heading == 0 else -1
    for row in range(rows):
        for column in range(4):
            place = x + 0.9 * column + generator.uniform(-0.06, 0.06), -away * 1.3 * row + generator.uniform(-0.08, 0.08)
            phase, size = generator.uniform(-0.05, 0.05) + column % 2 * 0.5, generator.uniform(0.94, 1.06)
            yield f"{place[0]:.3f} 0 {place[1]:.3f} {heading} {size:.3f} walk {phase % 1:.3f} 0 {STEP * size:.3f}"


def main():
    generator = random.Random(3)
    (FOLDER / "mannequin.gltf").write_text(json.dumps(mannequin()))
    for name, x, heading in (("going", 0.8, 0), ("coming", -3.6, 180)):
        lines = "\n".join(ranks(generator, x, heading, 60))
        (FOLDER / f"march_{name}.txt").write_text(f"# x y z heading scale clip phase 0 speed\n{lines}\n")


main()
