# SPDX-License-Identifier: GPL-3.0-or-later
"""What operators on the detail of the active object have in common."""

import librelievo as rl

from ..core import job
from ..core.error import Refused
from ..data import state


class Editing(job.Steps):
    """An operator on the detail of the active object, which it opens; the steps after that are `edit`."""

    bl_options = {"REGISTER", "UNDO"}
    failures = (Refused, rl.RelievoError, OSError)

    @classmethod
    def poll(cls, context):
        return state.is_editable(context)

    def steps(self, context):
        target = state.source_of(context.active_object)
        made = yield from state.opening(target)
        self.warn(made.take_notes())
        yield from self.edit(context, target, made)
