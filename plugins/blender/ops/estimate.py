# SPDX-License-Identifier: GPL-3.0-or-later
"""What a fluid is expected to take before it is simulated: particles, space and time."""

import bpy
import numpy

from ..core import job
from ..core.error import Refused
from . import fluid

# Bytes of a particle in a file of a frame, which is compressed, as measured where dams break.
BYTES = 20
# Seconds that a particle takes for a frame where none was simulated yet, as measured on two cores at 24 frames a second.
PACE = 5e-5


def volume_of(shape):
    """Returns the volume of a closed shape, m³; that of its box where it is not closed."""
    a, b, c = (shape.points[shape.corners.reshape(-1, 3)[:, number]].astype(float) for number in range(3))
    inside = abs(float((a * numpy.cross(b, c)).sum())) / 6
    return min(inside, float(numpy.ptp(shape.points, 0).prod()))


def share_within(shape, low, high):
    """Returns the share of the box of a shape that is in another box."""
    ends = shape.points.min(0), shape.points.max(0)
    size, both = ends[1] - ends[0], numpy.minimum(ends[1], high) - numpy.maximum(ends[0], low)
    return float(numpy.prod([max(own, 0.0) / whole if whole > 0 else float(own >= 0) for own, whole in zip(both, size)]))


def outline_of(shape, direction):
    """Returns the area that a shape has along a direction, m²."""
    a, b, c = (shape.points[shape.corners.reshape(-1, 3)[:, number]].astype(float) for number in range(3))
    facing = 0.5 * numpy.cross(b - a, c - a) @ direction
    return float(max(facing[facing > 0].sum(), -facing[facing < 0].sum()))


def of(simulation, count, pace):
    """Returns the particles of the last of `count` frames of a simulation, and the bytes and seconds of all frames."""
    grain, low, high = simulation.spacing**3, simulation.low, simulation.high
    most = float(numpy.prod(high - low)) / grain
    filled = sum(volume_of(shape) * share_within(shape, low, high) for shape, _velocity in simulation.fills) / grain
    rate = sum(outline_of(one.shape, one.direction) * one.speed for one in simulation.pourings) / grain / simulation.fps
    numbers = numpy.minimum(filled + rate * numpy.arange(count), most)
    return int(numbers[-1]), BYTES * float(numbers.sum()), (pace or PACE) * float(numbers[1:].sum())


def said(particles, size, seconds):
    """Returns an estimate in words."""
    return f"About {particles:,} particles, {size / 2**20:.3g} MiB, {seconds / 60:.2g} min"


class RELIEVO_OT_fluid_estimate(fluid.OnDomain, job.Steps, bpy.types.Operator):
    """Estimate particles, space and minutes of the active domain. Minutes go by the last simulation of the domain, if there was
    one"""

    bl_idname = "relievo.fluid_estimate"
    bl_label = "Estimate"

    def steps(self, context):
        scene, domain = context.scene, context.active_object
        if scene.frame_current != scene.frame_start:
            scene.frame_set(scene.frame_start)
        simulation = fluid.Simulation(scene, domain, context.evaluated_depsgraph_get())
        count = scene.frame_end - scene.frame_start + 1
        if count < 1:
            raise Refused("The scene has no frames")
        found = of(simulation, count, domain.relievo.fluid.pace)
        domain.relievo.fluid.estimate = said(*found)
        self.report({"INFO"}, domain.relievo.fluid.estimate)
        yield from ()


def register():
    bpy.utils.register_class(RELIEVO_OT_fluid_estimate)


def unregister():
    bpy.utils.unregister_class(RELIEVO_OT_fluid_estimate)
