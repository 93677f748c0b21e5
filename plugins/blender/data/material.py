# SPDX-License-Identifier: GPL-3.0-or-later
"""Paint and baked images in materials, so that results render without the add-on: displacement on the subdivided cage,
colours on its surface. Numbers are object units as they are, so the nodes neither shift nor scale them."""

import bpy

from . import cache, mesh

# The name of the node that lays paint over a base colour.
PAINT = "Relievo paint"
# The custom property of objects that have paint: the share by which it covers the base colour.
PAINTED = "relievo_paint"


def displace(target, path, frames=None):
    """Displaces an object by an image, or by a numbered sequence for a range of frames."""
    image, texture, nodes, links = _texture(target, path, "Relievo displacement", frames)
    image.colorspace_settings.name = "Non-Color"
    node = nodes.get("Relievo height") or nodes.new("ShaderNodeDisplacement")
    node.name = "Relievo height"
    node.inputs["Midlevel"].default_value, node.inputs["Scale"].default_value = 0.0, 1.0
    links.new(texture.outputs["Color"], node.inputs["Height"])
    links.new(node.outputs["Displacement"], _output(nodes).inputs["Displacement"])
    made = target.active_material
    if hasattr(made, "displacement_method"):
        made.displacement_method = "BOTH"
    elif hasattr(made, "cycles"):
        made.cycles.displacement_method = "BOTH"
    if not any(modifier.type == "SUBSURF" for modifier in target.modifiers):
        modifier = target.modifiers.new("Subdivision", "SUBSURF")
        modifier.levels, modifier.render_levels = 2, 6
        modifier.uv_smooth, modifier.use_limit_surface = "PRESERVE_CORNERS", True
    return image


def color(target, path):
    """Gives an object's surface the colours of an image."""
    image, texture, nodes, links = _texture(target, path, "Relievo colour", None)
    surface = _surface(target.active_material)
    if surface is None:
        surface = nodes.new("ShaderNodeBsdfPrincipled")
        links.new(surface.outputs[0], _output(nodes).inputs["Surface"])
    links.new(texture.outputs["Color"], surface.inputs["Base Color"])
    return image


def ground_of(target):
    """Returns the colour of an object before it is painted: the base colour of its first material, where that is plain."""
    first = next((slot.material for slot in target.material_slots), None)
    surface = _surface(first)
    if surface is None or surface.inputs["Base Color"].is_linked:
        return (0.8, 0.8, 0.8)
    return tuple(surface.inputs["Base Color"].default_value)[:3]


def show_paint(result, ground, name):
    """Lays the paint of a result over the base colours of its materials, or gives it a material called `name` where it has
    none. Meshes without paint look as before with them. Returns the names of the materials that stay: those whose base
    colour is not plain or not the ground that the paint begins with."""
    result[PAINTED] = 1.0
    materials = result.data.materials
    if not any(materials):
        made = bpy.data.materials.new(name)
        if made.node_tree is None:
            made.use_nodes = True
        _surface(made).inputs["Base Color"].default_value = (*ground, 1.0)
        if len(materials):
            materials[0] = made
        else:
            materials.append(made)
    return [made.name for made in materials if made is not None and not _lay_paint(made, ground)]


def _lay_paint(made, ground):
    """Returns whether a material shows paint, laid over its base colour if it is plain and the ground."""
    if made.node_tree is not None and PAINT in made.node_tree.nodes:
        return True
    surface = _surface(made)
    if surface is None or made.library is not None:
        return False
    base = surface.inputs["Base Color"]
    if base.is_linked or any(abs(one - two) > 1e-3 for one, two in zip(base.default_value, ground)):
        return False
    nodes, links = made.node_tree.nodes, made.node_tree.links
    paint, share, mix = (nodes.new(kind) for kind in ("ShaderNodeAttribute", "ShaderNodeAttribute", "ShaderNodeMix"))
    paint.attribute_name, mix.data_type, mix.name, mix.label = mesh.PAINT, "RGBA", PAINT, PAINT
    share.attribute_type, share.attribute_name = "OBJECT", PAINTED
    x, y = surface.location
    paint.location, share.location, mix.location = (x - 450, y), (x - 450, y - 220), (x - 220, y)
    inputs = {socket.identifier: socket for socket in mix.inputs}
    inputs["A_Color"].default_value = base.default_value
    # It is 0 for objects that do not have the property.
    links.new(share.outputs["Fac"], inputs["Factor_Float"])
    links.new(paint.outputs["Color"], inputs["B_Color"])
    links.new(next(socket for socket in mix.outputs if socket.identifier == "Result_Color"), base)
    return True


def _surface(made):
    """Returns the Principled node of a material, or None."""
    nodes = made.node_tree.nodes if made is not None and made.node_tree is not None else ()
    return next((node for node in nodes if node.type == "BSDF_PRINCIPLED"), None)


def _texture(target, path, name, frames):
    """The node of an image in the active material of an object."""
    made = target.active_material
    if made is None:
        made = bpy.data.materials.new(f"{target.name} Relievo")
        target.data.materials.append(made)
    if made.node_tree is None:
        made.use_nodes = True
    nodes, links = made.node_tree.nodes, made.node_tree.links
    first = path.replace("####", f"{frames[0]:04d}") if frames else path
    image = bpy.data.images.load(first, check_existing=True)
    image.filepath = cache.relative(first)
    texture = nodes.get(name) or nodes.new("ShaderNodeTexImage")
    texture.name, texture.image = name, image
    if frames:
        image.source = "SEQUENCE"
        user = texture.image_user
        user.frame_start, user.frame_duration = frames[0], frames[1] - frames[0] + 1
        # Files are numbered as the frames are.
        user.frame_offset, user.use_auto_refresh, user.use_cyclic = frames[0] - 1, True, False
    else:
        image.reload()
    return image, texture, nodes, links


def _output(nodes):
    found = next((node for node in nodes if node.type == "OUTPUT_MATERIAL"), None)
    return found or nodes.new("ShaderNodeOutputMaterial")
