# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel of the server that simulates fluids: where it is, and whether it answers."""

import bpy
import librelievo as rl

from . import fluid, job, preferences, remote
from .error import Refused
from .panel import Panel


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


class RELIEVO_PT_server(Panel, bpy.types.Panel):
    bl_label = "Server"
    bl_parent_id = "RELIEVO_PT_fluid"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        active = context.active_object
        return active is not None and fluid.OnDomain.poll(context) and active.relievo.fluid.place == "SERVER"

    def draw(self, _context):
        options, column = preferences.get(), self.column()
        for name in ("server", "token_file", "tls_authority"):
            column.prop(options, name)
        column.operator("relievo.server_check")


CLASSES = [RELIEVO_OT_server_check, RELIEVO_PT_server]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
