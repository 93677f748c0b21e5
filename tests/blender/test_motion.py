"""Imprints that follow armatures, rigid bodies and moving surfaces; the live preview; playback by the add-on."""

import os
import sys
import threading
import types
import unittest
from pathlib import Path
from unittest import mock

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host


class Case(unittest.TestCase):
    def setUp(self):
        self.relievo = host.empty()
        bpy.context.scene.relievo.imprint.voxels = 2**18

    def frames(self, first, last):
        bpy.context.scene.frame_start, bpy.context.scene.frame_end = first, last

    def imprint(self, field, *pressers, **options):
        host.select(field, *pressers)
        self.assertEqual(bpy.ops.relievo.imprint(**options), {"FINISHED"})
        return host.positions(field.relievo.result)

    def track(self, points, y=0.25):
        """Heights along the row of points at a y, by x."""
        row = points[numpy.abs(points[:, 1] - y) < 1e-3]
        return row[numpy.argsort(row[:, 0])][:, [0, 2]]


def skinned_ball(at, swing):
    """A ball that hangs on the tip of a bone, which turns about y by an angle from frame 1 to 3."""
    ball = host.ball(0.3)
    ball.location = at
    armature = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    bpy.context.scene.collection.objects.link(armature)
    host.select(armature)
    bpy.ops.object.mode_set(mode="EDIT")
    bone = armature.data.edit_bones.new("bone")
    bone.head, bone.tail = (0, at[1], 2.0), (0, at[1], 1.0)
    bpy.ops.object.mode_set(mode="OBJECT")
    group = ball.vertex_groups.new(name="bone")
    group.add(range(len(ball.data.vertices)), 1.0, "REPLACE")
    ball.modifiers.new("rig", "ARMATURE").object = armature
    pose = armature.pose.bones["bone"]
    pose.rotation_mode = "XYZ"
    for frame, angle in ((1, swing[0]), (3, swing[1])):
        pose.rotation_euler = (0, 0, 0)
        # The bone points down; its x axis is along the world's or against it, and z is along y.
        pose.rotation_euler[0 if abs(bone_axis(armature, 0)[1]) > 0.5 else 2] = angle
        pose.keyframe_insert("rotation_euler", frame=frame)
    bpy.context.view_layer.update()
    return ball


def bone_axis(armature, axis):
    return armature.data.bones["bone"].matrix_local.col[axis].xyz


class Following(Case):
    def test_a_skinned_collider_leaves_the_track_of_its_bone(self):
        """The ball swings on a bone, two long steps: between frames it presses at sub-steps, as far as lines between its
        points go."""
        field = host.field()
        field.relievo.cells = "32"
        self.frames(1, 3)
        ball = skinned_ball((0, 0.25, 0.25), (-0.35, 0.35))
        self.assertTrue((self.relievo.ops.imprint.Presser(ball, bpy.context.evaluated_depsgraph_get()).now == numpy.array(ball.matrix_world)).all())
        track = self.track(self.imprint(field, ball))
        inside = track[numpy.abs(track[:, 0]) < 0.4]
        # The tip is 1.75 + 0.3 below the pivot: at its lowest -0.05, elsewhere on the chords between the frames.
        self.assertLess(inside[:, 1].min(), -0.03)
        low = track[track[:, 1] < -0.01]
        # Without sub-steps it would be as wide as the ball is deep in: 0.27.
        self.assertGreater(low[:, 0].max() - low[:, 0].min(), 0.33)
        self.assertEqual(float(numpy.abs(track[numpy.abs(track[:, 0]) > 0.9][:, 1]).max()), 0.0)

    def test_sub_steps_of_a_deforming_collider_leave_no_gaps(self):
        """The same way as a transform, and as points that deform (a shape key): the tracks are the same."""
        tracks = {}
        for way in ("transform", "points"):
            self.setUp()
            field, ball = host.field(), host.ball(0.3)
            field.relievo.cells = "32"
            ball.location = (-0.6, 0.25, 0.2)
            self.frames(1, 2)
            if way == "transform":
                ball.keyframe_insert("location", frame=1)
                ball.location.x = 0.6
                ball.keyframe_insert("location", frame=2)
            else:
                ball.shape_key_add(name="rest")
                away = ball.shape_key_add(name="away")
                for point in away.data:
                    point.co.x += 1.2
                for frame in (1, 2):
                    away.value = frame - 1.0
                    away.keyframe_insert("value", frame=frame)
            tracks[way] = self.track(self.imprint(field, ball))
        inside = numpy.abs(tracks["points"][:, 0]) < 0.5
        numpy.testing.assert_allclose(tracks["points"][inside][:, 1], -0.1, atol=0.015)
        numpy.testing.assert_allclose(tracks["points"][:, 1], tracks["transform"][:, 1], atol=0.02)

    def test_a_rigid_body_falls_and_dents_where_it_lands(self):
        field = host.field()
        field.relievo.cells = "32"
        ball = host.ball(0.3)
        ball.location = (0.3, 0.25, 1.0)
        floor = host.field(1, "floor")
        floor.location.z = -0.1
        host.select(ball)
        bpy.ops.rigidbody.world_add()
        bpy.ops.rigidbody.object_add(type="ACTIVE")
        ball.rigid_body.collision_shape, ball.rigid_body.use_margin = "SPHERE", False
        host.select(floor)
        bpy.ops.rigidbody.object_add(type="PASSIVE")
        floor.rigid_body.collision_shape, floor.rigid_body.use_margin = "MESH", False
        cache = bpy.context.scene.rigidbody_world.point_cache
        cache.frame_start, cache.frame_end = 1, 60
        # The range begins in the middle of the fall: the simulation is played from its start.
        self.frames(5, 40)
        bpy.context.scene.frame_set(1)
        points = self.imprint(field, ball)
        dented = points[points[:, 2] < -0.02]
        self.assertGreater(len(dented), 10)
        numpy.testing.assert_allclose(dented[:, :2].mean(0), [0.3, 0.25], atol=0.06)
        self.assertAlmostEqual(float(points[:, 2].min()), -0.1, delta=0.04)

    def test_a_surface_that_moves_past_a_resting_collider_gets_a_track(self):
        field, ball = host.field(), host.ball(0.3)
        field.relievo.cells = "32"
        ball.location = (0, 0.25, 0.2)
        self.frames(1, 2)
        for frame, x in ((1, 0.5), (2, -0.5)):
            field.location.x = x
            field.keyframe_insert("location", frame=frame)
        track = self.track(self.imprint(field, ball))
        inside = numpy.abs(track[:, 0]) < 0.45
        numpy.testing.assert_allclose(track[inside][:, 1], -0.1, atol=0.015)

    def test_a_collider_that_gets_other_faces_presses_where_it_is(self):
        field, ball = host.field(), host.ball(0.3)
        ball.location = (0, 0.25, 0.2)
        decimate = ball.modifiers.new("fewer", "DECIMATE")
        for frame, ratio in ((1, 1.0), (2, 0.5)):
            decimate.ratio = ratio
            decimate.keyframe_insert("ratio", frame=frame)
        self.frames(1, 2)
        self.assertAlmostEqual(float(self.imprint(field, ball)[:, 2].min()), -0.1, delta=0.015)

    def test_a_cancelled_bake_leaves_nothing(self):
        field, ball = host.field(), host.ball(0.3)
        for frame, x in ((1, -0.6), (5, 0.6)):
            ball.location = (x, 0.25, 0.2)
            ball.keyframe_insert("location", frame=frame)
        self.frames(1, 5)
        host.draw(field, [[0, 0, 0], [0.2, 0, 0]])
        before = host.digest(self.relievo, field)
        host.select(field, ball)
        from relievo.core import job
        from relievo.ops import imprint

        def steps():
            options = {"frame_start": -1, "frame_end": -1, "cache": False, "images": False, "image_size": 64}
            return host.operator(imprint.RELIEVO_OT_imprint, **options)

        for patience in (1, 3, 6):
            worker = job.Worker(steps())
            while not worker.advance() and worker.share < patience / 8:
                pass
            self.assertFalse(worker.is_done)
            worker.stop()
            self.assertTrue(worker.is_done)
            self.assertEqual(host.digest(self.relievo, field), before)
            self.assertFalse(self.relievo.data.state.of(field).document.info.is_open)
        # Progress goes up, and what is left alone gets to its end.
        worker, shares = job.Worker(steps()), []
        tell, worker.progress = worker.progress, lambda *told: shares.append(told[0]) or tell(*told)
        while not worker.advance(0.01):
            pass
        self.assertLess(host.positions(field.relievo.result)[:, 2].min(), -0.05)
        self.assertGreater(len(shares), 5)
        self.assertTrue(all(0 <= share <= 1 for share in shares))


class Progress(Case):
    def test_progress_of_an_imprint_never_falls(self):
        from relievo.core import job
        from relievo.ops import imprint

        shares, field = [], host.field()
        balls = [host.ball(0.2, f"ball {number}", rings=6) for number in range(2)]
        for ball, x in zip(balls, (-0.4, 0.4)):
            for frame in (1, 4):
                ball.location = (x + 0.1 * frame, 0, 0.15)
                ball.keyframe_insert("location", frame=frame)
        scene = bpy.context.scene
        scene.frame_start, scene.frame_end, scene.relievo.imprint.voxels = 1, 4, 2**12
        host.select(field, *balls)

        class Noting(job.Worker):
            def progress(self, fraction, stage=None):
                answer = super().progress(fraction, stage)
                shares.append(self.share)
                return answer

        work = Noting(host.operator(imprint.RELIEVO_OT_imprint, frame_start=-1, frame_end=-1, cache=False, images=False, image_size=16))
        while not work.advance(0.01):
            shares.append(work.share)
        self.assertEqual(shares, sorted(shares))
        self.assertEqual(work.share, 1.0)
        # Every ball of every frame has told where it is.
        self.assertGreater(len(set(shares)), 8)


class Previews(Case):
    def preview(self):
        from relievo.ops import preview

        return preview

    def settle(self):
        """Turns the preview until it has nothing to do."""
        running = self.preview().current()
        while running.turn(bpy.context, 0.05):
            pass
        self.assertIsNone(running.message)

    def begin(self):
        field, ball = host.field(), host.ball(0.3)
        host.draw(field, [[-0.5, -0.5, 0], [0.5, -0.5, 0]], radius=0.2)
        ball.location = (0, 0.25, 0.2)
        bpy.context.view_layer.update()
        host.select(field, ball)
        self.before = host.positions(field.relievo.result)
        self.digest = host.digest(self.relievo, field)
        self.assertEqual(bpy.ops.relievo.preview(), {"FINISHED"})
        self.settle()
        return field, ball

    def check_clean(self, field):
        made = self.relievo.data.state.of(field)
        self.assertEqual(host.digest(self.relievo, field), self.digest)
        self.assertEqual((made.document.info.undo_count, made.document.info.is_open), (1, 0))

    def test_it_follows_what_presses_and_the_settings(self):
        field, ball = self.begin()
        low = host.positions(field.relievo.result)
        self.assertAlmostEqual(float(low[:, 2].min()), -0.1, delta=0.015)
        ball.location.z = 0.1
        bpy.context.view_layer.update()
        self.settle()
        self.assertAlmostEqual(float(host.positions(field.relievo.result)[:, 2].min()), -0.2, delta=0.02)
        bpy.context.scene.relievo.imprint.share = 0.5
        self.settle()
        self.assertAlmostEqual(float(host.positions(field.relievo.result)[:, 2].min()), -0.1, delta=0.02)
        # An animation is shown frame by frame, each by itself.
        bpy.context.scene.relievo.imprint.share = 1.0
        for frame, x in ((1, -0.5), (10, 0.5)):
            ball.location.x = x
            ball.keyframe_insert("location", frame=frame)
        for frame, x in ((1, -0.5), (10, 0.5)):
            bpy.context.scene.frame_set(frame)
            self.settle()
            points = host.positions(field.relievo.result)
            dented = points[points[:, 2] < -0.05]
            self.assertAlmostEqual(float(dented[:, 0].mean()), x, delta=0.1)
        self.check_clean(field)
        bpy.ops.relievo.preview()
        self.assertIsNone(self.preview().current())
        numpy.testing.assert_array_equal(host.positions(field.relievo.result), self.before)

    def test_a_change_cancels_what_is_under_way(self):
        field, ball = self.begin()
        running = self.preview().current()
        shown = running.shown
        ball.location.x = 0.3
        bpy.context.view_layer.update()
        from relievo.data import view

        # However fast the dent is made, it is under way until it may go on.
        follow, go_on = view.follow, threading.Event()

        def held(*arguments):
            go_on.wait(60)
            return follow(*arguments)

        with mock.patch.object(view, "follow", held):
            running.turn(bpy.context)
            worker = running.worker
            self.assertIsNotNone(worker)
            ball.location.x = -0.3
            bpy.context.view_layer.update()
            self.assertTrue(worker.is_cancelled)
            go_on.set()
            self.settle()
        points = host.positions(field.relievo.result)
        self.assertAlmostEqual(float(points[points[:, 2] < -0.05][:, 0].mean()), -0.3, delta=0.1)
        self.assertEqual(running.shown, shown + 1)
        self.check_clean(field)

    def test_undo_saving_and_editing_know_nothing_of_it(self):
        bpy.context.preferences.edit.undo_steps = 32
        bpy.ops.ed.undo_push(message="start")
        field, ball = self.begin()
        bpy.ops.ed.undo_push(message="preview")
        # A stroke while it runs is what it would be without.
        host.draw(field, [[-0.5, 0.6, 0], [0.5, 0.6, 0]], radius=0.2)
        bpy.ops.ed.undo_push(message="stroke")
        after = host.digest(self.relievo, bpy.data.objects["field"])
        self.assertNotEqual(after, self.digest)
        self.settle()
        bpy.ops.ed.undo()
        self.settle()
        self.check_clean(bpy.data.objects["field"])
        bpy.ops.ed.redo()
        self.assertEqual(host.digest(self.relievo, bpy.data.objects["field"]), after)
        self.settle()
        self.assertLess(host.positions(bpy.data.objects["field"].relievo.result)[:, 2].min(), -0.05)
        with host.folder() as folder:
            path = os.path.join(folder, "preview.blend")
            bpy.ops.wm.save_as_mainfile(filepath=path)
            self.settle()
            self.assertLess(host.positions(bpy.data.objects["field"].relievo.result)[:, 2].min(), -0.05)
            bpy.ops.wm.open_mainfile(filepath=path)
            self.assertIsNone(self.preview().current())
            points = host.positions(bpy.data.objects["field"].relievo.result)
            self.assertGreater(points[:, 2].min(), -0.01)
            self.assertEqual(host.digest(self.relievo, bpy.data.objects["field"]), after)

    def test_what_was_deleted_is_told(self):
        field, ball = self.begin()
        bpy.data.objects.remove(ball)
        running = self.preview().current()
        running.touch()
        while running.turn(bpy.context, 0.05):
            pass
        self.assertIn("deleted", running.message)
        bpy.ops.relievo.preview()
        numpy.testing.assert_array_equal(host.positions(field.relievo.result), self.before)


class Playback(Case):
    def test_the_handler_shows_the_frames_of_the_cache_and_between(self):
        with host.folder() as folder:
            field, ball = host.field(), host.ball(0.3)
            for frame, x in ((1, -0.6), (5, 0.6)):
                ball.location = (x, 0.25, 0.2)
                ball.keyframe_insert("location", frame=frame)
            self.frames(1, 5)
            bpy.ops.wm.save_as_mainfile(filepath=os.path.join(folder, "baked.blend"))
            field.relievo.playback = "HANDLER"
            last = self.imprint(field, ball, cache=True)
            result = field.relievo.result
            self.assertFalse(result.modifiers[0].show_viewport or result.modifiers[0].show_render)
            self.assertTrue(field.relievo.cache.startswith("//"))
            shown = {}
            scene = bpy.context.scene
            for frame in (1, 3, 5, 2, 4, 9):
                scene.frame_set(frame)
                shown[frame] = host.evaluated(result)
            numpy.testing.assert_array_equal(shown[5], host.positions(result) if scene.frame_current == 5 else shown[9])
            dented = [int((shown[frame][:, 2] < -0.02).sum()) for frame in (1, 2, 3, 4, 5)]
            self.assertEqual(dented, sorted(dented))
            self.assertGreater(dented[-1], 2 * dented[0])
            scene.frame_set(2, subframe=0.5)
            between = 0.5 * (shown[2] + shown[3])
            numpy.testing.assert_allclose(host.evaluated(result), between, atol=1e-6)
            # The same frames by Blender's own modifier.
            field.relievo.playback = "MODIFIER"
            self.assertEqual([modifier.type for modifier in result.modifiers], ["MESH_CACHE"])
            for frame in (1, 3, 5):
                scene.frame_set(frame)
                numpy.testing.assert_allclose(host.evaluated(result), shown[frame], atol=1e-6)
            # It goes on after the file was opened again, elsewhere.
            field.relievo.playback = "HANDLER"
            bpy.ops.wm.save_mainfile()
            moved = os.path.join(folder, "moved")
            os.mkdir(moved)
            for name in ("baked.blend", "relievo_cache"):
                os.rename(os.path.join(folder, name), os.path.join(moved, name))
            bpy.ops.wm.open_mainfile(filepath=os.path.join(moved, "baked.blend"))
            field = bpy.data.objects["field"]
            bpy.context.scene.frame_set(3)
            numpy.testing.assert_array_equal(host.evaluated(field.relievo.result), shown[3])
            # A cache that is cut or gone is told, and frames go on.
            path = bpy.path.abspath(field.relievo.cache)
            for length in (100, 10, 0):
                with open(path, "r+b") as file:
                    file.truncate(length)
                bpy.context.scene.frame_set(4)
            os.remove(path)
            bpy.context.scene.frame_set(5)
            numpy.testing.assert_array_equal(host.evaluated(field.relievo.result), shown[3])
            self.assertEqual(len(last), len(shown[3]))

    def test_a_render_does_not_write_from_its_thread_while_the_interface_is_open(self):
        from relievo.data import playback

        field = host.field()
        host.draw(field, [[0, 0, 0], [0.2, 0, 0]])
        seen = []
        original, playback.show = playback.show, lambda target, frame: seen.append(frame)
        field.relievo.cache, field.relievo.playback = "//none.pc2", "HANDLER"
        seen.clear()
        app = types.SimpleNamespace(background=False)
        real, playback.bpy = playback.bpy, types.SimpleNamespace(app=app, path=bpy.path, context=bpy.context)
        try:
            scene = bpy.context.scene
            playback.frame_changed(scene)
            playback.render_begins()
            scene.render.use_lock_interface = False
            playback.frame_changed(scene)
            self.assertEqual(len(seen), 1)
            scene.render.use_lock_interface = True
            playback.frame_changed(scene)
            playback.render_ends()
            scene.render.use_lock_interface = False
            playback.frame_changed(scene)
            self.assertEqual(len(seen), 3)
        finally:
            playback.show, playback.bpy = original, real


if __name__ == "__main__":
    host.main()
