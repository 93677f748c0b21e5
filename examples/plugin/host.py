"""A host that loads the plugin, rolls a ball over a plane, and writes what it gets as an OBJ file.

    python3 host.py PLUGIN [FILE.obj]
"""
import ctypes
import sys

SIDE = 16
plugin = ctypes.CDLL(sys.argv[1])
plugin.press_error.restype = ctypes.c_char_p
Place = ctypes.c_double * 3


def checked(result):
    if result != 0:
        sys.exit(plugin.press_error().decode())


# A plane of 16 x 16 quads from (-2, -2) to (2, 2).
numbers = [i / SIDE * 4 - 2 for i in range(SIDE + 1)]
points = [axis for y in numbers for x in numbers for axis in (x, y, 0)]
firsts = [y * (SIDE + 1) + x for y in range(SIDE) for x in range(SIDE)]
quads = [corner for first in firsts for corner in (first, first + 1, first + SIDE + 2, first + SIDE + 1)]
points, quads = (ctypes.c_float * len(points))(*points), (ctypes.c_uint32 * len(quads))(*quads)

press = ctypes.c_void_p()
size = ctypes.c_size_t
checked(plugin.press_create(points, size(len(points) // 3), quads, size(len(quads) // 4), ctypes.c_float(0.5),
                            Place(-1, -1, 0.4), ctypes.byref(press)))
for frame in range(1, 25):
    checked(plugin.press_move(press, Place(frame / 12 - 1, frame / 12 - 1, 0.4)))

positions, corners = ctypes.POINTER(ctypes.c_float)(), ctypes.POINTER(ctypes.c_uint32)()
point_count, triangle_count = size(), size()
plugin.press_mesh(press, *map(ctypes.byref, (positions, point_count, corners, triangle_count)))
positions, corners = positions[:3 * point_count.value], corners[:3 * triangle_count.value]
depth = -min(positions[2::3])
print(f"{point_count.value} points, the track is {depth:.3f} deep")
if len(sys.argv) > 2:
    with open(sys.argv[2], "w") as file:
        for i in range(0, len(positions), 3):
            file.write("v {} {} {}\n".format(*positions[i:i + 3]))
        for i in range(0, len(corners), 3):
            file.write("f {} {} {}\n".format(*(corner + 1 for corner in corners[i:i + 3])))
plugin.press_destroy(press)
