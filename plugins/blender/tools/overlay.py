# SPDX-License-Identifier: GPL-3.0-or-later
"""Balls that are drawn over the view while regions are grabbed: see-through, with three great circles."""

import bpy
import gpu
import numpy
from gpu_extras.batch import batch_for_shader

# Colours of what is grabbed and of what is held.
GRABBED, HELD = (0.75, 0.35, 0.8), (1.0, 0.6, 0.1)
RINGS = 24


def _ball():
    """A ball of radius 1: points and triangles."""
    down, around = numpy.linspace(0, numpy.pi, RINGS + 1), numpy.linspace(0, 2 * numpy.pi, 2 * RINGS + 1)
    theta, phi = numpy.meshgrid(down, around, indexing="ij")
    points = numpy.stack([numpy.sin(theta) * numpy.cos(phi), numpy.sin(theta) * numpy.sin(phi), numpy.cos(theta)], 2)
    first = numpy.arange(RINGS)[:, None] * (2 * RINGS + 1) + numpy.arange(2 * RINGS)
    below = first + 2 * RINGS + 1
    triangles = numpy.stack([first, below, below + 1, first, below + 1, first + 1], 2).reshape(-1, 3)
    return points.reshape(-1, 3).astype(numpy.float32), triangles.astype(numpy.int32)


def _circles():
    """The ends of the lines of three great circles."""
    angles = numpy.linspace(0, 2 * numpy.pi, 65)
    around = numpy.stack([numpy.cos(angles), numpy.sin(angles), 0 * angles], 1).astype(numpy.float32)
    lines = numpy.repeat(around, 2, 0)[1:-1]
    return numpy.concatenate([numpy.roll(lines, turn, 1) for turn in range(3)])


class Overlay:
    """Balls in the space of an object, drawn in all 3D views until it is taken away. Each is a centre, a radius and a
    colour."""

    def __init__(self, world):
        self.world, self.balls = world.copy(), []
        shader = gpu.shader.from_builtin("3D_UNIFORM_COLOR" if bpy.app.version < (4, 0) else "UNIFORM_COLOR")
        points, triangles = _ball()
        self.shader = shader
        self.ball = batch_for_shader(shader, "TRIS", {"pos": points}, indices=triangles)
        self.circles = batch_for_shader(shader, "LINES", {"pos": _circles()})
        self.handler = bpy.types.SpaceView3D.draw_handler_add(self.draw, (), "WINDOW", "POST_VIEW")

    def draw(self):
        gpu.state.blend_set("ALPHA")
        gpu.state.face_culling_set("BACK")
        for center, radius, color in self.balls:
            with gpu.matrix.push_pop():
                gpu.matrix.multiply_matrix(self.world)
                gpu.matrix.translate(tuple(center))
                gpu.matrix.scale_uniform(radius)
                self.shader.bind()
                self.shader.uniform_float("color", (*color, 0.2))
                self.ball.draw(self.shader)
                self.shader.uniform_float("color", (*color, 0.9))
                self.circles.draw(self.shader)
        gpu.state.face_culling_set("NONE")
        gpu.state.blend_set("NONE")

    def remove(self):
        """Takes it away; does nothing the second time."""
        if self.handler is not None:
            bpy.types.SpaceView3D.draw_handler_remove(self.handler, "WINDOW")
            self.handler = None
