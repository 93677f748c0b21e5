# SPDX-License-Identifier: GPL-3.0-or-later
"""Who presses into an object: a list and a collection that the object keeps in the file, with settings of their own where they
differ from those of the scene; and what the last imprint did."""

import bpy

from ..core import settings
from ..core.error import Refused
from ..data import state

# Types of objects that have a mesh when they are evaluated.
TYPES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}


def _can_press(_group, target):
    return target.type in TYPES


class RelievoPresser(bpy.types.PropertyGroup):
    """An object that presses."""

    target: bpy.props.PointerProperty(
        name="Object", description="The object that presses", type=bpy.types.Object, poll=_can_press
    )
    is_on: bpy.props.BoolProperty(name="Presses", description="Whether it presses", default=True)
    has_own: bpy.props.BoolProperty(
        name="Own settings", description="Whether what it presses gives way by settings of its own, not by those of the scene"
    )
    settings: bpy.props.PointerProperty(type=settings.RelievoImprintSettings)


class RelievoPress(bpy.types.PropertyGroup):
    """Who presses into an object, and what the last imprint did."""

    pressers: bpy.props.CollectionProperty(type=RelievoPresser)
    active: bpy.props.IntProperty(name="Active presser", description="The presser that is shown below the list")
    collection: bpy.props.PointerProperty(
        name="Collection", description="All objects of the collection press", type=bpy.types.Collection
    )
    is_there: bpy.props.BoolProperty(description="Whether there is an imprint to go back from")
    start: bpy.props.IntProperty(description="The revision of the detail before the last imprint")
    first: bpy.props.IntProperty(description="The first frame of the last imprint")
    last: bpy.props.IntProperty(description="The last frame of the last imprint")
    report: bpy.props.StringProperty(description="What the last imprint did")


def is_listed(options):
    """Returns whether what an object keeps says who presses into it."""
    return bool(len(options.pressers)) or options.collection is not None


def selected(context, target):
    """Returns the objects that are selected to press into another one."""
    return [other for other in context.selected_objects if other.type in TYPES and is_other(other, target)]


def is_other(other, target):
    """Returns whether an object may press into another: results do not, since their objects do."""
    return state.source_of(other) == other and other != target


def of(context, target):
    """Returns the objects that press into one: the objects that it keeps, or else the selected objects."""
    if not is_listed(target.relievo_press):
        return selected(context, target)
    found, options = [], target.relievo_press
    listed = [entry.target for entry in options.pressers if entry.is_on and state.is_used(entry.target)]
    off = {entry.target for entry in options.pressers if not entry.is_on}
    collected = options.collection.all_objects if options.collection is not None else ()
    for other in [*listed, *(one for one in collected if one not in off)]:
        if other.type in TYPES and is_other(other, target) and other not in found:
            found.append(other)
    return found


def settings_of(context, target, other):
    """Returns the settings by which an object gives way to another one."""
    for entry in target.relievo_press.pressers:
        if entry.target == other and entry.has_own:
            return settings.values(entry.settings)
    return settings.values(context.scene.relievo.imprint)


def check(context, target):
    """Returns the objects that press into one, or raises Refused where no object presses."""
    found = of(context, target)
    if not found and is_listed(target.relievo_press):
        raise Refused(f"Nothing in the list of {target.name} presses: switch one on, or empty the list and the collection")
    if not found:
        raise Refused("Select the objects that press, then the one that they dent as the last; or add them to its list")
    return found


class OnPress:
    """An operator on the list of the active object."""

    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return state.is_editable(context)


class RELIEVO_OT_press_add(OnPress, bpy.types.Operator):
    """Add the other selected objects to the pressers of the active one, which the file keeps"""

    bl_idname = "relievo.press_add"
    bl_label = "Add Selected Pressers"

    def execute(self, context):
        target = state.source_of(context.active_object)
        options, found = target.relievo_press, selected(context, target)
        there = {entry.target for entry in options.pressers}
        if not found:
            self.report({"ERROR"}, "Select the objects that press, then the one that they dent as the last")
            return {"CANCELLED"}
        for other in found:
            if other not in there:
                options.pressers.add().target = other
        options.active = len(options.pressers) - 1
        return {"FINISHED"}


class RELIEVO_OT_press_remove(OnPress, bpy.types.Operator):
    """Remove the active entry of the list of what presses"""

    bl_idname = "relievo.press_remove"
    bl_label = "Remove Presser"

    @classmethod
    def poll(cls, context):
        if not state.is_editable(context):
            return False
        options = state.source_of(context.active_object).relievo_press
        return 0 <= options.active < len(options.pressers)

    def execute(self, context):
        options = state.source_of(context.active_object).relievo_press
        options.pressers.remove(options.active)
        options.active = max(0, min(options.active, len(options.pressers) - 1))
        return {"FINISHED"}


CLASSES = [RelievoPresser, RelievoPress, RELIEVO_OT_press_add, RELIEVO_OT_press_remove]


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.types.Object.relievo_press = bpy.props.PointerProperty(type=RelievoPress)


def unregister():
    del bpy.types.Object.relievo_press
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
