"""Writes a bottle with a handle, a label with a logo, and a scene in which the label lies on the bottle:

    python bottle.py FOLDER && relievo scene run FOLDER/layer.toml

Needs NumPy. The label runs around the bottle and through under the handle."""

import sys

import numpy

import sticker

SEGMENTS = 16
# Radius and height of the rings of the cage, from the foot over the mouth to its inside.
RINGS = [
    (0.80, 0.00), (1.00, 0.06), (1.02, 0.45), (1.02, 1.05), (1.02, 1.70), (1.00, 2.10), (0.82, 2.55), (0.42, 2.90),
    (0.36, 3.20), (0.36, 3.50), (0.44, 3.55), (0.44, 3.72), (0.30, 3.72), (0.30, 3.40),
]
# The middle of the handle and half its thickness, from the lower end to the upper one.
HANDLE = [(1.25, 0.28, 0.13), (1.62, 0.48, 0.12), (1.78, 0.95, 0.11), (1.78, 1.50, 0.11), (1.66, 2.02, 0.12), (1.28, 2.30, 0.13)]
LOWER, UPPER = 1, 5
# The limit surface is smaller than its cage.
RADIUS = 1.02 * (2 + numpy.cos(2 * numpy.pi / SEGMENTS)) / 3
WIDTH, HEIGHT = 1280, 440
PIXEL = 3.4 / WIDTH
MIDDLE = 1.16


def bottle():
    """Returns the points and the faces of the cage."""
    turns = (numpy.arange(SEGMENTS) - 0.5) * 2 * numpy.pi / SEGMENTS
    points = [(r * numpy.cos(turn), r * numpy.sin(turn), z) for r, z in RINGS for turn in turns]

    def at(ring, segment):
        return ring * SEGMENTS + segment % SEGMENTS

    def side(ring, segment):
        return [at(ring, segment), at(ring, segment + 1), at(ring + 1, segment + 1), at(ring + 1, segment)]

    sides = [(ring, segment) for ring in range(len(RINGS) - 1) for segment in range(SEGMENTS)]
    faces = [side(*place) for place in sides if place not in ((LOWER, 0), (UPPER, 0))]
    faces.append([at(0, segment) for segment in reversed(range(SEGMENTS))])
    faces.append([at(len(RINGS) - 1, segment) for segment in range(SEGMENTS)])
    # The handle joins the two sides that were left out, by loops of four points.
    a, b, c, d = side(UPPER, 0)
    loops = [side(LOWER, 0)]
    middles = numpy.array([place[:2] for place in HANDLE])
    for (x, z, half), way in zip(HANDLE, numpy.gradient(middles, axis=0)):
        across = numpy.array([way[1], -way[0]]) / numpy.hypot(*way) * half
        first = len(points)
        for y, sign in ((-0.16, 1), (0.16, 1), (0.16, -1), (-0.16, -1)):
            points.append((x + sign * across[0], y, z + sign * across[1]))
        loops.append([first, first + 1, first + 2, first + 3])
    loops.append([d, c, b, a])
    for below, above in zip(loops, loops[1:]):
        for edge in range(4):
            after = (edge + 1) % 4
            faces.append([below[edge], below[after], above[after], above[edge]])
    return points, faces


def label():
    """Returns the pixels of the label, red, green, blue and alpha in sRGB."""
    fine = 3
    y, x = numpy.mgrid[0 : HEIGHT * fine, 0 : WIDTH * fine]
    x, y = (x + 0.5) / fine, (y + 0.5) / fine
    image = numpy.zeros((HEIGHT * fine, WIDTH * fine, 4))

    def fill(inside, color):
        image[inside] = (*color, 255)

    def rounded(inset, radius):
        across = numpy.maximum(numpy.abs(x - WIDTH / 2) - (WIDTH / 2 - inset - radius), 0)
        up = numpy.maximum(numpy.abs(y - HEIGHT / 2) - (HEIGHT / 2 - inset - radius), 0)
        return numpy.hypot(across, up) < radius

    cream, navy, red, gold = (244, 234, 208), (28, 46, 84), (178, 44, 40), (214, 164, 56)
    # Four corners that are cut out round.
    corner = numpy.hypot(numpy.abs(x - WIDTH / 2) - WIDTH / 2 + 8, numpy.abs(y - HEIGHT / 2) - HEIGHT / 2 + 8)
    body = rounded(8, 6) & (corner > 60)
    fill(body, navy)
    fill(rounded(20, 6) & (corner > 74), cream)
    fill(rounded(28, 6) & (corner > 82), gold)
    fill(rounded(34, 6) & (corner > 88), cream)
    # The logo: a sun over three ranges of hills in a disk.
    u, v = x - 300, y - HEIGHT / 2
    disk = numpy.hypot(u, v) < 150
    fill(disk, navy)
    fill(numpy.hypot(u, v) < 140, (150, 196, 214))
    inner = numpy.hypot(u, v) < 140
    fill(inner & (numpy.hypot(u - 40, v + 40) < 38), gold)
    for level, swing, wave, phase, color in (
        (10, 34, 62, 0.4, (94, 138, 120)), (48, 26, 48, 2.1, (52, 98, 88)), (88, 20, 70, 4.0, navy),
    ):
        fill(inner & (v > level - swing * numpy.abs(numpy.sin(u / wave + phase))), color)
    # The name in a font of five by seven squares.
    font = {
        "R": "11110 10001 10001 11110 10100 10010 10001", "E": "11111 10000 10000 11110 10000 10000 11111",
        "L": "10000 10000 10000 10000 10000 10000 11111", "I": "01110 00100 00100 00100 00100 00100 01110",
        "V": "10001 10001 10001 10001 10001 01010 00100", "O": "01110 10001 10001 10001 10001 10001 01110",
    }
    size = 15
    for index, letter in enumerate("RELIEVO"):
        for row, bits in enumerate(font[letter].split()):
            for column, bit in enumerate(bits):
                left, top = 520 + (6 * index + column) * size, 130 + row * size
                if bit == "1":
                    fill((x >= left) & (x < left + size) & (y >= top) & (y < top + size), navy)
    fill((numpy.abs(y - 270) < 4) & (numpy.abs(x - 828) < 310), red)
    for index in range(25):
        fill((numpy.abs(x - 540 - 24 * index) + numpy.abs(y - 318)) < (16 if index % 2 else 9), red if index % 2 else gold)
    return sticker.shrunk(image, fine)


def pins():
    """Returns the pins: the corners of the label, and two in its middle."""
    made = []
    for x in (60, WIDTH // 2, WIDTH - 60):
        for y in (90, HEIGHT - 90):
            turn = numpy.radians(-56) + (x - WIDTH / 2) * PIXEL / RADIUS
            place = RADIUS * numpy.cos(turn), RADIUS * numpy.sin(turn), MIDDLE + (HEIGHT / 2 - y) * PIXEL
            made.append((x, y, place, 0))
    return made


SCENE = """
[meshes.bottle]
file = "bottle.obj"
[surfaces.bottle]
mesh = "bottle"
[objects.bottle]
surface = "bottle"
colour = "#8fa58c"
specular = 0.06
roughness = 0.25

[details]
paint_size = 256

[camera]
position = [3.7, -5.4, 2.9]
target = [0.28, 0, 1.78]
fov = 38

[sun]
elevation = 40
azimuth = -95
angle = 4
"""

sticker.write(sys.argv[1], SCENE, 'object = "bottle"\ncontour = 0.5\ncells = 16\n', {"bottle": bottle()}, label(), pins(), rate=8, mesh_rate=32)
