"""Fluids: domains that are simulated into a cache, what fills them, pours into them and moves in them, what is shown of a
frame, and what is refused."""

import os
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host


def box(name, low, high):
    """A closed box."""
    corners = numpy.array([[x, y, z] for z in (low[2], high[2]) for y in (low[1], high[1]) for x in (low[0], high[0])])
    faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]]
    return host.add(name, corners, faces, 4)


class Case(unittest.TestCase):
    def setUp(self):
        self.relievo = host.empty()
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        bpy.context.preferences.addons["relievo"].preferences.cache_folder = self.folder.name
        scene = bpy.context.scene
        scene.frame_start, scene.frame_end = 1, 6
        self.domain = box("tank", (0, 0, 0), (0.8, 0.4, 0.6))
        self.domain.relievo.fluid.role = "DOMAIN"
        self.domain.relievo.fluid.spacing = 0.05

    def part(self, role, name, low, high, **options):
        made = box(name, low, high)
        made.relievo.fluid.role = role
        for option, value in options.items():
            setattr(made.relievo.fluid, option, value)
        return made

    def simulate(self):
        host.select(self.domain)
        self.assertEqual(bpy.ops.relievo.fluid_simulate(), {"FINISHED"})
        return self.domain.relievo.fluid.result

    def at(self, frame):
        bpy.context.scene.frame_set(frame)
        return host.positions(self.domain.relievo.fluid.result)

    def refused(self, operator, text):
        host.select(self.domain)
        with self.assertRaisesRegex(RuntimeError, text) as caught:
            operator()
        self.assertNotIn("Traceback", str(caught.exception))


class Resumed(Case):
    """A simulation that was cancelled goes on where it was, to the bit."""

    def pouring(self):
        self.part("FILL", "fill", (0.05, 0.05, 0.05), (0.3, 0.35, 0.3))
        self.part("EMITTER", "tap", (0.5, 0.15, 0.45), (0.6, 0.25, 0.5), velocity=(0, 0, -1.5))
        paddle = self.part("COLLIDER", "paddle", (0.4, 0.1, 0.02), (0.45, 0.3, 0.3))
        for frame, x in ((1, 0.0), (6, 0.15)):
            paddle.location.x = x
            paddle.keyframe_insert("location", frame=frame)

    def frames(self):
        return [self.at(frame).copy() for frame in range(1, 7)]

    def test_a_cancelled_simulation_goes_on_to_the_bit(self):
        from relievo.ops import fluid

        self.pouring()
        self.simulate()
        whole = self.frames()
        self.assertGreater(len(whole[-1]), len(whole[0]))
        host.select(self.domain)
        for turns in (3, 5):
            steps = host.operator(fluid.RELIEVO_OT_fluid_simulate)
            for _ in range(turns):
                next(steps)[2](None)
            steps.close()
            options = self.domain.relievo.fluid
            # The frame of the last turn is whole.
            self.assertEqual(options.last, turns - 1)
            self.assertEqual(bpy.ops.relievo.fluid_resume(), {"FINISHED"})
            self.assertEqual(options.last, 6)
            for one, other in zip(self.frames(), whole):
                numpy.testing.assert_array_equal(one, other)
        self.refused(bpy.ops.relievo.fluid_resume, "tank has all frames up to 6; raise the last frame of the scene")
        bpy.context.scene.frame_end = 7
        host.select(self.domain)
        self.assertEqual(bpy.ops.relievo.fluid_resume(), {"FINISHED"})
        self.assertEqual(self.domain.relievo.fluid.last, 7)
        folder = Path(bpy.path.abspath(self.domain.relievo.fluid.cache))
        self.assertEqual(len(list(folder.glob("state_*"))), 1)
        bpy.ops.relievo.fluid_clear()
        self.assertFalse(folder.exists())
        self.refused(bpy.ops.relievo.fluid_resume, "tank has nothing to go on from")

    def test_the_estimate_is_near_what_it_takes(self):
        self.part("FILL", "fill", (0.05, 0.05, 0.05), (0.45, 0.35, 0.35))
        host.select(self.domain)
        self.assertEqual(bpy.ops.relievo.fluid_estimate(), {"FINISHED"})
        said = self.domain.relievo.fluid.estimate
        self.assertRegex(said, r"^About [\d,]+ particles, [\d.]+ MiB, [\d.]+ min")
        particles = int(said.split()[1].replace(",", ""))
        count = len(self.simulate().data.vertices)
        self.assertAlmostEqual(particles / count, 1, delta=0.3)
        size = sum(path.stat().st_size for path in Path(self.folder.name).rglob("particles_*.rlvfluid")) / 2**20
        bpy.ops.relievo.fluid_estimate()
        self.assertAlmostEqual(float(self.domain.relievo.fluid.estimate.split()[3]) / size, 1, delta=0.4)


class Starts(Case):
    """How a fluid begins: at rest, with particles, in place of its fill."""

    def test_nothing_begins_under_pressure(self):
        """A fill reaches out of the box and lies around a pillar. It does not touch the floor, so in its first frame it falls
        and nothing else moves it."""
        self.part("FILL", "fill", (-0.03, -0.03, -0.03), (0.3, 0.43, 0.4))
        self.part("COLLIDER", "pillar", (0.1, 0.1, -0.1), (0.21, 0.21, 0.7))
        bpy.context.scene.frame_end = 2
        result = self.simulate()
        bpy.context.scene.frame_set(2)
        velocities = numpy.empty((len(result.data.vertices), 3), numpy.float32)
        result.data.attributes["velocity"].data.foreach_get("vector", velocities.ravel())
        self.assertGreater(len(velocities), 150)
        fall = 9.81 / bpy.context.scene.render.fps
        self.assertAlmostEqual(float(numpy.linalg.norm(velocities, axis=1).max()), fall, delta=0.1 * fall)

    def test_an_emitter_that_faces_away_pours(self):
        counts = []
        for number, order in enumerate(([0, 1, 2, 3], [3, 2, 1, 0])):
            corners = numpy.array([[0.2, 0.1, 0.4], [0.4, 0.1, 0.4], [0.4, 0.3, 0.4], [0.2, 0.3, 0.4]])
            sheet = host.add(f"sheet {number}", corners, [order], 4)
            sheet.relievo.fluid.role, sheet.relievo.fluid.velocity = "EMITTER", (0, 0, -1)
            counts.append(len(self.simulate().data.vertices) or len(self.at(6)))
            if number:
                sheet.relievo.fluid.velocity = (1, 0, 0)
                self.refused(bpy.ops.relievo.fluid_simulate, "sheet 1 pours along its own faces")
            sheet.relievo.fluid.role = "NONE"
        self.assertGreater(counts[0], 0)
        self.assertEqual(counts[0], counts[1])

    def test_no_particle_is_no_success(self):
        fill = self.part("FILL", "fill", (2, 2, 2), (2.3, 2.3, 2.3))
        self.refused(bpy.ops.relievo.fluid_simulate, "There is no particle of fill in the domain: move it into the box")
        self.assertFalse(fill.hide_render)
        fill.relievo.fluid.role = "NONE"
        self.part("EMITTER", "tap", (2, 2, 2), (2.3, 2.3, 2.3), velocity=(0, 0, -1))
        self.refused(bpy.ops.relievo.fluid_simulate, "There is no particle of tap in the domain")

    def test_a_fill_gives_way_to_its_fluid(self):
        fill = self.part("FILL", "fill", (0, 0, 0), (0.3, 0.4, 0.4))
        self.simulate()
        self.assertEqual((fill.display_type, fill.hide_render), ("WIRE", True))


class OnServer(Case):
    """What a server simulates; RELIEVO_COMMAND names the command that serves."""

    def setUp(self):
        super().setUp()
        self.serve("server")
        self.domain.relievo.fluid.place = "SERVER"

    def serve(self, cache, *more):
        command = [os.environ["RELIEVO_COMMAND"], "server", "run", "--listen", "127.0.0.1:0", "--threads", "1", *more]
        command += ["--cache", os.path.join(self.folder.name, cache)]
        server = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        self.addCleanup(server.stdout.close)
        self.addCleanup(server.wait)
        self.addCleanup(server.kill)
        preferences = bpy.context.preferences.addons["relievo"].preferences
        preferences.server = server.stdout.readline().split()[-1]
        return preferences

    def test_the_panel_checks_the_server(self):
        host.select(self.domain)
        self.assertTrue(bpy.types.RELIEVO_PT_server.poll(bpy.context))
        self.assertEqual(bpy.ops.relievo.server_check(), {"FINISHED"})
        preferences = bpy.context.preferences.addons["relievo"].preferences
        preferences.server = f"unix:{self.folder.name}/nowhere"
        self.refused(bpy.ops.relievo.server_check, "the server does not answer: .*check that the server runs")

    def test_frames_come_from_the_server_and_are_those_of_this_machine(self):
        self.part("FILL", "block", (0, 0, 0), (0.3, 0.4, 0.4))
        wall = self.part("COLLIDER", "wall", (0.6, 0.1, 0), (0.7, 0.3, 0.5))
        wall.keyframe_insert("location", frame=1)
        wall.location.x = -0.1
        wall.keyframe_insert("location", frame=6)
        self.simulate()
        there = [self.at(frame) for frame in (1, 6)]
        self.assertEqual(self.domain.relievo.fluid.last, 6)
        self.domain.relievo.fluid.place = "HERE"
        self.simulate()
        here = [self.at(frame) for frame in (1, 6)]
        for ours, theirs, within in zip(here, there, (1e-5, 0.05)):
            self.assertEqual(len(ours), len(theirs))
            # Particles may be in another order.
            ends = [numpy.sort(points, axis=0) for points in (ours, theirs)]
            self.assertLess(numpy.abs(ends[0] - ends[1]).max(), within)

    def test_connections_are_encrypted(self):
        files = Path(__file__).resolve().parent.parent / "tls"
        encryption = ["--tls-cert", files / "server.pem", "--tls-key", files / "server.key"]
        preferences = self.serve("encrypted", *encryption)
        # The certificate is of this name.
        preferences.server = "tls://localhost:" + preferences.server.rpartition(":")[2]
        self.part("FILL", "block", (0, 0, 0), (0.3, 0.4, 0.4))
        self.refused(bpy.ops.relievo.fluid_simulate, "certificates")
        preferences.tls_authority = str(files / "server.pem")
        self.refused(bpy.ops.relievo.fluid_simulate, "certificate of the server is refused")
        preferences.tls_authority = str(files / "authority.pem")
        self.simulate()
        self.assertEqual(self.domain.relievo.fluid.last, 6)
        preferences.tls_authority = ""

    def test_what_a_server_does_not_do_is_refused(self):
        block = self.part("FILL", "block", (0, 0, 0), (0.3, 0.5, 0.4))
        self.refused(bpy.ops.relievo.fluid_simulate, "reaches out of the domain")
        block.scale.y = 0.5
        self.part("FILL", "other", (0.2, 0, 0), (0.4, 0.2, 0.4))
        self.refused(bpy.ops.relievo.fluid_simulate, "may overlap")
        bpy.context.preferences.addons["relievo"].preferences.server = "nowhere"
        bpy.data.objects.remove(bpy.data.objects["other"])
        self.refused(bpy.ops.relievo.fluid_simulate, "host:port")


class OnFarm(Case):
    """What a farm simulates; `sbatch` is a script that says what it was called with."""

    def setUp(self):
        super().setUp()
        self.bin, self.job = (os.path.join(self.folder.name, name) for name in ("bin", "job"))
        os.mkdir(self.bin)
        self.sbatch("echo 7")
        before = os.environ["PATH"]
        self.addCleanup(os.environ.__setitem__, "PATH", before)
        os.environ["PATH"] = self.bin + os.pathsep + before
        self.preferences = bpy.context.preferences.addons["relievo"].preferences
        self.addCleanup(setattr, self.preferences, "command", "relievo")
        self.preferences.command = os.environ["RELIEVO_COMMAND"]
        options = self.domain.relievo.fluid
        options.place, options.farm_folder, options.farm_make, options.farm_chunk = "FARM", self.job, {"MESH"}, 2

    def sbatch(self, does):
        path = os.path.join(self.bin, "sbatch")
        with open(path, "w", encoding="utf-8") as file:
            file.write(f'#!/bin/sh\necho "$@" >> "{self.folder.name}/calls"\n{does}\n')
        os.chmod(path, 0o755)

    def test_a_job_is_written_and_submitted_and_its_tasks_make_the_frames(self):
        self.part("FILL", "block", (0, 0, 0), (0.3, 0.4, 0.4))
        wall = self.part("COLLIDER", "wall", (0.6, 0.1, 0), (0.7, 0.3, 0.5))
        wall.keyframe_insert("location", frame=1)
        wall.location.x = -0.1
        wall.keyframe_insert("location", frame=6)
        host.select(self.domain)
        self.assertEqual(bpy.ops.relievo.fluid_farm(), {"FINISHED"})
        calls = Path(self.folder.name, "calls").read_text(encoding="utf-8").splitlines()
        self.assertEqual([call.split()[-1] for call in calls], ["simulate.sbatch", "mesh.sbatch"])
        self.assertIn("--dependency=afterok", calls[1])
        script = Path(self.job, "farm", "simulate.sbatch").read_text(encoding="utf-8")
        self.assertIn("#SBATCH --job-name=tank-simulate", script)
        # The farm calls `relievo`, which here is in no folder of commands.
        words = script.split("exec relievo ")[1].split()
        done = subprocess.run([os.environ["RELIEVO_COMMAND"], *words], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(len(list(Path(self.job, "frames").glob("*.rlvfluid"))), 6)

    def test_what_cannot_be_submitted_is_refused(self):
        block, options = self.part("FILL", "block", (0, 0, 0), (0.3, 0.4, 0.4)), self.domain.relievo.fluid
        self.refused(bpy.ops.relievo.fluid_simulate, "simulated on a farm")
        self.sbatch("echo the queue is closed >&2; exit 1")
        self.refused(bpy.ops.relievo.fluid_farm, "the queue is closed")
        self.preferences.command = "no-such-command"
        self.refused(bpy.ops.relievo.fluid_farm, "preferences")
        options.farm_folder = ""
        self.refused(bpy.ops.relievo.fluid_farm, "no folder")
        options.farm_folder = self.job
        block.scale.x = 4
        self.refused(bpy.ops.relievo.fluid_farm, "reaches out of the domain")


class Simulating(Case):
    def test_a_dam_breaks_and_is_played(self):
        self.part("FILL", "water", (0, 0, 0), (0.3, 0.4, 0.4))
        result = self.simulate()
        options = self.domain.relievo.fluid
        self.assertEqual((options.first, options.last), (1, 6))
        first = self.at(1)
        self.assertEqual(len(first), 6 * 8 * 8)
        numpy.testing.assert_allclose(first.min(0), 0.025, atol=1e-5)
        fronts = [self.at(frame)[:, 0].max() for frame in range(1, 7)]
        self.assertEqual(fronts, sorted(fronts))
        self.assertGreater(fronts[-1], fronts[0] + 0.05)
        last = self.at(6)
        self.assertTrue((last > 0).all() and (last < (0.8, 0.4, 0.6)).all())
        numpy.testing.assert_array_equal(self.at(99), last)
        velocities = numpy.empty((len(last), 3), numpy.float32)
        result.data.attributes["velocity"].data.foreach_get("vector", velocities.ravel())
        self.assertGreater(velocities[:, 0].max(), 0.3)
        # The same again is the same, to the bit.
        self.simulate()
        numpy.testing.assert_array_equal(self.at(6), last)
        self.assertEqual(self.domain.relievo.fluid.result, result)

    def test_the_surface_is_shown_and_kept(self):
        self.part("FILL", "water", (0, 0, 0), (0.3, 0.4, 0.4))
        result = self.simulate()
        options = self.domain.relievo.fluid
        options.show = "SURFACE"
        live = self.at(3)
        self.assertGreater(len(result.data.polygons), 500)
        self.assertFalse(result.data.validate())
        host.select(self.domain)
        self.assertEqual(bpy.ops.relievo.fluid_mesh(), {"FINISHED"})
        numpy.testing.assert_array_equal(self.at(3), live)
        self.assertIn("velocity", result.data.attributes)
        for function in ("BLOBS", "DENSITY", "ANISOTROPIC"):
            options.function = function
        options.show = "PARTICLES"
        self.assertEqual((len(self.at(3)), len(result.data.polygons)), (6 * 8 * 8, 0))
        bpy.ops.relievo.fluid_clear()
        self.assertEqual((options.cache, len(result.data.vertices)), ("", 0))
        self.assertEqual([*Path(self.folder.name).rglob("*.npz"), *Path(self.folder.name).rglob("*.rlvfluid")], [])

    def test_emitters_pour_and_particles_keep_their_distance(self):
        self.part("EMITTER", "tap", (0.35, 0.15, 0.4), (0.45, 0.25, 0.5), velocity=(0, 0, -1.5))
        self.simulate()
        counts = [len(self.at(frame)) for frame in range(1, 7)]
        self.assertEqual(counts, sorted(counts))
        self.assertEqual(counts[0], 0)
        # 0.1 m x 0.1 m at 1.5 m/s for five frames.
        self.assertAlmostEqual(counts[-1], 0.01 * 1.5 * 5 / 24 / 0.05**3, delta=4)
        last = self.at(6).astype(float)
        apart = numpy.linalg.norm(last[:, None] - last, axis=2) + numpy.eye(len(last))
        self.assertGreater(apart.min(), 0.5 * 0.05)

    def test_emitters_move_and_what_is_beside_the_box_is_left_out(self):
        tap = self.part("EMITTER", "tap", (0.1, 0.1, 0.4), (0.3, 0.3, 0.5), velocity=(0, 0, -1.5))
        tap.keyframe_insert("location", frame=1)
        tap.location.x = 0.4
        tap.keyframe_insert("location", frame=6)
        self.part("EMITTER", "lost", (0.7, 0.1, 0.3), (1.4, 0.3, 0.4), velocity=(0, 0.5, 0))
        self.simulate()
        last = self.at(6)
        self.assertTrue((last > 0).all() and (last < (0.8, 0.4, 0.6)).all())
        # Those of the first layers are below where it was, the last ones where it is.
        deep = last[last[:, 2] < 0.2]
        high = last[(last[:, 2] > 0.33) & (last[:, 0] < 0.69)]
        self.assertGreater(high[:, 0].mean(), deep[:, 0].mean() + 0.1)

    def test_fills_that_overlap_and_colliders_in_them_leave_room(self):
        self.part("FILL", "water", (0, 0, 0), (0.4, 0.4, 0.4))
        self.part("FILL", "more", (0.2, 0, 0), (0.6, 0.4, 0.4))
        self.part("COLLIDER", "stone", (0.1, 0.1, 0.1), (0.3, 0.3, 0.3))
        self.simulate()
        first = self.at(1)
        inside = ((first > 0.1) & (first < 0.3)).all(1)
        self.assertFalse(inside.any())
        self.assertGreater(len(first), 12 * 8 * 8 - 6 * 6 * 6)
        self.assertLess(len(first), 12 * 8 * 8)
        apart = numpy.linalg.norm(first[:, None] - first.astype(float), axis=2) + numpy.eye(len(first))
        self.assertGreater(apart.min(), 0.9 * 0.05)

    def test_colliders_move_and_nothing_passes(self):
        self.part("FILL", "water", (0.3, 0, 0), (0.7, 0.4, 0.3))
        piston = self.part("COLLIDER", "piston", (-0.3, -0.2, -0.2), (0.1, 0.6, 0.8), contact="FRICTION")
        piston.keyframe_insert("location", frame=1)
        piston.location.x = 0.3
        piston.keyframe_insert("location", frame=6)
        self.simulate()
        last = self.at(6)
        self.assertGreater(last[:, 0].min(), 0.4 - 0.02)
        self.assertGreater(last[:, 2].max(), self.at(1)[:, 2].max())

    def test_gravity_is_that_of_the_scene(self):
        self.part("FILL", "water", (0.2, 0.1, 0.2), (0.4, 0.3, 0.4))
        bpy.context.scene.use_gravity = False
        self.simulate()
        numpy.testing.assert_allclose(self.at(6), self.at(1), atol=0.02)

    def test_what_cannot_be_simulated_is_refused(self):
        simulate = bpy.ops.relievo.fluid_simulate
        self.refused(simulate, "Nothing fills")
        self.refused(bpy.ops.relievo.fluid_mesh, "no frames")
        tap = self.part("EMITTER", "tap", (0.3, 0.1, 0.3), (0.4, 0.2, 0.4))
        self.refused(simulate, "no velocity")
        tap.relievo.fluid.role = "FILL"
        self.domain.relievo.fluid.spacing = 1e-4
        self.refused(simulate, "Spacing: it does not fit the domain")

    def test_damaged_and_missing_frames_are_told(self):
        self.part("FILL", "water", (0, 0, 0), (0.3, 0.4, 0.4))
        self.simulate()
        frames = sys.modules["relievo.data.frames"]
        path = frames.path_of(self.domain.relievo.fluid.cache, frames.PARTICLES, 4)
        data = Path(path).read_bytes()
        for kept in (data[:100], b"", data[:-200], b"PK\3\4" + bytes(99), os.urandom(500)):
            Path(path).write_bytes(kept)
            self.assertRegex(frames.show(self.domain, 4), "Frame 4 of tank cannot be shown")
        newer = bytearray(data)
        newer[8:12] = (1000).to_bytes(4, "little")
        Path(path).write_bytes(newer)
        self.assertRegex(frames.show(self.domain, 4), "version 1000")
        context = sys.modules["relievo.core.native"].context()
        with sys.modules["librelievo"].Particles(context, numpy.zeros((1, 3))) as made:
            made.write(path)
        self.assertRegex(frames.show(self.domain, 4), "no velocities")
        os.remove(path)
        self.assertRegex(frames.show(self.domain, 4), "cannot be shown")
        self.assertEqual(frames.show(self.domain, 5), "")
        Path(path).write_bytes(data)
        bpy.ops.relievo.fluid_mesh()
        self.domain.relievo.fluid.show = "SURFACE"
        path = frames.path_of(self.domain.relievo.fluid.cache, frames.SURFACE, 5)
        numpy.savez(path, format=numpy.uint32(2), points=numpy.zeros((1, 3), numpy.float32))
        self.assertRegex(frames.show(self.domain, 5), "newer")
        numpy.savez(path, format=numpy.uint32(1), points=numpy.zeros((1, 3)), triangles=numpy.zeros((0, 3), "u4"),
                    velocities=numpy.full((1, 3), numpy.nan, "f4"))
        self.assertRegex(frames.show(self.domain, 5), "no finite vectors")


if __name__ == "__main__":
    host.main()
