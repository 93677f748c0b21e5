# SPDX-License-Identifier: GPL-3.0-or-later
"""An asset library of the presets: brushes, and materials of what is dented and of fluids. A .blend file of it is made in the
user's data when it is first asked for. A shelf of the view shows its brushes while a brush tool is active."""

import os

import bpy
import numpy

from ..core.error import Refused, said
from . import preset

# Blender has brushes as assets, and shelves of add-ons, from this version on.
FIRST = (4, 3)
FILE, CATALOGS = "presets.blend", "blender_assets.cats.txt"
TOOLS = ("relievo.paint_tool", "relievo.sculpt_tool")
# Catalogs by the kind of preset: the id, which stays the same, and the path.
CATALOG = {
    "brush": ("5b0f6f0e-6a55-4d5f-8a40-6d1f0c8e5a01", "Relievo/Brushes"),
    "imprint": ("5b0f6f0e-6a55-4d5f-8a40-6d1f0c8e5a02", "Relievo/Materials of Imprints"),
    "fluid": ("5b0f6f0e-6a55-4d5f-8a40-6d1f0c8e5a03", "Relievo/Fluids"),
}
# Looks of materials by the name of their preset: colour, roughness, and how much light passes.
LOOKS = {
    "Snow": ((0.88, 0.91, 0.95), 0.7, 0.0),
    "Sand": ((0.58, 0.43, 0.25), 0.95, 0.0),
    "Mud": ((0.12, 0.07, 0.04), 0.35, 0.0),
    "Clay": ((0.42, 0.2, 0.12), 0.8, 0.0),
    "Skin": ((0.75, 0.45, 0.36), 0.5, 0.0),
    "Water": ((0.85, 0.95, 1.0), 0.0, 1.0),
    "Honey": ((0.9, 0.5, 0.06), 0.05, 0.8),
    "Oil": ((0.85, 0.75, 0.2), 0.02, 0.9),
}
# Pixels of a preview, along a side, and the colour of what brushes are shown on.
SIDE = 96
GROUND = (0.45, 0.43, 0.4)


def folder():
    """Returns the folder of the library, in the user's data."""
    return bpy.utils.user_resource("DATAFILES", path=os.path.join("relievo", "assets"))


def spread():
    """Returns how far the pixels of a preview are from its middle, which has a margin, up to 1."""
    along = numpy.linspace(-1.2, 1.2, SIDE)
    return numpy.minimum(numpy.hypot(along[:, None], along[None]), 1.0)


def profile(falloff, far):
    """Returns the strength of a brush at distances from its middle, by its falloff."""
    shapes = {"SPHERE": numpy.sqrt(1 - far * far), "GAUSSIAN": numpy.exp(-5 * far * far) * (far < 1)}
    return numpy.asarray(shapes.get(falloff, (1 - far) ** 2 * (1 + 2 * far)), float)


def picture(heights, color):
    """Returns a preview: rows of pixels from the bottom, with heights that are lit from the upper left, as RGBA."""
    up, right = (numpy.clip(slope, -1.5, 1.5) for slope in numpy.gradient(heights, 2.4 / SIDE))
    light = (0.8 + 0.4 * right - 0.4 * up) / numpy.sqrt(1 + right**2 + up**2)
    shaded = numpy.clip(light, 0.1, 1)[..., None] * numpy.asarray(color) ** (1 / 2.2)
    return numpy.concatenate([shaded, numpy.ones((SIDE, SIDE, 1))], 2).astype(numpy.float32)


def relief(name):
    """Returns the preview of a brush: paint on a plane, or what it makes of one."""
    values, far = preset.GIVEN["brush"][name], spread()
    shape = values["settings.strength"] ** 0.5 * profile(values["falloff"], far)
    if "paint_mode" in values:
        color = GROUND + shape[..., None] * (numpy.array((0.7, 0.08, 0.06)) - GROUND)
        return picture(numpy.zeros_like(far), color)
    return picture(-shape if values["sculpt_mode"] in ("SCRAPE", "SMOOTH") else shape, GROUND)


def brush(data, name):
    """Makes a brush that Blender's own modes do not list. Returns it and its preview."""
    made = data.brushes.new(name, mode="SCULPT")
    made.use_paint_sculpt = False
    return made, relief(name)


def material(data, name):
    """Makes a material that looks like its preset. Returns it and its preview."""
    color, roughness, passing = LOOKS[name]
    made = data.materials.new(name)
    if made.node_tree is None:
        made.use_nodes = True
    made.diffuse_color, made.roughness = (*color, 1), roughness
    shader = next(node for node in made.node_tree.nodes if node.type == "BSDF_PRINCIPLED")
    values = {"Base Color": (*color, 1), "Roughness": roughness, "Transmission Weight": passing}
    for socket, value in values.items():
        shader.inputs[socket].default_value = value
    return made, picture(profile("SPHERE", spread()), color)


def assets(data):
    """Makes the assets of all presets in a file. Returns them."""
    found = set()
    for kind, presets in preset.GIVEN.items():
        for name in presets:
            made, pixels = (brush if kind == "brush" else material)(data, name)
            made.asset_mark()
            told = made.asset_data
            told.description, told.author = preset.TIPS.get(name, f"Relievo brush {name}"), "Relievo"
            told.catalog_id, told["relievo"] = CATALOG[kind][0], kind
            shown = made.preview_ensure()
            shown.image_size = SIDE, SIDE
            shown.image_pixels_float.foreach_set(pixels.ravel())
            found.add(made)
    return found


def write(to):
    """Writes the library into a folder: its .blend file and its catalogs, each under another name first."""
    os.makedirs(to, exist_ok=True)
    path, catalogs = os.path.join(to, FILE), os.path.join(to, CATALOGS)
    # A file of their own: names are those of the presets, whatever the user's file has.
    with bpy.data.temp_data() as data:
        data.libraries.write(f"{path}.new", assets(data), fake_user=True)
    os.replace(f"{path}.new", path)
    lines = [f"{number}:{place}:{place.replace('/', '-')}" for number, place in CATALOG.values()]
    with open(f"{catalogs}.new", "w", encoding="utf-8") as file:
        file.write("\n".join(["VERSION 1", "", *lines, ""]))
    os.replace(f"{catalogs}.new", catalogs)


class RELIEVO_OT_assets_add(bpy.types.Operator):
    """Make an asset library of Relievo's brushes and materials in your data, and add it to the preferences. The Asset Browser and
    the shelf of the brush tools show it"""

    bl_idname = "relievo.assets_add"
    bl_label = "Add Asset Library"

    @classmethod
    def poll(cls, _context):
        if bpy.app.version < FIRST:
            cls.poll_message_set("Blender has brushes as assets from version 4.3 on; Presets of the panels have the same")
        return bpy.app.version >= FIRST

    def execute(self, context):
        to, libraries = folder(), context.preferences.filepaths.asset_libraries
        try:
            write(to)
        except OSError as failure:
            self.report({"ERROR"}, said(failure))
            return {"CANCELLED"}
        if all(os.path.normpath(one.path) != os.path.normpath(to) for one in libraries):
            libraries.new(name="Relievo", directory=to)
            context.preferences.is_dirty = True
        self.report({"INFO"}, f"The asset library Relievo has {sum(map(len, preset.GIVEN.values()))} presets")
        return {"FINISHED"}


class RELIEVO_OT_asset_use(bpy.types.Operator):
    """Have the brush, what is dented, or the active domain be as the asset says; lengths stay"""

    bl_idname = "relievo.asset_use"
    bl_label = "Use Asset"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    # What a shelf names an asset by.
    asset_library_type: bpy.props.EnumProperty(
        name="Library",
        items=[("LOCAL", "Local", "", 1), ("ALL", "All", "", 2), ("ESSENTIALS", "Essentials", "", 3), ("CUSTOM", "Custom", "", 100)],
        options={"HIDDEN", "SKIP_SAVE"},
        default="CUSTOM",
    )
    asset_library_identifier: bpy.props.StringProperty(name="Name of the library", options={"HIDDEN", "SKIP_SAVE"})
    relative_asset_identifier: bpy.props.StringProperty(name="Asset", options={"HIDDEN", "SKIP_SAVE"})

    def execute(self, context):
        try:
            use(context, self.relative_asset_identifier)
        except Refused as failure:
            self.report({"ERROR"}, said(failure))
            return {"CANCELLED"}
        return {"FINISHED"}


def kind_of(identifier):
    """Returns the kind and the name of the preset of an asset, by its place in the library. Raises Refused where there is
    none."""
    *_file, block, name = ["", "", *identifier.replace("\\", "/").split("/")]
    kinds = ("brush",) if block == "Brush" else ("imprint", "fluid")
    found = [kind for kind in kinds if name in preset.GIVEN[kind]]
    if not found:
        raise Refused(f"{name or 'This'} is no asset of Relievo; choose one of the library Relievo")
    return found[0], name


def use(context, identifier):
    """Sets what the preset of an asset says."""
    kind, name = kind_of(identifier)
    group = preset.group_of(context, kind)
    if group is None:
        raise Refused(f"{name} is for fluids: make a domain the active object first")
    for path, value in preset.GIVEN[kind][name].items():
        preset.put(group, path, value)


def tool_of(context):
    """Returns the name of the tool of the view."""
    tool = context.workspace.tools.from_space_view3d_mode("OBJECT", create=False) if context.workspace else None
    return tool.idname if tool is not None else ""


if hasattr(bpy.types, "AssetShelf"):

    class RELIEVO_AST_brushes(bpy.types.AssetShelf):
        bl_space_type = "VIEW_3D"
        bl_idname = "RELIEVO_AST_brushes"
        bl_activate_operator = "relievo.asset_use"

        @classmethod
        def poll(cls, context):
            return context.mode == "OBJECT" and tool_of(context) in TOOLS

        @classmethod
        def asset_poll(cls, asset):
            return asset.metadata.get("relievo") == "brush"


def draw_menu(self, context):
    """What the context menu of the Asset Browser has at its end for assets of the library."""
    asset = getattr(context, "asset", None)
    if asset is not None and asset.metadata.get("relievo"):
        self.layout.separator()
        self.layout.operator("relievo.asset_use", text="Use in Relievo").relative_asset_identifier = asset.full_path


CLASSES = [RELIEVO_OT_assets_add, RELIEVO_OT_asset_use]
if bpy.app.version >= FIRST:
    CLASSES.append(RELIEVO_AST_brushes)


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.ASSETBROWSER_MT_context_menu.append(draw_menu)


def unregister():
    bpy.types.ASSETBROWSER_MT_context_menu.remove(draw_menu)
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
