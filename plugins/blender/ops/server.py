# SPDX-License-Identifier: GPL-3.0-or-later
"""The check whether the server that simulates fluids answers."""

import bpy
import librelievo as rl

from ..core import job, preferences
from ..core.error import Refused
from ..data import remote


class RELIEVO_OT_server_check(job.Steps, bpy.types.Operator):
    """Ask the server that the preferences name whether it answers and takes the token"""

    bl_idname = "relievo.server_check"
    bl_label = "Check Server"
    bl_options = {"REGISTER"}
    failures = (Refused, rl.RelievoError, OSError, ValueError)

    def steps(self, _context):
        address, link = preferences.get().server, remote.linking()
        yield 0.0, 1.0, lambda _progress: link().close()
        self.report({"INFO"}, f"{address} answers")


CLASSES = [RELIEVO_OT_server_check]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
