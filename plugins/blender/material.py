# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked images in materials, so that results render without the add-on: displacement on the subdivided cage, colours on
its surface. Numbers are object units as they are, so the nodes neither shift nor scale them."""

import bpy

from . import cache


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
    surface = next((node for node in nodes if node.type == "BSDF_PRINCIPLED"), None)
    if surface is None:
        surface = nodes.new("ShaderNodeBsdfPrincipled")
        links.new(surface.outputs[0], _output(nodes).inputs["Surface"])
    links.new(texture.outputs["Color"], surface.inputs["Base Color"])
    return image


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
