# SPDX-License-Identifier: GPL-3.0-or-later
"""Removal of bakes that nothing in the .blend file plays any more. A bake never writes over another one, since undo may
bring the earlier one back, so the cache folder grows until they are removed."""

import os

import bpy

from ..core import job, preferences
from ..core.error import Refused, said
from ..data import cache, frames


def used():
    """Returns the names of the bakes that objects play and images show."""
    paths = [path for _target, path in cache.played()]
    paths += [cache.attached(target) for target in bpy.data.objects]
    paths += [image.filepath for image in bpy.data.images]
    return {cache.bake_of(os.path.basename(os.path.normpath(path))) for path in paths if path}


def found():
    """Returns the paths of unused bakes of this .blend file. Raises Refused where it has not been saved."""
    if not bpy.data.filepath:
        raise Refused("Save the .blend file first: bakes of files without a name may be those of another session")
    folder, wanted = bpy.path.abspath(preferences.get().cache_folder), used()
    names = sorted(os.listdir(folder)) if os.path.isdir(folder) else []
    ours = [name for name in names if (cache.parts(name) or ("",))[0] == cache.file_name()]
    return [os.path.join(folder, name) for name in ours if cache.bake_of(name) not in wanted]


class RELIEVO_OT_cache_clean(bpy.types.Operator):
    """Remove the files of bakes that nothing in this .blend file plays any more"""

    bl_idname = "relievo.cache_clean"
    bl_label = "Remove unused bakes"
    bl_options = {"REGISTER"}

    def invoke(self, context, event):
        try:
            count = len(found())
        except (Refused, OSError) as failure:
            self.report({"ERROR"}, said(failure))
            return {"CANCELLED"}
        text = f"{count} files and folders are removed. Undo and older copies of this .blend file may play them."
        return job.ask(self, context, event, text)

    def execute(self, _context):
        try:
            paths = found()
            for path in paths:
                if os.path.isdir(path):
                    frames.clear(path)
                else:
                    os.remove(path)
        except (Refused, OSError) as failure:
            self.report({"ERROR"}, said(failure))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{len(paths)} files and folders were removed")
        return {"FINISHED"}


def register():
    bpy.utils.register_class(RELIEVO_OT_cache_clean)


def unregister():
    bpy.utils.unregister_class(RELIEVO_OT_cache_clean)
