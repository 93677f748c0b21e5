"""Installing the add-on from its zip file as a user does, and what it says where the library is not there."""

import os
import sys
import unittest
from pathlib import Path

import bpy

sys.path.append(str(Path(__file__).resolve().parent))

import host

INSTALL = r"""
import sys
sys.path.append({tests!r})
import bpy
zip_file, is_extension = {zip!r}, {extension}
if is_extension:
    repository = next(repo for repo in bpy.context.preferences.extensions.repos if repo.module == "user_default")
    bpy.ops.extensions.package_install_files(filepath=zip_file, repo="user_default", enable_on_install=True)
    module = "bl_ext.user_default.relievo"
else:
    bpy.ops.preferences.addon_install(filepath=zip_file)
    bpy.ops.preferences.addon_enable(module="relievo")
    module = "relievo"
assert module in bpy.context.preferences.addons, list(bpy.context.preferences.addons.keys())
import host
bpy.context.preferences.addons[module].preferences.threads = 1
field = host.field()
print("drawn", host.draw(field, [[0, 0, 0], [0.2, 0, 0]]), float(host.positions(field.relievo.result)[:, 2].max()) > 0.05)
import librelievo
print("library", librelievo.library.HERE)
"""

ENABLE = r"""
import bpy
bpy.ops.preferences.addon_enable(module="relievo")
print("panel", hasattr(bpy.types, "RELIEVO_PT_missing"), hasattr(bpy.types, "RELIEVO_PT_surface"))
bpy.ops.preferences.addon_disable(module="relievo")
"""


class Installing(unittest.TestCase):
    def test_the_zip_file_installs_and_works(self):
        extension = bpy.app.version >= (4, 2)
        zip_file = os.environ["RELIEVO_EXTENSION" if extension else "RELIEVO_ADDON"]
        with host.folder() as folder:
            code = INSTALL.format(tests=str(Path(__file__).resolve().parent), zip=zip_file, extension=extension)
            places = {
                "BLENDER_USER_RESOURCES": folder,
                "BLENDER_USER_SCRIPTS": os.path.join(folder, "scripts"),
                "BLENDER_USER_CONFIG": os.path.join(folder, "config"),
                "BLENDER_USER_EXTENSIONS": os.path.join(folder, "extensions"),
            }
            for name in places.values():
                os.makedirs(name, exist_ok=True)
            os.makedirs(os.path.join(folder, "scripts", "addons"), exist_ok=True)
            said = host.run(code, **places)
            self.assertIn("drawn {'FINISHED'} True", said)
            self.assertIn(f"library {os.path.realpath(folder)}", said)
            self.assertNotIn("Traceback", said)

    def test_a_missing_library_is_told_by_a_panel_and_no_traceback(self):
        with host.folder() as folder:
            for library in (os.path.join(folder, "none.so"), "libm.so.6"):
                said = host.run(ENABLE, RELIEVO_LIBRARY=library)
                self.assertIn("Relievo cannot be used:", said)
                self.assertIn("panel True False", said)
                self.assertNotIn("Traceback", said)


if __name__ == "__main__":
    host.main()
