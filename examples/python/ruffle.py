"""Writes a ruffled sheet, a sticker shaped like the letter C that goes around its middle, and the sticker's pins:

    python ruffle.py FOLDER
    relievo decal mesh FOLDER/ruffle.obj -o c.obj --image FOLDER/sticker.png --contour 0.5 $(cat FOLDER/pins.txt)
    python ruffle.py FOLDER c.obj

The sheet is curved like a saddle everywhere, so that a ring around its middle is longer than a circle of the plane. The last
command flattens the sticker's triangles with the least change of angles (Lévy et al. 2002, LSCM) and draws them to
FOLDER/flat.png: the ends of the C lie on each other there. It prints the share of that picture of the sticker that is covered
twice.

Needs NumPy."""

import pathlib
import sys

import numpy

import sticker

SIDE = 120
HEIGHT = 0.42
PIXELS = 600
# Radii of the C in pixels, and half of the angle that it goes around.
INNER, OUTER, HALF = 130, 285, numpy.radians(170)
# Planar units for a pixel.
PIXEL = 1.05 / 285


def lift(x, y):
    """Returns the point of the sheet over a point of the plane."""
    radius, turn = numpy.hypot(x, y), numpy.arctan2(y, x)
    return x, y, HEIGHT * radius**2 * numpy.cos(3 * turn)


def sheet():
    """Returns the points and the triangles of the sheet."""
    at = numpy.linspace(-1.2, 1.2, SIDE + 1)
    points = [lift(x, y) for y in at for x in at]
    faces = []
    for row in range(SIDE):
        for column in range(SIDE):
            first = row * (SIDE + 1) + column
            above = first + SIDE + 1
            faces += [[first, first + 1, above + 1], [first, above + 1, above]]
    return points, faces


def letter():
    """Returns the pixels of the C: a band with a border, ticks and dots whose colour runs from one end to the other."""
    fine = 3
    y, x = (numpy.mgrid[0 : PIXELS * fine, 0 : PIXELS * fine] + 0.5) / fine - PIXELS / 2
    radius, turn = numpy.hypot(x, y), numpy.arctan2(-y, x)
    image = numpy.zeros((PIXELS * fine, PIXELS * fine, 4))
    # Round corners: the distance to a band that is smaller by the radius of the corners.
    corner, middle = 30, (INNER + OUTER) / 2
    across = numpy.maximum(numpy.abs(radius - middle) - (OUTER - INNER) / 2 + corner, 0)
    along = numpy.maximum((numpy.abs(turn) - HALF) * radius + corner, 0)
    away = numpy.hypot(across, along) - corner
    share = ((turn / HALF + 1) / 2)[..., None]
    low, high = numpy.array([245, 196, 60]), numpy.array([24, 84, 150])
    color = low + (high - low) * numpy.clip(share, 0, 1)
    inside = away < -3
    image[inside, :3] = color[inside]
    image[inside, 3] = 255
    image[inside & (away > -12)] = (24, 40, 66, 255)
    # Ticks every 20 degrees, and a dot between two of them.
    step = numpy.radians(20)
    tick = (numpy.abs((turn + step / 2) % step - step / 2) * radius < 2.5) & (radius > OUTER - 45)
    dot = numpy.hypot((turn % step - step / 2) * middle, radius - middle + 15) < 13
    image[inside & tick & (away < -12)] = (24, 40, 66, 255)
    image[inside & dot] = (250, 244, 228, 255)
    return sticker.shrunk(image, fine)


def pins():
    """Returns nine pins along the middle of the C: columns, rows, and positions."""
    made = []
    for turn in numpy.radians(numpy.linspace(-155, 155, 9)):
        radius = (INNER + OUTER) / 2
        x, y = round(PIXELS / 2 + radius * numpy.cos(turn)), round(PIXELS / 2 - radius * numpy.sin(turn))
        place = lift((x - PIXELS / 2) * PIXEL, (PIXELS / 2 - y) * PIXEL)
        made.append((x, y, place))
    return made


def read(path):
    """Returns points, texture coordinates and triangles of an OBJ file whose corners have both of one number."""
    points, coordinates, corners = [], [], []
    for line in pathlib.Path(path).read_text().splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            points.append([float(value) for value in rest[:3]])
        elif word == "vt":
            coordinates.append([float(value) for value in rest[:2]])
        elif word == "f":
            corners.append([[int(part) - 1 for part in corner.split("/")[:2]] for corner in rest])
    corners = numpy.array(corners)
    placed = numpy.zeros((len(points), 2))
    placed[corners[..., 0]] = numpy.array(coordinates)[corners[..., 1]]
    return numpy.array(points), placed, corners[..., 0]


def flatten(points, triangles, ends):
    """Returns the positions in the plane of the least squares conformal map that holds two vertices."""
    a, b, c = (points[triangles[:, corner]] for corner in range(3))
    first = b - a
    length = numpy.linalg.norm(first, axis=1)
    axis = first / length[:, None]
    normal = numpy.cross(first, c - a)
    area = numpy.linalg.norm(normal, axis=1)
    other = numpy.cross(normal / area[:, None], axis)
    flat = [numpy.zeros(len(a), complex), length + 0j, ((c - a) * axis).sum(1) + 1j * ((c - a) * other).sum(1)]
    # The Cauchy-Riemann equation of each triangle in complex numbers: the sum of its weights and positions is 0.
    weights = numpy.stack([flat[2] - flat[1], flat[0] - flat[2], flat[1] - flat[0]], 1) / numpy.sqrt(area)[:, None]
    plane = numpy.zeros(len(points), complex)
    plane[ends] = 0, 1
    free = numpy.ones(len(points), bool)
    free[ends] = False

    def forces(positions):
        """Returns minus the gradient of the squares of all equations."""
        errors = (weights * positions[triangles]).sum(1, keepdims=True)
        terms = (weights.conj() * errors).ravel()
        at = triangles.ravel()
        sums = numpy.bincount(at, terms.real, len(points)) + 1j * numpy.bincount(at, terms.imag, len(points))
        return numpy.where(free, -sums, 0)

    # Conjugate gradients, with the diagonal as preconditioner.
    diagonal = numpy.bincount(triangles.ravel(), (abs(weights) ** 2).ravel(), len(points))
    residual = forces(plane)
    ahead = residual / diagonal
    size = enough = numpy.vdot(residual, ahead).real
    for _ in range(20000):
        image = -forces(ahead)
        length = size / numpy.vdot(ahead, image).real
        plane, residual = plane + length * ahead, residual - length * image
        before, size = size, numpy.vdot(residual, residual / diagonal).real
        if size < 1e-16 * enough:
            break
        ahead = residual / diagonal + size / before * ahead
    return numpy.stack([plane.real, plane.imag], 1)


def draw(plane, coordinates, triangles, image):
    """Returns a picture of the triangles with the image on them, and the share of its pixels that are covered twice."""
    low, high = plane.min(0), plane.max(0)
    scale = 560 / (high - low).max()
    plane = (plane - (low + high) / 2) * scale
    plane = numpy.stack([PIXELS / 2 + plane[:, 0], PIXELS / 2 - plane[:, 1]], 1)
    picture, count = numpy.full((PIXELS, PIXELS, 3), 255.0), numpy.zeros((PIXELS, PIXELS), int)
    for triangle in triangles:
        a, b, c = plane[triangle]
        area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        start = numpy.floor(numpy.minimum(numpy.minimum(a, b), c)).astype(int)
        end = numpy.ceil(numpy.maximum(numpy.maximum(a, b), c)).astype(int)
        y, x = numpy.mgrid[start[1] : end[1] + 1, start[0] : end[0] + 1]
        px, py = x + 0.5, y + 0.5
        second = ((px - a[0]) * (c[1] - a[1]) - (py - a[1]) * (c[0] - a[0])) / area
        third = ((b[0] - a[0]) * (py - a[1]) - (b[1] - a[1]) * (px - a[0])) / area
        first = 1 - second - third
        inside = (first >= 0) & (second > 0) & (third > 0)
        uv = sum(w[..., None] * coordinates[v] for w, v in zip((first, second, third), triangle))[inside]
        column = numpy.clip((uv[:, 0] * PIXELS).astype(int), 0, PIXELS - 1)
        row = numpy.clip(((1 - uv[:, 1]) * PIXELS).astype(int), 0, PIXELS - 1)
        found, y, x = image[row, column].astype(float), y[inside], x[inside]
        # Half transparent, so that what lies below shows.
        share = 0.6 * found[:, 3:] / 255
        picture[y, x] += share * (found[:, :3] - picture[y, x])
        count[y, x] += found[:, 3] > 127
    opaque = numpy.full((PIXELS, PIXELS, 1), 255.0)
    return numpy.concatenate([picture, opaque], -1).round().astype(numpy.uint8), (count > 1).sum() / (count > 0).sum()


if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    if len(sys.argv) == 2:
        sticker.write_obj(folder / "ruffle.obj", *sheet())
        sticker.write_png(folder / "sticker.png", letter())
        options = [f"--pin {x},{y}@{','.join(f'{value:.4f}' for value in place)}" for x, y, place in pins()]
        (folder / "pins.txt").write_text("\n".join(options) + "\n")
    else:
        points, coordinates, triangles = read(sys.argv[2])
        # The vertices nearest to the first and the last pin.
        ends = [numpy.linalg.norm(points - place, axis=1).argmin() for *_, place in (pins()[0], pins()[-1])]
        plane = flatten(points, triangles, ends)
        picture, share = draw(plane, coordinates, triangles, letter())
        sticker.write_png(folder / "flat.png", picture)
        print(f"{100 * share:.1f} % of the flattened sticker is covered twice")
