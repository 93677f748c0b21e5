"""The asset library of the add-on's presets: what is in it, what its assets set, and where they are offered."""

import sys
import unittest
from pathlib import Path
from types import SimpleNamespace

import bpy
import numpy

sys.path.append(str(Path(__file__).resolve().parent))

import host
from test_interface import Case, Recorder


class Assets(Case):
    def setUp(self):
        super().setUp()
        from relievo.ui import asset, preset

        self.asset, self.given = asset, preset.GIVEN
        kept, folder = asset.folder, host.folder()
        self.addCleanup(folder.cleanup)
        self.addCleanup(setattr, asset, "folder", kept)
        self.path = f"{folder.name}/assets"
        asset.folder = lambda: self.path

    def test_a_library_has_all_presets_and_is_added_once(self):
        if bpy.app.version < self.asset.FIRST:
            with self.assertRaisesRegex(RuntimeError, "from version 4.3 on|poll"):
                bpy.ops.relievo.assets_add()
            return
        own = bpy.data.materials.new("Snow")
        for _ in range(2):
            self.assertEqual(bpy.ops.relievo.assets_add(), {"FINISHED"})
        libraries = bpy.context.preferences.filepaths.asset_libraries
        added = [one for one in libraries if one.path.rstrip("/") == self.path]
        self.assertEqual(len(added), 1)
        libraries.remove(added[0])
        self.assertEqual((own.name, len(bpy.data.materials), len(bpy.data.brushes)), ("Snow", 1, 0))
        with bpy.data.libraries.load(f"{self.path}/presets.blend", assets_only=True) as (kept, wanted):
            wanted.brushes, wanted.materials = list(kept.brushes), list(kept.materials)
        self.assertEqual({one.name for one in wanted.brushes}, set(self.given["brush"]))
        names = {one.name.removesuffix(".001") for one in wanted.materials}
        self.assertEqual(names, {*self.given["imprint"], *self.given["fluid"]})
        with open(f"{self.path}/blender_assets.cats.txt", encoding="utf-8") as file:
            catalogs = dict(line.split(":")[:2] for line in file.read().splitlines() if ":" in line)
        for one in [*wanted.brushes, *wanted.materials]:
            self.assertTrue(catalogs[one.asset_data.catalog_id].startswith("Relievo/"), one.name)
            self.assertIn(one.asset_data["relievo"], self.given)
            pixels = numpy.empty(4 * 96 * 96, numpy.float32)
            one.preview.image_pixels_float.foreach_get(pixels)
            self.assertGreater(pixels.reshape(-1, 4)[:, :3].std(), 0.02, one.name)
        self.assertFalse(any(one.use_paint_sculpt for one in wanted.brushes))

    def test_assets_set_what_presets_set(self):
        field = host.field()
        host.select(field)
        brush, use = bpy.context.scene.relievo.brush, bpy.ops.relievo.asset_use
        use(relative_asset_identifier="presets.blend/Brush/Scrape")
        self.assertEqual((brush.sculpt_mode, brush.falloff), ("SCRAPE", "SPHERE"))
        use(relative_asset_identifier="presets.blend\\Material\\Clay")
        self.assertAlmostEqual(bpy.context.scene.relievo.imprint.smoothing, 0.1)
        with self.assertRaisesRegex(RuntimeError, "make a domain the active object"):
            use(relative_asset_identifier="presets.blend/Material/Honey")
        field.relievo.fluid.role = "DOMAIN"
        use(relative_asset_identifier="presets.blend/Material/Honey")
        self.assertAlmostEqual(field.relievo.fluid.viscosity, 7e-3)
        with self.assertRaisesRegex(RuntimeError, "Grass is no asset of Relievo"):
            use(relative_asset_identifier="other.blend/Brush/Grass")

    def test_the_browser_uses_assets_of_this_library(self):
        drawn = []
        for data in ({"relievo": "imprint"}, {}):
            layout = Recorder()
            asset = SimpleNamespace(metadata=data, full_path="/home/presets.blend/Material/Mud")
            self.asset.draw_menu(SimpleNamespace(layout=layout), SimpleNamespace(asset=asset))
            drawn.append((layout.operators, getattr(layout, "relative_asset_identifier", "")))
        self.assertEqual(drawn, [(["relievo.asset_use"], "/home/presets.blend/Material/Mud"), ([], "")])
        self.asset.use(bpy.context, drawn[0][1])
        self.assertAlmostEqual(bpy.context.scene.relievo.imprint.repose, 0.35)

    def test_the_shelf_lists_brushes_of_this_library(self):
        if bpy.app.version < self.asset.FIRST:
            self.assertFalse(hasattr(bpy.types, "RELIEVO_AST_brushes"))
            return
        shelf = self.asset.RELIEVO_AST_brushes
        self.assertEqual(shelf.bl_activate_operator, self.asset.RELIEVO_OT_asset_use.bl_idname)
        listed = [shelf.asset_poll(SimpleNamespace(metadata=data)) for data in ({"relievo": "brush"}, {"relievo": "fluid"}, {})]
        self.assertEqual(listed, [True, False, False])
        for tool, is_shown in (("relievo.sculpt_tool", True), ("builtin.select_box", False)):
            tools = SimpleNamespace(from_space_view3d_mode=lambda *_, tool=tool, **__: SimpleNamespace(idname=tool))
            context = SimpleNamespace(mode="OBJECT", workspace=SimpleNamespace(tools=tools))
            self.assertEqual(shelf.poll(context), is_shown)


if __name__ == "__main__":
    host.main()
