"""Runs test files one after the other in one process of a host, whose start takes longer than most of them, and says the
seconds of each: `python tests/blender/suite.py -- test_addon.py test_files.py`, or `blender --background --python
tests/blender/suite.py -- ...`."""

import importlib
import sys
import time
import unittest
from pathlib import Path

sys.path.append(str(Path(__file__).resolve().parent))

import host


def run():
    """Runs the files that the arguments name, each with a result of its own."""
    seconds, failed = {}, []
    for file in host.arguments():
        start = time.perf_counter()
        print(f"\n{file}", file=sys.stderr, flush=True)
        tests = unittest.defaultTestLoader.loadTestsFromModule(importlib.import_module(Path(file).stem))
        outcome = unittest.TextTestRunner().run(tests)
        if not outcome.wasSuccessful() or not outcome.testsRun:
            failed.append(file)
        seconds[file] = time.perf_counter() - start
    print("\n" + "\n".join(f"{file:<20} {length:6.1f} s" for file, length in seconds.items()))
    print(f"failed: {', '.join(failed)}" if failed else "all passed")
    host.end(bool(seconds) and not failed)


run()
