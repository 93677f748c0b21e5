"""Writes the files of a sticker on a limit surface, as bottle.py makes it: meshes, image, scenes and pins."""

import pathlib
import struct
import zlib

import numpy

TABLE = """
[meshes.table]
shape = "plane"
size = [40, 40, 1]
faces = 1
[objects.table]
mesh = "table"
colour = [0.62, 0.58, 0.52]
specular = 0.0
"""

OUTPUT = """
[output]
frames = 1
width = 720
height = 720
samples = 6
sky_rays = 4
rate = {rate}
mesh_rate = {mesh_rate}
blender = "last"
"""


def shrunk(image, fine):
    """Returns the means of squares of `fine` pixels of an image, red, green, blue and alpha from 0 to 255."""
    height, width = image.shape[0] // fine, image.shape[1] // fine
    alpha = image[..., 3:] / 255
    means = lambda values: values.reshape(height, fine, width, fine, -1).mean(axis=(1, 3))
    share = means(alpha)
    color = means(image[..., :3] * alpha) / numpy.maximum(share, 1e-6)
    return numpy.concatenate([color, 255 * share], -1).round().astype(numpy.uint8)


def write_png(path, pixels):
    """Writes an image of four bytes a pixel."""
    height, width, _ = pixels.shape
    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    chunks = [(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 6, 0, 0, 0)), (b"IDAT", zlib.compress(rows, 9)), (b"IEND", b"")]
    with open(path, "wb") as out:
        out.write(b"\x89PNG\r\n\x1a\n")
        for name, data in chunks:
            out.write(struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data)))


def write_obj(path, points, faces):
    lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in points]
    lines += ["f " + " ".join(str(point + 1) for point in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")


def write(folder, scene, decal, meshes, image, pins, rate=16, mesh_rate=128):
    """Writes into a folder:

    - layer.toml, a scene in which the sticker is painted into a layer, and bare.toml, the same without the sticker, whose
      surfaces are written as PLY;
    - sticker.png; the meshes, a dictionary of points and faces, as OBJ;
    - pins.txt, the pins as options of `relievo decal mesh`.

    Pins are columns and rows of pixels, positions, and depths. `rate` and `mesh_rate` are those of the scene's output."""
    folder = pathlib.Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    for name, (points, faces) in meshes.items():
        write_obj(folder / f"{name}.obj", points, faces)
    write_png(folder / "sticker.png", image)
    lines, options = [], []
    for x, y, place, depth in pins:
        place = [f"{value:.4f}" for value in place]
        lines.append(f"    {{ image = [{x}, {y}], position = [{', '.join(place)}], depth = {depth} }},")
        options.append(f"--pin {x},{y}@{','.join(place)}")
    if any(pin[3] for pin in pins):
        options.extend(f"--depth {depth}" for *_, depth in pins)
    text = "\n".join(lines)
    decal = f'\n[[decals]]\nimage = "sticker.png"\n{decal}pins = [\n{text}\n]\n'
    scene, output = "version = 1\n" + scene + TABLE, OUTPUT.format(rate=rate, mesh_rate=mesh_rate)
    (folder / "layer.toml").write_text(scene + decal + output + 'mesh = "none"\n')
    (folder / "bare.toml").write_text(scene + output + 'mesh = "last"\nmesh_formats = ["ply"]\n')
    (folder / "pins.txt").write_text("\n".join(options) + "\n")
