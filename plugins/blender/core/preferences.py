# SPDX-License-Identifier: GPL-3.0-or-later
"""Preferences: device, threads, and where baked caches go."""

import zlib
from types import SimpleNamespace

import bpy

from . import native


def _anew(_self, _context):
    native.forget()


# Blender shows the texts of such a list only as long as somebody else keeps them.
_devices = []


def _offered(_self, _context):
    """The processor, the best there is, and every graphics device by its name, whose number does not depend on others."""
    if not _devices:
        _devices.append(("CPU", "CPU", "The processor", 0))
        _devices.append(("AUTO", "Automatic", "The best graphics device, or else the processor", 1))
        for adapter in native.adapters():
            number = 2 + zlib.crc32(adapter.name.encode()) % (1 << 30)
            if all(known[3] != number for known in _devices):
                _devices.append((adapter.name, adapter.name, f"{adapter.backend}, {adapter.driver}", number))
    return _devices


class RelievoPreferences(bpy.types.AddonPreferences):
    bl_idname = native.PACKAGE

    device: bpy.props.EnumProperty(
        name="Device",
        description="What computes",
        items=_offered,
        default=0,
        update=_anew,
    )
    threads: bpy.props.IntProperty(
        name="Threads", description="Threads that work, 0 for one per core", min=0, max=1024, default=0, update=_anew
    )
    cache_folder: bpy.props.StringProperty(
        name="Cache folder",
        description="Where baked caches and images go; // is the folder of the .blend file",
        subtype="DIR_PATH",
        default="//relievo_cache",
    )
    server: bpy.props.StringProperty(
        name="Server",
        description="Where `relievo server run` listens: host:port, tls://host:port or unix:/path",
        default="127.0.0.1:7350",
    )
    token_file: bpy.props.StringProperty(
        name="Token file", description="A file with your token, where the server wants one", subtype="FILE_PATH"
    )
    tls_authority: bpy.props.StringProperty(
        name="Authority of TLS",
        description="A file with the certificates, in PEM, that the certificate of a server at tls:// is checked against",
        subtype="FILE_PATH",
    )

    command: bpy.props.StringProperty(
        name="Command", description="The command `relievo`, which submits jobs to render farms", default="relievo"
    )

    def draw(self, _context):
        problem = native.problem()
        if problem:
            self.layout.label(text=problem, icon="ERROR")
        for name in ("device", "threads", "cache_folder", "server", "token_file", "tls_authority", "command"):
            self.layout.prop(self, name)
        fallback = native.fallback()
        if fallback:
            self.layout.label(text=f"The processor works: {fallback}", icon="INFO")
        row = self.layout.row()
        row.operator("relievo.manual", icon="HELP")
        row.operator("relievo.report", icon="URL")


DEFAULTS = SimpleNamespace(device="CPU", threads=0, cache_folder="//relievo_cache", command="relievo")


def get():
    """The preferences, or their defaults where the add-on was not enabled by Blender."""
    addon = bpy.context.preferences.addons.get(native.PACKAGE)
    return addon.preferences if addon and addon.preferences else DEFAULTS


def register():
    native.configure(get)
    bpy.utils.register_class(RelievoPreferences)


def unregister():
    bpy.utils.unregister_class(RelievoPreferences)
