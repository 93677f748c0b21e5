"""Tests of the folders of the add-on's sources: how many files they have, and which import which."""

import ast
import unittest

import host

SOURCES = host.ROOT / "plugins" / "blender"
# From the bottom: a folder imports itself and those before it.
FOLDERS = ("core", "data", "ops", "tools", "ui")


def imports(path):
    """Yields the folders of the add-on that a file imports from, anywhere in it."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.level == 2:
            yield from [node.module.split(".")[0]] if node.module else [one.name for one in node.names]


class Folders(unittest.TestCase):
    def test_folders_import_those_below(self):
        for place, folder in enumerate(FOLDERS):
            for path in (SOURCES / folder).glob("*.py"):
                above = set(imports(path)) - set(FOLDERS[:place])
                self.assertEqual(above, set(), f"{folder}/{path.name} imports a folder that is not below its own")

    def test_all_files_are_in_these_folders(self):
        kinds = {path.parent.relative_to(SOURCES).as_posix() for path in SOURCES.rglob("*.py")}
        self.assertEqual(kinds, {".", *FOLDERS})

    def test_a_folder_has_25_files_at_most(self):
        for folder in (".", *FOLDERS):
            self.assertLessEqual(len(list((SOURCES / folder).glob("*.*"))), 25, folder)


if __name__ == "__main__":
    host.main()
