# SPDX-License-Identifier: GPL-3.0-or-later
"""The native library: what is missing if it cannot be used, and the context that all documents share."""

import importlib
import sys

# The add-on's own package, which Blender calls differently for extensions.
PACKAGE = __package__.rpartition(".")[0]

_context = None
# Returns the device and the number of threads of a context.
_options = None


def configure(options):
    """Has contexts made with the device and threads that a function returns."""
    global _options
    _options = options


def _package():
    """librelievo: the one that Blender's extensions bring as a wheel, or the folder in the add-on."""
    try:
        return importlib.import_module("librelievo")
    except ModuleNotFoundError as missing:
        if missing.name != "librelievo":
            raise
    inside = importlib.import_module(f"{PACKAGE}.librelievo")
    # The modules of the add-on import it by its own name.
    sys.modules["librelievo"] = inside
    for name, module in list(sys.modules.items()):
        if name.startswith(f"{PACKAGE}.librelievo."):
            sys.modules[name.removeprefix(f"{PACKAGE}.")] = module
    return inside


def problem():
    """Why the library cannot be used, a sentence for the user, or None."""
    try:
        _package().load()
    except ModuleNotFoundError as missing:
        if missing.name.endswith("librelievo"):
            return "The package librelievo is missing; install the add-on from its zip file, which brings it"
        return f"{missing.name} is missing, which Relievo needs"
    except ImportError as failure:
        return str(failure)
    return None


def context():
    """The context of this session, with the device and threads of the preferences."""
    global _context
    if _context is None:
        options = _options()
        # "" is a device that was chosen once and is not there any more.
        device = options.device or "AUTO"
        named = {} if device in ("CPU", "AUTO") else {"adapter": device}
        # A graphics device that was chosen by its name and is gone leaves the work to the processor.
        _context = _package().Context(device="cpu" if device == "CPU" else "auto", threads=options.threads, **named)
    return _context


def adapters():
    """The graphics devices there are; none where the library is missing."""
    return [] if problem() else _package().adapters()


def version():
    """The version of the library, such as 0.1.0."""
    return ".".join(map(str, _package().version()))


def fallback():
    """Why the processor works in place of a graphics device, or ""."""
    return _context.info.fallback if _context is not None else ""


def forget():
    """Lets the context go; objects that were made with it keep it."""
    global _context
    _context = None
