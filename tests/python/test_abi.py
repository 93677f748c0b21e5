"""The declarations say what the headers say: a C++ compiler sees the same constants, initial values, structs (size,
offset and type of every field) and functions (every type). That they are current, `cargo xtask bindings --check` tests."""

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
    if issubclass(kind, ctypes.Structure):
        return kind.__name__
    if hasattr(kind, "target"):
        return "*" + name_of(kind.target)
    if kind in (ctypes.c_void_p, ctypes.c_char_p):
        return "*void" if kind is ctypes.c_void_p else "*char"
    if kind is ctypes.c_char:
        return "char"
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

    enumerators = enumerators_of_headers()
    for name, value in vars(abi).items():
        if name.startswith("RLV_"):
            expect(f"value {name} {value}", f'std::printf("value {name} %llu\\n", (unsigned long long){name});')
        elif isinstance(value, type) and issubclass(value, enum.IntEnum) and value is not enum.IntEnum:
            full_names = enumerators[name]
            assert len(full_names) == len(value), (name, full_names)
            for full, entry in zip(full_names, value):
                assert full.endswith("_" + entry.name), (full, entry)
                same = f"std::is_same_v<decltype({full}), {name}>"
                expect(
                    f"value {full} {entry.value} 1",
                    f'std::printf("value {full} %llu %d\\n", (unsigned long long){full}, {same});',
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


def enumerators_of_headers():
    """The names of the enumerators of each enum, in the order of the headers."""
    headers = "".join(path.read_text() for path in (ROOT / "include" / "relievo").glob("*.h"))
    enums = re.findall(r"typedef enum (\w+) \{([^}]*)\}", headers)
    return {name: re.findall(r"\b(RLV_\w+) = \d+", body) for name, body in enums}


class Declarations(unittest.TestCase):
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


class Order(unittest.TestCase):
    """Names and the order of parameters are one way everywhere, as `context.h` says; exceptions have no list."""

    def test_functions_name_their_noun_and_take_parameters_in_one_order(self):
        exceptions = []
        texts = {}
        for header in (ROOT / "include" / "relievo").glob("*.h"):
            texts[header.stem] = re.sub(r"/\*.*?\*/", " ", header.read_text(), flags=re.S)
        handle = re.compile(r"struct (Rlv\w+) \{\s*uint64_t id;\s*\}")
        handles = {name for text in texts.values() for name in handle.findall(text)}
        callbacks = {name for text in texts.values() for name in re.findall(r"\(\*(Rlv\w+)\)\(void \*user", text)}
        self.assertGreater(len(handles), 30)
        found = 0
        for header, text in texts.items():
            nouns = [header] + [re.sub(r"(?<!^)([A-Z])", r"_\1", name[3:]).lower() for name in handle.findall(text)]
            for name, parameters in re.findall(r"RLV_API[^;(]*\b(rlv_\w+)\(([^;]*)\);", text):
                found += 1
                if not f"{name}_".startswith(tuple(f"rlv_{noun}_" for noun in nouns)):
                    exceptions.append(f"{name}: it names none of {nouns}")
                given = [re.fullmatch(r"(.*?)(\w+)", " ".join(one.split())).groups() for one in parameters.split(",")]
                kinds = [kind.strip() for kind, _ in given]
                names = [one for _, one in given]
                for at, (kind, one) in enumerate(zip(kinds, names)):
                    before = kinds[at - 1] if at else ""
                    if kind in handles and any(other not in handles for other in kinds[:at]):
                        exceptions.append(f"{name}: {one} is a handle behind other parameters")
                    made = kind.removesuffix("*").strip() in handles and kind.endswith("*") and not kind.startswith("const")
                    if made and (one != "out" or at + 1 < len(kinds)):
                        exceptions.append(f"{name}: {one} is a new handle, but not out at the end")
                    if one.endswith("capacity") and "*" not in before:
                        exceptions.append(f"{name}: {one} is not behind its array")
                    counts = ("count", "capacity", "stride")
                    if one.endswith("stride") and "*" not in before and not names[at - 1].endswith(counts):
                        exceptions.append(f"{name}: {one} is not behind its array or its count")
                    if one == "count" and kind == "size_t" and "*" not in before and names[at - 1] != "first":
                        exceptions.append(f"{name}: {one} is neither behind its array nor behind first")
                    if one == "user" and before not in callbacks:
                        exceptions.append(f"{name}: {one} is not behind its callback")
                    # Several callbacks in a row have one user.
                    behind = next((names[k] for k in range(at + 1, len(kinds)) if kinds[k] not in callbacks), None)
                    if kind in callbacks and behind != "user":
                        exceptions.append(f"{name}: {one} has no user behind it")
        self.assertGreater(found, 500)
        self.assertEqual(exceptions, [])

    # Fields of places that are single although hosts give them, with the reason.
    SINGLE = {"RlvIsosurfaceRay.origin": "renderers hand over their own rays, which are single, one a call"}
    PLACES = ("center", "eye", "high", "low", "origin", "place", "position", "target")

    def test_places_have_one_name_and_are_double(self):
        """A place that a host gives is double, as a field and as a parameter; an array of places is of floats, and so is what
        the library finds in such arrays: bounds, hits and pictures."""
        text = "".join(path.read_text() for path in (ROOT / "include" / "relievo").glob("*.h"))
        text = re.sub(r"/\*.*?\*/", " ", text, flags=re.S)
        structs = dict(re.findall(r"typedef struct (Rlv\w+) \{(.*?)\} \1;", text, flags=re.S))
        found = {kind: re.findall(r"(\w[\w ]*?) (\w+)(?:\[(\w+)\])?;", body) for kind, body in structs.items()}
        self.assertGreater(len(found), 150)
        given = set(re.findall(r"const (Rlv\w+) \*", text)) & set(found)
        while inner := {kind for outer in given for kind, _, _ in found[outer] if kind in found} - given:
            given |= inner
        exceptions, places, single = [], 0, set()
        for struct, fields in found.items():
            for kind, name, size in fields:
                if re.search(r"middle|centre", name):
                    exceptions.append(f"{struct}.{name}: say center")
                if name in self.PLACES and size == "3" and struct in given:
                    places += 1
                    if kind == "float":
                        single.add(f"{struct}.{name}")
                    elif kind != "double":
                        exceptions.append(f"{struct}.{name}: it is {kind}")
        for function, parameters in re.findall(r"RLV_API[^;(]*\b(rlv_\w+)\(([^;]*)\);", text):
            listed = [" ".join(one.split()) for one in parameters.split(",")]
            for at, one in enumerate(listed):
                name = one.split()[-1].lstrip("*")
                if re.search(r"middle|centre", name):
                    exceptions.append(f"{function}: {name}: say center")
                behind = listed[at + 1] if at + 1 < len(listed) else ""
                if name in self.PLACES and "*" in one and not behind.startswith("size_t"):
                    places += 1
                    if not one.startswith(("const double *", "const int32_t *")):
                        exceptions.append(f"{function}: {one}")
        self.assertGreater(places, 20)
        self.assertEqual(exceptions, [])
        self.assertEqual(sorted(single), sorted(self.SINGLE))

    def test_every_handle_is_retained_and_released(self):
        for kind in structs():
            if [name for name, *_ in kind._fields_] == ["id"]:
                noun = re.sub(r"(?<!^)([A-Z])", r"_\1", kind.__name__[3:]).lower()
                for verb in ("retain", "release"):
                    _, parameters = abi.FUNCTIONS[f"rlv_{noun}_{verb}"]
                    self.assertEqual([one for _, one in parameters], [kind], noun)


class Package(unittest.TestCase):
    """What is written by hand: every module but the declarations."""

    def modules(self):
        folder = ROOT / "plugins" / "python" / "librelievo"
        return [path for path in sorted(folder.glob("*.py")) if path.name != "abi.py"]

    def test_every_function_has_hints(self):
        self.assertTrue((ROOT / "plugins" / "python" / "librelievo" / "py.typed").exists())
        bare, count = [], 0
        for path in self.modules():
            for node in ast.walk(ast.parse(path.read_text())):
                if not isinstance(node, ast.FunctionDef):
                    continue
                count += 1
                listed = node.args.posonlyargs + node.args.args + node.args.kwonlyargs
                listed += [more for more in (node.args.vararg, node.args.kwarg) if more is not None]
                hinted = all(one.annotation is not None for one in listed if one.arg not in ("self", "cls"))
                if not hinted or node.returns is None:
                    bare.append(f"{path.name}: {node.name}")
        self.assertEqual(bare, [])
        self.assertGreater(count, 500)

    def test_texts_name_what_the_package_has(self):
        """Structs of C are those of `librelievo.abi` here."""
        for path in self.modules():
            tree = ast.parse(path.read_text())
            kinds = (ast.Module, ast.ClassDef, ast.FunctionDef)
            for text in (ast.get_docstring(node) or "" for node in ast.walk(tree) if isinstance(node, kinds)):
                for name in re.findall(r"Rlv[A-Z]\w+", text):
                    self.assertIn(f"`abi.{name}`", text, path.name)
                    self.assertTrue(hasattr(abi, name), f"{path.name}: {name}")
                self.assertNotIn("rlv_", text, path.name)


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
        wanted = {name for name in abi.FUNCTIONS if not name.endswith("_retain")} - {"rlv_error_last"}
        self.assertEqual(sorted(wanted - called), [])


if __name__ == "__main__":
    unittest.main()
