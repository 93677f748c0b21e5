"""Far instances of an armature's character: built, shown as meshes by the pixels of the camera, followed over frames, cleared
and refused."""

import math
import sys
import tempfile
import unittest
from pathlib import Path

import bpy
import numpy
from mathutils import Matrix, Quaternion

sys.path.append(str(Path(__file__).resolve().parent))

import host

RINGS, SIDES = 33, 20


class Crowds(unittest.TestCase):
    def setUp(self):
        self.relievo = host.empty()
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        bpy.context.preferences.addons["relievo"].preferences.cache_folder = folder.name
        self.scene = bpy.context.scene
        self.scene.frame_start, self.scene.frame_end = 1, 13
        self.scene.render.resolution_x = self.scene.render.resolution_y = 200
        self.collection = bpy.data.collections.new("walkers")
        self.scene.collection.children.link(self.collection)
        self.rig = self.armature()
        self.tube = self.skin(self.rig)
        camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
        camera.matrix_world = Matrix.Translation((0, -6, 1)) @ Quaternion((1, 0, 0), math.pi / 2).to_matrix().to_4x4()
        self.scene.collection.objects.link(camera)
        self.scene.camera = camera

    def armature(self):
        """Two bones along z; the upper one bends by 90 degrees about x within 12 frames."""
        rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
        self.collection.objects.link(rig)
        host.select(rig)
        bpy.ops.object.mode_set(mode="EDIT")
        lower, upper = rig.data.edit_bones.new("lower"), rig.data.edit_bones.new("upper")
        lower.head, lower.tail = (0, 0, 0), (0, 0, 1)
        upper.head, upper.tail, upper.parent = (0, 0, 1), (0, 0, 2), lower
        bpy.ops.object.mode_set(mode="OBJECT")
        bone = rig.pose.bones["upper"]
        for frame, angle in ((1, 0.0), (13, math.pi / 2)):
            bone.rotation_quaternion = Quaternion((1, 0, 0), angle)
            bone.keyframe_insert("rotation_quaternion", frame=frame)
        rig.animation_data.action.name = "bend"
        return rig

    def skin(self, rig):
        """A bumpy tube around both bones."""
        ring, side = numpy.divmod(numpy.arange(RINGS * SIDES), SIDES)
        angle, height = 2 * numpy.pi * side / SIDES, 2.0 * ring / (RINGS - 1)
        radius = 0.2 + 0.01 * numpy.sin(5 * angle) * numpy.cos(9 * height)
        points = numpy.column_stack([radius * numpy.cos(angle), radius * numpy.sin(angle), height])
        low = numpy.arange((RINGS - 1) * SIDES)
        turn = low - low % SIDES + (low + 1) % SIDES
        corners = numpy.column_stack([low, turn, turn + SIDES, low + SIDES])
        tube = host.add("tube", points, corners, 4)
        self.scene.collection.objects.unlink(tube)
        self.collection.objects.link(tube)
        for name in ("red", "blue"):
            tube.data.materials.append(bpy.data.materials.new(name))
        tube.data.polygons.foreach_set("material_index", (corners[:, 0] >= RINGS * SIDES // 2).astype(numpy.int32))
        share = numpy.clip(2.5 * height - 2.0, 0.0, 1.0)
        for name, weights in (("lower", 1 - share), ("upper", share)):
            group = tube.vertex_groups.new(name=name)
            for point, weight in enumerate(weights):
                if weight > 0:
                    group.add([point], float(weight), "REPLACE")
        tube.parent = rig
        tube.modifiers.new("rig", "ARMATURE").object = rig
        return tube

    def place(self, name, depth, **custom):
        empty = bpy.data.objects.new(name, None)
        empty.instance_type, empty.instance_collection = "COLLECTION", self.collection
        empty.location = (0, depth, 0)
        for key, value in custom.items():
            empty[key] = value
        self.scene.collection.objects.link(empty)
        return empty

    def build(self):
        host.select(self.rig)
        self.assertEqual(bpy.ops.relievo.crowd_build(), {"FINISHED"})
        return self.rig.relievo_crowd

    def test_far_instances_are_meshes_of_their_pixels_in_the_pose_of_the_frame(self):
        options = self.build()
        self.assertIn(f"{2 * (RINGS - 1) * SIDES:,} triangles, 1 actions, 12 poses", options.report)
        near, middle, far = (self.place(name, depth) for name, depth in (("near", -5), ("middle", 15), ("far", 150)))
        twin, ahead = self.place("twin", 150.5), self.place("ahead", 150, phase=0.25)
        self.scene.frame_set(7)
        self.assertEqual(bpy.ops.relievo.crowd_show(), {"FINISHED"})
        shown = {one.name: self.relievo.ops.crowd.child_of(one) for one in (near, middle, far, twin, ahead)}
        self.assertIsNone(shown["near"])
        self.assertEqual((near.instance_type, far.instance_type), ("COLLECTION", "NONE"))
        faces = {name: len(child.data.polygons) for name, child in shown.items() if child}
        self.assertTrue(2 * (RINGS - 1) * SIDES > faces["middle"] > 2 * faces["far"] > 0, faces)
        self.assertEqual(shown["far"].data, shown["twin"].data)
        self.assertNotEqual(shown["far"].data, shown["ahead"].data)
        # Points of the mesh are points of the character in this frame.
        bpy.context.view_layer.update()
        posed = host.evaluated(self.tube)
        made = host.positions(shown["middle"])
        distances = numpy.linalg.norm(posed[None] - made[:, None], axis=2).min(axis=1)
        self.assertLess(distances.max(), 2e-3)
        self.assertGreater(numpy.ptp(made[:, 1]), 0.5, "the upper half leans")
        self.assertEqual([slot.name for slot in shown["middle"].data.materials], ["red", "blue"])
        slots = numpy.empty(faces["middle"], numpy.int32)
        shown["middle"].data.polygons.foreach_get("material_index", slots)
        self.assertEqual(set(slots.tolist()), {0, 1})

        # Another frame has other meshes, and those of the last one are gone.
        count = len(bpy.data.meshes)
        before = host.positions(shown["far"])
        self.scene.frame_set(12)
        self.assertEqual(len(bpy.data.meshes), count)
        after = host.positions(shown["far"])
        self.assertTrue(before.shape != after.shape or abs(before - after).max() > 0.1)
        # A finer error, and full instances again.
        options.pixels = 0.1
        bpy.ops.relievo.crowd_show()
        self.assertGreater(len(shown["far"].data.polygons), faces["far"])
        bpy.ops.relievo.crowd_clear()
        self.assertEqual({one.instance_type for one in (near, middle, far)}, {"COLLECTION"})
        self.assertFalse([one for one in bpy.data.objects if "relievo_crowd_child" in one])

    def test_a_model_that_was_sculpted_is_refitted(self):
        host.select(self.rig)
        with self.assertRaisesRegex(RuntimeError, "build it first"):
            bpy.ops.relievo.crowd_refit()
        options = self.build()
        before, report = options.path, options.report
        top = max(vertex.co.z for vertex in self.tube.data.vertices)
        for vertex in self.tube.data.vertices:
            vertex.co.z *= 1.5
        self.assertEqual(bpy.ops.relievo.crowd_refit(), {"FINISHED"})
        self.assertNotEqual(options.path, before)
        self.assertEqual(options.report, report)
        with self.relievo.ops.crowd.model_of(self.rig).mesh(0.0) as made:
            self.assertGreater(made.points()[:, 2].max(), 1.2 * top)
        host.select(self.tube)
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.subdivide()
        bpy.ops.object.mode_set(mode="OBJECT")
        host.select(self.rig)
        with self.assertRaisesRegex(RuntimeError, "other faces or vertices"):
            bpy.ops.relievo.crowd_refit()

    def test_what_cannot_be_shown_is_refused(self):
        host.select(self.rig)
        with self.assertRaisesRegex(RuntimeError, "build it first"):
            bpy.ops.relievo.crowd_show()
        self.build()
        with self.assertRaisesRegex(RuntimeError, "No empty"):
            bpy.ops.relievo.crowd_show()
        self.place("far", 50)
        self.scene.camera = None
        with self.assertRaisesRegex(RuntimeError, "no camera"):
            bpy.ops.relievo.crowd_show()
        bpy.data.objects.remove(self.tube)
        with self.assertRaisesRegex(RuntimeError, "deforms no mesh"):
            bpy.ops.relievo.crowd_build()


if __name__ == "__main__":
    host.main()
