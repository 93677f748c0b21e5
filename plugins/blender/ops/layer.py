# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers of the active object's detail. Every change is one edit and one step of undo."""

from types import SimpleNamespace

import bpy
from librelievo import abi

from ..core import settings
from ..core.error import Refused
from ..data import layer_list, state, view
from .editing import Editing

ACTIONS = [
    ("ACTIVATE", "Make active", "Strokes and imprints go to this layer"),
    ("REMOVE", "Remove", "Remove the layer with all that is on it"),
    ("UP", "Move up", "Put the layer above the next one"),
    ("DOWN", "Move down", "Put the layer below the one before"),
    ("MERGE", "Merge down", "Put the layer and the one below into one"),
]


# What operators say of the layer that they are about.
NUMBER = "The number of the layer, -1 for the one that was chosen in the list"


class LayerOperator(Editing):
    """An operator that edits layers; `change` needs nothing of Blender."""

    def edit(self, _context, target, made):
        # On a thread the operator's properties are not to be read.
        text, wanted = self.bl_label, SimpleNamespace(**self.as_keywords())
        if getattr(wanted, "layer", 0) < 0:
            row = layer_list.chosen(target)
            if row is None:
                raise Refused(f"{target.name} has no layers yet; paint or sculpt first")
            wanted.layer = layer_list.number_of(made.detail.layers, row)

        def work(_progress):
            with made.edit(text):
                self.change(made.detail.layers, wanted)

        yield 0.2, 0.8, work
        made.record(target)
        yield from view.refreshing(target, made)


class RELIEVO_OT_layer_add(LayerOperator, bpy.types.Operator):
    """Add a layer above the others of its kind"""

    bl_idname = "relievo.layer_add"
    bl_label = "Add layer"

    name: bpy.props.StringProperty(name="Name", description="The name of the layer", default="Layer")
    kind: bpy.props.EnumProperty(name="Kind", description="What the layer has", items=settings.choices(abi.RlvLayerKind))

    @staticmethod
    def change(layers, wanted):
        names = {layer.name for layer in layers}
        name, number = wanted.name, 2
        while name in names:
            name, number = f"{wanted.name} {number}", number + 1
        layers.add(name, kind=wanted.kind.lower())


class RELIEVO_OT_layer_change(LayerOperator, bpy.types.Operator):
    """Order, merge or remove the layer that was chosen in the list"""

    bl_idname = "relievo.layer_change"
    bl_label = "Change layer"

    layer: bpy.props.IntProperty(name="Layer", description=NUMBER, default=-1, options={"HIDDEN"})
    action: bpy.props.EnumProperty(name="Action", description="What is done to the layer", items=ACTIONS)

    @staticmethod
    def change(layers, wanted):
        if wanted.action == "ACTIVATE":
            layers.set_active(wanted.layer)
        elif wanted.action == "REMOVE":
            layers.remove(wanted.layer)
        elif wanted.action == "MERGE":
            layers.merge(wanted.layer)
        else:
            kind = next((layer.kind for layer in layers if layer.id == wanted.layer), None)
            stack = [layer.id for layer in layers if layer.kind == kind]
            if wanted.layer in stack:
                place = stack.index(wanted.layer) + (1 if wanted.action == "UP" else -1)
                layers.place(wanted.layer, min(max(place, 0), len(stack) - 1))


class LayerLook:
    """How a layer is seen, as properties of an operator."""

    layer: bpy.props.IntProperty(name="Layer", description=NUMBER, default=-1, options={"HIDDEN"})
    visible: bpy.props.BoolProperty(name="Visible", description="Whether the layer is seen", default=True)
    opacity: bpy.props.FloatProperty(
        name="Opacity", description="How much of the layer is seen, 0 to 1", min=0, max=1, default=1, subtype="FACTOR"
    )
    blend: bpy.props.EnumProperty(
        name="Blend", description="How the layer covers those below", items=settings.choices(abi.RlvBlend)
    )


class RELIEVO_OT_layer_set(LayerLook, LayerOperator, bpy.types.Operator):
    """Change how a layer is seen, without a dialog"""

    bl_idname = "relievo.layer_set"
    bl_label = "Layer settings"
    bl_options = {"REGISTER", "UNDO", "INTERNAL"}

    @staticmethod
    def change(layers, wanted):
        blend = wanted.blend.lower()
        layers.set(wanted.layer, is_visible=wanted.visible, opacity=wanted.opacity, blend=blend)


class RELIEVO_OT_layer_edit(LayerLook, bpy.types.Operator):
    """Change opacity and blending of the layer that was chosen in the list"""

    bl_idname = "relievo.layer_edit"
    bl_label = "Layer settings"
    bl_options = {"REGISTER"}

    def invoke(self, context, _event):
        target = state.source_of(context.active_object)
        made, row = state.existing(target), layer_list.chosen(target)
        if self.layer < 0 and made is not None and row is not None:
            self.layer = layer_list.number_of(made.detail.layers, row)
        for layer in made.detail.layers if made else ():
            if layer.id == self.layer:
                self.visible, self.opacity = bool(layer.is_visible), layer.opacity
                self.blend = abi.RlvBlend(layer.blend).name
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, _context):
        # A dialog cannot go on in the background itself.
        return bpy.ops.relievo.layer_set("INVOKE_DEFAULT", **self.as_keywords()) & {"FINISHED", "CANCELLED"} or {"FINISHED"}


CLASSES = [RELIEVO_OT_layer_add, RELIEVO_OT_layer_change, RELIEVO_OT_layer_set, RELIEVO_OT_layer_edit]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
