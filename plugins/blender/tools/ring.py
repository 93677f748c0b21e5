# SPDX-License-Identifier: GPL-3.0-or-later
"""The circle of the brush: where the pointer meets the surface, in the plane that touches it there, and inside of it a second one
that shows the strength."""

import bpy
import gpu
import numpy
from bpy_extras import view3d_utils
from gpu_extras.batch import batch_for_shader

from ..data import pose, state

ANGLES = numpy.linspace(0, 2 * numpy.pi, 65)
SHADER = "2D_UNIFORM_COLOR" if bpy.app.version < (4, 0) else "UNIFORM_COLOR"
SCULPT = (1.0, 0.85, 0.6)

# Where the circle stays while its size is changed, or None.
held = None


def meet(context, place):
    """Returns where a place of the window region meets the active object, and the normal there, in the world; or None."""
    target = state.source_of(context.active_object)
    if context.region_data is None or target is None or target.type != "MESH":
        return None
    origin = view3d_utils.region_2d_to_origin_3d(context.region, context.region_data, place)
    direction = view3d_utils.region_2d_to_vector_3d(context.region, context.region_data, place)
    world = state.world(target)
    if not numpy.linalg.det(world[:3, :3]):
        return None
    inverse = pose.inverse_of(target)
    start, along = (inverse @ [*origin, 1.0])[:3], inverse[:3, :3] @ direction
    made = state.existing(target)
    if made is not None and made.caster is not None:
        # That of the last stroke, which is near enough to what is seen.
        hit = made.caster[1].cast([start], [along])[0]
        if not numpy.isfinite(hit["distance"]):
            return None
        point, normal = hit["position"], hit["normal"]
    else:
        evaluated = target.evaluated_get(context.evaluated_depsgraph_get())
        is_hit, point, normal, _face = evaluated.ray_cast(tuple(start), tuple(along))
        if not is_hit:
            return None
    normal = inverse[:3, :3].T @ numpy.asarray(normal, float)
    return (world @ [*numpy.asarray(point, float), 1.0])[:3], normal / (numpy.linalg.norm(normal) or 1.0)


def circle(point, normal, radius):
    """Returns the points of a circle (n, 3) about a point across a normal."""
    across = numpy.cross(normal, numpy.eye(3)[numpy.abs(normal).argmin()])
    across /= numpy.linalg.norm(across)
    up = numpy.cross(normal, across)
    return point + radius * (numpy.cos(ANGLES)[:, None] * across + numpy.sin(ANGLES)[:, None] * up)


def projected(region, view, points):
    """Returns points of the world as pixels of the window (n, 2), or None where one is behind the eye."""
    whole = numpy.column_stack([points, numpy.ones(len(points))]) @ numpy.array(view.perspective_matrix).T
    if (whole[:, 3] <= 0).any():
        return None
    half = 0.5 * numpy.array([region.width, region.height])
    return whole[:, :2] / whole[:, 3:] * half + half + [region.x, region.y]


def draw(context, place, action):
    """Draws the circle of a tool for a pointer at a place of the window."""
    region, group = context.region, context.scene.relievo.brush
    found = held or meet(context, (place[0] - region.x, place[1] - region.y))
    if found is None:
        return
    color = tuple(min(value, 1.0) for value in group.color[:3]) if action == "PAINT" else SCULPT
    radius = group.settings.radius
    for share, opacity in ((1.0, 0.9), (group.settings.strength, 0.4)):
        points = projected(region, context.region_data, circle(*found, max(share * radius, 1e-9)))
        if points is not None:
            draw_line(points, (*color, opacity))


def draw_line(points, color):
    """Draws a line of pixels over a dark one, so that it is seen on any ground."""
    shader = gpu.shader.from_builtin(SHADER)
    gpu.state.blend_set("ALPHA")
    for width, shade in ((3.0, (0.0, 0.0, 0.0, 0.5 * color[3])), (1.5, color)):
        gpu.state.line_width_set(width)
        batch = batch_for_shader(shader, "LINE_STRIP", {"pos": points.astype(numpy.float32)})
        shader.bind()
        shader.uniform_float("color", shade)
        batch.draw(shader)
    gpu.state.line_width_set(1.0)
    gpu.state.blend_set("NONE")
