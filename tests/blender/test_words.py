"""What operators say to values and files that cannot be used: sentences in words of the panels, without names of functions, fields
or types of the library, of Python or of JSON."""

import contextlib
import io
import json
import re
import sys
import tempfile
import unittest
from pathlib import Path

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host
from test_fluid import box

# What no artist reads. Paths are taken out before.
FOREIGN = re.compile(
    r"rlv_|\bRlv|\bRLV|\b[a-z]+_[a-z_]+\b|::|Traceback|\b[A-Z]\w*Error\b|\bErrno\b|\bNULL\b|JSON|\bjson\b|[{}\[\]]|\bu32\b|\bf32\b"
    r"|\bstruct\b|\bhandle 0x|\bNone\b|\bchar \d|\bNaN\b|\bnan\b"
)
PATH = re.compile(r"(?:/[\w.#-]+)+/?")


class Words(unittest.TestCase):
    def setUp(self):
        self.relievo = host.empty()
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.options = bpy.context.preferences.addons["relievo"].preferences
        self.options.cache_folder = self.folder.name
        bpy.context.scene.frame_end = 3
        self.said = []

    def run_it(self, operator, **properties):
        """Runs an operator and keeps what it says."""
        printed = io.StringIO()
        with contextlib.redirect_stdout(printed):
            try:
                operator(**properties)
            except RuntimeError as failure:
                self.assertNotIn("poll() failed", str(failure), operator)
                self.said += [line.removeprefix("Error: ") for line in str(failure).splitlines() if line.strip()]
        self.said += [line.removeprefix("Relievo: ") for line in printed.getvalue().splitlines() if line.startswith("Relievo: ")]

    def extremes(self, group, names, function):
        """Calls a function with each setting of a group at both ends of what the panel takes."""
        for name in names:
            told = group.bl_rna.properties[name]
            if told.type not in ("FLOAT", "INT") or told.is_array:
                continue
            for value in (told.hard_min, told.hard_max):
                setattr(group, name, value)
                function()
            group.property_unset(name)

    def told(self, least, *wanted):
        """Checks all that was said, and that it has what is wanted."""
        said, self.said = self.said, []
        for sentence in said:
            self.assertNotRegex(PATH.sub("", sentence), FOREIGN)
        self.assertGreaterEqual(len(said), least)
        for text in wanted:
            self.assertRegex("\n".join(said), text)

    def damaged_field(self, value=float("nan")):
        field = host.field()
        field.data.vertices[3].co.z = value
        return field

    def test_meshes_that_cannot_be_used(self):
        bpy.context.scene.relievo.imprint.voxels = 4096
        for value in (float("nan"), float("inf")):
            field, ball = self.damaged_field(value), host.ball(rings=4)
            host.select(field)
            self.run_it(bpy.ops.relievo.stroke, action="SCULPT", points="[[0, 0, 0]]")
            self.run_it(bpy.ops.relievo.levels_build)
            for target, presser in ((field, ball), (ball, field)):
                host.select(target, presser)
                self.run_it(bpy.ops.relievo.imprint, frame_start=1, frame_end=1)
            field.relievo.kind = "TRIANGLES"
            host.select(field)
            self.run_it(bpy.ops.relievo.stroke, action="SCULPT", points="[[0, 0, 0]]")
        self.told(6, "What presses reaches too far", "Vertex 3 .*Repair mesh")

    def test_sentences_of_the_table_are_those_of_the_library(self):
        from relievo.core.error import said
        import librelievo as rl

        context, points = self.relievo.core.native.context(), numpy.eye(4, 3, dtype=numpy.float32)
        for corners, text in (([0, 1, 1], "Face 0 of the mesh has a vertex twice"), ([0, 1, 9], "a vertex that is not there")):
            with self.assertRaises(rl.RelievoError) as caught:
                rl.Mesh(context, points, numpy.uint32(corners), 3)
            self.assertIn("rlv_", str(caught.exception))
            self.assertRegex(said(caught.exception), text)
            self.assertNotRegex(said(caught.exception), FOREIGN)
        with self.assertRaises(rl.RelievoError) as caught:
            rl.Tissue.block(context, (0, 0, 0), 1e-2, (1, 1, 1), young=-1, poisson=0.4, density=1000)
        self.assertNotRegex(said(caught.exception), FOREIGN)

    def test_names_in_quotes_and_paths_stay(self):
        from relievo.core import words

        text = "material `soft_skin`: air_max of /tmp/a_b/c_d.ply is [1, 2, 3]; rlv_repair_check lists those without"
        wanted = "material `soft_skin`: Trapped air to of /tmp/a_b/c_d.ply is 1, 2, 3; Repair mesh may mend it"
        self.assertEqual(words.plain(text, ["rlv_diffuse"]), wanted)
        self.assertEqual(words.plain("the level is gone, or copy it with rlv_level_read; wait"), "the level is gone; wait")

    def test_strokes_that_cannot_be_used(self):
        field = host.field()
        host.select(field)
        for points in ("", "{", "[]", "[[1]]", '[[1, 2, "a"]]', "[[1e400, 0, 0]]", "null", '{"a": 1}', "[[0,0,0,0,0,0,0]]"):
            self.run_it(bpy.ops.relievo.stroke, action="SCULPT", points=points)
        group = bpy.context.scene.relievo.brush
        stroke = lambda: self.run_it(bpy.ops.relievo.stroke, action="SCULPT", points="[[0, 0, 0], [0.1, 0, 0]]")
        names = [one.name for one in group.settings.table if one.name not in ("radius", "rate", "spacing")]
        self.extremes(group.settings, names, stroke)
        self.extremes(group, ["height"], stroke)
        for text in ("{", "{}", '{"points": 1}', "[]"):
            field.relievo.strokes.add().text = text
        self.run_it(bpy.ops.relievo.replay)
        self.told(9, "list of x, y, z", "Height: it is out of range")

    def test_settings_of_imprints_at_their_ends(self):
        field, ball = host.field(), host.ball()
        ball.location.z = 0.2
        host.select(field, ball)
        imprint = bpy.context.scene.relievo.imprint
        imprint.voxels = 4096
        names = [one.name for one in imprint.table if one.name not in ("voxels", "sub_steps", "smoothing_passes")]
        self.extremes(imprint, names, lambda: self.run_it(bpy.ops.relievo.imprint, frame_start=1, frame_end=1))
        self.told(0)

    def test_fluids_and_foam_that_cannot_be(self):
        domain = box("tank", (0, 0, 0), (0.4, 0.4, 0.4))
        domain.relievo.fluid.role, domain.relievo.fluid.spacing = "DOMAIN", 0.05
        fill = box("water", (0.05, 0.05, 0.05), (0.35, 0.35, 0.2))
        fill.relievo.fluid.role = "FILL"
        host.select(domain)
        simulate = lambda: self.run_it(bpy.ops.relievo.fluid_simulate)
        options = domain.relievo.fluid
        self.extremes(options, ["viscosity", "friction", "cohesion", "tension"], simulate)
        for spacing in (1e-4, 1e3, 1e20):
            options.spacing = spacing
            simulate()
        options.spacing = 0.05
        fill.relievo.fluid.velocity = (float("nan"), 0, 0)
        simulate()
        fill.relievo.fluid.velocity = (1, 0, 0)
        self.told(4, "[Ss]pacing", "Viscosity", "Surface tension", "Velocity|velocity")
        simulate()
        foam = domain.relievo_foam.settings
        self.extremes(foam, [one.name for one in foam.table if one.name != "most"], lambda: self.run_it(bpy.ops.relievo.foam_bake))
        self.told(4, "Trapped air to", "Crests to", "Energy to", "Longest life")
        options.function = "ZHU_BRIDSON"
        self.extremes(options, ["cell"], lambda: self.run_it(bpy.ops.relievo.fluid_mesh))
        for path in Path(self.folder.name).rglob("particles_*2.rlvfluid"):
            path.write_bytes(b"\0" * 99)
        for operator in (bpy.ops.relievo.fluid_mesh, bpy.ops.relievo.foam_bake, bpy.ops.relievo.foam_estimate):
            self.run_it(operator)
        options.place = "SERVER"
        remote = self.relievo.data.remote
        self.addCleanup(setattr, remote, "PATIENCE", remote.PATIENCE)
        remote.PATIENCE = 0.0
        for address in ("nonsense", "127.0.0.1:1", "tls://127.0.0.1:1", "unix:/nonexistent"):
            self.options.server = address
            self.run_it(bpy.ops.relievo.server_check)
        self.options.token_file = "/nonexistent/token"
        self.run_it(bpy.ops.relievo.server_check)
        self.told(8, "does not begin as its extension says", "does not answer", "no address")

    def test_tissue_that_cannot_be(self):
        parts = {}
        for role, low, high in (("VOLUME", 0, 0.1), ("SKIN", 0, 0.1)):
            parts[role] = box(role.lower(), (low,) * 3, (high,) * 3)
            parts[role].relievo_tissue.role = role
        host.select(parts["VOLUME"])
        model, volume = bpy.context.scene.collection.relievo_tissue, parts["VOLUME"].relievo_tissue
        bake = lambda: [self.run_it(one) for one in (bpy.ops.relievo.tissue_estimate, bpy.ops.relievo.tissue_bake)]
        for voxel in (1e-6, 1e3):
            model.voxel = voxel
            bake()
        model.voxel = 0.05
        self.extremes(model, ["samples", "dermis", "epidermis"], bake)
        for name, values in {"young": (1, 1e30), "density": (1e-3, 1e30), "poisson": (-0.9, 0.4999), "level": (63,)}.items():
            for value in values:
                setattr(volume, name, value)
                self.run_it(bpy.ops.relievo.tissue_estimate)
            volume.property_unset(name)
        model.property_unset("samples")
        bone = box("bone", (5, 5, 5), (6, 6, 6))
        bone.relievo_tissue.role = "HOLD"
        self.run_it(bpy.ops.relievo.tissue_bake)
        self.told(4, "surface `bone`: no tissue is near it", "elements; give Element size", "Element size: no element", "`volume`: the stiffness", "`volume`: the density")

    def test_files_that_are_not_there_or_damaged(self):
        field = host.field()
        host.draw(field, [[0, 0, 0], [0.1, 0, 0]])
        missing = "/nonexistent/folder/a"
        for name, ending in (("result_ptex", "ptx"), ("result_document", "relievo"), ("export_scene", "toml")):
            self.run_it(getattr(bpy.ops.relievo, name), filepath=f"{missing}.{ending}")
        self.run_it(bpy.ops.relievo.result_image)
        self.run_it(bpy.ops.relievo.levels_read, filepath=f"{missing}.rlvpm")
        wrong = Path(self.folder.name, "text.rlvpm")
        wrong.write_text("no mesh")
        self.run_it(bpy.ops.relievo.levels_read, filepath=str(wrong))
        host.select(field)
        self.run_it(bpy.ops.relievo.decal_mesh)
        field.relievo.decal.image = bpy.data.images.new("picture", 8, 8)
        for place in ((9e9, 9e9, 9e9), (float("nan"), 0, 0), (0, 0, 0)):
            for _ in range(2):
                pin = field.relievo.decal.pins.add()
                pin.position, pin.image = place, (1, 1)
            self.run_it(bpy.ops.relievo.decal_mesh)
            self.run_it(bpy.ops.relievo.decal_apply)
            field.relievo.decal.pins.clear()
        field.relievo.decal.pins.add().image = (4, 4)
        field.relievo.decal.up = (0, 0, 0)
        self.run_it(bpy.ops.relievo.decal_mesh)
        self.extremes(field.relievo.decal, ["width"], lambda: self.run_it(bpy.ops.relievo.decal_mesh))
        self.told(9, "Up: it is not finite", "pin 1: it is at the same place")

    def test_what_objects_keep_may_be_damaged(self):
        field = host.field()
        host.draw(field, [[0, 0, 0], [0.1, 0, 0]])
        for name in [key for key in field.keys() if key.startswith("relievo")]:
            if isinstance(field[name], (bytes, str)):
                del field[name]
        field.relievo.layers = "[{"
        self.relievo.data.state.forget_all()
        for path in Path(self.relievo.data.document.folder()).glob("*"):
            path.unlink()
        host.select(field)
        self.run_it(bpy.ops.relievo.stroke, action="SCULPT", points="[[0, 0, 0]]")
        self.run_it(bpy.ops.relievo.replay)
        leveled = host.ball(name="leveled")
        host.select(leveled)
        bpy.ops.relievo.levels_build()
        for text in ("{", "[]", '{"level": {"error": "a"}}', '{"level": {"triangles": 9}}'):
            leveled.relievo.progressive.edits.add().text = text
            leveled.relievo.progressive.ratio = 0.5 if len(text) % 2 else 0.7
            self.run_it(bpy.ops.relievo.levels_edit)
            self.run_it(bpy.ops.relievo.levels_sculpt)
            leveled.relievo.progressive.edits.clear()
        self.told(3)


if __name__ == "__main__":
    host.main()
