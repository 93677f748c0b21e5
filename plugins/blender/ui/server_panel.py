# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel of the server that simulates fluids: where it is, and whether it answers."""

import bpy

from ..core import preferences
from ..ops import fluid
from .panel import Panel


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


CLASSES = [RELIEVO_PT_server]

register, unregister = bpy.utils.register_classes_factory(CLASSES)
