"""The declarations say what the headers say: they are current, and a C++ compiler sees the same constants, initial
values, structs (size, offset and type of every field) and functions (every type)."""

import ast
import ctypes
import enum
import os
import re
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.append(str(ROOT / "plugins" / "python"))

import declare
from librelievo import abi, record

PROGRAM = r"""
#include <cstddef>
#include <cstdio>
#include <string>
#include <type_traits>
#include "relievo/relievo.h"

template <class T> struct Name {
    static std::string text() {
        return (std::is_floating_point_v<T> ? "f" : std::is_signed_v<T> ? "i" : "u") + std::to_string(sizeof(T));
    }
};
template <> struct Name<char> { static std::string text() { return "char"; } };
template <> struct Name<void> { static std::string text() { return "void"; } };
template <class T> struct Name<T *> { static std::string text() { return "*" + Name<std::remove_cv_t<T>>::text(); } };
template <class T, size_t N> struct Name<T[N]> {
    static std::string text() { return Name<T>::text() + "[" + std::to_string(N) + "]"; }
};
template <class R, class... A> struct Name<R(A...)> {
    static std::string text() {
        std::string list = "(";
        ((list += Name<A>::text() + ","), ...);
        return Name<R>::text() + list + ")";
    }
};
@NAMES@
template <class T> void initial(const char *name, const T &value) {
    std::printf("init %s ", name);
    const unsigned char *bytes = reinterpret_cast<const unsigned char *>(&value);
    for (size_t i = 0; i < sizeof value; ++i) std::printf("%02x", bytes[i]);
    std::printf("\n");
}
int main() {
@BODY@
}
"""


def structs():
    found = [kind for kind in vars(abi).values() if isinstance(kind, type) and issubclass(kind, ctypes.Structure)]
    return [kind for kind in found if kind is not ctypes.Structure]


def name_of(kind):
    """The name that the program gives a type."""
    if kind is None:
        return "void"
    if hasattr(kind, "target"):
        return "*" + name_of(kind.target)
    if kind in (ctypes.c_void_p, ctypes.c_char_p):
        return "*void" if kind is ctypes.c_void_p else "*char"
    if kind is ctypes.c_char:
        return "char"
    if issubclass(kind, ctypes.Structure):
        return kind.__name__
    if issubclass(kind, ctypes.Array):
        return f"{name_of(kind._type_)}[{kind._length_}]"
    if issubclass(kind, ctypes._Pointer):
        return "*" + name_of(kind._type_)
    if issubclass(kind, ctypes._CFuncPtr):
        return "*" + signature(kind._restype_, kind._argtypes_)
    letter = {"f": "f", "d": "f", "i": "i", "l": "i", "q": "i"}.get(kind._type_, "u")
    return f"{letter}{ctypes.sizeof(kind)}"


def signature(result, arguments):
    return f"{name_of(result)}({''.join(name_of(kind) + ',' for kind in arguments)})"


def expected():
    """What the program has to print, as a set of lines, and the statements that print it."""
    lines, body = [], []

    def expect(line, statement):
        lines.append(line)
        body.append(statement)

    headers = "".join(path.read_text() for path in (ROOT / "include" / "relievo").glob("*.h"))
    enumerators = set(re.findall(r"\b(RLV_\w+) = \d+", headers))
    for name, value in vars(abi).items():
        if name.startswith("RLV_"):
            expect(f"value {name} {value}", f'std::printf("value {name} %llu\\n", (unsigned long long){name});')
        elif isinstance(value, type) and issubclass(value, enum.IntEnum) and value is not enum.IntEnum:
            for entry in value:
                # An enum's names in C begin alike; the headers have each enumerator once.
                full = [n for n in enumerators if n.endswith("_" + entry.name) and belongs(n, value, entry)]
                assert len(full) == 1, (value, entry, full)
                cast = f"(unsigned long long){full[0]}"
                member = f"std::is_same_v<decltype({full[0]}), {value.__name__}>"
                expect(
                    f"value {full[0]} {entry.value} 1",
                    f'std::printf("value {full[0]} %llu %d\\n", {cast}, {member});',
                )
    for kind in structs():
        name = kind.__name__
        expect(f"size {name} {ctypes.sizeof(kind)}", f'std::printf("size {name} %zu\\n", sizeof({name}));')
        for field, of in kind._fields_:
            place = f"{name}.{field} {getattr(kind, field).offset} {name_of(of)}"
            type_name = f"Name<std::remove_cv_t<decltype({name}::{field})>>::text().c_str()"
            expect(
                f"field {place}",
                f'std::printf("field {name}.{field} %zu %s\\n", offsetof({name}, {field}), {type_name});',
            )
        if kind in abi.INIT:
            macro = "RLV" + re.sub(r"([A-Z])", r"_\1", name.removeprefix("Rlv")).upper() + "_INIT"
            data = bytes(record.empty(kind)).hex()
            expect(f"init {name} {data}", f'{{ static const {name} value = {macro}; initial("{name}", value); }}')
    for name, (result, arguments) in abi.FUNCTIONS.items():
        expect(
            f"function {name} {signature(result, [kind for _, kind in arguments])}",
            f'std::printf("function {name} %s\\n", Name<std::remove_pointer_t<decltype(&{name})>>::text().c_str());',
        )
    return lines, body


def belongs(full, kind, entry):
    """Whether a C enumerator is that of a Python one: its siblings exist with the same beginning."""
    prefix = full.removesuffix(entry.name)
    return SIBLINGS.get(kind.__name__) == prefix


def siblings():
    """What the enumerators of each enum begin with."""
    return {name: declare.common_prefix(values) for name, values in declare.Declarations().enums.items()}


SIBLINGS = siblings()


class Declarations(unittest.TestCase):
    def test_the_module_is_current(self):
        written = declare.module(declare.Declarations())
        self.assertEqual(declare.MODULE.read_text(), written, "run `python plugins/python/declare.py`")

    def test_a_compiler_sees_the_same(self):
        lines, body = expected()
        self.assertGreater(len(lines), 600)
        names = "".join(
            f'template <> struct Name<{kind.__name__}> {{ static std::string text() {{ return "{kind.__name__}"; }} }};\n'
            for kind in structs()
        )
        program = PROGRAM.replace("@NAMES@", names).replace("@BODY@", "\n".join(body))
        with tempfile.TemporaryDirectory() as folder:
            source, binary = Path(folder, "abi.cpp"), Path(folder, "abi")
            source.write_text(program)
            compiler = os.environ.get("CXX", "c++")
            flags = ["-std=c++17", "-Wno-invalid-offsetof", f"-I{ROOT / 'include'}", str(source), "-o", str(binary)]
            subprocess.run([compiler, *flags], check=True)
            printed = subprocess.run([binary], check=True, capture_output=True, text=True).stdout.splitlines()
        self.assertEqual(lines, printed)

    def test_every_header_constant_and_exported_function_is_there(self):
        headers = "".join(path.read_text() for path in (ROOT / "include" / "relievo").glob("*.h"))
        for name in re.findall(r"RLV_API [\w ]+?\*? ?(rlv_\w+)\(", headers):
            self.assertIn(name, abi.FUNCTIONS)
        listed = (ROOT / "tests" / "c" / "symbols.txt").read_text().split()
        self.assertEqual(sorted(listed), sorted(abi.FUNCTIONS))

    def test_what_the_reader_does_not_know_is_refused(self):
        declared = declare.Declarations()
        for text in ("int x;", "typedef union U { int a; } U;", "RLV_API RlvResult rlv_x(long a);"):
            with self.assertRaises(declare.Unreadable):
                declared.declarations(text)


class Coverage(unittest.TestCase):
    def test_the_package_calls_every_function(self):
        """Counting references is the affair of objects, so nobody calls _retain; releases are called by their noun."""
        called, nouns = set(), set()
        for path in (ROOT / "plugins" / "python" / "librelievo").glob("*.py"):
            if path.name == "abi.py":
                continue
            tree = ast.parse(path.read_text())
            for node in ast.walk(tree):
                if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.startswith("rlv_"):
                    called.add(node.value)
                if isinstance(node, ast.Attribute) and node.attr.startswith("rlv_"):
                    called.add(node.attr)
            nouns |= set(re.findall(r'noun, kind = "(\w+)"', path.read_text()))
        called |= {f"rlv_{noun}_release" for noun in nouns}
        wanted = {name for name in abi.FUNCTIONS if not name.endswith("_retain")} - {"rlv_last_error"}
        self.assertEqual(sorted(wanted - called), [])


if __name__ == "__main__":
    unittest.main()
