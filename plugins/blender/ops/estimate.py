# SPDX-License-Identifier: GPL-3.0-or-later
"""What fluids, foam and soft tissue are expected to take before they are made: particles or elements, space and time."""

import os
import tempfile
import time

import bpy
import librelievo as rl
import numpy

from ..core import job, native
from ..core.error import Refused
from ..data import frames
from . import fluid, foam, tissue

# Bytes of a particle in a file of a frame, which is compressed, as measured where dams break.
BYTES = 20
# Seconds that a particle takes for a frame where none was simulated yet, as measured on two cores at 24 frames a second.
PACE = 5e-5
# The same of a particle of foam, whose forces are those of the fluid beside it.
FOAM_PACE = 2e-6
# Frames whose foam is made to tell that of all frames.
SAMPLES = 9
# Seconds of an element for a step where no tissue was baked yet, as measured on two cores, and steps that a model takes to come to
# rest by its elements along its longest side.
TISSUE_PACE, REST = 1.5e-7, 35
# Bytes of a vertex in a frame of a point cache.
POINT = 12


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
    filled = sum(shape.volume() * share_within(shape, low, high) for shape, _velocity in simulation.fills) / grain
    rate = sum(outline_of(one.shape, one.direction) * one.speed for one in simulation.pourings) / grain / simulation.fps
    numbers = numpy.minimum(filled + rate * numpy.arange(count), most)
    return int(numbers[-1]), BYTES * float(numbers.sum()), (pace or PACE) * float(numbers[1:].sum())


def said(count, size, seconds, what="particles"):
    """Returns an estimate in words."""
    return f"About {count:,} {what}, {size / 2**20:.3g} MiB, {seconds / 60:.2g} min"


class Sample:
    """What the foam of one frame of a fluid comes to, made for itself."""

    def __init__(self, number, path, start):
        self.number, self.path, self.start = number, path, start
        self.born = self.size = 0
        self.seconds = 0.0

    def make(self, progress):
        """Makes the foam; without Blender's data."""
        run, seconds = self.start()
        particles, began = frames.particles(self.path), time.perf_counter()
        run.advance(*particles, seconds, progress)
        self.seconds, self.born = time.perf_counter() - began, run.info.count
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "sample")
            run.save(path, 0.0)
            self.size = os.path.getsize(path)


def foam_of(samples, count, fps, settings):
    """Returns the foam of the last of `count` frames by the samples of some, and the bytes and seconds of all frames. What is born
    in a frame lives as long as the settings say, evenly between the shortest and the longest life."""
    numbers, at = numpy.arange(1, count), [one.number for one in samples]
    born = numpy.interp(numbers, at, [one.born for one in samples])
    ages = numpy.arange(count - 1) / fps
    low, high = settings["lifetime_min"], max(settings["lifetime_max"], settings["lifetime_min"] + 1e-6)
    alive = numpy.convolve(born, numpy.clip((high - ages) / (high - low), 0, 1))[: count - 1]
    alive = numpy.minimum(alive, settings["most"])
    sampled = max(sum(one.born for one in samples), 1)
    size = sum(one.size for one in samples) / sampled * float(alive.sum())
    seconds = float(numpy.interp(numbers, at, [one.seconds for one in samples]).sum()) + FOAM_PACE * float(alive.sum())
    return int(alive[-1]), size, seconds


def step_of(simulation):
    """Returns the seconds of a step of a tissue: the least of its materials, each as one element of the library; without Blender's
    data."""
    thin, steps = [name for name, thickness in simulation.layers.items() if thickness > 0], []
    for material in [*simulation.materials, *({"name": name, "library": name} for name in thin)]:
        with rl.Tissue.block(native.context(), (0, 0, 0), simulation.description["cell"], (1, 1, 1), **material) as made:
            with made.simulate(safety=simulation.how["safety"]) as one:
                steps.append(one.info.step)
    return max(min(steps), simulation.how["mass_scaling"])


def tissue_of(simulation, count, pace):
    """Returns the elements of a tissue, and the bytes and seconds of `count` frames; without Blender's data."""
    elements, cell = simulation.expected(), simulation.description["cell"]
    across = max(float(numpy.ptp(shape.points, 0).max()) for _one, shape in simulation.volumes) / cell
    steps = (count - 1) / simulation.fps / step_of(simulation) + (REST * across if simulation.relaxes else 0)
    size = POINT * count * sum(len(follower.points) for follower in simulation.skins)
    return elements, size, steps * elements * (pace or TISSUE_PACE)


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


class RELIEVO_OT_foam_estimate(fluid.OnDomain, job.Steps, bpy.types.Operator):
    """Estimate particles, space and minutes of the foam of the active domain, by what is born in nine of its frames"""

    bl_idname = "relievo.foam_estimate"
    bl_label = "Estimate"

    def steps(self, context):
        scene, domain = context.scene, context.active_object
        options, folder = domain.relievo.fluid, frames.folder_of(domain)
        if not folder:
            raise Refused(f"{domain.name} has no frames; simulate it first")
        count = options.last - options.first + 1
        if count < 2:
            raise Refused(f"{domain.name} has one frame, in which no foam is born; simulate more")
        start, settings = foam.start_of(scene, domain)
        numbers = sorted({1 + round(share * (count - 2)) for share in numpy.linspace(0, 1, SAMPLES)})
        samples = [Sample(one, frames.path_of(folder, frames.PARTICLES, options.first + one), start) for one in numbers]
        for at, sample in enumerate(samples):
            yield at / len(samples), (at + 1) / len(samples), sample.make
        fps = scene.render.fps / scene.render.fps_base
        domain.relievo_foam.estimate = said(*foam_of(samples, count, fps, settings))
        self.report({"INFO"}, domain.relievo_foam.estimate)


class RELIEVO_OT_tissue_estimate(tissue.OnCollection, job.Steps, bpy.types.Operator):
    """Estimate elements, space and minutes of the soft tissue of the active object's collection. Minutes go by its last bake, if
    there was one"""

    bl_idname = "relievo.tissue_estimate"
    bl_label = "Estimate"

    def steps(self, context):
        scene, collection = context.scene, tissue.collection_of(context)
        count = scene.frame_end - scene.frame_start + 1
        if count < 1:
            raise Refused("The scene has no frames")
        simulation = tissue.Simulation(scene, collection, context.evaluated_depsgraph_get())
        model, found = collection.relievo_tissue, []
        pace = model.pace
        yield 0.0, 1.0, lambda _progress: found.extend(tissue_of(simulation, count, pace))
        model.estimate = said(*found, "elements")
        self.report({"INFO"}, model.estimate)


CLASSES = [RELIEVO_OT_fluid_estimate, RELIEVO_OT_foam_estimate, RELIEVO_OT_tissue_estimate]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
