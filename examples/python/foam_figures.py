"""Renders pictures as in Figures 5 to 8 of Akinci, Dippel, Akinci and Teschner 2013 from a frame of foam over the pictures of
water_cycles.py, as one sheet of three columns. Runs in Blender, whose Python writes the sheet:

    blender --background --python foam_figures.py -- foam/0014.rlvfluid small small_solids figures.png

Rows from the top: spray, surface foam and bubbles alone; the intensity of thin foam by rho_mod 3, 12 and 48; shadows of
occlusion by ao_sh_scale 0, 1 and 2; irradiance of the sky, the same without occlusion, and white light from all sides;
occlusion by 4, 16 and 512 samples without the filter.
"""

import os
import struct
import subprocess
import sys
import tempfile
import zlib

import bpy
import numpy

LOOK = {"irr_scale": 1.7, "ao_fluid_opacity": 0.2, "rho_mod": 12}
VIEW = ["--eye=4.1,-2.0,1.5", "--target", "1.7,0.5,0.5", "--fov", "34"]
KINDS = ("spray", "foam", "bubbles")


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


def write(path, sheet):
    """Writes red, green and blue of a sheet, rows from the bottom, as a PNG of 8 bits."""
    # Steps of 1/32 are not seen in the noise, and make the file half as large.
    rows = (255 / 31 * numpy.round(31 * sheet[::-1, :, :3].clip(0, 1))).astype(numpy.uint8)
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
    frame, picture, solids, output = sys.argv[sys.argv.index("--") + 1 :]
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
            # The wave alone.
            shown.append(pixels(path)[:136, 112:])
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
