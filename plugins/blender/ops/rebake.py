# SPDX-License-Identifier: GPL-3.0-or-later
"""Imprints that are made again: an object knows its state before the last imprint, goes back to it, and is dented anew. What was
done to it since goes too; undo brings all of it back."""

import json

import bpy
import librelievo as rl

from ..core import job
from ..core.error import Refused
from ..data import playback, state, view
from . import imprint


def going_back(target):
    """Steps that bring the state of an object to what it was before its last imprint; they return it."""
    options = target.relievo_press
    made = yield from state.opening(target)
    if not options.is_there:
        raise Refused(f"{target.name} has no imprint; make one first")
    came = []
    yield 0.9, 1.0, lambda _progress: came.append(made.follow(options.start))
    if not came[0]:
        options.is_there = False
        raise Refused(f"The history of {target.name} does not reach back to before its imprint; undo, or clear the detail")
    return made


def drop_strokes(target, made):
    """Has an object forget the strokes that its state does not have any more. Returns how many those are."""
    entries, kept = target.relievo.strokes, set(made.revisions[: made.position + 1])
    gone = [number for number, entry in enumerate(entries) if json.loads(entry.text).get("revision") not in kept]
    for number in reversed(gone):
        entries.remove(number)
    return len(gone)


def warning(gone):
    """Returns what the user reads of strokes that went, nothing where no stroke went."""
    return [f"{gone} strokes since the imprint are gone too; undo brings them back"] if gone else []


def is_bakeable(context):
    """Whether the active object has an imprint to go back from."""
    return state.is_editable(context) and state.source_of(context.active_object).relievo_press.is_there


class RELIEVO_OT_imprint_reset(job.Steps, bpy.types.Operator):
    """Bring the active object back to what it was before its last imprint. Undo brings the imprint back"""

    bl_idname = "relievo.imprint_reset"
    bl_label = "Reset Imprint"
    bl_options = {"REGISTER", "UNDO"}
    failures = (Refused, rl.RelievoError, OSError)

    @classmethod
    def poll(cls, context):
        return is_bakeable(context)

    def steps(self, context):
        target = state.source_of(context.active_object)
        made = yield from going_back(target)
        playback.pause(target)
        made.record(target)
        self.warn(warning(drop_strokes(target, made)))
        target.relievo_press.is_there, target.relievo_press.report = False, ""
        yield from view.ensuring(target, made)


class RELIEVO_OT_imprint_again(imprint.Imprint, bpy.types.Operator):
    """Go back to before the last imprint of the active object, and make it again as settings and animation are now"""

    bl_idname = "relievo.imprint_again"
    bl_label = "Imprint Again"

    @classmethod
    def poll(cls, context):
        return is_bakeable(context)

    def opening(self, target):
        return going_back(target)

    def steps(self, context):
        target = state.source_of(context.active_object)
        try:
            yield from imprint.Imprint.steps(self, context)
        except BaseException:
            # Back to what the object has, though the history may have been cut where the imprint began.
            job.run(view.ensuring(target, job.run(state.opening(target))))
            raise
        self.warn(warning(drop_strokes(target, state.existing(target))))


CLASSES = [RELIEVO_OT_imprint_reset, RELIEVO_OT_imprint_again]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
