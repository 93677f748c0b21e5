"""Writes librelievo/abi.py, the ctypes declarations of the C ABI, from the headers in include/relievo.

It reads the C that the headers are written in and nothing else: whatever it does not know is an error that shows the
text. `python declare.py` writes the module; tests/python/test_abi.py fails where it is not current, and holds it
against what a C++ compiler makes of the headers.
"""

import re
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
HEADERS = HERE.parents[1] / "include" / "relievo"
MODULE = HERE / "librelievo" / "abi.py"

NUMBERS = {
    "float": "c_float",
    "double": "c_double",
    "uint8_t": "c_uint8",
    "uint32_t": "c_uint32",
    "uint64_t": "c_uint64",
    "int32_t": "c_int32",
    "size_t": "c_size_t",
}
# Pointers to numbers take addresses, as NumPy gives them, and remember what they point to.
POINTERS = {"void": "c_void_p"} | {name: f"{python}_p" for name, python in NUMBERS.items()}

HEAD = '''"""The C ABI of Relievo as ctypes sees it: constants, enumerations, structs and functions, named as in the headers.

Written by declare.py from include/relievo; do not edit. `INIT` holds what the RLV_..._INIT of a struct hold.
"""

import ctypes
from ctypes import POINTER, Structure, c_char, c_char_p, c_void_p
from ctypes import c_double, c_float, c_int32, c_size_t, c_uint8, c_uint32, c_uint64
from enum import IntEnum

'''


class Unreadable(Exception):
    """A piece of a header that this reader does not know."""


def without_comments(text):
    """The text without comments and line continuations."""
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.S)
    if "//" in text:
        raise Unreadable("a // comment")
    return text.replace("\\\n", " ")


class Declarations:
    """What the headers declare, in their order."""

    def __init__(self, folder=HEADERS):
        self.constants, self.enums, self.structs = {}, {}, {}
        self.callbacks, self.functions, self.inits = {}, {}, {}
        self.aliases = {}
        read = set()
        self.order = []

        def include(name):
            if name in read:
                return
            read.add(name)
            text = without_comments((folder / name).read_text(encoding="utf-8"))
            for inner in re.findall(r'#include "relievo/(\w+\.h)"', text):
                include(inner)
            try:
                self.directives(text)
                self.declarations(text)
            except Unreadable as error:
                raise Unreadable(f"{name}: {error}") from None

        include("relievo.h")
        unread = {path.name for path in folder.glob("*.h")} - read
        if unread:
            raise Unreadable(f"relievo.h does not include {sorted(unread)}")

    def directives(self, text):
        for line in re.findall(r"^[ \t]*#[ \t]*(.*)$", text, flags=re.M):
            define = re.fullmatch(r"define\s+(RLV_\w+)(\([^)]*\))?\s*(.*)", line.strip())
            if not define or define[2] or define[1] in ("RLV_EXTERN_C", "RLV_API") or not define[3]:
                continue
            name, value = define[1], define[3].strip()
            if name.endswith("_H") or name == "RLV_VERSION" or name == "RLV_NULL":
                continue
            if name.endswith("_INIT"):
                self.inits[name] = value
            elif number := re.fullmatch(r"(0x[0-9a-fA-F]+|\d+)u?", value):
                self.constants[name] = int(number[1], 0)
            else:
                raise Unreadable(f"#define {name} {value}")

    def declarations(self, text):
        text = re.sub(r"^[ \t]*#.*$", " ", text, flags=re.M)
        text = " ".join(text.split())
        while text:
            for pattern, read in (
                (r"typedef enum (\w+) \{([^}]*)\} (\w+); ?", self.enum),
                (r"enum \{([^}]*)\}; ?", self.bare_enum),
                (r"typedef struct (\w+) \{([^}]*)\} (\w+); ?", self.struct),
                (r"typedef (\w+) \(\*(\w+)\)\(([^)]*)\); ?", self.callback),
                (r"typedef (\w+) (\w+); ?", self.alias),
                (r"RLV_API ([\w ]+?\*?) ?(rlv_\w+)\(([^)]*)\); ?", self.function),
            ):
                found = re.match(pattern, text)
                if found:
                    read(*found.groups())
                    text = text[found.end() :]
                    break
            else:
                raise Unreadable(text[:80])

    def values(self, body):
        values = {}
        for entry in filter(None, (entry.strip() for entry in body.split(","))):
            found = re.fullmatch(r"(RLV_\w+) = (\d+)", entry)
            if not found:
                raise Unreadable(entry)
            values[found[1]] = int(found[2])
        return values

    def enum(self, name, body, again):
        if name != again:
            raise Unreadable(f"typedef enum {name} ... {again}")
        self.enums[name] = self.values(body)

    def bare_enum(self, body):
        self.constants.update(self.values(body))

    def alias(self, old, new):
        if old not in NUMBERS:
            raise Unreadable(f"typedef {old} {new}")
        self.aliases[new] = NUMBERS[old]
        self.order.append(("alias", new))

    def struct(self, name, body, again):
        if name != again:
            raise Unreadable(f"typedef struct {name} ... {again}")
        fields = []
        for entry in filter(None, (entry.strip() for entry in body.split(";"))):
            found = re.fullmatch(r"((?:const )?\w+ \**)(\w+)(?:\[(\w+)\])?", entry)
            if not found:
                raise Unreadable(f"{name}: {entry}")
            kind = self.type(found[1])
            if found[3]:
                kind = f"{kind} * {found[3]}"
            fields.append((found[2], kind))
        self.structs[name] = fields
        self.order.append(("struct", name))

    def type(self, text):
        """The ctypes type of `const float *`, or of whatever else stands before a name."""
        words = text.replace("*", " * ").split()
        words = [word for word in words if word != "const"]
        base, stars = words[0], words[1:]
        if any(star != "*" for star in stars):
            raise Unreadable(text)
        known = {**NUMBERS, "char": "c_char", **{name: name for name in (*self.aliases, *self.structs, *self.callbacks)}}
        if not stars:
            if base in known:
                return known[base]
        elif base == "char" and len(stars) == 1:
            return "c_char_p"
        elif base in POINTERS and len(stars) == 1:
            return POINTERS[base]
        elif base in self.structs:
            return "POINTER(" * len(stars) + base + ")" * len(stars)
        raise Unreadable(f"the type {text}")

    def arguments(self, text):
        if text == "void":
            return []
        arguments = []
        for entry in text.split(","):
            found = re.fullmatch(r"((?:const )?\w+ \**)(\w+)", entry.strip())
            if not found:
                raise Unreadable(f"the argument {entry}")
            arguments.append((found[2], self.type(found[1])))
        return arguments

    def callback(self, result, name, arguments):
        kind = "None" if result == "void" else self.type(result)
        self.callbacks[name] = (kind, self.arguments(arguments))
        self.order.append(("callback", name))

    def function(self, result, name, arguments):
        self.functions[name] = (self.type(result), self.arguments(arguments))

    def initial(self, macro, text):
        """What an initialiser holds, as Python."""
        enumerated = {name: value for values in self.enums.values() for name, value in values.items()}
        text = re.sub(r"sizeof\((\w+)\)", r"ctypes.sizeof(\1)", text)
        text = re.sub(r"\bNULL\b", "None", text)
        text = re.sub(r"(\d\.\d+)f\b", r"\1", text)
        text = re.sub(r"\{", "(", text)
        text = re.sub(r"\}", ",)", text)

        def named(found):
            name = found[0]
            if name not in enumerated and name not in self.constants:
                raise Unreadable(f"{macro}: {name}")
            return str(enumerated.get(name, self.constants.get(name)))

        text = re.sub(r"\bRLV_\w+", named, text)
        # What remains are numbers, None, brackets and the sizes of structs.
        if re.sub(r"ctypes\.sizeof\(Rlv\w+\)|None|[-\d.,() ]", "", text):
            raise Unreadable(f"{macro}: {text}")
        return " ".join(text.split())


def common_prefix(names):
    """What the enumerators of an enum begin with, up to an underscore."""
    first, last = min(names), max(names)
    same = next((i for i, (a, b) in enumerate(zip(first, last)) if a != b), min(len(first), len(last)))
    return first[: first[:same].rfind("_") + 1]


def module(declared):
    """The text of the module."""
    lines = [HEAD]
    lines += [f"{name} = {value}\n" for name, value in declared.constants.items()]
    for name, values in declared.enums.items():
        prefix = common_prefix(values)
        lines.append(f"\n\nclass {name}(IntEnum):\n")
        lines += [f"    {entry.removeprefix(prefix)} = {value}\n" for entry, value in values.items()]
    for python in NUMBERS.values():
        lines.append(f"\n\nclass {python}_p(c_void_p):\n    target = {python}\n")
    lines.append("\n")
    for sort, name in declared.order:
        if sort == "alias":
            lines.append(f"\n{name} = {declared.aliases[name]}\n")
        elif sort == "callback":
            result, arguments = declared.callbacks[name]
            kinds = ", ".join([result, *(kind for _, kind in arguments)])
            lines.append(f"\n{name} = ctypes.CFUNCTYPE({kinds})\n")
        else:
            lines.append(f"\n\nclass {name}(Structure):\n    _fields_ = [\n")
            lines += [f'        ("{field}", {kind}),\n' for field, kind in declared.structs[name]]
            lines.append("    ]\n\n")
    lines.append("\nINIT = {\n")
    for macro, text in declared.inits.items():
        # The struct is the one whose size the initialiser begins with, or else the one of that name.
        found = re.match(r"\{sizeof\((\w+)\)", text)
        key = found[1] if found else struct_of(macro, declared.structs)
        lines.append(f"    {key}: {declared.initial(macro, text)},\n")
    lines.append("}\n\n# Every function: what it returns, and the names and types of what it takes.\nFUNCTIONS = {\n")
    for name, (result, arguments) in declared.functions.items():
        pairs = ", ".join(f'("{argument}", {kind})' for argument, kind in arguments)
        lines.append(f'    "{name}": ({result}, [{pairs}]),\n')
    lines.append("}\n")
    return re.sub(r"\n{4,}", "\n\n\n", "".join(lines))


def struct_of(macro, structs):
    """The struct that RLV_BRUSH_SETTINGS_INIT is of."""
    plain = macro.removeprefix("RLV_").removesuffix("_INIT").replace("_", "").lower()
    for name in structs:
        if name.removeprefix("Rlv").lower() == plain:
            return name
    raise Unreadable(macro)


if __name__ == "__main__":
    try:
        MODULE.write_text(module(Declarations()), encoding="utf-8")
    except Unreadable as error:
        sys.exit(f"cannot read the headers: {error}")
