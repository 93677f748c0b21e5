"""Renders pictures as in Figures 5 to 8 of Akinci, Dippel, Akinci and Teschner 2013 from a frame of foam over the pictures of
water_cycles.py, as one sheet of three columns. Runs in Blender, whose Python writes the sheet:

    blender --background --python foam_figures.py -- foam/0014.rlvfluid small small_solids rock.obj figures.png

Rows from the top: spray, surface foam and bubbles alone; the intensity of thin foam by rho_mod 3, 12 and 48; shadows of
occlusion by ao_sh_scale 0, 1 and 2; irradiance of the sky, the same without occlusion, and white light from all sides;
occlusion by 4, 16 and 512 samples without the filter; screen space, and ray casting through the same foam as a medium,
which absorbs and emits, or scatters the light of the sky once.
"""

import os
import re
import struct
import subprocess
import sys
import tempfile
import zlib

import bpy
import mathutils
import numpy
from mathutils.bvhtree import BVHTree

LOOK = {"irr_scale": 1.7, "ao_fluid_opacity": 0.2, "rho_mod": 12}
EYE, TARGET, FOV = (4.1, -2.0, 1.5), (1.7, 0.5, 0.5), 34.0
VIEW = [f"--eye={','.join(map(str, EYE))}", f"--target={','.join(map(str, TARGET))}", "--fov", str(FOV)]
KINDS = ("spray", "foam", "bubbles")
# The wave alone: rows from the bottom, and columns.
CROP = slice(8, 130), slice(124, 312)
# What the medium's coefficients are multiplied by, so that thin spray is about as bright as in screen space.
EXTINCTION = 0.2


def panels():
    """Returns the kind of particles, the settings, and whether light is white of each panel, row after row."""
    yield from ((kind, {}, False) for kind in KINDS)
    yield from ((None, {"rho_mod": value}, False) for value in (3, 12, 48))
    yield from ((None, {"ao_sh_scale": value}, False) for value in (0, 1, 2))
    yield from [(None, {}, False), (None, {"ao_passes": 0}, False), (None, {}, True)]
    few = ({"ao_min_samp": value, "ao_max_samp": value, "filter": 0} for value in (4, 16, 512))
    yield from ((None, settings, False) for settings in few)


def pixels(path):
    """Returns the pixels of a picture, rows from the bottom."""
    image = bpy.data.images.load(path)
    width, height = image.size
    found = numpy.empty(4 * width * height, numpy.float32)
    image.pixels.foreach_get(found)
    bpy.data.images.remove(image)
    return found.reshape(height, width, 4)


def medium(path):
    """Returns coefficients of extinction in 1/m with axes z, y and x, the lowest corner, and the edge of a cell, in metres, of a
    density file for POV-Ray and the declaration beside it."""
    with open(path, "rb") as file:
        size = struct.unpack(">3H", file.read(6))
        values = numpy.frombuffer(file.read(), ">u2").reshape(size[::-1])
    with open(os.path.splitext(path)[0] + ".inc") as file:
        text = file.read()
    most = float(re.search(r"rgb (\S+) extinction", text)[1])
    place = re.search(r"scale <(\S+),.*translate <(\S+), (\S+), (\S+)>", text, re.S)
    width, x, y, z = map(float, place.groups())
    return values * (EXTINCTION * most / 65535), numpy.array([x, y, z]), width / size[0]


def between(grid, places):
    """Returns values between those of a grid with a border of zeros, without which they are at whole numbers; 0 outside."""
    limit = numpy.array(grid.shape[::-1]) - 2
    at = (places + 1).clip(0, limit + 0.999)
    cell = at.astype(int)
    share = at - cell
    found = numpy.zeros(len(places))
    for corner in range(8):
        step = numpy.array([corner & 1, corner >> 1 & 1, corner >> 2])
        weight = numpy.where(step, share, 1 - share).prod(axis=1)
        x, y, z = (cell + step).T
        found += weight * grid[z, y, x]
    return found


def ray_cast(foam, solid, picture, is_scattering):
    """Returns the wave in a picture with a medium over it, by rays that a solid ends: each place of the medium shines white, or as much of
    the white sky above as reaches it."""
    grid, low, cell = foam
    above = numpy.cumsum(grid[::-1], axis=0)[::-1] - 0.5 * grid
    density, source = numpy.pad(grid, 1), numpy.pad(numpy.exp(-cell * above), 1)
    eye, forward = numpy.array(EYE), numpy.array(TARGET) - EYE
    forward /= numpy.linalg.norm(forward)
    right = numpy.cross(forward, (0, 0, 1))
    right /= numpy.linalg.norm(right)
    height, width = picture.shape[:2]
    half = numpy.tan(numpy.radians(FOV) / 2)
    x, y = numpy.meshgrid(2 * numpy.arange(width) + 1 - width, 2 * numpy.arange(height) + 1 - height)
    x, y, picture = x[CROP], y[CROP], picture[CROP]
    shape = (*picture.shape[:2], 1)
    ways = forward + half / height * (x.ravel()[:, None] * right + y.ravel()[:, None] * numpy.cross(right, forward))
    ways /= numpy.linalg.norm(ways, axis=1, keepdims=True)
    corners = numpy.stack([(low - eye) / ways, (low + cell * numpy.array(grid.shape[::-1]) - eye) / ways])
    near, far = corners.min(axis=0).max(axis=1).clip(0), corners.max(axis=0).min(axis=1)
    hits = (solid.ray_cast(mathutils.Vector(eye), mathutils.Vector(way))[3] for way in ways)
    far = numpy.minimum(far, [numpy.inf if hit is None else hit for hit in hits])
    light, left = numpy.zeros(len(ways)), numpy.ones(len(ways))
    step = 0.5 * cell
    distance = near + 0.5 * step
    while (rows := numpy.flatnonzero((distance < far) & (left > 0.005))).size:
        places = (eye + distance[rows, None] * ways[rows] - low) / cell
        stopped = 1 - numpy.exp(-step * between(density, places))
        shine = between(source, places) if is_scattering else 1
        light[rows] += left[rows] * stopped * shine
        left[rows] *= 1 - stopped
        distance += step
    linear = numpy.where(picture <= 0.04045, picture / 12.92, ((picture + 0.055) / 1.055) ** 2.4)
    linear = linear * left.reshape(shape) + light.reshape(shape)
    return numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear.clip(0) ** (1 / 2.4) - 0.055)


def tree_of(path):
    """Returns the triangles of a mesh file, for rays."""
    bpy.ops.wm.obj_import(filepath=path, forward_axis="Y", up_axis="Z")
    mesh = bpy.context.selected_objects[0].data
    return BVHTree.FromPolygons([corner.co for corner in mesh.vertices], [list(face.vertices) for face in mesh.polygons])


def write(path, sheet):
    """Writes red, green and blue of a sheet, rows from the bottom, as a PNG of 8 bits."""
    # Steps of 1/24 are not seen in the noise, and make the file half as large.
    rows = (255 / 23 * numpy.round(23 * sheet[::-1, :, :3].clip(0, 1))).astype(numpy.uint8)
    height, width = rows.shape[:2]
    rows = rows.reshape(height, 3 * width)
    left, above = numpy.zeros_like(rows), numpy.zeros_like(rows)
    left[:, 3:], above[1:] = rows[:, :-3], rows[:-1]
    # Each row is stored as its difference to the left or to the row above, whichever is smaller.
    changes = numpy.stack([rows - left, rows - above])
    sizes = numpy.abs(changes.astype(numpy.int8).astype(int)).sum(axis=2)
    best = sizes.argmin(axis=0)
    lines = b"".join(bytes([1 + best[at]]) + changes[best[at], at].tobytes() for at in range(height))

    def chunk(kind, content):
        return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))

    header = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header))
        file.write(chunk(b"IDAT", zlib.compress(lines, 9)) + chunk(b"IEND", b""))


def main():
    frame, picture, solids, solid, output = sys.argv[sys.argv.index("--") + 1 :]
    relievo = os.environ.get("RELIEVO", "relievo")
    shown = []
    with tempfile.TemporaryDirectory() as folder:
        white = os.path.join(folder, "white.png")
        write(white, numpy.ones((2, 4, 3)))
        spacing = ["--set", "radius=0.015"]
        for kind in KINDS:
            alone = os.path.join(folder, f"{kind}.ply")
            subprocess.run([relievo, "foam", "export", frame, "-o", alone, "--kind", kind, *spacing], check=True)
        for number, (kind, settings, is_white) in enumerate(panels()):
            source = os.path.join(folder, f"{kind}.ply") if kind else frame
            path = os.path.join(folder, f"{number}.png")
            look = {**LOOK, **settings, "radius": 0.015}
            options = [part for name, value in look.items() for part in ("--set", f"{name}={value}")]
            if is_white:
                options += ["--environment", white]
            given = ["--picture", f"{picture}.exr", "--solids", f"{solids}.exr", *VIEW, *options, "-o", path]
            subprocess.run([relievo, "foam", "composite", source, *given], check=True)
            shown.append(pixels(path)[CROP])
        # A picture without foam, over which the medium is laid.
        path = os.path.join(folder, "none.png")
        given = ["--picture", f"{picture}.exr", *VIEW, "--set", "near_depth=1000", "-o", path]
        subprocess.run([relievo, "foam", "composite", frame, *given], check=True)
        grid = os.path.join(folder, "foam.df3")
        subprocess.run([relievo, "foam", "export", frame, "-o", grid, "--cell", "0.02", *spacing], check=True)
        foam, tree, without = medium(grid), tree_of(solid), pixels(path)
        shown.append(shown[list(panels()).index((None, {}, False))])
        shown += [ray_cast(foam, tree, without, is_scattering) for is_scattering in (False, True)]
    height, width = shown[0].shape[:2]
    rows = len(shown) // 3
    gap = 4
    sheet = numpy.ones((rows * (height + gap) - gap, 3 * (width + gap) - gap, 4))
    for number, panel in enumerate(shown):
        # Rows of Blender's images begin at the bottom.
        bottom, left = (rows - 1 - number // 3) * (height + gap), number % 3 * (width + gap)
        sheet[bottom : bottom + height, left : left + width] = panel
    write(output, sheet)


main()
