# SPDX-License-Identifier: GPL-3.0-or-later
"""Histories that are made short: the document of an object without the edits that undo would take back, which makes files smaller.
What is seen stays to the bit."""

import os
import tempfile
import uuid

import bpy
import librelievo as rl

from ..core import job, native
from ..core.error import Refused
from ..data import document, state, view


def compacting(target):
    """Steps that put a document without history in the place of an object's; they return the state, and the bytes before and
    after. The uid is another one, so that Blender's undo finds the old document."""
    before = yield from state.opening(target)
    revision, found = before.revision, []

    def work(_progress):
        data = before.data()
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "history.relievo")
            with open(path, "wb") as file:
                file.write(data.data)
            rl.document.compact(native.context(), path)
            with open(path, "rb") as file:
                found.extend([len(data.data), file.read()])

    yield 0.0, 0.3, work
    size, data = found
    made = yield from state.replacing(target, uuid.uuid4().hex, document.Document(data, [revision], 0))
    return made, size, len(data)


class RELIEVO_OT_compact(job.ConfirmedSteps, bpy.types.Operator):
    """Forget the history of the active object's detail, which makes the file smaller; what is seen stays"""

    bl_idname = "relievo.compact"
    bl_label = "Compact History"
    bl_options = {"REGISTER", "UNDO"}
    question = "Earlier states of the detail are let go, and imprints cannot be made again from their start. Undo brings them back."
    failures = (Refused, rl.RelievoError, OSError)

    @classmethod
    def poll(cls, context):
        return state.is_editable(context) and state.has_detail(state.source_of(context.active_object))

    def steps(self, context):
        target = state.source_of(context.active_object)
        made, before, after = yield from compacting(target)
        made.record(target)
        target.relievo_press.is_there = False
        yield from state.placing(made, target, context.evaluated_depsgraph_get())
        yield from view.ensuring(target, made)
        self.report({"INFO"}, f"{before / 2**20:.2f} MiB are {after / 2**20:.2f} MiB now")


def register():
    bpy.utils.register_class(RELIEVO_OT_compact)


def unregister():
    bpy.utils.unregister_class(RELIEVO_OT_compact)
