"""Paints a checkered sticker onto a ball, with its corners and its middle where they are wanted:

    python decal.py OUT.relievo

Needs the package librelievo and NumPy. The document that is written can be opened by `relievo` and by the add-on for
Blender."""

import sys

import numpy

import librelievo

SIZE, RINGS = 128, 12

# A ball: rings of quads, and a polygon at each pole.
polar = numpy.linspace(0.0, numpy.pi, RINGS + 1)[1:-1, None]
turn = numpy.linspace(0.0, 2.0 * numpy.pi, 2 * RINGS, endpoint=False)[None, :]
points = numpy.stack(
    numpy.broadcast_arrays(numpy.sin(polar) * numpy.cos(turn), numpy.sin(polar) * numpy.sin(turn), numpy.cos(polar)), -1
)
points = points.reshape(-1, 3).astype(numpy.float32)
ring, segment = numpy.divmod(numpy.arange((RINGS - 2) * 2 * RINGS), 2 * RINGS)
after = (segment + 1) % (2 * RINGS)
upper, lower = ring * 2 * RINGS, (ring + 1) * 2 * RINGS
quads = numpy.stack([upper + segment, lower + segment, lower + after, upper + after], 1)
caps = numpy.arange(2 * RINGS), len(points) - 1 - numpy.arange(2 * RINGS)
corners = numpy.concatenate([quads.ravel(), *caps]).astype(numpy.uint32)
sizes = numpy.array([4] * len(quads) + [2 * RINGS] * 2, numpy.uint32)

# Red and cream squares with alpha, rows from the top, linear.
y, x = numpy.mgrid[0:SIZE, 0:SIZE]
is_red = ((x // 16 + y // 16) % 2 == 0)[..., None]
image = numpy.where(is_red, (0.6, 0.03, 0.02, 1.0), (0.9, 0.8, 0.6, 1.0)).astype(numpy.float32)


def place(u, v):
    """The place of a point of the image on the ball."""
    across, up = 1.4 * (u / SIZE - 0.5), 1.4 * (v / SIZE - 0.5)
    return numpy.cos(up) * numpy.cos(across), numpy.cos(up) * numpy.sin(across), numpy.sin(up)


pins = [((u, v), place(u, v)) for u, v in ((8, 8), (120, 8), (64, 64), (8, 120), (120, 120))]

context = librelievo.Context()
cage = librelievo.Mesh(context, points, corners, sizes)
detail = librelievo.Detail(librelievo.Surface(context, cage))
detail.add_paint(color=(0.2, 0.25, 0.3, 1.0))
document = librelievo.Document(detail, sys.argv[1])
with document.edit("decal"):
    decal = librelievo.Decal.on_detail(detail, pins, (SIZE, SIZE))
    report = decal.paint(image)
document.sync()
quality = decal.quality
print(f"{report.texels} texels of {report.changed_tiles} tiles painted")
print(f"{100 * quality.coverage:.1f} % covered, L2 stretch {quality.l2:.3f}, {quality.flip_count} flipped")
