# SPDX-License-Identifier: GPL-3.0-or-later
"""Layers of the active object's detail. Every change is one edit and one step of undo."""

import bpy
import librelievo as rl
from librelievo import abi

from . import settings, state, view

ACTIONS = [
    ("ACTIVATE", "Make active", "Strokes and imprints go to this layer"),
    ("REMOVE", "Remove", "Remove the layer with all that is on it"),
    ("UP", "Move up", "Put the layer above the next one"),
    ("DOWN", "Move down", "Put the layer below the one before"),
    ("MERGE", "Merge down", "Put the layer and the one below into one"),
]


class LayerOperator:
    """An operator that edits layers."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return state.is_editable(context)

    def execute(self, context):
        target = state.source_of(context.active_object)
        try:
            made = state.of(target)
            with made.edit(target, self.bl_label):
                self.change(made.detail.layers)
            view.refresh(target, made)
        except (state.Refused, rl.RelievoError) as failure:
            self.report({"ERROR"}, str(failure))
            return {"CANCELLED"}
        return {"FINISHED"}


class RELIEVO_OT_layer_add(LayerOperator, bpy.types.Operator):
    """Add a layer above the others of its kind"""

    bl_idname = "relievo.layer_add"
    bl_label = "Add layer"

    name: bpy.props.StringProperty(name="Name", default="Layer")
    kind: bpy.props.EnumProperty(name="Kind", items=settings.choices(abi.RlvLayerKind))

    def change(self, layers):
        names = {layer.name for layer in layers}
        name, number = self.name, 2
        while name in names:
            name, number = f"{self.name} {number}", number + 1
        layers.add(name, kind=self.kind.lower())


class RELIEVO_OT_layer_change(LayerOperator, bpy.types.Operator):
    """Change a layer"""

    bl_idname = "relievo.layer_change"
    bl_label = "Change layer"

    layer: bpy.props.IntProperty(name="Layer")
    action: bpy.props.EnumProperty(name="Action", items=ACTIONS)

    def change(self, layers):
        if self.action == "ACTIVATE":
            layers.set_active(self.layer)
        elif self.action == "REMOVE":
            layers.remove(self.layer)
        elif self.action == "MERGE":
            layers.merge(self.layer)
        else:
            kind = next((layer.kind for layer in layers if layer.id == self.layer), None)
            stack = [layer.id for layer in layers if layer.kind == kind]
            if self.layer in stack:
                place = stack.index(self.layer) + (1 if self.action == "UP" else -1)
                layers.place(self.layer, min(max(place, 0), len(stack) - 1))


class RELIEVO_OT_layer_set(LayerOperator, bpy.types.Operator):
    """Change how a layer is seen"""

    bl_idname = "relievo.layer_set"
    bl_label = "Layer settings"

    layer: bpy.props.IntProperty(name="Layer", options={"HIDDEN"})
    visible: bpy.props.BoolProperty(name="Visible", default=True)
    opacity: bpy.props.FloatProperty(name="Opacity", min=0, max=1, default=1, subtype="FACTOR")
    blend: bpy.props.EnumProperty(name="Blend", items=settings.choices(abi.RlvBlend))

    def invoke(self, context, _event):
        target = state.source_of(context.active_object)
        made = state.existing(target)
        for layer in made.detail.layers if made else ():
            if layer.id == self.layer:
                self.visible, self.opacity = bool(layer.is_visible), layer.opacity
                self.blend = abi.RlvBlend(layer.blend).name
        return context.window_manager.invoke_props_dialog(self)

    def change(self, layers):
        blend = self.blend.lower()
        layers.set(self.layer, is_visible=self.visible, opacity=self.opacity, blend=blend)


CLASSES = [RELIEVO_OT_layer_add, RELIEVO_OT_layer_change, RELIEVO_OT_layer_set]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
