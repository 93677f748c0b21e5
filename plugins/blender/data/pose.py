# SPDX-License-Identifier: GPL-3.0-or-later
"""Where hooks of levels are: what the objects that move regions have moved, as handles and anchors of an edit."""

import math

import mathutils
import numpy

from ..core.error import Refused


def inverse_of(target):
    """From the world to the space of an object."""
    world = numpy.array(target.matrix_world)
    if not numpy.linalg.det(world):
        raise Refused(f"{target.name} has no size along one of its axes")
    return numpy.linalg.inv(world)


def placed(target, other, graph=None):
    """Where another object is in the space of an object, as a matrix; as a graph has evaluated both, if it is given."""
    if graph is not None:
        target, other = target.evaluated_get(graph), other.evaluated_get(graph)
    return mathutils.Matrix((inverse_of(target) @ numpy.array(other.matrix_world)).tolist())


def rest_of(hook):
    """Where a hook was when it was made, in the space of the object it moves."""
    return mathutils.Matrix([hook.rest[start : start + 4] for start in range(0, 16, 4)])


def handles(target, graph=None):
    """What the hooks of an object have moved and what they hold, as edits keep handles and anchors. Without handles it is
    at rest."""
    moved, held = [], []
    for hook in target.relievo.progressive.hooks:
        if hook.target is None:
            continue
        rest, now = rest_of(hook), placed(target, hook.target, graph)
        region = {"center": list(rest.translation), "radius": hook.radius, "falloff": hook.falloff.lower()}
        if hook.is_held:
            held.append(region)
            continue
        axis, angle = (now.to_quaternion() @ rest.to_quaternion().inverted()).to_axis_angle()
        move, angle = now.translation - rest.translation, math.remainder(angle, 2 * math.pi)
        # Matrices have last digits of their own at every evaluation.
        if move.length > 1e-6 * hook.radius or abs(angle) > 1e-6:
            moved.append({**region, "translation": list(move), "axis": list(axis), "angle": angle})
    return moved, held
