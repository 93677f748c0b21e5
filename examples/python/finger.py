"""Writes a finger, a plaster, and a scene in which the plaster goes around the finger one and a half times, over itself:

    python finger.py FOLDER && relievo scene run FOLDER/layer.toml

Needs NumPy."""

import sys

import numpy

import sticker

SEGMENTS = 12
# Radius and height of the rings of the cage, from below the table to the tip.
RINGS = [
    (0.60, -0.50), (0.58, 0.10), (0.55, 0.60), (0.55, 1.05), (0.55, 1.50), (0.55, 1.95), (0.53, 2.35), (0.49, 2.70),
    (0.40, 2.95), (0.22, 3.10),
]
# The limit surface is smaller than its cage.
SHRINK = (2 + numpy.cos(2 * numpy.pi / SEGMENTS)) / 3
RADIUS = 0.55 * SHRINK
WIDTH, HEIGHT = 900, 150
# The plaster is one and a half times as long as the finger is round.
PIXEL = 3 * numpy.pi * RADIUS / WIDTH
TILT = numpy.radians(6)


def finger():
    """Returns the points and the faces of the cage."""
    turns = numpy.arange(SEGMENTS) * 2 * numpy.pi / SEGMENTS
    points = [(r * numpy.cos(turn), r * numpy.sin(turn), z) for r, z in RINGS for turn in turns]
    faces = [[segment for segment in reversed(range(SEGMENTS))]]
    for ring in range(len(RINGS) - 1):
        for segment in range(SEGMENTS):
            after = (segment + 1) % SEGMENTS
            below, above = ring * SEGMENTS, (ring + 1) * SEGMENTS
            faces.append([below + segment, below + after, above + after, above + segment])
    faces.append([(len(RINGS) - 1) * SEGMENTS + segment for segment in range(SEGMENTS)])
    return points, faces


def nail():
    """Returns the points and the faces of a cage that lies on the front of the tip, its border within the finger."""
    radii, heights = numpy.array(RINGS).T
    points, faces = [], []
    for row, z in enumerate(numpy.linspace(2.38, 3.02, 7)):
        for column, turn in enumerate(numpy.radians(numpy.linspace(-128, -52, 7))):
            is_border = row in (0, 6) or column in (0, 6)
            r = numpy.interp(z, heights, radii) * SHRINK + (-0.05 if is_border else 0.03)
            points.append((r * numpy.cos(turn), r * numpy.sin(turn), z))
    for row in range(6):
        for column in range(6):
            first = 7 * row + column
            faces.append([first, first + 1, first + 8, first + 7])
    return points, faces


def plaster():
    """Returns the pixels of the plaster, red, green, blue and alpha in sRGB."""
    fine = 3
    y, x = numpy.mgrid[0 : HEIGHT * fine, 0 : WIDTH * fine]
    x, y = (x + 0.5) / fine, (y + 0.5) / fine
    image = numpy.zeros((HEIGHT * fine, WIDTH * fine, 4))

    def fill(inside, color):
        image[inside] = (*color, 255)

    def rounded(inset):
        across = numpy.maximum(numpy.abs(x - WIDTH / 2) - (WIDTH - HEIGHT) / 2, 0)
        return numpy.hypot(across, y - HEIGHT / 2) < HEIGHT / 2 - inset

    teal, dark, cream, gold = (38, 148, 156), (12, 78, 92), (246, 236, 212), (240, 180, 60)
    fill(rounded(3), dark)
    fill(rounded(10), teal)
    # Rows of air holes, and stars between them.
    holes = (numpy.hypot((x + 10) % 20 - 10, (y - 75 + 10) % 20 - 10) < 3) & (numpy.abs(y - 75) > 35)
    fill(rounded(14) & holes, dark)
    for index, u in enumerate(range(75, 900, 75)):
        turn, away = numpy.arctan2(x - u, 75 - y), numpy.hypot(x - u, y - 75)
        wedge = numpy.abs((turn + numpy.pi / 5) % (2 * numpy.pi / 5) - numpy.pi / 5)
        # Five points, with straight edges to the notches between them.
        star = away * (numpy.cos(wedge) + 1.376 * numpy.sin(wedge)) < 28
        fill(star, gold if index % 2 else cream)
    return sticker.shrunk(image, fine)


def pins():
    """Returns the pins along the middle of the plaster. Its right end lies on top."""
    made = []
    for depth, x in enumerate(numpy.linspace(75, WIDTH - 75, 6).round().astype(int)):
        along = (x - WIDTH / 2) * PIXEL
        turn = numpy.pi / 2 + along * numpy.cos(TILT) / RADIUS
        place = RADIUS * numpy.cos(turn), RADIUS * numpy.sin(turn), 1.28 + along * numpy.sin(TILT)
        made.append((x, HEIGHT // 2, place, depth))
    return made


SCENE = """
[meshes.finger]
file = "finger.obj"
[meshes.nail]
file = "nail.obj"
[surfaces.finger]
mesh = "finger"
[surfaces.nail]
mesh = "nail"
[objects.finger]
surface = "finger"
colour = "#d09a7c"
specular = 0.04
roughness = 0.45
[objects.nail]
surface = "nail"
colour = "#e8bfae"
specular = 0.06
roughness = 0.2

[details]
paint_size = 32

[camera]
position = [0.9, -5.6, 3.0]
target = [0, 0, 1.5]
fov = 36

[sun]
elevation = 42
azimuth = -60
angle = 4
"""

if __name__ == "__main__":
    decal = 'object = "finger"\ncontour = 0.5\ncells = 8\noverlap = true\n'
    meshes = {"finger": finger(), "nail": nail()}
    sticker.write(sys.argv[1], SCENE, decal, meshes, plaster(), pins(), rate=8, mesh_rate=32)
