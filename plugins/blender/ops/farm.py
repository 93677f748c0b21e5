# SPDX-License-Identifier: GPL-3.0-or-later
"""Fluids on a render farm: a domain as a description and mesh files in a folder that all machines see, and
`relievo farm submit`, which makes a job of them."""

import os
import re
import subprocess

import bpy

from ..core import job, native, preferences
from ..core.error import Refused
from ..data import remote
from . import fluid

# The folder of the description and its meshes, in that of the job.
INPUT = "input"
# How long the command may take to submit a job, seconds.
PATIENCE = 120


def submit(command, description, options, name):
    """Calls `relievo farm submit` and returns what it says; without Blender's data."""
    called = [command, "farm", "submit", description, "-o", options["folder"], "--engine", options["engine"]]
    called += ["--make", options["make"], "--chunk", str(options["chunk"]), "--name", name]
    try:
        done = subprocess.run(called, capture_output=True, text=True, stdin=subprocess.DEVNULL, timeout=PATIENCE)
    except OSError as failure:
        raise Refused(f"{command} cannot be called: {failure.strerror}; name the command in the add-on's preferences") from None
    except subprocess.TimeoutExpired:
        raise Refused(f"{command} has not submitted the job within {PATIENCE} s") from None
    if done.returncode:
        raise Refused(done.stderr.strip() or f"{command} ended with {done.returncode}")
    return done.stdout.strip()


class RELIEVO_OT_fluid_farm(fluid.OnDomain, job.Steps, bpy.types.Operator):
    """Submit the fluid of the active domain over the frames of the scene to a render farm, as a simulation and what is made of
    its frames"""

    bl_idname = "relievo.fluid_farm"
    bl_label = "Submit to farm"

    def steps(self, context):
        scene, domain = context.scene, context.active_object
        told, now = domain.relievo.fluid, scene.frame_current
        if not told.farm_folder:
            raise Refused("The job has no folder; name one that all machines of the farm see")
        if not told.farm_make:
            raise Refused("Nothing is made of the frames; choose meshes, foam or pictures")
        folder = os.path.abspath(bpy.path.abspath(told.farm_folder))
        make = ",".join(one.lower() for one in ("MESH", "FOAM", "RENDER") if one in told.farm_make)
        options = {"folder": folder, "engine": told.farm.lower(), "make": make, "chunk": told.farm_chunk}
        name = re.sub("[^A-Za-z0-9_-]", "_", domain.name)
        native.context()
        inputs, first, last = os.path.join(folder, INPUT), scene.frame_start, scene.frame_end
        os.makedirs(inputs, exist_ok=True)
        try:
            scene.frame_set(first)
            simulation = fluid.Simulation(scene, domain, context.evaluated_depsgraph_get())
            there = remote.Remote(simulation, last - first + 1, inputs)
            for number in range(last - first + 1):
                scene.frame_set(first + number)
                simulation.read(context.evaluated_depsgraph_get())
                there.read(number)
        finally:
            scene.frame_set(now)
        description = os.path.join(inputs, "fluid.toml")
        # Under its name when it is complete, since a job that was submitted before may read it.
        with open(description + ".part", "w", encoding="utf-8") as file:
            file.write(there.description())
        os.replace(description + ".part", description)
        command, said = preferences.get().command, []
        yield 0.0, 1.0, lambda _progress: said.append(submit(command, description, options, name))
        self.report({"INFO"}, said[0] or f"{name} is submitted")


CLASSES = [RELIEVO_OT_fluid_farm]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
