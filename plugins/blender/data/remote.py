# SPDX-License-Identifier: GPL-3.0-or-later
"""Fluids that a server simulates: what is in a domain as a description and mesh files, and the frames that come back while
later ones are computed."""

import os
import tempfile
import uuid

import bpy
import librelievo as rl
import numpy
from librelievo import client

from ..core import native
from ..core.error import Refused
from . import frames

# Bytes of a file with a token at most.
LONGEST = 4096
# Seconds to wait for a server that does not answer.
PATIENCE = 3.0


def linking():
    """Returns what connects to the server that the preferences name; that needs nothing of Blender."""
    options = bpy.context.preferences.addons[native.PACKAGE].preferences
    token = ""
    if options.token_file:
        with open(bpy.path.abspath(options.token_file), encoding="utf-8") as file:
            token = file.read(LONGEST).strip()
    address, authority = options.server, bpy.path.abspath(options.tls_authority)
    return lambda: client.Client(address, token, patience=PATIENCE, authority=authority)


def connect():
    """Connects to the server that the preferences name."""
    return linking()()


def numbers(values):
    """Numbers as TOML has them, such that they are read back to the bit."""
    return "[" + ", ".join(repr(float(value)) for value in values) + "]"


class Remote:
    """A simulation as a server or a farm takes it: a description, and meshes in a folder."""

    def __init__(self, simulation, count, folder):
        self.simulation, self.count, self.folder = simulation, count, folder
        self.files, self.moving = {}, set()
        low, high = simulation.low, simulation.high
        fills = [shape for shape, _velocity in simulation.fills]
        for number, shape in enumerate(fills):
            ends = shape.points.min(0), shape.points.max(0)
            if (ends[0] < low).any() or (ends[1] > high).any():
                raise Refused(f"{shape.name} reaches out of the domain; on a server or farm, fills lie in it")
            for other in fills[:number]:
                if (ends[0] < other.points.max(0)).all() and (other.points.min(0) < ends[1]).all():
                    raise Refused(f"{shape.name} and {other.name} may overlap; on a server or farm, fills lie apart")
        self.emitters = [pouring.shape.points for pouring in simulation.pourings]
        self.colliders = [shape.points for _target, _how, shape in simulation.colliders]

    def add(self, name, made):
        """Adds a mesh to the files."""
        path = os.path.join(self.folder, name)
        made.write(path)
        self.files[name] = path

    def read(self, number):
        """Takes what emitters and colliders are in a frame of the simulation."""
        for pouring, points in zip(self.simulation.pourings, self.emitters):
            if not numpy.array_equal(pouring.shape.points, points):
                raise Refused(f"{pouring.name} moves; on a server or farm, emitters stand still")
        for at, (_target, _how, shape) in enumerate(self.simulation.colliders):
            if not numpy.array_equal(shape.points, self.colliders[at]):
                self.moving.add(at)
            with shape.build() as made:
                self.add(f"collider{at}.{number:06}.ply", made)

    def description(self):
        """The description of all frames."""
        simulation = self.simulation
        options = {**simulation.options, "gravity": numbers(simulation.options["gravity"])}
        lines = [f"frames = {self.count - 1}", f"fps = {float(simulation.fps)!r}", "[fluid]"]
        lines += [f"{name} = {value}" for name, value in options.items()]
        ends = f"low = {numbers(simulation.low)}\nhigh = {numbers(simulation.high)}"
        lines += ["[basin]", ends]
        for at, (shape, velocity) in enumerate(simulation.fills):
            with shape.build() as made:
                self.add(f"fill{at}.ply", made)
            lines += ["[[fill]]", f'mesh = "fill{at}.ply"', f"velocity = {numbers(velocity)}"]
        for at, pouring in enumerate(simulation.pourings):
            with pouring.shape.section(pouring.direction) as made:
                self.add(f"emitter{at}.ply", made)
            lines += ["[[emitter]]", f'mesh = "emitter{at}.ply"', f"speed = {float(pouring.speed)!r}"]
        if simulation.pourings:
            lines += ["[[sink]]", f"outside = {{ low = {numbers(simulation.low)}, high = {numbers(simulation.high)} }}"]
        for at, (_target, how, _shape) in enumerate(simulation.colliders):
            lines.append("[[collider]]")
            if at in self.moving:
                lines += [f'sequence = "collider{at}.######.ply"', f"count = {self.count}"]
            else:
                lines.append(f'mesh = "collider{at}.000000.ply"')
                for number in range(1, self.count):
                    del self.files[f"collider{at}.{number:06}.ply"]
            contact = how["contact"]
            lines.append(f"friction = {float(how['friction'])!r}" if contact == "friction" else f'contact = "{contact}"')
        return "\n".join(lines) + "\n"


def steps(scene, domain, simulation, folder, first, last):
    """Has a server simulate, and fetches frame after frame, as the steps of an operator. Yields what is done without
    Blender's data; after each frame, the domain's last frame is that one."""
    native.context()
    count = last - first + 1
    with tempfile.TemporaryDirectory() as meshes:
        remote = Remote(simulation, count, meshes)
        for number in range(count):
            scene.frame_set(first + number)
            simulation.read(bpy.context.evaluated_depsgraph_get())
            remote.read(number)
        text, name = remote.description(), f"{domain.name} {uuid.uuid4().hex[:8]}"
        with connect() as server:
            is_done = False
            try:
                yield 0.0, 0.0, lambda _progress: server.submit(name, text, remote.files)
                for number in range(count):

                    def work(progress, number=number):
                        server.wait(name, number, progress)
                        server.fetch(name, number, frames.path_of(folder, frames.PARTICLES, first + number))

                    yield number / count, (number + 1) / count, work
                    if number == 0:
                        frames.begin(domain, folder)
                        domain.relievo.fluid.first = first
                    domain.relievo.fluid.last = first + number
                is_done = True
            finally:
                release(server, name, is_done)


def release(server, name, is_done):
    """Has the server forget a scene, which it stops first if it is not done."""
    try:
        if not is_done:
            server.cancel(name)
        server.remove(name)
    except rl.RelievoError:
        # A server that is gone computes frames that nobody fetches when it is back, and no more.
        pass
