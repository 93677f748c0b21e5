"""Writes a head, a painted face, and a scene in which the face lies on the head by twelve pins:

    python head.py FOLDER && relievo scene run FOLDER/layer.toml

Needs NumPy. The head is a smooth union of simple shapes, and the cage of its surface a ball that was pulled onto it."""

import sys

import numpy

import sticker

# Faces along each edge of the cube that the ball is made of.
EDGE = 14
# The head stands on the table by its neck.
LIFT = 1.25
WIDTH, HEIGHT = 640, 800


def joined(a, b, softness):
    """The union of two shapes, whose crease is rounded (a polynomial smooth minimum)."""
    share = numpy.clip(0.5 + 0.5 * (b - a) / softness, 0, 1)
    return b + (a - b) * share - softness * share * (1 - share)


def ellipsoid(points, center, radii):
    away = (points - center) / radii
    near, far = numpy.linalg.norm(away, axis=-1), numpy.linalg.norm(away / radii, axis=-1)
    return near * (near - 1) / numpy.maximum(far, 1e-9)


def capsule(points, start, end, radius):
    start, way = numpy.array(start), numpy.subtract(end, start)
    along = numpy.clip((points - start) @ way / (way @ way), 0, 1)
    return numpy.linalg.norm(points - start - along[..., None] * way, axis=-1) - radius


def head(points):
    """The distance of points from the head, about; negative inside. The face looks along -y, and z is up."""
    # Both sides are alike.
    side = numpy.concatenate([numpy.abs(points[..., :1]), points[..., 1:]], -1)
    shape = ellipsoid(points, (0, 0.08, 0.30), (0.74, 0.90, 0.80))
    shape = joined(shape, ellipsoid(points, (0, -0.20, -0.14), (0.60, 0.64, 0.78)), 0.15)
    shape = joined(shape, ellipsoid(points, (0, -0.46, -0.70), (0.32, 0.34, 0.24)), 0.20)
    shape = joined(shape, capsule(points, (0, 0.12, -0.5), (0, 0.22, -1.6), 0.38), 0.15)
    shape = joined(shape, ellipsoid(side, (0.38, -0.54, -0.14), (0.22, 0.22, 0.16)), 0.20)
    shape = joined(shape, capsule(side, (0.12, -0.80, 0.31), (0.44, -0.62, 0.33), 0.06), 0.12)
    # Sockets, and eyes in them.
    shape = -joined(-shape, ellipsoid(side, (0.29, -0.98, 0.13), (0.22, 0.22, 0.16)), 0.12)
    shape = joined(shape, ellipsoid(side, (0.28, -0.62, 0.12), (0.16, 0.16, 0.13)), 0.04)
    shape = joined(shape, capsule(points, (0, -0.76, 0.24), (0, -0.96, -0.14), 0.08), 0.10)
    shape = joined(shape, ellipsoid(points, (0, -0.97, -0.17), (0.12, 0.12, 0.10)), 0.06)
    shape = joined(shape, ellipsoid(side, (0.11, -0.86, -0.20), (0.08, 0.10, 0.07)), 0.05)
    shape = joined(shape, ellipsoid(points, (0, -0.78, -0.44), (0.21, 0.10, 0.06)), 0.06)
    shape = joined(shape, ellipsoid(points, (0, -0.77, -0.54), (0.17, 0.10, 0.06)), 0.05)
    shape = joined(shape, ellipsoid(side, (0.72, 0.10, 0.06), (0.10, 0.18, 0.27)), 0.06)
    return numpy.maximum(shape, -1.35 - points[..., 2])


def met(origins, ways, far):
    """Where rays that come from `far` along `ways` to the origins first meet the head."""
    steps = numpy.linspace(far, 0, 241)
    inside = numpy.stack([head(origins + step * ways) < 0 for step in steps])
    first = inside.argmax(0)
    outer, inner = steps[first - 1], steps[first]
    for _ in range(30):
        middle = 0.5 * (outer + inner)
        is_in = head(origins + middle[:, None] * ways) < 0
        inner, outer = numpy.where(is_in, middle, inner), numpy.where(is_in, outer, middle)
    return origins + inner[:, None] * ways


def cage():
    """Returns the points and the faces of a cube's grid that is pulled onto the head."""
    turns = numpy.tan(numpy.linspace(-numpy.pi / 4, numpy.pi / 4, EDGE + 1))
    numbers, points, faces = {}, [], []

    def number(place):
        key = tuple(numpy.round(place, 6))
        if key not in numbers:
            numbers[key] = len(points)
            points.append(place)
        return numbers[key]

    for axis in range(3):
        for sign in (-1, 1):
            normal, right = numpy.zeros(3), numpy.zeros(3)
            normal[axis], right[(axis + 1) % 3] = sign, 1
            up = numpy.cross(normal, right)
            for i in range(EDGE):
                for j in range(EDGE):
                    corners = ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))
                    faces.append([number(normal + turns[a] * right + turns[b] * up) for a, b in corners])
    ways = numpy.array(points)
    ways /= numpy.linalg.norm(ways, axis=1)[:, None]
    return met(numpy.zeros_like(ways), ways, 2.5) + (0, 0, LIFT), faces


def painted():
    """Returns the pixels of the painted face, red, green, blue and alpha in sRGB."""
    fine = 2
    y, x = numpy.mgrid[0 : HEIGHT * fine, 0 : WIDTH * fine]
    x, y = (x + 0.5) / fine, (y + 0.5) / fine
    image = numpy.zeros((HEIGHT * fine, WIDTH * fine, 4))

    def fill(inside, color):
        image[inside] = (*color, 255)

    def flower(u, v, radius, petals, depth):
        return numpy.hypot(x - u, y - v) < radius + depth * numpy.cos(petals * numpy.arctan2(y - v, x - u))

    bone, ink, red, gold = (242, 234, 218), (22, 18, 26), (186, 36, 52), (232, 174, 52)
    teal, pink = (20, 132, 140), (206, 62, 128)

    def face(inset):
        low = numpy.clip((y - 420) / 380, 0, 1)
        across = (x - 320) / ((300 - inset) * (1 - 0.28 * low**2))
        return across**2 + ((y - 410) / (384 - inset)) ** 2 < 1

    fill(face(0), teal)
    fill(face(12), bone)
    for side in (-1, 1):
        u = 320 + 138 * side
        fill(flower(u, 330, 100, 10, 10), teal)
        fill(flower(u, 330, 84, 20, 3), red)
        fill(numpy.hypot(x - u, y - 330) < 74, ink)
        for turn in numpy.radians(numpy.arange(-160, -15, 18)):
            fill(numpy.hypot(x - u - 128 * numpy.cos(turn), y - 330 - 128 * numpy.sin(turn)) < 7, pink)
        # The nose is a heart that stands on its head.
        fill(numpy.hypot((x - 320 - 17 * side) / 20, (y - 480) / 34) < 1, ink)
        u = 320 + 168 * side
        radius, turn = numpy.hypot(x - u, y - 540), numpy.arctan2(y - 540, side * (x - u))
        coil = (radius - 18 * turn / (2 * numpy.pi)) % 18
        fill((radius < 46) & (numpy.abs(coil - 9) < 3.5), pink)
    fill((numpy.abs(x - 320) < (y - 425) * 0.55) & (y < 480), ink)
    fill(numpy.hypot((x - 320) / 112, (y - 610) / 30) < 1, red)
    fill((numpy.abs(y - 610) < 3) & (numpy.abs(x - 320) < 160), ink)
    for u in range(172, 480, 27):
        fill((numpy.abs(x - u) < 2.5) & (numpy.abs(y - 610) < 24), ink)
    for u, v, radius, petals, color in ((320, 150, 58, 8, pink), (320, 735, 34, 6, teal)):
        fill(flower(u, v, radius, petals, 0.25 * radius), color)
        fill(numpy.hypot(x - u, y - v) < 0.4 * radius, gold)
    for side in (-1, 1):
        fill(numpy.hypot((x - 320 - 118 * side) / 44, (y - 150 - 0.2 * side * (x - 320 - 118 * side)) / 15) < 1, teal)
        fill(numpy.hypot(x - 320 - 182 * side, y - 176) < 11, gold)
    return sticker.shrunk(image, fine)


# Points of the image, and where on the head they belong, seen from the front: across and up.
PINS = [
    ((112, 330), (-0.43, 0.13)), ((252, 330), (-0.14, 0.12)), ((388, 330), (0.14, 0.12)), ((528, 330), (0.43, 0.13)),
    ((320, 470), (0, -0.17)), ((200, 610), (-0.21, -0.48)), ((320, 610), (0, -0.49)), ((440, 610), (0.21, -0.48)),
    ((320, 735), (0, -0.74)), ((320, 150), (0, 0.60)), ((152, 540), (-0.40, -0.22)), ((488, 540), (0.40, -0.22)),
]


def pins():
    """Returns the pins: corners of the eyes and of the mouth, nose, lips, chin, forehead and cheeks."""
    across = numpy.array([(x, 0, z) for _, (x, z) in PINS], float)
    places = met(across, numpy.broadcast_to((0.0, -1.0, 0.0), across.shape), 2) + (0, 0, LIFT)
    return [(*image, place, 0) for (image, _), place in zip(PINS, places)]


SCENE = """
[meshes.head]
file = "head.obj"
[surfaces.head]
mesh = "head"
[objects.head]
surface = "head"
colour = "#b98a68"
specular = 0.04
roughness = 0.4

[details]
paint_size = 16

[camera]
position = [1.9, -5.6, 1.9]
target = [0, 0, 1.2]
fov = 30

[sun]
elevation = 40
azimuth = -60
angle = 4
"""

if __name__ == "__main__":
    decal = 'object = "head"\ncontour = 0.5\ncells = 2\n'
    sticker.write(sys.argv[1], SCENE, decal, {"head": cage()}, painted(), pins(), rate=4, mesh_rate=16)
