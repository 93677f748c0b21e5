"""Every noun of the package, against closed forms and against one another; failures, cancelling and threads."""

import ctypes
import gc
import io
import json
import multiprocessing
import os
import subprocess
import sys
import tempfile
import threading
import unittest
from pathlib import Path

import numpy

ROOT = Path(__file__).resolve().parents[2]
sys.path += [str(ROOT / "plugins" / "python"), str(Path(__file__).resolve().parent)]

import librelievo as rl
import shapes
from librelievo import bake, decal, document, imprint, job, ptex, repair, stroke

PACKAGE = str(Path(rl.__file__).parents[1])


def flat_detail(context, cells=4, **options):
    points, corners, uvs = shapes.grid(cells)
    mesh = rl.Mesh(context, points, corners, 4)
    mesh.add_attribute("uv", uvs, "corner", indices=corners)
    surface = rl.Surface(context, mesh, boundary="edges_and_corners")
    return rl.Detail(surface, **options)


def heights(detail):
    """Displacement in the middle of every tile."""
    tiles = numpy.arange(detail.info.tile_count)
    return detail.evaluate(tiles, numpy.full((len(tiles), 2), 0.5), ["displacements"])["displacements"]


def finished(started):
    """What a job makes, once it has ended."""
    started.wait()
    return started.result()


class Hosts(unittest.TestCase):
    """What a host asks of the library besides its nouns."""

    def test_capabilities_and_formats(self):
        found = rl.capability()
        self.assertGreaterEqual(found.opensubdiv_version, (3 << 22) + (5 << 12))
        self.assertEqual(rl.Context().info.threads, found.cores)
        rows = {(row.content, row.extension): row for row in rl.formats()}
        self.assertTrue(rows[rl.Content.MESH, "obj"].can_write_bytes)
        self.assertFalse(rows[rl.Content.MESH, "gltf"].can_write)

    def test_failures_have_numbers(self):
        with self.assertRaises(rl.Invalid) as failed:
            rl.Mesh(rl.Context(threads=1), numpy.eye(3, dtype="f4"), [0, 1, 9], 3)
        self.assertEqual((failed.exception.element_kind, failed.exception.element), (rl.Element.CORNER, 2))
        self.assertNotEqual(failed.exception.code, 0)

    def test_corners_may_be_rows(self):
        context = rl.Context(threads=1)
        points, corners, _ = shapes.grid(4)
        rows = numpy.reshape(corners, (-1, 4))
        for mesh in (rl.Mesh(context, points, rows), rl.Mesh(context, points, rows, 4), rl.Mesh.borrow(context, points, rows)):
            self.assertEqual((mesh.info.face_count, mesh.info.corner_count), (len(rows), rows.size))
        with self.assertRaises(rl.Invalid):
            rl.Mesh(context, points, rows, 3)

    def test_threads_are_shared_memory_is_watched_and_jobs_say_when_they_end(self):
        with self.assertRaisesRegex(rl.Invalid, "shared"):
            rl.Context(shared=rl.Context(threads=2), threads=3)
        context = rl.Context(shared=rl.Context(threads=2))
        self.assertEqual(context.info.threads, 2)
        taken, limit = [0], [1 << 20]

        def watch(count):
            if count > 0 and taken[0] + count > limit[0]:
                return False
            taken[0] += count

        context.set_memory_monitor(watch)
        points, corners, _ = shapes.grid(4)
        mesh = rl.Mesh(context, points, corners, 4)
        self.assertEqual(taken[0], 12 * len(points) + 20 * 16)
        limit[0] = 0
        with self.assertRaises(rl.MemoryLimit):
            rl.Mesh(context, points, corners, 4)
        mesh.release()
        self.assertEqual(taken[0], 0)
        context.set_memory_monitor(None)
        detail = flat_detail(context)
        self.assertEqual((detail.wait_idle(0).is_busy, detail.wait_idle().noun), (0, "detail"))
        ended = threading.Event()
        running = job.tessellate(detail)
        running.notify(ended.set)
        self.assertTrue(ended.wait(60))
        self.assertEqual(running.wait().state, rl.JobState.DONE)


class Tissues(unittest.TestCase):
    """A block of gel that stands on its lower side, and one with a muscle of rings."""

    def setUp(self):
        self.context = rl.Context(threads=1)
        self.block = rl.Tissue.block(self.context, (0, 0, 0), 0.025, (4, 4, 4), young=8000, poisson=0.45)
        self.low = self.block.add_set("low", (-1, -1, -1), (1, 1, 0.001))
        self.block.hold(self.low)

    def test_blocks_are_simulated_pressed_and_kept(self):
        self.assertEqual((self.block.info.element_count, len(self.low), self.block.nodes().shape), (64, 25, (125, 3)))
        top = self.block.add_set("top", (-1, -1, 0.0999), (1, 1, 1))
        with self.block.simulate(gravity=(0, 0, 0), damping=5) as simulation:
            simulation.press(top, [(0, 500.0)])
            self.assertTrue(simulation.relax(1e-3).is_at_rest)
            found = simulation.get("positions", "volumes", "principal_stresses")
            self.assertLess(found["positions"][top, 2].mean(), 0.0985)
            numpy.testing.assert_array_equal(found["positions"][self.low], self.block.nodes()[self.low])
            self.assertTrue((found["volumes"] < 1).any())
            results = simulation.get("strains", "principal_strains", "contact_pressures")
            numpy.testing.assert_allclose(
                results["strains"][:, :3].sum(axis=1), results["principal_strains"].sum(axis=1), atol=1e-6
            )
            pressures = results["contact_pressures"]
            self.assertEqual((pressures.shape, pressures.max()), ((125,), 0))
            with self.assertRaisesRegex(rl.Invalid, "velocities"):
                simulation.get("strain")
            with tempfile.TemporaryDirectory() as folder, self.block.simulate() as other:
                simulation.save(Path(folder, "a.rtstate"))
                other.restore_bytes(simulation.save_bytes())
                other.restore(Path(folder, "a.rtstate"))
                numpy.testing.assert_array_equal(other.get("positions")["positions"], found["positions"])
                simulation.write_vtu(Path(folder, "a.vtu"))
                self.block.write(Path(folder, "a.rtissue"))
                with rl.Tissue.read(self.context, Path(folder, "a.rtissue")) as read:
                    self.assertEqual(read.info.checksum, self.block.info.checksum)
                with rl.Tissue.read_bytes(self.context, self.block.write_bytes()) as read:
                    self.assertEqual(read.info.checksum, self.block.info.checksum)

    def test_balls_press_and_jobs_advance(self):
        with self.block.simulate(step=0) as simulation:
            simulation.drive(self.low, [(0, (0, 0, 0)), (0.01, (0.001, 0, 0))], "x")
            simulation.add_collider(radius=0.03, friction=0.3, keys=[(0, (0.05, 0.05, 0.12))])
            work = job.advance_tissue(simulation, 0.01)
            work.wait()
            work.result()
            places = simulation.get("positions")["positions"]
            distances = numpy.linalg.norm(places - (0.05, 0.05, 0.12), axis=1)
            self.assertGreater(distances.min(), 0.0299)
            self.assertGreater(simulation.energies.kinetic, 0)
            simulation.relax(1e-3, 400)
            self.assertGreater(simulation.get("contact_pressures")["contact_pressures"].max(), 100)

    def test_muscles_of_rings_pull(self):
        points, corners = shapes.cube()
        mesh = rl.Mesh(self.context, 0.05 * (points + 1), corners, 4)
        angles = numpy.linspace(0, 2 * numpy.pi, 8, endpoint=False)
        ring = numpy.stack([numpy.zeros(8), 0.05 + 0.03 * numpy.cos(angles), 0.05 + 0.03 * numpy.sin(angles)], 1)
        rings = numpy.stack([ring + (x, 0, 0) for x in (0.01, 0.05, 0.09)])
        materials = [{"name": "gel", "young": 8000, "poisson": 0.45}, {"name": "flesh", "library": "muscle"}]
        biceps = {"name": "biceps", "level": 1, "material": "flesh", "is_muscle": True, "strength": 2e5, "rings": rings}
        description = {"cell": 0.02, "materials": materials, "volumes": [{"name": "gel", "mesh": mesh}, biceps]}
        with rl.Tissue(self.context, **description) as tissue:
            self.assertEqual((tissue.find_muscle("biceps"), tissue.muscles()[0].name), (0, "biceps"))
            index = tissue.bind("skin", mesh)
            with tissue.simulate(gravity=(0, 0, 0)) as simulation:
                simulation.activate(0, [(0, 0.0), (0.002, 0.5)])
                simulation.advance(0.004)
                self.assertLess(simulation.get("fibre_stretches")["fibre_stretches"].min(), 0.999)
                with simulation.mesh(index) as skin:
                    self.assertEqual(skin.points().shape, (8, 3))
                    points = simulation.bound_points(index, numpy.empty((8, 3), numpy.float32))
                    numpy.testing.assert_array_equal(points, skin.points())
            work = job.build_tissue(self.context, **description)
            work.wait()
            with work.result() as built:
                self.assertEqual(built.info.element_count, tissue.info.element_count)
                self.assertEqual((built.report.volume, tissue.report.volume), (tissue.report.volume,) * 2)
                self.assertAlmostEqual(built.report.volume, 1e-3, delta=1e-5)
                with tempfile.TemporaryDirectory() as folder:
                    path = Path(folder, "block.rtissue")
                    self.assertIsNone(finished(job.write_tissue(built, path)))
                    with finished(job.read_tissue(self.context, path)) as read:
                        self.assertEqual(read.info, built.info)
        with rl.Tissue(self.context, **description, bend=(0.5, 0.6)) as bent:
            self.assertEqual(bent.info.has_cells, 0)
            self.assertAlmostEqual(bent.info.high[0], 0.5 * numpy.sin(0.1 / 0.5), delta=1e-6)
        with self.assertRaisesRegex(rl.Invalid, "no material `bone`"):
            rl.Tissue(self.context, **{**description, "volumes": [{"name": "gel", "mesh": mesh, "material": "bone"}]})


class Decals(unittest.TestCase):
    """A plane of 5 by 5 quads of the unit square, and pins that lay an image of 40 by 20 pixels flat on it."""

    def setUp(self):
        self.context = rl.Context(threads=1)
        self.detail = flat_detail(self.context, 5, tile_size=16)
        places = [(4, 4), (36, 4), (36, 16), (4, 16)]
        self.pins = [(place, (0.3 + 0.01 * place[0], 0.4 + 0.01 * place[1], 0)) for place in places]
        points, corners, _ = shapes.grid(8)
        self.mesh = rl.Mesh(self.context, points, corners, 4)

    def test_the_example_paints_a_ball(self):
        with tempfile.TemporaryDirectory() as folder:
            example = [sys.executable, str(ROOT / "examples" / "python" / "decal.py"), str(Path(folder) / "ball.relievo")]
            done = subprocess.run(example, env={**os.environ, "PYTHONPATH": PACKAGE}, capture_output=True, text=True)
            self.assertRegex(done.stdout, "[1-9][0-9]* texels of [1-9][0-9]* tiles painted\n(99.|100).*, 0 flipped", done.stderr)

    def test_stickers_lie_flat_and_follow(self):
        with rl.Decal.on_mesh(self.mesh, self.pins, (40, 20)) as decal:
            quality = decal.quality
            self.assertEqual((quality.pin_count, quality.flip_count, quality.coverage), (4, 0, 1.0))
            self.assertAlmostEqual(quality.l2, 1.0, 5)
            with decal.mesh(0.1) as mesh:
                uv, points = mesh.attribute("uv").values, mesh.points()
                numpy.testing.assert_allclose(uv[:, 0], (points[:, 0] - 0.3) / 0.4, atol=1e-5)
                numpy.testing.assert_allclose(points[:, 2], 0.1, atol=1e-6)
            decal.drag_pin(0, (0.35, 0.45, 0))
            decal.settle()
            self.assertGreater(decal.quality.l2, 1.0001)
            decal.move_image(0, (5, 5))
            self.assertAlmostEqual(decal.quality.l2, 1.0, 2)
            with self.assertRaisesRegex(rl.Invalid, "outside"):
                decal.move_image(0, (50, 5))
            decal.pose(2 * self.mesh.points())
            self.assertAlmostEqual(decal.quality.l2, 1.0, 2)
            with self.assertRaisesRegex(rl.Invalid, "points"):
                decal.pose(self.mesh.points()[1:])
        with self.assertRaisesRegex(rl.Invalid, "pin 1"):
            rl.Decal.on_mesh(self.mesh, [self.pins[0], ((1, 2),)], (40, 20))
        with self.assertRaises(rl.Cancelled):
            rl.Decal.on_mesh(self.mesh, self.pins, (40, 20), progress=lambda *_: False)
        outline = [(0, 0), (40, 0), (40, 20)]
        with rl.Decal.on_mesh(self.mesh, self.pins[1:2], (40, 20), outline, pose_width=0.4) as decal:
            self.assertEqual(decal.quality.coverage, 1.0)

    def test_stickers_are_painted_into_textures(self):
        points, corners, uv = shapes.grid(8)
        mesh = rl.Mesh(self.context, points, corners, 4)
        mesh.add_attribute("uv", uv, "point")
        image = numpy.ones((20, 40, 3), numpy.float32)
        with rl.Decal.on_mesh(mesh, self.pins, (40, 20)) as decal:
            made, count = decal.paint_texture(image, numpy.zeros((100, 100, 3)), 0.5)
        self.assertEqual((count, made.shape), (200, (100, 100, 3)))
        numpy.testing.assert_allclose(made[21:29, 66:84], 0.5, atol=1e-5)
        self.assertEqual(numpy.count_nonzero(made[..., 0]), 200)

    def test_stickers_are_cut_out_by_alpha_and_laid_along_curves(self):
        image = numpy.zeros((20, 40, 4), numpy.float32)
        image[5:15, 10:30, 3] = 1
        corners = decal.contour(image, tolerance=0.25)
        numpy.testing.assert_allclose([corners.min(0), corners.max(0)], [(10, 5), (30, 15)], atol=0.01)
        curve = [(-0.8, 0, 0), (0.8, 0, 0)]
        for strip, ground in ((decal.strip_on_mesh, self.mesh), (decal.strip_on_detail, self.detail)):
            pins, length = strip(ground, curve, (80, 10), cells=4)
            self.assertAlmostEqual(length, 1.6 if ground is self.mesh else length)
            self.assertGreaterEqual(len(pins), 8)
        pins, _ = decal.strip_on_mesh(self.mesh, curve, (80, 10))
        with rl.Decal.on_mesh(self.mesh, pins, (80, 10)) as laid:
            self.assertAlmostEqual(laid.quality.l2, 1.0, 3)

    def test_stickers_are_written_into_layers(self):
        image = numpy.ones((20, 40, 3), numpy.float32)
        image[..., 1:] = 0
        laid = job.decal_on_detail(self.detail, self.pins, (40, 20), cells=4)
        laid.wait()
        with laid.result() as sticker:
            with self.assertRaisesRegex(rl.Invalid, "no colours"):
                sticker.paint(image)
            self.detail.add_paint(tile_size=16)
            report = sticker.paint(image, 0.5)
            self.assertGreater(report.texels, 100)
            self.assertEqual(report.refused_tiles, 0)
            sticker.emboss(numpy.ones((20, 40), numpy.float32), 0.25)
            with self.assertRaisesRegex(rl.Invalid, "pixels"):
                sticker.paint(image[1:])
            self.assertGreater(sticker.write(image, blend="multiply").texels, 100)
        self.detail.commit()
        self.assertGreater(float(heights(self.detail).max()), 0.1)
        with rl.Document(self.detail) as kept:
            with rl.Decal.on_detail(self.detail, self.pins, (40, 20), cells=4) as laid:
                number, pins = laid.apply(kept, "label", image, opacity=0.5), laid.pins
            found = decal.recipes_of(kept)
            self.assertEqual([(one.id, one.pin_count, one.opacity) for one in found], [(number, 4, 0.5)])
            with rl.Decal.take_up(kept, number) as laid:
                self.assertEqual([at for at, _, _ in laid.pins], [at for at, _, _ in pins])
                places = [[position for _, position, _ in list_of] for list_of in (laid.pins, pins)]
                numpy.testing.assert_allclose(*places, atol=1e-4)
                laid.drag_pin(1, (0.63, 0.44, 0))
                laid.update(kept, number, image, opacity=0.25)
            self.assertEqual(decal.recipes_of(kept)[0].opacity, 0.25)
            decal.remove(kept, number)
            self.assertEqual(decal.recipes_of(kept), [])
        started = job.decal_on_mesh(self.mesh, self.pins, (40, 20))
        started.wait()
        self.assertEqual(started.result().quality.flip_count, 0)


class Meshes(unittest.TestCase):
    def setUp(self):
        self.context = rl.Context(threads=1)

    def test_arrays_are_borrowed_as_long_as_they_are_read(self):
        points, corners = shapes.cube()
        points, corners = numpy.array(points, numpy.float32), numpy.array(corners, numpy.uint32)
        taken = []
        self.context.set_memory_monitor(lambda size: taken.append(size) or True)
        mesh = rl.Mesh.borrow(self.context, points, corners, numpy.full(6, 4, numpy.uint32))
        self.context.set_memory_monitor(None)
        # Not a byte is copied.
        self.assertEqual(sum(taken), 0)
        address, count = points.__array_interface__["data"][0], sys.getrefcount(points)
        numpy.testing.assert_array_equal(mesh.points(), points)
        self.assertEqual(mesh.info.face_count, 6)
        surface = rl.Surface(self.context, mesh)
        mesh.release()
        self.assertLess(sys.getrefcount(points), count)
        points[:] = 0.0
        self.assertEqual((points.__array_interface__["data"][0], surface.info.point_count), (address, 8))
        with self.assertRaisesRegex(rl.Invalid, "points: a packed array of float32"):
            rl.Mesh.borrow(self.context, points.astype(float), corners, 4)
        with self.assertRaisesRegex(rl.Invalid, "points: a packed array"):
            rl.Mesh.borrow(self.context, points[::2], corners, 4)

    def test_a_limit_bounds_all_that_the_library_occupies(self):
        points, corners, _ = shapes.grid(64)
        made = rl.Mesh(self.context, points, corners, 4)
        self.assertEqual(rl.allocator_info().limit, 0)
        rl.set_memory_limit(rl.allocator_info().bytes + 1000)
        try:
            with self.assertRaises(rl.MemoryLimit):
                rl.Mesh(self.context, points, corners, 4)
        finally:
            rl.set_memory_limit(0)
        before = rl.allocator_info().bytes
        made.release()
        self.assertLess(rl.allocator_info().bytes, before)

    def test_an_allocator_comes_before_all_else(self):
        with self.assertRaisesRegex(rl.Invalid, "too late"):
            rl.set_allocator(16, 16)
        with self.assertRaisesRegex(rl.Invalid, "addresses"):
            rl.set_allocator(None, None)

    def test_what_goes_in_comes_out(self):
        points, corners = shapes.cube()
        creases = (numpy.array([[0, 1], [1, 3]]), [2.0, 10.0])
        mesh = rl.Mesh(self.context, points, corners, 4, creases=creases, sharp_points=([7], [3.0]))
        info = mesh.info
        self.assertEqual((info.point_count, info.face_count, info.crease_count, info.sharp_point_count), (8, 6, 2, 1))
        numpy.testing.assert_array_equal(mesh.points(), points)
        sizes, back = mesh.faces()
        numpy.testing.assert_array_equal(sizes, [4] * 6)
        numpy.testing.assert_array_equal(back, corners)
        self.assertEqual(mesh.triangles().shape, (12, 3))
        self.assertEqual((info.low, info.high), ((-1, -1, -1), (1, 1, 1)))

    def test_strided_and_converted_arrays_are_read_and_written_in_place(self):
        points, corners = shapes.cube()
        wide = numpy.zeros((8, 5), numpy.float32)
        wide[:, 1:4] = points
        mesh = rl.Mesh(self.context, wide[:, 1:4], corners.astype(numpy.int64), numpy.full(6, 4))
        numpy.testing.assert_array_equal(mesh.points(), points)
        backwards = rl.Mesh(self.context, points[::-1].astype(numpy.float64)[::-1], corners[::-1][::-1], 4)
        numpy.testing.assert_array_equal(backwards.points(), points)
        out = numpy.full((8, 4), 9.0, numpy.float32)
        self.assertIs(mesh.points(out[:, :3]).base, out)
        numpy.testing.assert_array_equal(out[:, :3], points)
        numpy.testing.assert_array_equal(out[:, 3], 9.0)
        with self.assertRaisesRegex(rl.Invalid, "float32"):
            mesh.points(numpy.empty((8, 3)))
        with self.assertRaisesRegex(rl.Invalid, "points"):
            rl.Mesh(self.context, numpy.zeros((8, 2)), corners, 4)
        with self.assertRaisesRegex(rl.Invalid, "numbers from 0"):
            rl.Mesh(self.context, points, corners.astype(numpy.int64) - 1, 4)

    def test_attributes_keep_their_type_width_and_indices(self):
        points, corners = shapes.cube()
        mesh = rl.Mesh(self.context, points, corners, 4)
        mesh.add_attribute("uv", [[0, 0], [1, 0.5]], "corner", indices=[0, 1] * 12)
        mesh.add_attribute("material", numpy.arange(6), "face")
        self.assertEqual(mesh.attribute_names(), ["uv", "material"])
        uv = mesh.attribute("uv")
        self.assertEqual((uv.values.shape, len(uv.indices), uv.domain.name), ((2, 2), 24, "CORNER"))
        numpy.testing.assert_array_equal(mesh.attribute("material").values[:, 0], range(6))
        with self.assertRaises(rl.NotFound):
            mesh.attribute("nothing")

    def test_files(self):
        points, corners = shapes.cube()
        with tempfile.TemporaryDirectory() as folder, rl.Mesh(self.context, points, corners, 4) as mesh:
            path = Path(folder, "würfel.obj")
            mesh.write(path)
            numpy.testing.assert_allclose(rl.Mesh.read(self.context, path).points(), points)
            with self.assertRaises(rl.NotFound) as caught:
                rl.Mesh.read(self.context, Path(folder, "none.obj"))
            self.assertIn("none.obj", str(caught.exception))
            self.assertTrue(caught.exception.what)
        self.assertEqual(mesh_edges(rl.Mesh(self.context, points, corners, 4).split(0.5)) <= 0.5, True)


def mesh_edges(mesh):
    points, triangles = mesh.points(), mesh.triangles()
    return max(numpy.linalg.norm(points[triangles[:, k]] - points[triangles[:, k - 1]], axis=1).max() for k in range(3))


class Misuses(unittest.TestCase):
    def test_what_cannot_be_used_is_said_in_a_sentence(self):
        """Arguments of wrong types are errors of the library that name them, and not Python's own."""
        context, points, quads = rl.Context(threads=1), numpy.eye(4, 3, dtype=numpy.float32), [[0, 1, 2, 3]]
        mesh = rl.Mesh(context, points, quads)
        detail = rl.Detail(rl.Surface(context, mesh), tile_size=8)
        detail.commit()
        brush = rl.Brush(context)
        for wanted, misuse in (
            ("context: an object of the library is needed, not NoneType", lambda: rl.Mesh(None, points, quads)),
            ("surface: an object of the kind Surface is needed, not Mesh", lambda: rl.Detail(mesh)),
            ("context: an object of the kind Context is needed, not Mesh", lambda: rl.Surface(mesh, context)),
            ("brush: an object of the library", lambda: stroke.run(detail, None, [[0, 0, 0]])),
            ("points: an array of numbers is needed", lambda: rl.Mesh(context, [[0, 0, 0], [1]], quads)),
            ("points: an array of numbers is needed", lambda: stroke.run(detail, brush, "abc")),
            ("matrix: an array of numbers is needed", lambda: detail.set_transform("x")),
            ("index: a whole number from 0 to 4294967295 is needed, not -1", lambda: mesh.attribute_info(-1)),
            ("triangles: a whole number from 0 to 18446744073709551615 is needed, not 0.5", lambda: mesh.simplify(0.5)),
            ("is_border_locked: True or False is needed, not 2", lambda: mesh.simplify(1, is_border_locked=2)),
            ("models: a list is needed, not int", lambda: rl.Crowd(context, 3)),
            ("models: an object of the kind CrowdModel is needed, not Mesh", lambda: rl.Crowd(context, [mesh])),
            ("files: a dictionary is needed, not list", lambda: job.submit_scene(context, "a", "b", [])),
            ("log: a function is needed, not int", lambda: context.set_log(3)),
            ("names: 'mass' is unknown; there are points", lambda: rl.Fluid(context).get("mass")),
            ("Job: other functions make it", lambda: rl.Job(None)),
            ("creases: a pair of elements and their sharpness", lambda: rl.Mesh(context, points, quads, creases=3)),
            ("longest_edge: a number is needed, not None", lambda: mesh.split(None)),
            ("path: a text or a path is needed, not int", lambda: rl.Mesh.read(context, 3)),
            ("name: a text is needed, not int", lambda: mesh.attribute(3)),
            ("data: bytes are needed, not str", lambda: rl.Mesh.read_bytes(context, "abc", "obj")),
            ("a dictionary of BrushSettings is needed, not list", lambda: rl.Brush(context, [1])),
            ("weights: a dictionary", lambda: mesh.simplify(triangles=1, weights=3)),
            ("progress: a function is needed, not int", lambda: mesh.simplify(triangles=1, progress=3)),
            ("curve: `None` is unknown; there are size, strength, angle", lambda: brush.set_curve(None, [[0, 0]])),
            ("wanted: a list of names (positions, normals", lambda: detail.evaluate([0], [[0, 0]], "positions")),
        ):
            with self.assertRaises(rl.Invalid) as caught:
                misuse()
            self.assertIn(wanted, str(caught.exception))

    def test_a_monitor_and_a_log_end_with_their_context(self):
        context, heard = rl.Context(threads=1), []
        context.set_memory_monitor(heard.append)
        context.set_log(lambda level, line: heard.append(line))
        mesh = rl.Mesh(context, numpy.eye(4, 3, dtype=numpy.float32), [[0, 1, 2, 3]])
        told = list(heard)
        del context
        gc.collect()
        # It gives back memory, of which a function that is gone would hear.
        mesh.release()
        self.assertTrue(told)
        self.assertEqual(heard, told)

    def test_rows_of_corners_are_faces(self):
        context, points = rl.Context(threads=1), numpy.eye(4, 3, dtype=numpy.float32)
        for rows in ([[0, 1, 2, 3]], [[0, 1, 2], [1, 2, 3]]):
            sizes, corners = rl.Mesh(context, points, rows).faces()
            self.assertEqual(sizes.tolist(), [len(row) for row in rows])
            self.assertEqual(corners.reshape(len(rows), -1).tolist(), rows)
        with self.assertRaisesRegex(rl.Invalid, "corners"):
            rl.Mesh(context, points, numpy.zeros((1, 2, 2), int))


class Surfaces(unittest.TestCase):
    def setUp(self):
        self.context = rl.Context(threads=1)

    def test_a_regular_grid_is_itself_inside(self):
        points, corners, _ = shapes.grid(6)
        surface = rl.Surface(self.context, rl.Mesh(self.context, points, corners, 4))
        tiles = numpy.full(3, 14, numpy.uint32)
        uvs = numpy.array([[0, 0], [0.5, 0.25], [1, 1]], numpy.float32)
        found = surface.evaluate(tiles, uvs, ["positions", "normals", "du"])
        corner = points[corners[14 * 4]]
        wanted = corner + numpy.column_stack([uvs / 3, numpy.zeros(3)])
        numpy.testing.assert_allclose(found["positions"], wanted, atol=1e-6)
        numpy.testing.assert_allclose(found["normals"], [[0, 0, 1]] * 3, atol=1e-6)
        numpy.testing.assert_allclose(found["du"], [[1 / 3, 0, 0]] * 3, atol=1e-5)
        self.assertEqual(list(surface.face_tiles(14)), [14])
        self.assertEqual(surface.tile_info(14).face, 14)
        with self.assertRaisesRegex(rl.Invalid, "wanted"):
            surface.evaluate(tiles, uvs, ["colour"])
        with self.assertRaises(rl.Invalid):
            surface.evaluate([99], [[0, 0]])

    def test_a_pose_and_a_tessellation(self):
        points, corners = shapes.cube()
        surface = rl.Surface(self.context, rl.Mesh(self.context, points, corners, 4))
        before = surface.tessellate(coarse=4)
        surface.set_points(points * 2)
        after = surface.tessellate(coarse=4)
        numpy.testing.assert_allclose(after.points(), before.points() * 2, atol=1e-5)
        with self.assertRaisesRegex(rl.Invalid, "coarse"):
            surface.tessellate(course=4)

    def test_triangles(self):
        points, corners = shapes.ball()
        surface = rl.Surface(self.context, rl.Mesh(self.context, points, corners, 3), kind="triangles")
        self.assertEqual(surface.info.tile_count, len(corners) // 3)


class Subdivisions(unittest.TestCase):
    def test_schemes_and_primvars(self):
        context = rl.Context(threads=1)
        points = [[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]]
        cage = rl.Mesh(context, points, [0, 1, 2, 3], 4)
        cage.add_attribute("heat", [0.0, 10.0, 20.0, 10.0], "point")
        square = rl.Subdivision(context, cage, scheme="bilinear", face_varying="all")
        self.assertEqual((square.info.tile_count, square.face_tiles(0)), (1, range(0, 1)))
        found = square.evaluate([0], [[0.25, 0.5]], ["values", "du", "duv"])
        numpy.testing.assert_allclose(found["values"], [[0.25, 0.5, 0.125]], atol=1e-6)
        numpy.testing.assert_allclose(found["du"], [[1, 0, 0.5]], atol=1e-6)
        numpy.testing.assert_allclose(found["duv"], [[0, 0, 1]], atol=1e-5)
        heat = square.evaluate([0], [[0.25, 0.5]], attribute="heat", rule="varying")["values"]
        numpy.testing.assert_allclose(heat, [[7.5]], atol=1e-5)
        square.set_points(numpy.add(points, [0, 0, 2]))
        self.assertEqual(square.refine(2).info.low[2], 2.0)
        with self.assertRaises(rl.NotFound):
            square.evaluate([0], [[0, 0]], attribute="st")
        with self.assertRaisesRegex(rl.Unsupported, "Loop"):
            rl.Subdivision(context, cage, scheme="loop")
        with self.assertRaisesRegex(rl.Invalid, "scheme"):
            rl.Subdivision(context, cage, scheme="kobbelt")
        with self.assertRaisesRegex(rl.Invalid, "normals"):
            square.evaluate([0], [[0, 0]], ["normals"])


class Beziers(unittest.TestCase):
    def setUp(self):
        self.context = rl.Context(threads=1)
        rows, columns = numpy.mgrid[0:4, 0:4] / 3.0
        heights = numpy.array([0.25, -1 / 12, -1 / 12, 0.25])  # of (u - 0.5)^2
        self.points = numpy.stack([columns, rows, numpy.broadcast_to(heights, (4, 4))], 2).reshape(16, 3)

    def test_a_parabola_is_one_and_its_triangles_are_on_it(self):
        bezier = rl.Bezier(self.context, self.points)
        self.assertEqual((bezier.info.patch_count, bezier.info.is_rational), (1, 0))
        numpy.testing.assert_allclose(bezier.controls(0)[:, :3], self.points, atol=1e-7)
        found = bezier.evaluate([0, 0], [[0.25, 0.5], [1.0, 0.0]], ["positions", "normals", "du", "duu", "duv"])
        numpy.testing.assert_allclose(found["duu"][:, 2], 2.0, atol=1e-5)
        numpy.testing.assert_allclose(found["duv"], 0.0, atol=1e-5)
        numpy.testing.assert_allclose(found["positions"][:, 2], [0.0625, 0.25], atol=1e-6)
        numpy.testing.assert_allclose(found["du"][:, 2], [-0.5, 1.0], atol=1e-6)
        positions, normals, triangles = bezier.tessellate(3)
        self.assertEqual((positions.shape, triangles.shape), ((256, 3), (450, 3)))
        numpy.testing.assert_allclose(positions[:, 2], (positions[:, 0] - 0.5) ** 2, atol=1e-6)
        numpy.testing.assert_allclose(numpy.linalg.norm(normals, axis=1), 1.0, atol=1e-6)
        self.assertEqual(bezier.mesh([3]).info.triangle_count, 450)

    def test_levels_follow_the_view_and_weights_make_circles(self):
        bezier = rl.Bezier(self.context, self.points)
        near, far = (bezier.levels(eye=(0.5, 0.5, z))[0] for z in (2.0, 500.0))
        self.assertGreater(near, far)
        with self.assertRaisesRegex(rl.Invalid, "tolerance"):
            bezier.levels(tolerance=-1.0)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "quarter.bpt")
            middle = 0.5**0.5
            path.write_text(f"1\n1 2\n1 0 0 1\n1 1 0 {middle}\n0 1 0 1\n1 0 1 1\n1 1 1 {middle}\n0 1 1 1\n")
            quarter = rl.Bezier.read(self.context, path)
        self.assertEqual(quarter.info.is_rational, 1)
        positions = quarter.tessellate(2)[0]
        numpy.testing.assert_allclose(numpy.hypot(positions[:, 0], positions[:, 1]), 1.0, atol=1e-6)


class Levels(unittest.TestCase):
    def setUp(self):
        self.context = rl.Context(threads=1)
        points, corners = shapes.ball(1.0)
        self.mesh = rl.Mesh(self.context, points, corners, 3)
        self.whole = rl.Progressive(self.mesh, base_triangles=20, locked=[0])

    def test_meshes_are_simplified_with_their_attributes(self):
        points = self.mesh.points()
        self.mesh.add_attribute("height", points[:, 2:], "point")
        made, error = self.mesh.simplify(triangles=300, weights={"height": 0.1}, locked=[0, 1], factors=numpy.ones(len(points)))
        self.assertIn(made.info.triangle_count, (299, 300))
        self.assertGreater(error, 0.0)
        less = made.points()
        heights = made.attribute("height").values
        numpy.testing.assert_allclose(heights.reshape(-1), less[:, 2], atol=0.03)
        for pole in points[:2]:
            self.assertTrue((less == pole).all(axis=1).any())
        started = job.simplify(self.mesh, triangles=300, weights={"height": 0.1}, locked=[0, 1])
        started.wait()
        direct, deviation = self.mesh.simplify(triangles=300, weights={"height": 0.1}, locked=[0, 1])
        in_background, same = started.result()
        self.assertTrue((in_background.points() == direct.points()).all())
        self.assertEqual(same, deviation)
        bare, _ = self.mesh.simplify(error=0.01, left_out=["height"])
        self.assertEqual(bare.info.attribute_count, 0)
        bounded, distance = self.mesh.simplify(bound=0.02, left_out=["height"])
        self.assertTrue(0.0 < distance <= 0.02)
        self.assertLess(bounded.info.triangle_count, self.mesh.info.triangle_count // 2)
        radii = numpy.linalg.norm(bounded.points(), axis=1)
        self.assertLessEqual(radii.max(), 1.02 + 1e-5)
        with self.assertRaisesRegex(rl.Invalid, "no attribute"):
            self.mesh.simplify(triangles=300, weights={"uv": 1.0})
        with self.assertRaises(rl.Cancelled):
            self.mesh.simplify(triangles=300, progress=lambda fraction, stage: False)

    def test_meshes_are_checked_and_repaired(self):
        points, corners = self.mesh.points(), self.mesh.faces()[1].reshape(-1, 3)
        self.assertEqual(repair.check(self.mesh).is_solid, 1)
        turned = corners[3:].copy()
        turned[::5] = turned[::5, ::-1]
        soup = points[turned].reshape(-1, 3)
        heights = ("height", soup[:, 2:], "point")
        made, report = repair.arrays(self.context, soup, numpy.arange(len(soup)), 3, [heights], refine=False)
        self.assertEqual(made.info.face_count, len(corners))
        self.assertEqual((report.holes.count, report.filled_holes, report.after.euler), (1, 1, 2))
        self.assertEqual(len(report.holes.first[0]), 2)
        self.assertEqual(len(report.misoriented_edges.first), 8)
        numpy.testing.assert_array_equal(made.attribute("height").values.reshape(-1), made.points()[:, 2])
        open_mesh, report = repair.arrays(self.context, soup, numpy.arange(len(soup)), 3, fill=0)
        self.assertEqual(report.open_holes.count, 1)
        started = job.repair(open_mesh, refine=0)
        started.wait()
        in_background, same = started.result()
        self.assertEqual((same.filled_holes, in_background.info.face_count), (1, len(corners)))
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "open.obj"
            path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 2\n")
            with self.assertRaisesRegex(rl.Invalid, "rlv_repair_read"):
                rl.Mesh.read(self.context, path)
            _, report = repair.read(self.context, path)
            self.assertEqual((report.degenerate_faces, report.after.faces), ((1, [1]), 1))
        with self.assertRaises(rl.Cancelled):
            repair.mesh(open_mesh, progress=lambda fraction, stage: False)
        with self.assertRaisesRegex(rl.Invalid, "tolerance"):
            repair.mesh(open_mesh, tolerance=-1.0)
        self.assertIn("hole_area", [row.name for row in repair.params()])

    def test_the_example_repairs_a_ball(self):
        with tempfile.TemporaryDirectory() as folder:
            example = [sys.executable, str(ROOT / "examples" / "python" / "repair.py"), str(Path(folder) / "ball.ply")]
            done = subprocess.run(example, env={**os.environ, "PYTHONPATH": PACKAGE}, capture_output=True, text=True)
            self.assertRegex(done.stdout, "1 hole filled with [1-9][0-9]* points\nvolume 4.1", done.stderr)

    def test_files_and_jobs_have_the_same_mesh(self):
        info = self.whole.info
        self.assertEqual(info.triangle_count, self.mesh.info.face_count)
        self.assertLessEqual(info.base_triangle_count, 20)
        started = job.build(self.mesh, base_triangles=20, locked=[0])
        started.wait()
        self.assertEqual(started.result().info, info)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "ball.rlvpm")
            self.whole.write(path)
            self.assertEqual(rl.Progressive.read(self.context, path).info, info)
            rl.Progressive.read(self.context, path, 50)
            again = Path(folder, "again.rlvpm")
            self.assertIsNone(finished(job.write_progressive(self.whole, again)))
            self.assertEqual(again.read_bytes(), path.read_bytes())
            self.assertEqual(finished(job.read_progressive(self.context, again)).info, info)
            self.assertIsNotNone(finished(job.read_progressive(self.context, again, 50)))
            data = path.read_bytes()
        arrival = rl.Arrival(self.context)
        with self.assertRaisesRegex(rl.NotFound, "base"):
            arrival.progressive
        there = [arrival.push(data[at : at + 999]) for at in range(0, len(data), 999)]
        self.assertTrue(there[-1].is_complete and there[-1].triangle_count == info.triangle_count)
        level = rl.Level(arrival.progressive)
        level.take_up(self.whole)
        with self.assertRaisesRegex(rl.Invalid, "another"):
            level.take_up(rl.Progressive(self.mesh, base_triangles=60))
        with self.assertRaises(rl.Cancelled):
            rl.Progressive(self.mesh, progress=lambda fraction, stage: False)
        with self.assertRaisesRegex(rl.Invalid, "no point"):
            rl.Progressive(self.mesh, locked=[10**6])

    def test_levels_have_the_attributes_of_the_mesh(self):
        points, corners = shapes.ball(1.0)
        self.mesh.add_attribute("height", points[:, 2:], "point")
        self.mesh.add_attribute("half", (numpy.arange(len(corners) // 3, dtype=numpy.uint32) % 2)[:, None], "face")
        whole = rl.Progressive(self.mesh, base_triangles=20, weights={"height": 0.1})
        self.assertEqual([info.name for info in whole.attributes()], ["height", "half"])
        self.assertEqual(rl.Progressive(self.mesh, left_out=["half"]).info.attribute_count, 1)
        self.assertEqual(rl.Progressive(self.mesh).attributes(), [])
        level = rl.Level(whole)
        for triangles, tolerance in ((None, 0.0), (len(corners) // 6, 0.3), (None, 0.0)):
            level.set_triangles(triangles)
            level.update()
            at_corners = level.wedge_values[level.wedges.reshape(-1), 0]
            numpy.testing.assert_allclose(at_corners, level.points[level.triangles.reshape(-1), 2], atol=tolerance)
            self.assertEqual(level.face_values.shape, (len(level.triangles), 1))
        self.assertEqual(int(level.face_values.sum()), len(corners) // 6)
        self.assertIn("height", level.mesh().attribute_names())
        plain = rl.Level(self.whole)
        plain.update()
        self.assertEqual((plain.wedges.shape, plain.wedge_values.shape), ((0, 3), (0, 0)))

    def test_levels_are_balls_and_follow_edits(self):
        level = rl.Level(self.whole)
        for triangles in (50, 300, None):
            level.set_triangles(triangles)
            update = level.update()
            self.assertEqual(len(level.triangles), update.triangle_count)
            self.assertEqual(level.triangles.max() + 1, len(level.points))
            numpy.testing.assert_allclose(numpy.linalg.norm(level.points, axis=1), 1.0, atol=0.4)
        self.assertEqual(level.update().changed_vertex_count, 0)
        self.assertEqual(level.changed_ranges().shape, (0, 2))
        finest = level.points.copy()
        level.set_view(eye=(0, 0, 1.5), pixels=100.0, planes=[[0, 0, 1, 0]])
        level.set_triangles(100)
        pull = rl.Grip(rl.Region((0, 0, 1), 0.8), (0, 0, 0.5))
        self.assertGreater(level.edit([pull], [rl.Region((1, 0, 0), 0.2, "constant")]), 0)
        level.set_triangles()
        level.update()
        self.assertGreater(level.points[:, 2].max(), 1.4)
        pushed = rl.Level(self.whole)
        pushed.set_triangles()
        pushed.update()
        before = pushed.points.copy()
        pushed.edit([rl.Grip(rl.Region((0, 0, -1), 0.5), (0, 0, -0.1))])
        update, ranges = pushed.update(), pushed.changed_ranges()
        inside = numpy.zeros(len(before), bool)
        for first, count in ranges:
            inside[first : first + count] = True
        self.assertTrue(inside[(pushed.points != before).any(axis=1)].all() and not inside.all())
        self.assertEqual(ranges[0, 0], update.first_vertex)
        self.assertEqual(ranges[-1].sum(), update.first_vertex + update.changed_vertex_count)
        self.assertEqual(len(pushed.changed_ranges("face")), 0)
        self.assertEqual(level.mesh().info.face_count, self.whole.info.triangle_count)
        moving = rl.Level(self.whole)
        keys = [rl.GripKey(0.0), rl.GripKey(2.0, (0, 0, 1))]
        moving.add_motion([rl.GripTrack(rl.Region((0, 0, 0), 9, "constant"), keys)])
        moving.update()
        rest = moving.points.copy()
        self.assertGreater(moving.set_time(0.5), 0)
        moving.update()
        numpy.testing.assert_allclose(moving.points, rest + [0, 0, 0.25], atol=1e-6)
        moving.clear_motions()
        moving.update()
        numpy.testing.assert_array_equal(moving.points, rest)
        with self.assertRaisesRegex(rl.Invalid, "time"):
            moving.set_time(float("nan"))
        worst, count = level.misplaced(3)
        self.assertTrue(count >= len(worst) and (worst[:, 4] > 2 * worst[:, 3]).all())
        self.assertEqual(len(level.misplaced()[0]), count)
        rebuilt = rl.Level(level.rebuild(base_triangles=20))
        self.assertEqual(rebuilt.misplaced()[1], 0)
        with self.assertRaises(rl.Cancelled):
            level.rebuild(progress=lambda fraction, stage: False)
        settled = rl.Level(level.settle())
        settled.set_triangles()
        settled.update()
        self.assertGreater(settled.points[:, 2].max(), 1.4)
        level.undo()
        self.assertEqual(level.info.redo_count, 1)
        level.update()
        numpy.testing.assert_array_equal(numpy.sort(level.points, axis=0), numpy.sort(finest, axis=0))
        level.redo()
        with self.assertRaises(rl.NotFound):
            level.redo()
        # A stroke at a coarse level raises the finest one too, and is one edit.
        level.set_triangles(400)
        brush = rl.Brush(self.context, {"radius": 0.9}, action="sculpt", mode="draw", height=0.3)
        level.update()
        lowest = level.points[level.points[:, 1].argmin()].copy()
        done = level.sculpt(brush, [lowest])
        self.assertEqual((done.dabs, done.missed_dabs, level.info.undo_count), (1, 0, 2))
        self.assertGreater(done.vertices, 5)
        level.update()
        self.assertAlmostEqual(lowest[1] - level.points[:, 1].min(), 0.3, delta=0.03)
        level.set_triangles()
        level.update()
        self.assertLess(level.points[:, 1].min(), -1.15)
        with self.assertRaisesRegex(rl.Invalid, "no vertex is in the brush"):
            level.sculpt(brush, [[0, -9, 0]])
        with self.assertRaisesRegex(rl.Invalid, "no colours"):
            level.sculpt(rl.Brush(self.context), [[0, -1, 0]])
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "level.journal")
            with self.assertRaisesRegex(rl.Invalid, "edits already"):
                level.open_journal(path)
            first, second = rl.Level(self.whole), rl.Level(self.whole)
            first.open_journal(path)
            first.edit([pull])
            first.sync_journal()
            first.close_journal()
            second.open_journal(path)
            self.assertEqual(second.info.undo_count, 1)
            first.update(), second.update()
            numpy.testing.assert_array_equal(first.points, second.points)
            with self.assertRaises(rl.NotFound):
                first.close_journal()
            second.close_journal()
        self.assertLessEqual(level.set_bound(0.05), 0.05)
        with self.assertRaisesRegex(rl.Invalid, "error"):
            level.set_error(-1.0)
        with self.assertRaisesRegex(rl.Invalid, "bound"):
            level.set_bound(-1.0)
        with self.assertRaisesRegex(rl.Invalid, "steep"):
            level.edit([rl.Grip(rl.Region((0, 0, 1), 0.8, "steep"))])

    def test_the_example_runs(self):
        with tempfile.TemporaryDirectory() as folder:
            example = [sys.executable, str(ROOT / "examples" / "python" / "levels.py"), folder]
            told = subprocess.run(example, env={**os.environ, "PYTHONPATH": PACKAGE}, capture_output=True, text=True)
            self.assertRegex(told.stdout, r"moved [1-9]\d* of", told.stderr)
            self.assertEqual(len(list(Path(folder).glob("level_*.obj"))), 3)


class Fluids(unittest.TestCase):
    """A block of a fluid in a basin."""

    def setUp(self):
        self.context = rl.Context(threads=2)
        self.fluid = rl.Fluid(self.context)
        self.fluid.set_basin((0, 0, 0), (0.2, 0.16, 0.3))
        self.fluid.add_box((0, 0, 0), (0.16, 0.16, 0.16))

    def test_it_is_simulated_here_and_in_the_background(self):
        report = self.fluid.advance(0.02)
        self.assertGreater(report.steps, 0)
        self.assertAlmostEqual(report.seconds, 0.02, places=6)
        self.assertLess(report.max_excess, 0.05)
        started = job.advance(self.fluid, 0.02)
        started.wait()
        self.assertGreater(started.result().steps, 0)
        self.assertAlmostEqual(self.fluid.info.seconds, 0.04, places=6)
        with self.assertRaises(rl.Cancelled):
            self.fluid.advance(10.0, progress=lambda fraction, stage: False)
        other = rl.Fluid(self.context, solver="dfsph")
        other.set_basin((0, 0, 0), (0.2, 0.16, 0.3))
        other.add_box((0, 0, 0), (0.16, 0.16, 0.16))
        self.assertGreater(other.advance(0.02).divergence_corrections, 0)
        self.assertEqual(report.divergence_corrections, 0)
        with self.assertRaisesRegex(rl.Invalid, "spacing"):
            rl.Fluid(self.context, spacing=-1.0)
        with self.assertRaisesRegex(rl.Invalid, "seconds"):
            self.fluid.step(-1.0)

    def test_what_particles_carry_stays_with_them(self):
        heat = numpy.linspace(0, 1, 512, dtype=numpy.float32)
        self.fluid.set_channel("heat", heat)
        self.fluid.add([(0.1, 0.12, 0.2), (0.14, 0.12, 0.2)], channels={"heat": [3.0, 4.0], "color": [(1, 0, 0.5)]})
        self.fluid.step(0.001)
        carried = self.fluid.channels()
        self.assertEqual((carried["heat"].shape, carried["color"].shape), ((514, 1), (514, 3)))
        self.assertTrue((carried["heat"].ravel() == numpy.append(heat, [3, 4]).astype(numpy.float32)).all())
        self.assertTrue((carried["color"][-2:] == (1, 0, 0.5)).all() and not carried["color"][:-2].any())
        self.assertTrue((self.fluid.channel("heat") == carried["heat"]).all())
        with self.assertRaisesRegex(rl.NotFound, "did you mean `heat`"):
            self.fluid.channel("heal")
        with self.fluid.isosurface() as surface, surface.mesh() as mesh:
            self.assertEqual(mesh.attribute("color").values.shape[1], 3)

    def test_a_state_goes_on_to_the_bit(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "state.rlvfluid"
            self.fluid.advance(0.01)
            self.fluid.save(path)
            kept, others = self.fluid.save_bytes(), [rl.Fluid(self.context), rl.Fluid(self.context)]
            for other in others:
                other.set_basin((0, 0, 0), (0.2, 0.16, 0.3))
            others[0].restore(path)
            others[1].restore_bytes(kept)
            names = ("points", "velocities", "pressures", "numbers")
            self.fluid.advance(0.01)
            expected = self.fluid.get(*names)
            for other in others:
                other.advance(0.01)
                found = other.get(*names)
                self.assertTrue(all((found[name] == expected[name]).all() for name in names))
            for damaged in (b"", kept[:-1], kept[:100] + b"damaged" + kept[107:]):
                with self.assertRaises(rl.Invalid):
                    self.fluid.restore_bytes(damaged)
            with self.assertRaises(rl.NotFound):
                self.fluid.restore(Path(folder) / "nothing")

    def test_particles_are_written_and_read(self):
        self.fluid.set_channel("heat", numpy.linspace(0, 1, 512))
        expected = self.fluid.get("points", "velocities")
        with tempfile.TemporaryDirectory() as folder, self.fluid.particles() as made:
            for name in ("rlvfluid", "bgeo", "vtk", "ply", "vdb"):
                path = Path(folder) / f"some.{name}"
                made.write(path)
                with rl.Particles.read(self.context, path) as found:
                    numpy.testing.assert_allclose(found.points(), expected["points"], atol=1e-6)
                    self.assertTrue((found.channels()["velocity"] == expected["velocities"]).all())
                    self.assertTrue((found.channel("heat") == self.fluid.channel("heat")).all())
                    self.assertTrue((found.numbers() == numpy.arange(512)).all())
            with self.assertRaisesRegex(rl.Unsupported, "rlvfluid"):
                made.write(Path(folder) / "some.doc")
        own = rl.Particles(self.context, [(0, 0, 0), (1, 0, 0)], {"blind": [0, 1]}, numbers=[7, 3], time=0.5, spacing=0.1)
        self.assertEqual((own.info.time, own.info.has_numbers, own.info.count), (0.5, 1, 2))
        self.assertEqual(list(rl.Particles(self.context, [(0, 0, 0)]).channels()), [])
        self.assertIsNone(rl.Particles(self.context, [(0, 0, 0)]).numbers())
        with own.isosurface() as surface, own.keep([0, 2]) as kept:
            self.assertAlmostEqual(surface.info.support, 0.2, places=6)
            self.assertEqual((kept.info.count, kept.channel("blind").item()), (1, 0.0))
        self.fluid.add_particles(rl.Particles(self.context, [(0.1, 0.08, 0.25)], {"velocity": [(0, 0, -1)]}))
        self.assertEqual(self.fluid.get("velocities")["velocities"][-1, 2], -1.0)
        with self.assertRaisesRegex(rl.Invalid, "numbers"):
            rl.Particles(self.context, [(0, 0, 0)], numbers=[1, 2])

    def test_what_particles_have_is_in_the_order_of_their_numbers(self):
        self.fluid.add([(0.1, 0.08, 0.2), (0.14, 0.08, 0.2)], [(0, 0, 1), (0, 0, 2)], lifetime=5.0)
        self.fluid.step(0.001)
        found = self.fluid.get(*("points", "velocities", "numbers", "pressures", "densities", "births"))
        numpy.testing.assert_array_equal(found["numbers"], numpy.arange(514))
        self.assertGreater(found["velocities"][513, 2], found["velocities"][512, 2])
        self.assertTrue((found["densities"] > 0).all() and (found["births"] == 0).all())
        self.assertEqual(self.fluid.remove([512, 7, 4000]), 2)
        wide = numpy.zeros((512, 5), numpy.float32)
        self.fluid.get(points=wide[:, 1:4])
        numpy.testing.assert_array_equal(wide[-1, 1:4], found["points"][513])
        before = self.fluid.info.momentum[1]
        self.fluid.accelerate(numpy.tile((0.0, 3.0, 0.0), (512, 1)))
        self.fluid.step(0.001)
        self.assertGreater(self.fluid.info.momentum[1], before)
        points, corners = shapes.cube()
        box = rl.Mesh(self.context, points, corners, 4)
        placed = numpy.diag((0.05, 0.05, 0.05, 1.0))
        placed[2, 3] = -0.07
        number = self.fluid.add_collider(box, placed, contact="friction", friction=0.3)
        self.fluid.move_collider(number, points * 0.05 + (0, 0, -0.06), 0.01, points * 0.05 + (0, 0, -0.07))
        self.fluid.step(0.001)
        self.assertEqual([given.shape for given in self.fluid.impulse(number)], [(3,), (3,)])
        self.assertLess(self.fluid.impulse()[0][2], 0)
        inside = self.fluid.fill(box, numpy.diag((0.05, 0.05, 0.05, 1.0)) + numpy.array([[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 3], [0] * 4]))
        self.assertEqual(inside, 5**3)
        self.fluid.add_emitter(center=(0, 0, 5), radius=0.1, speed=50.0, channels={"heat": 7.0})
        self.fluid.add_emitter(box, placed, speed=1.0, begin=100.0)
        self.fluid.set_forces([{"kind": "drag", "strength": 1.0}, {"kind": "turbulence", "strength": 1.0, "radius": 0.1}])
        self.fluid.set_budget(10**6, stops=True)
        report = self.fluid.advance(0.002)
        self.assertGreater(report.added, 0)
        self.assertEqual(len(report.forces), 3)
        self.fluid.add_sink((-9, -9, 1), (9, 9, 9))
        self.fluid.add_sink_mesh(box, placed)
        self.assertGreaterEqual(self.fluid.step(0.0001).removed, inside)
        self.fluid.clear_sources()
        self.fluid.set_walls(numpy.zeros((1, 3)))
        self.fluid.move_walls([(1.0, 1.0, 1.0)], [(0.0, 0.0, 1.0)])
        for call, text in (
            (lambda: self.fluid.accelerate(numpy.zeros((3, 3))), "512 particles"),
            (lambda: self.fluid.add(numpy.zeros((3, 3)), numpy.zeros((2, 3))), "velocities"),
            (lambda: self.fluid.get("mass"), "unknown"),
            (lambda: self.fluid.set_channel("heat", numpy.zeros((512, 2))), "heat"),
            (lambda: self.fluid.set_channel("heat", numpy.zeros(3)), "512 particles"),
            (lambda: self.fluid.set_channel("velocity", numpy.zeros((512, 3))), "velocity"),
            (lambda: self.fluid.add_emitter(channels={"heat": (1, 2, 3, 4, 5)}), "width"),
            (lambda: self.fluid.move_collider(5, points, 0.1), "collider 5"),
            (lambda: self.fluid.set_forces([{"kind": "magnet"}]), "magnet"),
            (lambda: self.fluid.add_emitter(speed=-1.0), "speed"),
            (lambda: self.fluid.get(points=numpy.zeros((4, 3), numpy.float32)), "shape"),
            (lambda: self.fluid.add_box((0, 0), (1, 1, 1)), "low"),
        ):
            with self.assertRaisesRegex(rl.Invalid, text):
                call()

    def test_its_surface_is_a_mesh_and_is_met_by_rays(self):
        surface = self.fluid.isosurface()
        self.assertEqual((surface.info.particle_count, surface.info.has_velocities), (512, 1))
        heights = self.fluid.get("points")["points"][:, 2]
        mesh = surface.mesh(channels={"height": heights}, iterations=2)
        self.assertEqual(set(mesh.attribute_names()), {"normal", "velocity", "height"})
        self.assertEqual(2 * mesh.info.point_count, mesh.info.triangle_count + 4)
        self.assertLess(abs(mesh.attribute("height").values[:, 0] - mesh.points()[:, 2]).max(), 0.02)
        started = job.mesh(surface, {"height": heights}, iterations=2)
        started.wait()
        numpy.testing.assert_array_equal(started.result().points(), mesh.points())
        found = surface.classify()
        self.assertEqual(numpy.bincount(found.classes, minlength=3).tolist(), list(found[1:4]))
        hits = surface.cast([(0.08, 0.08, 1.0), (5, 5, 1)], [(0, 0, -2)] * 2)
        self.assertAlmostEqual(float(hits["position"][0, 2]), 0.16, delta=0.02)
        self.assertAlmostEqual(float(hits["distance"][0]), (1 - hits["position"][0, 2]) / 2, places=5)
        self.assertTrue(numpy.isinf(hits["distance"][1]) and hits["enters"][0] == 1)
        ray, hit = rl.abi.RlvIsosurfaceRay(origin=(0.08, 0.08, 1), direction=(0, 0, -1)), rl.abi.RlvIsosurfaceHit()
        table = surface.table
        self.assertEqual(table.intersect(table.data, ray, hit), 1)
        self.assertAlmostEqual(hit.distance, 2 * hits["distance"][0], places=5)
        sphere = rl.Isosurface(self.context, [(0, 0, 0)], [(1, 0, 0)], [False], radius=0.1, shutter_close=1.0)
        hits = sphere.cast([(0, 0, 2)] * 2, [(0, 0, -1)] * 2, times=[0.0, 0.5])
        self.assertAlmostEqual(float(hits["distance"][0]), 1.9, places=4)
        self.assertTrue(numpy.isinf(hits["distance"][1]))
        hits = sphere.cast([(0.5, 0, 2)] * 3, [(0, 0, -1)] * 3, [0.0, -1.0, 0.0], numpy.inf, 0.5, [1, 1, 0])
        self.assertEqual(numpy.isinf(hits["distance"]).tolist(), [False, True, True])
        with self.assertRaisesRegex(rl.Invalid, "min_distance"):
            sphere.cast([(0, 0, 2)], [(0, 0, -1)], 3.0, 2.0)
        with self.assertRaisesRegex(rl.Invalid, "times"):
            sphere.cast([(0, 0, 2)], [(0, 0, -1)], times=[0.0, 0.5])
        with self.assertRaisesRegex(rl.Invalid, "blind"):
            rl.Isosurface(self.context, [(0, 0, 0)], blind=[0, 1])
        with self.assertRaisesRegex(rl.Invalid, "function"):
            self.fluid.isosurface(function="cubes")
        with self.assertRaises(rl.Cancelled):
            surface.mesh(progress=lambda fraction, stage: False)

    def test_the_example_runs(self):
        with tempfile.TemporaryDirectory() as folder:
            example = [sys.executable, str(ROOT / "examples" / "python" / "dam.py"), folder]
            told = subprocess.run(example, env={**os.environ, "PYTHONPATH": PACKAGE}, capture_output=True, text=True)
            self.assertRegex(told.stdout, r"the front is at 1\.1\d m[\s\S]*the water is 0\.\d", told.stderr)
            self.assertEqual(len(list(Path(folder).glob("dam_*.ply"))), 3)


class Foams(unittest.TestCase):
    def test_a_particle_is_drawn_lit_and_composited(self):
        context = rl.Context(threads=1)
        make = lambda **more: rl.Foam(context, (33, 25), (0, 0, 5), (0, 0, 0), up=(0, 1, 0), fov=0.8, radius=0.5, **more)
        foam = make()
        foam.add([(0, 0, 0)], ids=[0], kinds=[rl.FoamKind.SPRAY], lives=[0.5])
        stages = []
        foam.shade(numpy.full((1, 2, 3), 0.5), progress=lambda fraction, stage: stages.append(stage))
        self.assertIn("occlusion of foam", stages)
        layers = foam.layers()
        self.assertEqual(layers["normal"].shape, (25, 33, 3))
        self.assertAlmostEqual(float(layers["depth"][12, 16]), 4.5, places=5)
        self.assertAlmostEqual(float(layers["thickness"][12, 16]), 0.75**0.4, places=4)
        numpy.testing.assert_allclose(layers["irradiance"][12, 16], 0.5, atol=1e-5)
        background = numpy.full((25, 33, 4), 0.25)
        picture = foam.composite(background)
        share = layers["intensity"][12, 16]
        self.assertAlmostEqual(float(picture[12, 16, 0]), 0.25 + 0.25 * float(share), places=4)
        self.assertTrue((picture[..., 3] == 0.25).all() and (picture[0, 0] == 0.25).all())
        hidden = make(solids=numpy.full((25, 33), 1.0))
        hidden.add([(0, 0, 0)])
        hidden.shade()
        self.assertEqual(hidden.layers()["intensity"].max(), 0)
        self.assertEqual([entry.name for entry in rl.foam.params()][0], "radius")
        with self.assertRaisesRegex(rl.Invalid, "solids"):
            make(solids=numpy.zeros((33, 25)))
        with self.assertRaisesRegex(rl.Invalid, "ids"):
            make().add([(0, 0, 0)], ids=[1, 2])
        with self.assertRaises(rl.Cancelled):
            make().shade(progress=lambda fraction, stage: False)


class Shaders(unittest.TestCase):
    TEXT = (
        "uniform float gain;\nvarying vec2 uv;\nvoid main() {\n    float a = uv.x * gain;\n    float b = a * a;\n"
        "    gl_FragColor = vec4(b /*. * confidence */);\n}\n"
    )

    def test_a_host_marks_augments_and_classifies(self):
        shader = rl.Shader(self.TEXT, name="ramp.frag")
        self.assertEqual([it.name for it in shader.variables() if it.function == "main"], ["a", "b"])
        with self.assertRaisesRegex(rl.Invalid, "no vector"):
            shader.layout()
        marked = shader.mark("a", "b", weight="gain")
        self.assertIn("//. vector a; b; gain", marked.text("marked"))
        self.assertIn("pel_take(gain)", marked.text())
        self.assertIn("@fragment", marked.text("augmented_wgsl"))
        self.assertEqual([it.expression for it in marked.features()], ["a", "b"])
        layout = marked.layout()
        # The log of a pixel that took one vector (0.5, 0.25) of the weight 2.
        log = numpy.zeros(layout.log_head + layout.feature_count, numpy.uint32)
        log[:2] = 1
        log[2:].view(numpy.float32)[:] = (2, 1, 0.5)
        numpy.testing.assert_array_equal(marked.unpack(log), (0.5, 0.25))
        examples = rl.ShaderExamples([marked.unpack(log), (1, 1)], [True, False], exponent=1)
        vectors = numpy.column_stack([numpy.linspace(0, 1, 9), numpy.linspace(0, 1, 9) ** 2])
        distances = numpy.linalg.norm(vectors[:, None] - examples.vectors, axis=2)
        with numpy.errstate(divide="ignore", invalid="ignore"):
            expected = 1 / distances[:, 0] / (1 / distances).sum(axis=1)
        expected[4], expected[8] = 1, 0
        numpy.testing.assert_allclose(examples.membership(vectors), expected, atol=1e-6)
        self.assertEqual(list(examples.pack(rl.ShaderMode.CLASSIFY, 3, 4)[:4]), [1, 3, 4, 2])

    def test_faults_have_places_and_wrong_arguments_are_refused(self):
        with self.assertRaisesRegex(rl.Invalid, "ramp.frag:4:"):
            rl.Shader(self.TEXT.replace("uv.x", "missing"), name="ramp.frag")
        with self.assertRaisesRegex(rl.Invalid, "language"):
            rl.Shader(self.TEXT, language="hlsl")
        with self.assertRaisesRegex(rl.Invalid, "there are"):
            rl.Shader(self.TEXT).mark("c")
        with self.assertRaisesRegex(rl.Invalid, "classes"):
            rl.ShaderExamples([(0, 1)], [1, 0])
        with self.assertRaisesRegex(rl.Invalid, "vectors"):
            rl.ShaderExamples([(0, 1)], [1]).membership([(1, 2, 3)])

    def test_the_notebook_runs(self):
        notebook = json.loads((ROOT / "examples" / "python" / "shader.ipynb").read_text(encoding="utf-8"))
        names = {}
        for cell in notebook["cells"]:
            if cell["cell_type"] == "code":
                self.assertEqual(cell["outputs"], [])
                exec("".join(cell["source"]), names)
        mask = names["mask"]
        self.assertEqual(mask.shape, names["height"].shape)
        self.assertGreater(mask[names["inside"]].mean(), 0.9)
        self.assertLess(mask[~names["inside"]].mean(), 0.1)


class DiffuseParticles(unittest.TestCase):
    def test_foam_is_born_where_blocks_of_fluid_meet(self):
        context = rl.Context(threads=1)
        grid = 0.02 * numpy.stack(numpy.meshgrid(*3 * [numpy.arange(8)], indexing="ij"), -1).reshape(-1, 3)
        positions = numpy.vstack([grid, grid + (0.16, 0, 0)])
        velocities = numpy.repeat([(4.0, 0, 0), (-4.0, 0, 0)], len(grid), 0)
        run = rl.Diffuse(context, 0.02, seed=3)
        potentials = run.potentials(positions, velocities)
        trapped = potentials["air"] > 0.5
        self.assertTrue((abs(positions[trapped, 0] - 0.15) < 0.011).all() and trapped.sum() == 2 * 64)
        report = run.advance(positions, velocities, 0.04)
        self.assertEqual((run.info.births, run.info.count), (report.born, report.born))
        self.assertGreater(report.born, 100)
        found = run.get()
        self.assertEqual(found["positions"].shape, (report.born, 3))
        numpy.testing.assert_array_equal(found["ids"], numpy.arange(report.born))
        foam = rl.Foam(context, (9, 9), (0, 0, 5), (0, 0, 0), up=(0, 1, 0))
        foam.add(*(found[name] for name in ("positions", "ids", "kinds", "lives")))
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "foam.rlvfluid")
            run.save(path, 0.04)
            with rl.Particles.read(context, path) as kept:
                self.assertEqual((kept.info.count, kept.info.time), (report.born, 0.04))
            other = rl.Diffuse(context, 0.02, seed=3)
            other.restore(path)
        for one in (run, other):
            one.advance(positions, velocities, 0.04)
        numpy.testing.assert_array_equal(run.get("positions")["positions"], other.get("positions")["positions"])
        self.assertEqual([entry.name for entry in rl.diffuse.params()][0], "air_min")
        with self.assertRaisesRegex(rl.Invalid, "velocities"):
            run.advance(positions, velocities[:4], 0.04)
        with self.assertRaisesRegex(rl.Invalid, "bounds"):
            rl.Diffuse(context, 0.02, bounds=((0, 0, 0), (0, 1, 1)))
        with self.assertRaises(rl.Cancelled):
            run.advance(positions, velocities, 0.04, progress=lambda fraction, stage: False)


class Crowds(unittest.TestCase):
    """A wavy square of 20 by 20 quads as a static model."""

    def setUp(self):
        self.context = rl.Context(threads=1)
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.path = Path(self.folder.name) / "waves.obj"
        self.write(0.1)

    def write(self, height):
        points, corners, uvs = shapes.grid(20)
        points = numpy.array(points, numpy.float32)
        points[:, 2] = height * numpy.sin(7 * points[:, 0]) * numpy.cos(5 * points[:, 1])
        mesh = rl.Mesh(self.context, points, corners, 4)
        mesh.add_attribute("uv", uvs, "corner", indices=corners)
        mesh.write(self.path)

    def test_a_model_is_built_written_read_and_meshed(self):
        stages = []
        model = rl.CrowdModel.build(
            self.context, self.path, cluster_triangles=40, progress=lambda fraction, stage: stages.append(stage)
        )
        self.assertIn("simplify", stages)
        info = model.info
        self.assertEqual((info.input_triangles, info.clip_count, info.bone_count), (800, 1, 1))
        self.assertEqual(model.clips[0].name, "rest")
        clusters, (triangles, materials) = model.clusters(), model.triangles()
        self.assertEqual(int(clusters["triangle_count"].sum()), len(triangles))
        self.assertEqual((len(materials), int(triangles.max())), (info.triangle_count, info.vertex_count - 1))
        vertices = model.vertices("points", "uvs", "bones", "weights")
        self.assertEqual(vertices["uvs"].shape, (info.vertex_count, 2))
        self.assertTrue((vertices["weights"][:, 0] == 1).all() and (vertices["bones"] == 0).all())
        sizes = [model.mesh(share * info.largest_error).info.triangle_count for share in (0, 0.3, 1)]
        self.assertTrue(sizes[0] == 800 > sizes[1] > sizes[2], sizes)
        path = Path(self.folder.name) / "waves.rcrowd"
        model.write(path)
        self.assertEqual(rl.CrowdModel.read(self.context, path).info, info)
        self.assertEqual(rl.CrowdModel.read_bytes(self.context, model.write_bytes()).info, info)
        started = job.crowd_model(self.context, self.path, cluster_triangles=40)
        started.wait()
        self.assertEqual(started.result().info, info)
        self.assertIsNone(finished(job.write_crowd_model(model, path)))
        self.assertEqual(finished(job.read_crowd_model(self.context, path)).info, info)
        self.assertEqual([entry.name for entry in rl.crowd.params()][0], "pose_distance")
        with self.assertRaisesRegex(rl.Invalid, "cluster_triangles"):
            rl.CrowdModel.build(self.context, self.path, cluster_triangles=1)
        with self.assertRaises(rl.RelievoError):
            rl.CrowdModel.build(self.context, self.path, clips=["walk"])
        with self.assertRaises(rl.Cancelled):
            rl.CrowdModel.build(self.context, self.path, progress=lambda fraction, stage: False)
        with self.assertRaisesRegex(rl.Invalid, "colors"):
            model.vertices("colors")

    def test_a_model_that_was_sculpted_is_refitted(self):
        model = rl.CrowdModel.build(self.context, self.path, cluster_triangles=40)
        same, report = model.refit(self.path)
        self.assertEqual((report.grown_groups, report.growth, report.is_rebuild_due), (0, 1.0, 0))
        self.assertEqual(same.info, model.info)
        self.write(0.5)
        stages = []
        made, report = model.refit(self.path, progress=lambda fraction, stage: stages.append(stage))
        self.assertIn("measure", stages)
        self.assertGreater(report.grown_groups, model.info.group_count // 2)
        self.assertTrue(report.growth >= 1.5 and report.is_rebuild_due == 1)
        self.assertGreater(made.info.largest_error, model.info.largest_error)
        numpy.testing.assert_array_equal(made.triangles()[0], model.triangles()[0])
        started = job.refit_crowd_model(model, self.path)
        started.wait()
        again, told = started.result()
        self.assertEqual((again.info, told), (made.info, report))
        with self.assertRaises(rl.Cancelled):
            model.refit(self.path, progress=lambda fraction, stage: False)
        with self.assertRaisesRegex(rl.Invalid, "pose_rate"):
            model.refit(self.path, pose_rate=-1)

    def test_clusters_are_read_while_a_crowd_is_drawn(self):
        model = rl.CrowdModel.build(self.context, self.path, cluster_triangles=40)
        path = Path(self.folder.name) / "waves.rcrowd"
        model.write(path)
        stream, whole = rl.CrowdStream(self.context, [path], most_read=4), rl.Crowd(self.context, [model])
        transforms = numpy.tile(numpy.eye(4), (2, 1, 1))
        transforms[:, 2, 3] = [0, -8]
        view = (400, 400), (0.5, 0.5, 3), (0.5, 0.5, 0)
        triangles, known = model.triangles()[0], model.clusters()
        mirror = numpy.zeros((stream.info.slot_count, stream.info.slot_triangles, 3), numpy.uint32)
        for crowd in (stream, whole):
            crowd.add(transforms)
        goal, shown, missing = whole.cut(*view), [], None
        copied = stream.read()
        while missing != 0:
            shown.append(stream.cut(*view).triangles)
            copied = numpy.concatenate([copied, stream.read()])
            missing = stream.info.missing
            self.assertLessEqual(stream.info.read, 4)
        for _model, cluster, slot, count in copied:
            mirror[slot, :count] = stream.triangles(slot, count)[0]
            first = known[cluster]["first_triangle"]
            numpy.testing.assert_array_equal(mirror[slot, :count], triangles[first : first + count])
        self.assertTrue(len(shown) > 2 and shown == sorted(shown), shown)
        self.assertEqual((shown[-1], stream.info.wanted_triangles), (goal.triangles, goal.triangles))
        draws, clusters = stream.draws()[:2]
        for draw, (_model, cluster) in zip(draws, clusters):
            first, count = draw["first_index"], draw["index_count"]
            drawn = mirror.reshape(-1)[first : first + count]
            numpy.testing.assert_array_equal(drawn.reshape(-1, 3)[0], triangles[known[cluster]["first_triangle"]])
        points = stream.model(0).vertices("points")["points"]
        numpy.testing.assert_array_equal(points, model.vertices("points")["points"])
        with self.assertRaisesRegex(rl.Unsupported, "read while"):
            stream.model(0).triangles()
        with self.assertRaisesRegex(rl.Invalid, "no stream"):
            rl.CrowdStream.info.fget(whole)
        with self.assertRaises(rl.NotFound):
            rl.CrowdStream(self.context, [path.with_name("none.rcrowd")])

    def test_bones_are_blended_as_dual_quaternions(self):
        model = rl.CrowdModel.build(self.context, self.path, cluster_triangles=40)
        dual = model.with_blend("dual_quaternion")
        self.assertEqual((model.info.blend, dual.info.blend), (rl.abi.RlvCrowdBlend.LINEAR, rl.abi.RlvCrowdBlend.DUAL_QUATERNION))
        # One bone at rest: vertices stay where they are.
        self.assertAlmostEqual(dual.info.largest_error, model.info.largest_error, delta=1e-4 * model.info.largest_error)
        self.assertEqual(finished(job.blend_crowd_model(model, "dual_quaternion")).info, dual.info)
        self.assertEqual(rl.CrowdModel.read_bytes(self.context, dual.write_bytes()).info.blend, 0)
        crowd = rl.Crowd(self.context, [dual])
        crowd.add(numpy.eye(4)[None])
        crowd.cut((400, 400), eye=(0.5, 0.5, 3), target=(0.5, 0.5, 0))
        numpy.testing.assert_array_equal(crowd.dual_rows(), [[*numpy.eye(3, 4), (0, 0, 0, 1), (0, 0, 0, 0)]])
        with self.assertRaisesRegex(rl.Invalid, "linear, dual_quaternion"):
            model.with_blend("cubic")
        with self.assertRaisesRegex(rl.Invalid, "blend 2"):
            model.with_blend(2)

    def test_agents_are_cut_into_draws(self):
        model = rl.CrowdModel.build(self.context, self.path, cluster_triangles=40)
        crowd = rl.Crowd(self.context, [model])
        with self.assertRaisesRegex(rl.Invalid, "rlv_crowd_cut"):
            crowd.draws()
        transforms = numpy.tile(numpy.eye(4), (6, 1, 1))
        transforms[:, 2, 3] = [0, -2, -8, -32, -32, 10]
        self.assertEqual(crowd.add(transforms), 0)
        frame = crowd.cut((400, 400), eye=(0.5, 0.5, 3), target=(0.5, 0.5, 0))
        draws, clusters, instances, matrices = crowd.draws()
        self.assertEqual(frame.agent_count, 5)
        self.assertEqual(sorted(instances["agent"].tolist()), [0, 1, 2, 3, 4])
        numpy.testing.assert_array_equal(matrices, [numpy.eye(4)[:3]])
        culled = crowd.cut((400, 400), eye=(0.5, 0.5, 3), target=(0.5, 0.5, 0), occlusion=True)
        self.assertGreater(culled.occluder_triangles, 0)
        self.assertEqual(culled.agent_count + culled.hidden, 5)
        self.assertEqual(len(crowd.draws()[2]), culled.agent_count)
        # The sun is behind the camera, as an agent is whose shadow falls into view.
        lit = crowd.cut((400, 400), eye=(0.5, 0.5, 3), target=(0.5, 0.5, 0), suns=[(0, 0, 1, 0.01)])
        self.assertEqual(sorted(crowd.draws()[2]["agent"].tolist()), [0, 1, 2, 3, 4, 5])
        self.assertEqual(crowd.cut((400, 400), eye=(0.5, 0.5, 3), target=(0.5, 0.5, 0), around=8.0).agent_count, lit.agent_count)
        for suns in ([(0, 0, 1)], [(0, 0, 0, 0.1)], [(0, 0, 1, -0.1)], 3, "high"):
            with self.assertRaisesRegex(rl.Invalid, "suns"):
                crowd.cut((400, 400), (0.5, 0.5, 3), (0.5, 0.5, 0), suns=suns)
        with self.assertRaisesRegex(rl.Invalid, "around"):
            crowd.cut((400, 400), (0.5, 0.5, 3), (0.5, 0.5, 0), around=-1.0)
        with self.assertRaisesRegex(rl.Invalid, "failed"):
            crowd.draws()
        self.assertEqual(crowd.cut((400, 400), (0.5, 0.5, 3), (0.5, 0.5, 0)).triangles, frame.triangles)
        counts = draws["index_count"].astype(int) // 3 * draws["instance_count"]
        self.assertEqual(int(counts.sum()), frame.triangles)
        known = model.clusters()[clusters[:, 1]]
        numpy.testing.assert_array_equal(draws["first_index"], 3 * known["first_triangle"])
        self.assertTrue((draws["instance_count"] == 2).any())
        self.assertTrue((crowd.blends() == 0).all())
        moving = crowd.cut((400, 400), eye=(0.5, 0.5, 3), target=(0.5, 0.5, 0), tolerance=2, geomorph=True)
        blends, collapses = crowd.blends(), model.collapses()
        self.assertTrue(len(blends) == moving.draw_count and (blends > 0).any() and (blends <= 1).all())
        info = model.info
        removed = collapses["group"] < info.group_count
        self.assertTrue(removed.any() and (collapses["target"] < info.vertex_count).all())
        far = crowd.cut((400, 400), eye=(0.5, 0.5, 400), target=(0.5, 0.5, 0), impostors=True)
        impostors, pictures, texels = crowd.impostors()
        self.assertEqual((far.agent_count, far.impostor_count), (0, 6))
        self.assertEqual(impostors["agent"].tolist(), [0, 1, 2, 3, 4, 5])
        self.assertEqual(texels.shape, (far.picture_count, 32, 32))
        self.assertTrue((impostors["picture"] < len(pictures)).all() and (pictures["radius"] > 0).all())
        self.assertTrue((texels["cluster"] < info.cluster_count).any())
        # Without morph targets there are no weights to set, and none to draw with.
        self.assertEqual(info.morph_count + info.offset_count + len(model.offsets()), 0)
        with self.assertRaisesRegex(rl.Invalid, "1 weights for 0"):
            crowd.set_weights(0, [1.0])
        crowd.set_weights(0, None)
        crowd.cut((400, 400), eye=(0.5, 0.5, 3), target=(0.5, 0.5, 0))
        weights, firsts = crowd.weights()
        self.assertEqual((len(weights), firsts.tolist()), (0, [0] * 5))
        crowd.set(0, transforms[3:4])
        self.assertLess(crowd.cut((400, 400), (0.5, 0.5, 3), (0.5, 0.5, 0)).triangles, frame.triangles)
        with self.assertRaisesRegex(rl.Invalid, "transforms"):
            crowd.add(numpy.eye(4))
        with self.assertRaisesRegex(rl.Invalid, "agent 0"):
            crowd.add(transforms[:1], clips=4)

    def test_the_example_runs(self):
        example = [sys.executable, str(ROOT / "examples" / "python" / "crowd.py"), str(self.path), self.folder.name]
        told = subprocess.run(example, env={**os.environ, "PYTHONPATH": PACKAGE}, capture_output=True, text=True)
        self.assertRegex(told.stdout, r"800 triangles[\s\S]*[1-9]\d* of 1000 agents", told.stderr)
        self.assertTrue((Path(self.folder.name) / "waves_far.ply").exists())


class Devices(unittest.TestCase):
    def test_foam_is_drawn_on_a_device(self):
        adapters = rl.adapters()
        if not adapters:
            self.assertNotEqual(os.environ.get("RELIEVO_GPU_TESTS"), "required")
            self.skipTest("there is no graphics device")

        def draw(context):
            foam = rl.Foam(context, (33, 25), (0, 0, 5), (0, 0, 0), up=(0, 1, 0), fov=0.8, radius=0.3, ao_max_samp=32)
            places = numpy.random.default_rng(5).uniform(-1, 1, (400, 3))
            foam.add(places, lives=numpy.linspace(0, 1, 400))
            memory = context.info.device_memory
            foam.shade()
            return foam.composite(numpy.full((25, 33, 3), 0.25)), memory

        device = rl.Context(threads=1, device="gpu", adapter=adapters[-1].name)
        (ours, memory), (theirs, none) = draw(device), draw(rl.Context(threads=1))
        self.assertGreaterEqual(memory, 48 * 25 * 33)
        self.assertEqual(none, 0)
        self.assertGreater(theirs.max(), 0.6)
        # No pixel of so few may be further away than one in a thousand.
        self.assertLessEqual(numpy.abs(ours - theirs).max(), 1 / 255)
        device.close_device()
        numpy.testing.assert_array_equal(draw(device)[0], theirs)

    def check_lent_device(self, context, buffer):
        """A second context on the device that the first one made, and a semaphore between the two."""
        vulkan = ctypes.CDLL("libvulkan.so.1")
        found = buffer.vulkan()
        lent = {name: getattr(found, name) for name in ("instance", "physical_device", "device", "queue_family", "queue_index")}
        lent["api_version"] = 1 << 22 | 1 << 12
        lent["loader"] = ctypes.cast(vulkan.vkGetInstanceProcAddr, ctypes.c_void_p).value
        second = rl.Context(vulkan=lent, threads=1)
        self.assertEqual((second.info.device, second.info.adapter), (rl.Device.GPU, context.info.adapter))
        tessellation = rl.Tessellation(flat_detail(second, tile_size=16), coarse=4, fine=4)
        theirs = rl.Buffer(tessellation)
        self.assertEqual(theirs.vulkan().device, found.device)
        numpy.testing.assert_array_equal(theirs.points(), numpy.hstack(tessellation.points()))
        taken = {"points": found.points, "point_bytes": 24 * buffer.info.point_count - 1}
        taken |= {"triangles": found.triangles, "triangle_bytes": 12 * buffer.info.triangle_count}
        with self.assertRaisesRegex(rl.MemoryLimit, "point_bytes"):
            rl.Buffer(tessellation, vulkan=taken)
        taken["point_bytes"] += 1
        filled = rl.Buffer(tessellation, vulkan=taken)
        self.assertEqual(filled.vulkan().points, found.points)
        numpy.testing.assert_array_equal(buffer.points(), theirs.points())
        # VK_STRUCTURE_TYPE_SEMAPHORE_CREATE_INFO, no extension, no flags.
        info, semaphore = (ctypes.c_uint64 * 3)(9, 0, 0), ctypes.c_uint64()
        device = ctypes.c_void_p(found.device)
        self.assertEqual(vulkan.vkCreateSemaphore(device, info, None, ctypes.byref(semaphore)), 0)
        context.signal(semaphore.value)
        second.wait(semaphore.value)
        numpy.testing.assert_array_equal(theirs.points(), numpy.hstack(tessellation.points()))
        for used in (filled, theirs, tessellation, second):
            used.release()
        vulkan.vkDestroySemaphore(device, semaphore, None)
        with self.assertRaisesRegex(rl.Invalid, "semaphore"):
            context.wait(0)
        with self.assertRaisesRegex(rl.Unsupported, "1.1"):
            rl.Context(vulkan=lent | {"api_version": 1 << 22})

    def test_what_is_listed_can_be_opened_and_let_go(self):
        adapters = rl.adapters()
        if not adapters:
            self.assertNotEqual(os.environ.get("RELIEVO_GPU_TESTS"), "required")
            self.skipTest("there is no graphics device")
        name = adapters[-1].name
        context = rl.Context(threads=1, device="gpu", adapter=name)
        self.assertEqual((context.info.device, context.info.adapter), (rl.Device.GPU, name))
        detail = flat_detail(context, tile_size=16)
        self.assertIsNone(detail.check_device())
        self.assertGreater(context.info.device_memory, 0)
        tessellation = rl.Tessellation(detail, coarse=4, fine=4)
        buffer = rl.Buffer(tessellation)
        self.assertEqual(buffer.info.point_count, tessellation.info.point_count)
        numpy.testing.assert_array_equal(buffer.points(), numpy.hstack(tessellation.points()))
        self.assertEqual(buffer.update().written_count, 0)
        detail.add_paint(tile_size=16, color=(0.5, 0.25, 0.125, 1.0))
        detail.commit()
        colors = rl.ColorBuffer(detail)
        self.assertEqual((colors.info.tile_count, colors.info.allocated_count), (detail.info.tile_count, 0))
        paint = rl.Brush(context, action="paint", color=(1.0, 0.0, 0.0, 1.0), settings={"radius": 0.3})
        stroke.run(detail, paint, [[0.0, 0.0, 0.0]])
        detail.commit()
        self.assertGreater(colors.update().written_count, 0)
        tile = [tile for tile in range(detail.info.tile_count) if detail.read_block("color", tile)][0]
        self.assertEqual(colors.block(tile), detail.read_block("color", tile))
        self.assertEqual(len(colors.block(tile, 1)), 4 * 10 * 10)
        if "vulkan" in adapters[-1].backend:
            self.assertTrue(buffer.vulkan().device)
            self.assertTrue(colors.vulkan().mips)
            self.check_lent_device(context, buffer)
        points, corners = shapes.ball(1.0)
        ball = rl.Mesh(context, points, corners, 3)
        ball.add_attribute("height", points[:, 2:], "point")
        whole = rl.Progressive(ball, base_triangles=20, weights={"height": 0.1})
        there, level = rl.DeviceLevel(whole), rl.Level(whole)
        pull = rl.Grip(rl.Region((0, 0, 1), 0.8), (0, 0, 0.5))
        for one in (there, level):
            one.set_view(eye=(0, 0, 1.5), pixels=100.0, planes=[[0, 0, 1, 0]])
            one.set_error(0.01)
            one.set_triangles(300)
            self.assertGreater(one.edit([pull], [rl.Region((1, 0, 0), 0.2, "constant")]), 10)
            one.undo()
            one.redo()
            one.set_triangles()
        for one in (there, level):
            one.add_motion([rl.GripTrack(rl.Region((0, 0, 0), 9, "constant"), [rl.GripKey(0.0), rl.GripKey(2.0, (0, 0, 1))])])
            self.assertGreater(one.set_time(1.0), 100)
        level.update()
        self.assertEqual(there.read().triangle_count, whole.info.triangle_count)
        places = [numpy.sort(one.points, axis=0) for one in (there, level)]
        numpy.testing.assert_allclose(*places, atol=1e-4)
        at_corners = there.wedge_values[there.wedges.reshape(-1), 0]
        expected = points[corners.reshape(-1), 2]
        numpy.testing.assert_array_equal(numpy.sort(at_corners), numpy.sort(expected))
        self.assertEqual((there.info.undo_count, there.info.redo_count), (1, 0))
        there.clear_motions()
        there.read()
        self.assertLess(there.points[:, 2].min(), -0.99)
        if "vulkan" in adapters[-1].backend:
            self.assertTrue(there.vulkan().wedges)
        with tempfile.TemporaryDirectory() as folder:
            ball.write(Path(folder) / "ball.obj")
            crowd = rl.Crowd(context, [rl.CrowdModel.build(context, Path(folder) / "ball.obj")])
        transforms = numpy.tile(numpy.eye(4), (3, 1, 1))
        transforms[:, 2, 3] = [0, -20, -20]
        crowd.add(transforms)
        on_device, place = rl.DeviceCrowd(crowd), {"eye": (0, 0, 4), "target": (0, 0, 0)}
        self.assertEqual(on_device.cut((200, 200), **place).draw_count, crowd.cut((200, 200), **place).draw_count)
        for one, other in zip(on_device.draws(), crowd.draws(), strict=True):
            numpy.testing.assert_array_equal(one, other)
        numpy.testing.assert_array_equal(on_device.dual_rows(), crowd.dual_rows())
        far = {"eye": (0, 0, 3000), "target": (0, 0, 0), "impostors": True}
        self.assertEqual(on_device.cut((200, 200), **far).impostor_count, crowd.cut((200, 200), **far).impostor_count)
        for one, other in zip(on_device.impostors(), crowd.impostors(), strict=True):
            self.assertEqual(one.tobytes(), other.tobytes())
            self.assertGreater(len(one), 0)
        if "vulkan" in adapters[-1].backend:
            self.assertTrue(on_device.vulkan().draws)
        context.close_device()
        with self.assertRaises(rl.DeviceFailure):
            on_device.cut((200, 200), **place)
        with self.assertRaises(rl.DeviceFailure):
            there.set_error(0.1)
        with self.assertRaises(rl.DeviceFailure):
            buffer.update()
        brush = rl.Brush(context, action="sculpt", height=0.1, settings={"radius": 0.3})
        self.assertGreater(stroke.run(detail, brush, [[0.0, 0.0, 0.0]]).changed_tiles, 0)
        with self.assertRaisesRegex(rl.DeviceFailure, "lost"):
            detail.check_device()
        self.assertIn("lost", context.info.fallback)

    def test_one_that_is_not_there_is_an_error_or_the_processor(self):
        with self.assertRaises(rl.NotFound):
            rl.Context(device="gpu", adapter="nobody's")
        info = rl.Context(threads=1, device="auto", adapter="nobody's").info
        self.assertEqual((info.device, info.adapter), (rl.Device.CPU, ""))
        self.assertTrue(info.fallback)


class Jobs(unittest.TestCase):
    def setUp(self):
        self.context = rl.Context(threads=2)
        points, corners = shapes.ball(0.3)
        self.ball = rl.Collider(self.context, rl.Mesh(self.context, points, corners, 3))
        self.before, self.after = numpy.eye(4), numpy.eye(4)
        self.before[:3, 3], self.after[:3, 3] = (-0.6, 0.25, 0.2), (0.6, 0.25, 0.2)

    def test_a_sweep_in_the_background_is_the_sweep(self):
        here, there = (flat_detail(self.context, tile_size=32) for _ in range(2))
        expected = imprint.sweep(here, self.ball, self.before, self.after, {"voxels": 2**18})
        started = job.sweep(there, self.ball, self.before, self.after, {"voxels": 2**18})
        self.assertEqual(started.wait().state, rl.JobState.DONE)
        self.assertEqual(started.result(), expected)
        here.commit(), there.commit()
        numpy.testing.assert_array_equal(heights(here), heights(there))
        triangles = job.tessellate(there)
        triangles.wait(60.0)
        self.assertEqual(triangles.result().info.triangle_count, there.tessellate().info.triangle_count)

    def test_jobs_are_cancelled_and_fail(self):
        detail = flat_detail(self.context, tile_size=32)
        self.after[0, 3] = 400.0
        started = job.sweep(detail, self.ball, self.before, self.after, {"voxels": 2**18, "sub_steps": 4096})
        with self.assertRaises(rl.Busy):
            started.result()
        started.cancel()
        self.assertEqual(started.wait().state, rl.JobState.CANCELLED)
        with self.assertRaises(rl.Cancelled):
            started.result()
        self.assertEqual(started.poll().result, rl.abi.RLV_ERROR_CANCELLED)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "heights.exr")
            written = job.write(detail, path, width=64, height=64)
            self.assertEqual(written.wait().state, rl.JobState.DONE)
            self.assertEqual(written.result().picture_count, 1)
            self.assertTrue(path.exists())
            kept, other = Path(folder, "kept.ptx"), flat_detail(self.context, tile_size=32)
            self.assertEqual(job.write_ptex(detail, "displacement", kept).wait().state, rl.JobState.DONE)
            read = job.read_ptex(other, kept)
            read.wait()
            self.assertEqual(read.result().face_count, 16)
            document_path, to = Path(folder, "kept.relievo"), Path(folder, "moved.relievo")
            rl.Document(detail, document_path).release()
            points, corners, _ = shapes.grid(6)
            moved = job.transfer(self.context, document_path, rl.Mesh(self.context, points, corners, 4), to)
            moved.wait()
            self.assertAlmostEqual(moved.result().area, 4.0, delta=0.01)
            self.assertTrue(to.exists())
        with self.assertRaisesRegex(rl.Invalid, "seconds"):
            written.wait(-3.0)

    def test_jobs_make_what_calls_make(self):
        detail = flat_detail(self.context, tile_size=32)
        points, corners, _ = shapes.grid(3)
        mesh = rl.Mesh(self.context, points, corners, 4)
        kinds = rl.abi.RlvJobKind

        def taken(started, kind):
            self.assertEqual(started.wait().state, rl.JobState.DONE)
            self.assertEqual(started.poll().kind, kind)
            return started.result()

        surface = taken(job.create_surface(self.context, mesh, kind="triangles"), kinds.SURFACE)
        self.assertEqual(surface.info, rl.Surface(self.context, mesh, kind="triangles").info)
        for started in (
            job.caster_of_mesh(self.context, mesh),
            job.caster_of_detail(detail),
            job.caster_of_tessellation(rl.Tessellation(detail)),
        ):
            hits = taken(started, kinds.CASTER).cast([[0.1, 0.2, 1.0]], [[0.0, 0.0, -1.0]])
            self.assertAlmostEqual(float(hits["distance"][0]), 1.0, places=5)
        for started in (
            job.collider_of_mesh(self.context, mesh),
            job.collider_of_surface(surface, coarse=1),
            job.collider_of_detail(detail),
        ):
            self.assertGreater(taken(started, kinds.COLLIDER).info.triangle_count, 17)
        still = taken(job.create_procedural(detail, coarse=4), kinds.PROCEDURAL)
        moving = taken(job.create_moving_procedural(still, detail), kinds.PROCEDURAL)
        self.assertEqual(moving.info.time_step_count, 2)
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "grid.obj")
            self.assertIsNone(taken(job.write_mesh(mesh, path), kinds.NONE))
            self.assertEqual(taken(job.read_mesh(self.context, path), kinds.MESH).info, mesh.info)
            path = Path(folder, "drops.bgeo")
            drops = rl.Particles(self.context, points)
            self.assertIsNone(taken(job.write_particles(drops, path), kinds.NONE))
            self.assertEqual(taken(job.read_particles(self.context, path), kinds.PARTICLES).info.count, len(points))
            path = Path(folder, "kept.relievo")
            taken(job.create_document(detail, path), kinds.DOCUMENT).release()
            self.assertIsNone(taken(job.compact_document(self.context, path), kinds.NONE))
            self.assertEqual(taken(job.open_picture(self.context, path), kinds.PICTURE).info.face_count, 16)
            document = taken(job.open_document(detail, path), kinds.DOCUMENT)
            self.assertIsNone(taken(job.save_document(document, Path(folder, "again.relievo")), kinds.NONE))
            data = taken(job.save_document_bytes(document), kinds.BYTES)
            self.assertEqual(data, document.save_bytes())
            document.release()
            taken(job.open_document_bytes(detail, data), kinds.DOCUMENT).release()
            with self.assertRaisesRegex(rl.Invalid, "data: bytes are needed"):
                job.open_document_bytes(detail, 7)
        missing = job.read_mesh(self.context, "nowhere.obj")
        self.assertEqual(missing.wait().state, rl.JobState.FAILED)
        with self.assertRaisesRegex(rl.NotFound, "nowhere.obj"):
            missing.result()

    def test_a_collider_that_deforms_is_swept_in_the_background(self):
        here, there = (flat_detail(self.context, tile_size=32) for _ in range(2))
        points, _ = shapes.ball(0.3)
        places = (self.before, points), (self.after, [1.5 * numpy.asarray(point) for point in points])
        expected = imprint.sweep_points(here, self.ball, *places, {"voxels": 2**18})
        started = job.sweep_points(there, self.ball, *places, {"voxels": 2**18})
        started.wait()
        self.assertEqual(started.result(), expected)


class Details(unittest.TestCase):
    def setUp(self):
        self.context = rl.Context(threads=2)

    def test_a_ball_dents_as_deep_as_it_reaches_and_leaves_traces(self):
        detail = flat_detail(self.context, tile_size=64)
        detail.add_traces()
        points, corners = shapes.ball(0.5, rings=48)
        ball = rl.Collider(self.context, rl.Mesh(self.context, points, corners, 3))
        self.assertTrue(ball.info.is_closed)
        place = numpy.eye(4)
        place[2, 3] = 0.4
        ball.set_transform(place)
        self.assertEqual(ball.info.matrix[9:], (0, 0, 0.4))
        report = imprint.run(detail, ball, {"voxels": 2**20}, {"frame": 3})
        self.assertGreater(report.changed_tiles, 0)
        changes = detail.commit()
        self.assertEqual(changes.tile_count, len(detail.changed_tiles()))
        # Nothing folds a plane.
        folds = detail.folds()
        self.assertGreater(folds.triangle_count, 0)
        self.assertEqual((folds.folded_count, folds.tile), (0, 2**32 - 1))
        tile = 5
        middle = detail.evaluate([tile], [[1.0, 1.0]], ["displacements", "traces", "positions"])
        self.assertAlmostEqual(float(middle["displacements"][0]), -0.1, delta=0.01)
        self.assertGreater(middle["traces"][0, 0], 0.9)
        self.assertLess(abs(middle["positions"][0, 2] + 0.1), 0.01)
        block = detail.read_block("displacement", tile)
        self.assertEqual(len(block), 66 * 66 * 2)
        self.assertTrue(detail.tile_info("displacement", tile).is_allocated)
        dent = detail.evaluate([tile], [[0.6, 0.6]], ["displacements"])["displacements"]
        detail.write_block("displacement", tile, b"")
        detail.commit()
        self.assertFalse(detail.tile_info("displacement", tile).is_allocated)
        detail.write_block("displacement", tile, block)
        detail.commit()
        again = detail.evaluate([tile], [[0.6, 0.6]], ["displacements"])["displacements"]
        numpy.testing.assert_array_equal(again, dent)

    def test_a_sweep_can_be_watched_cancelled_and_fail(self):
        points, corners = shapes.ball(0.3)
        ball = rl.Collider(self.context, rl.Mesh(self.context, points, corners, 3))
        before, after = numpy.eye(4), numpy.eye(4)
        before[:3, 3], after[:3, 3] = (-0.6, 0.25, 0.2), (0.6, 0.25, 0.2)

        def swept(progress):
            detail = flat_detail(self.context, tile_size=32)
            outcome = imprint.sweep(detail, ball, before, after, {"voxels": 2**18}, progress=progress)
            detail.commit()
            return detail, outcome

        seen = []
        detail, report = swept(lambda fraction, stage: seen.append((fraction, stage)))
        self.assertGreater(report.steps, 3)
        self.assertGreaterEqual(len(seen), report.steps)
        self.assertTrue(all(0 <= fraction <= 1 and stage for fraction, stage in seen))
        self.assertLess(heights(detail).min(), -0.05)
        with self.assertRaises(rl.Cancelled):
            swept(lambda fraction, stage: False)
        with self.assertRaisesRegex(KeyError, "from the callback"):
            swept(lambda fraction, stage: {}["from the callback"])

    def test_a_sweep_of_points_leaves_the_track_of_a_move(self):
        points, corners = shapes.ball(0.3)
        before, after = numpy.eye(4), numpy.eye(4)
        before[:3, 3], after[:3, 3] = (-0.55, 0.25, 0.2), (0.55, 0.25, 0.2)
        tracks = []
        for deforms in (False, True):
            ball = rl.Collider(self.context, rl.Mesh(self.context, points, corners, 3))
            detail = flat_detail(self.context, tile_size=32)
            settings = {"voxels": 2**18, "jitter": 0.0}
            if deforms:
                moved = points + numpy.array([1.1, 0, 0])
                report = imprint.sweep_points(detail, ball, (before, points), (before, moved), settings)
                with self.assertRaisesRegex(rl.Invalid, "before and"):
                    imprint.sweep_points(detail, ball, (before, points), (before, moved[1:]), settings)
            else:
                report = imprint.sweep(detail, ball, before, after, settings)
            detail.commit()
            tracks.append((report.steps, heights(detail)))
        self.assertEqual(tracks[0][0], tracks[1][0])
        self.assertLess(tracks[0][1].min(), -0.05)
        numpy.testing.assert_allclose(tracks[0][1], tracks[1][1], atol=2e-3)

    def test_strokes_layers_and_tessellation_follow(self):
        detail = flat_detail(self.context, tile_size=32)
        detail.add_paint(tile_size=32, color=(0, 0, 0, 1))
        detail.add_vectors()
        follow = rl.Tessellation(detail, coarse=32, fine=32)
        start = follow.positions()
        sculpt = rl.Brush(self.context, {"radius": 0.3}, action="sculpt", mode="draw", falloff="constant", height=0.2)
        relief = detail.layers.add("relief", kind="displacement")
        line = [(-0.5, 0.25, 0.0, 1.0), (0.5, 0.25, 0.0, 1.0)]
        report = stroke.run(detail, sculpt, line)
        self.assertGreater(report.dabs, 5)
        paint = rl.Brush(self.context, {"radius": 0.3}, color=(1, 0, 0, 1), falloff="constant")
        with rl.Stroke(detail, paint) as drawn:
            for point in line:
                drawn.extend(point)
            drawn.end()
        detail.commit()
        changes = follow.update()
        self.assertFalse(changes.rebuilt)
        ranges = follow.changed_ranges()
        self.assertEqual(ranges[:, 1].sum(), changes.point_count)
        first, count = ranges[0]
        now = follow.positions()
        numpy.testing.assert_array_equal(follow.points(first, count)[0], now[first : first + count])
        self.assertGreater((now - start)[:, 2].max(), 0.15)
        numpy.testing.assert_array_equal(now, detail.tessellate(coarse=32, fine=32).points())
        numpy.testing.assert_allclose(follow.colors().max(0), [1, 0, 0], atol=1e-6)
        layers = detail.layers
        self.assertEqual([layer.name for layer in layers][1], "relief")
        layers.set(relief, opacity=0.5)
        detail.commit()
        follow.update()
        numpy.testing.assert_allclose(follow.positions()[:, 2], now[:, 2] / 2, atol=1e-3)
        layers.remove(relief)
        detail.commit()
        follow.update()
        numpy.testing.assert_allclose(follow.positions(), start, atol=1e-6)
        follow.update()
        self.assertEqual(follow.changed_ranges().shape, (0, 2))

    def test_documents_undo_to_the_bit_and_open_again(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "detail.relievo")
            detail = flat_detail(self.context, tile_size=32)
            kept = rl.Document(detail, path)
            brush = rl.Brush(self.context, {"radius": 0.4}, action="sculpt", height=0.1)
            states = [heights(detail).tobytes()]
            for y in (-0.5, 0.0, 0.5):
                with kept.edit("a line"):
                    stroke.run(detail, brush, [(-0.7, y, 0), (0.7, y, 0)])
                detail.commit()
                states.append(heights(detail).tobytes())
            self.assertEqual(len(set(states)), 4)
            for state in states[2::-1]:
                self.assertTrue(kept.undo().is_done)
                detail.commit()
                self.assertEqual(heights(detail).tobytes(), state)
            kept.redo()
            with self.assertRaises(ZeroDivisionError), kept.edit("a fault"):
                stroke.run(detail, brush, [(0, 0, 0), (0.1, 0, 0)])
                1 / 0
            detail.commit()
            self.assertEqual(heights(detail).tobytes(), states[1])
            self.assertEqual(kept.info.undo_count, 1)
            kept.sync()
            kept.release()
            other = flat_detail(self.context, tile_size=32)
            again = rl.Document.open(other, path)
            other.commit()
            self.assertEqual(heights(other).tobytes(), states[1])
            again.release()
            document.compact(self.context, path)
            self.assertEqual(document.mesh(self.context, path).info.face_count, 16)
            points, corners, _ = shapes.grid(6)
            report = document.transfer(
                self.context, path, rl.Mesh(self.context, points, corners, 4), Path(folder, "other.relievo")
            )
            self.assertAlmostEqual(report.area, 4.0, delta=0.01)

    def test_documents_live_in_bytes_and_in_files_of_python(self):
        detail = flat_detail(self.context, tile_size=32)
        file = io.BytesIO()
        kept = rl.Document(detail, file=file)
        brush = rl.Brush(self.context, {"radius": 0.4}, action="sculpt", height=0.1)
        for y in (-0.5, 0.5):
            with kept.edit("a line"):
                stroke.run(detail, brush, [(-0.7, y, 0), (0.7, y, 0)])
        detail.commit()
        kept.undo()
        kept.redo()
        data = file.getvalue()
        self.assertGreater(len(kept.save_bytes()), 100)
        second = io.BytesIO(b"what was here before")
        kept.save_file(second)
        self.assertEqual(kept.save_bytes(), second.getvalue())
        kept.sync()
        kept.release()
        for opened in (rl.Document.open_bytes, lambda *args: rl.Document.open_file(args[0], io.BytesIO(args[1]))):
            other = flat_detail(self.context, tile_size=32)
            with opened(other, data) as again:
                other.commit()
                self.assertEqual(heights(other).tobytes(), heights(detail).tobytes())
                self.assertEqual(again.info.undo_count, 2)
        self.assertEqual(document.mesh_of_bytes(self.context, data).info.face_count, 16)
        with self.assertRaisesRegex(rl.Invalid, "bytes"):
            rl.Document.open_bytes(flat_detail(self.context, tile_size=32), data[:40])

        class Full(io.BytesIO):
            def write(self, data):
                raise OSError("no room")

        with self.assertRaises(rl.FileFailure) as caught:
            rl.Document(detail, file=Full())
        self.assertEqual(str(caught.exception.__cause__), "no room")

    def test_meshes_go_to_bytes_and_back(self):
        points, corners, _ = shapes.grid(6)
        mesh = rl.Mesh(self.context, points, corners, 4)
        for name in ("obj", "ply", "glb"):
            with rl.Mesh.read_bytes(self.context, mesh.write_bytes(name), name) as again:
                self.assertEqual(again.info.face_count, 72 if name == "glb" else 36)
        with rl.Progressive(mesh) as whole, rl.Progressive.read_bytes(self.context, whole.write_bytes()) as again:
            self.assertEqual(again.info, whole.info)

    def test_bakes_and_ptex(self):
        detail = flat_detail(self.context, tile_size=32)
        brush = rl.Brush(self.context, {"radius": 0.5, "reach": 4}, action="sculpt", falloff="constant", height=0.25)
        stroke.run(detail, brush, [(0, 0, 0), (0.01, 0, 0)])
        detail.commit()
        with tempfile.TemporaryDirectory() as folder:
            pictures, report = bake.run(detail, quantity="displacement", width=64, height=32, gutter=0)
            self.assertEqual((len(pictures), pictures[0].pixels.shape, pictures[0].udim), (1, (32, 64, 1), 1001))
            self.assertEqual(report.covered_pixels, 64 * 32)
            self.assertTrue(pictures[0].covered.all())
            middle = detail.evaluate([5], [[1.0, 1.0]], ["displacements"])["displacements"][0]
            self.assertAlmostEqual(float(pictures[0].pixels[16, 32, 0]), float(middle), delta=0.02)
            bake.write(detail, Path(folder, "height.exr"), quantity="displacement", width=64, height=64)
            self.assertTrue(Path(folder, "height.exr").exists())
            with self.assertRaises(rl.Cancelled):
                bake.run(detail, progress=lambda *_: False, width=64, height=64)
            path = Path(folder, "height.ptx")
            ptex.write(detail, "displacement", path)
            other = flat_detail(self.context, tile_size=32)
            self.assertEqual(ptex.read(other, path).face_count, 16)
            other.commit()
            numpy.testing.assert_allclose(heights(other), heights(detail), atol=2e-3)
            faces = rl.Picture(self.context, path)
            self.assertEqual((faces.info.image_count, faces.meta()["ptex:meshType"]), (16, "quad"))
            self.assertEqual(faces.read(5, level=1).shape, (16, 16, 1))
            kept = Path(folder, "height.relievo")
            rl.Document(detail, kept).release()
            shown = rl.Picture(self.context, kept)
            image = shown.image(0)
            self.assertEqual((image.side, image.columns, int(shown.meta()["faces"][0])), (32, 4, 16))
            at = [5 // 4 * image.cell + image.gutter + 20, 5 % 4 * image.cell + image.gutter + 20]
            centre = detail.evaluate([5], [[20.5 / 32, 20.5 / 32]], ["displacements"])["displacements"][0]
            self.assertAlmostEqual(float(shown.read(0)[at[0], at[1], 0]), float(centre), places=4)
            self.assertEqual(shown.read(0, 1, 3, 4, 2, 5).shape, (5, 2, 1))

    def test_rays_meet_the_dented_surface(self):
        detail = flat_detail(self.context)
        hits = rl.Caster.of_detail(detail).cast([[0.1, 0.2, 2], [5, 5, 5]], [[0, 0, -1]] * 2)
        self.assertAlmostEqual(float(hits["distance"][0]), 2.0, places=5)
        numpy.testing.assert_allclose(hits["position"][0], [0.1, 0.2, 0], atol=1e-5)
        self.assertTrue(numpy.isinf(hits["distance"][1]))
        followed = rl.Tessellation(detail, coarse=32, fine=32)
        caster = rl.Caster.of_tessellation(followed)
        rays = [[0.1, 0.2, 2], [0.1, 0.2, 2], [5, 5, 5]], [[0, 0, -1]] * 3
        self.assertEqual(caster.occluded(*rays, max_distance=[1.9, 2.1, 9]).tolist(), [False, True, False])
        brush = rl.Brush(self.context, {"radius": 0.5, "reach": 4}, action="sculpt", falloff="constant", height=0.25)
        stroke.run(detail, brush, [(0.1, 0.2, 0), (0.11, 0.2, 0)])
        detail.commit()
        followed.update()
        caster.update()
        self.assertAlmostEqual(float(caster.cast(*rays)["distance"][0]), 1.75, places=2)
        with self.assertRaisesRegex(rl.Invalid, "max_distances"):
            caster.occluded(*rays, max_distance=[1, 2])
        caster.set_mask(6)
        self.assertEqual(caster.occluded(*rays, masks=[1, 4, 4]).tolist(), [False, True, False])
        self.assertEqual(numpy.isinf(caster.cast(*rays, masks=2)["distance"]).tolist(), [False, False, True])
        self.assertTrue(numpy.isinf(caster.cast(*rays, masks=0xFFFFFFF9)["distance"]).all())
        for wrong in (-1, 1 << 32, 1.5, [1, 2], [1, -2, 3]):
            with self.assertRaisesRegex(rl.Invalid, "masks"):
                caster.cast(*rays, masks=wrong)
        with self.assertRaisesRegex(rl.Invalid, "mask"):
            caster.set_mask(-1)

    def test_a_procedural_has_primitives_and_says_what_is_at_hits(self):
        detail = flat_detail(self.context)
        made = rl.Procedural(detail, coarse=16)
        self.assertEqual((made.info.primitive_count, made.info.cell_count), (16, 16 * 256))
        table = made.table
        self.assertEqual((table.primitive_count, table.time_step_count), (16, 1))
        self.assertTrue(table.data and table.intersect)
        found = made.evaluate([5, 6], [[0.5, 0.5], [0.0, 0.25]])
        self.assertEqual(found["tiles"].tolist(), [5, 6])
        expected = detail.evaluate([5, 6], [[0.5, 0.5], [0.0, 0.25]], ["positions", "normals"])
        numpy.testing.assert_array_equal(found["positions"], expected["positions"])
        numpy.testing.assert_array_equal(found["normals"], expected["normals"])
        moving = made.moving(detail)
        self.assertEqual(moving.info.time_step_count, 2)
        with self.assertRaises(rl.Invalid):
            made.evaluate([16], [[0.5, 0.5]])

    def test_an_object_that_is_at_work_is_busy_and_two_threads_draw_on_two_details(self):
        details = [flat_detail(self.context, tile_size=32) for _ in range(2)]
        brush = rl.Brush(self.context, {"radius": 0.3}, action="sculpt")
        failures = []

        def work(detail):
            try:
                for _ in range(5):
                    stroke.run(detail, brush, [(-0.5, 0, 0), (0.5, 0, 0)])
                    detail.commit()
            except Exception as failure:
                failures.append(failure)

        threads = [threading.Thread(target=work, args=(detail,)) for detail in details]
        [thread.start() for thread in threads]
        [thread.join() for thread in threads]
        self.assertEqual(failures, [])
        numpy.testing.assert_array_equal(*[heights(detail) for detail in details])


class Failures(unittest.TestCase):
    def test_a_released_object_and_bad_settings_are_told_apart(self):
        context = rl.Context(threads=1)
        brush = rl.Brush(context)
        brush.release()
        brush.release()
        with self.assertRaises(rl.Invalid):
            brush.set()
        with self.assertRaises(rl.Invalid) as caught:
            rl.Brush(context, {"radius": -1.0})
        self.assertIn("radius", str(caught.exception))
        with self.assertRaisesRegex(rl.Invalid, "`scrub` is unknown; there are draw"):
            rl.Brush(context, action="sculpt", mode="scrub")

    def test_a_forked_process_refuses_objects_of_its_parent(self):
        context = rl.Context(threads=2)
        detail = flat_detail(context, 12)
        detail.tessellate()
        processes = multiprocessing.get_context("fork")
        answers = processes.Queue()

        def work():
            try:
                detail.tessellate()
                answers.put("not refused")
            except rl.Unsupported as error:
                answers.put(str(error))
            answers.put(len(flat_detail(rl.Context(threads=2), 12).tessellate().points()))

        process = processes.Process(target=work)
        process.start()
        try:
            self.assertIn("forked", answers.get(timeout=60))
            self.assertEqual(answers.get(timeout=60), len(detail.tessellate().points()))
            process.join(60)
            self.assertEqual(process.exitcode, 0)
        finally:
            process.kill()

    def test_parameters_describe_the_settings(self):
        for table, struct in (
            (rl.brush.params(), rl.abi.RlvBrushSettings),
            (rl.brush.stamp_params(), rl.abi.RlvStampSettings),
            (imprint.params(), rl.abi.RlvImprintSettings),
            (rl.collider.press_params(), rl.abi.RlvToolSettings),
        ):
            fields = [name for name, _ in struct._fields_ if name != "struct_size"]
            self.assertEqual([entry.name for entry in table], fields)
            self.assertTrue(all(entry.help and entry.min <= entry.value <= entry.max for entry in table))

    def test_the_log_and_statistics(self):
        context = rl.Context(threads=1)
        lines = []
        context.set_log(lambda level, line: lines.append((level, line)))
        points = numpy.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [1, 0, 1], [0, 0, 1], [1, 0, -1], [0, 0, -1]])
        corners = [0, 1, 2, 3, 1, 0, 5, 4, 0, 1, 6, 7]
        rl.Surface(context, rl.Mesh(context, points, corners, 4))
        self.assertTrue(lines and "manifold" in lines[0][1], lines)
        self.assertTrue(all(row.samples for row in context.stats()))
        context.reset_stats()
        self.assertEqual(context.stats(), [])

    def load(self, library):
        """What a new interpreter says when it loads the library."""
        code = "import librelievo\ntry: librelievo.load()\nexcept librelievo.LibraryMissing as e: print(e.what, '|', e.remedy)"
        environment = {**os.environ, "RELIEVO_LIBRARY": str(library), "PYTHONPATH": PACKAGE}
        outcome = subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True)
        self.assertEqual(outcome.stderr, "")
        return outcome.stdout

    def test_a_missing_or_foreign_library_is_told_plainly(self):
        with tempfile.TemporaryDirectory() as folder:
            self.assertIn("is not there | install the wheel", self.load(Path(folder, "librelievo.so.0.1")))
            text = Path(folder, "text.so")
            text.write_text("no library" * 100)
            self.assertIn("no library for this machine", self.load(text))
            self.assertIn("not the Relievo library", self.load("libm.so.6"))

    def test_what_the_linker_says_is_explained(self):
        explain = rl.library.explain
        lines = {
            "/lib/libc.so.6: version `GLIBC_2.36' not found (required by x)": "needs GLIBC 2.36",
            "/lib/libstdc++.so.6: version `GLIBCXX_3.4.30' not found": "needs GLIBCXX 3.4.30",
            "libstdc++.so.6: cannot open shared object file: No such file": "the C++ library",
            "libtbb.so.12: cannot open shared object file: No such file": "oneTBB",
        }
        for problem, wanted in lines.items():
            what, remedy = explain("librelievo.so.0.1", OSError(problem))
            self.assertIn(wanted, what)
            self.assertTrue(remedy)


if __name__ == "__main__":
    unittest.main()
