"""The shared library: where it is looked for, what is wrong if it cannot be used, and calls of its functions.

It is the file that the environment variable RELIEVO_LIBRARY names, or else the one in this folder, where a wheel has it,
or else the one that the system knows by its SONAME. It is loaded at the first call, with symbols of its own.
"""

from __future__ import annotations

import ctypes
import operator
import os
import platform
import re
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any

from . import abi, error, record

if TYPE_CHECKING:
    from .error import LibraryMissing

SONAME = f"librelievo.so.{abi.RLV_VERSION_MAJOR}.{abi.RLV_VERSION_MINOR}"
HERE = Path(__file__).resolve().parent

_lock = threading.Lock()
_loaded = None


def candidates() -> list[str]:
    """Files and names to load, in order."""
    named = os.environ.get("RELIEVO_LIBRARY")
    if named:
        return [named]
    inside = HERE / SONAME
    return [str(inside)] if inside.exists() else [SONAME]


def explain(name: str, problem: Any) -> tuple[str, str]:
    """What the dynamic linker's complaint means to a user, and what to do."""
    problem = str(problem)
    if found := re.search(r"version [`'](GLIBC(?:XX)?_[\d.]+)' not found", problem):
        have = " ".join(platform.libc_ver()).strip() or "another"
        return (
            f"Relievo needs {found[1].replace('_', ' ')} or newer, and this system has {have}",
            "use a system as new as Debian 12, Ubuntu 22.10 or Fedora 37",
        )
    if found := re.search(r"(lib[\w+.-]+?\.so[\w.]*): cannot open shared object file", problem):
        missing = found[1]
        if missing == SONAME or name.endswith(missing):
            return (
                f"the Relievo library {name} is not there",
                "install the wheel for this system, or set RELIEVO_LIBRARY to the file of the library",
            )
        known = {"libtbb": "oneTBB (Debian: libtbb12)", "libstdc++": "the C++ library (Debian: libstdc++6)"}
        what = next((text for start, text in known.items() if missing.startswith(start)), missing)
        return f"Relievo needs {what}, and {missing} is not there", "install it, or install the wheel, which brings it"
    if "wrong ELF class" in problem or "invalid ELF header" in problem or "Exec format" in problem:
        return f"{name} is no library for this machine ({platform.machine()})", "install the build for this machine"
    return f"the Relievo library cannot be loaded: {problem}", "install the wheel for this system anew"


def missing(what: Any, remedy: Any, place: str = "") -> error.LibraryMissing:
    """The exception for a library that cannot be used."""
    where = f"{place}: " if place else ""
    return error.LibraryMissing(f"{where}{what}; {remedy}", what, place, remedy, abi.RLV_ERROR_NOT_FOUND)


def checked(kind: Any) -> Any:
    """A type of integers for arguments that refuses numbers that do not fit, where ctypes would cut them off."""
    low, high = record.limits(kind)
    convert = kind.from_param

    class Integer(kind):
        @classmethod
        def from_param(cls, value: Any) -> Any:
            if not low <= operator.index(value) <= high:
                raise ValueError("it does not fit")
            return convert(value)

    return Integer


# Types of integers of C and what stands for them in the types of functions.
CHECKED = {kind: checked(kind) for kind in (ctypes.c_uint32, ctypes.c_uint64, ctypes.c_int64, ctypes.c_size_t)}


def declare(library: Any) -> None:
    """Gives every function its types. A function that is not there is an old or foreign library."""
    for name, (result, arguments) in abi.FUNCTIONS.items():
        try:
            function = getattr(library, name)
        except AttributeError:
            raise missing(f"the library lacks {name}", "install library and package of one version") from None
        function.restype = result
        # Strides are the package's own.
        function.argtypes = [kind if place.endswith("stride") else CHECKED.get(kind, kind) for place, kind in arguments]


def load() -> Any:
    """The library, loaded at the first call."""
    global _loaded
    with _lock:
        if _loaded is None:
            _loaded = open_library()
        return _loaded


def open_library() -> Any:
    for name in candidates():
        try:
            library = ctypes.CDLL(name)
        except OSError as problem:
            raise missing(*explain(name, problem)) from None
        if not hasattr(library, "rlv_version"):
            raise missing(f"{name} is not the Relievo library", "set RELIEVO_LIBRARY to the right file")
        library.rlv_version.restype = ctypes.c_uint32
        version = library.rlv_version()
        found = (version >> 22, version >> 12 & 0x3FF, version & 0xFFF)
        wanted = (abi.RLV_VERSION_MAJOR, abi.RLV_VERSION_MINOR)
        if found[:2] != wanted:
            have, need = ".".join(map(str, found)), ".".join(map(str, wanted))
            raise missing(f"the library is version {have}, this package is for {need}", f"install version {need}", name)
        declare(library)
        use_own_libraries(Path(name).resolve().parent)
        return library
    raise missing("there is no library to load", "install the wheel for this system")


def use_own_libraries(folder: Any) -> None:
    """Names the OpenMesh of the wheel and the Embree of `librelievo-embree`, so that the library opens them and not those of the
    system. Where they are not installed, the library looks for others itself."""
    own = {"RELIEVO_OPENMESH": folder / "libOpenMeshCore-relievo.so"}
    try:
        import librelievo_embree
    except ImportError:
        pass
    else:
        own["RELIEVO_EMBREE"] = librelievo_embree.FILE
    for variable, file in own.items():
        if file.exists() and not os.environ.get(variable):
            os.environ[variable] = str(file)


def version() -> tuple[int, int, int]:
    """The version of the library that is loaded: three numbers."""
    number = load().rlv_version()
    return number >> 22, number >> 12 & 0x3FF, number & 0xFFF


def refusal(name: str, problem: Any, arguments: Any) -> str:
    """What ctypes' complaint about an argument of a function means to a user."""
    found = re.match(r"argument (\d+): \w+: (?:expected Rlv(\w+) instance instead of (\w+))?", problem)
    if found is None:
        return problem
    at = int(found[1]) - 1
    place, kind = abi.FUNCTIONS[name][1][at]
    if found[2] is not None:
        return f"{place}: an object of the kind {found[2]} is needed, not {found[3].removeprefix('Rlv')}"
    if kind in CHECKED:
        low, high = record.limits(kind)
        return f"{place}: a whole number from {low} to {high} is needed, not {error.shown(arguments[at])}"
    if kind in (ctypes.c_float, ctypes.c_double):
        return f"{place}: a number is needed, not {error.shown(arguments[at])}"
    return f"{place}: this cannot be used here: {problem[found.end() :]}"


def call(name: str, *arguments: Any) -> None:
    """Calls a function that returns `abi.RlvResult`; a failure is an exception."""
    library = _loaded or load()
    try:
        result = getattr(library, name)(*arguments)
    except ctypes.ArgumentError as problem:
        raise error.Invalid(refusal(name, str(problem), arguments)) from None
    if result != abi.RLV_OK:
        raise error.last(library, result)
