# SPDX-License-Identifier: GPL-3.0-or-later
"""Sentences of the library in words of the panels: names of settings as they are shown, what to do by the operators there are, and
no names of functions, fields or types."""

import re

import bpy

# Groups of settings that the fields of functions are in, by the noun of the functions.
GROUPS = {
    "rlv_fluid": ("RelievoFluid",),
    "rlv_isosurface": ("RelievoFluid",),
    "rlv_diffuse": ("RelievoFoamSettings",),
    "rlv_foam": ("RelievoFoamLook",),
    "rlv_tissue": ("RelievoTissueModel", "RelievoTissue"),
    "rlv_brush": ("RelievoBrushSettings", "RelievoStampSettings", "RelievoBrush"),
    "rlv_stroke": ("RelievoBrushSettings", "RelievoStampSettings", "RelievoBrush"),
    "rlv_imprint": ("RelievoImprintSettings",),
    "rlv_repair": ("RelievoRepairSettings",),
    "rlv_decal": ("RelievoDecal",),
    "rlv_detail": ("RelievoObject",),
    "rlv_level": ("RelievoHandle", "RelievoBrushSettings"),
}
# Names of the library that are no setting of a panel.
TERMS = {"cell": "Element size", "voxel": "Element size", "jitter_position": "Jitter", "level": "Coarseness"}
# Sentences in place of the library's own, which have # for each number: what happened, and what to do. {element} is the number of
# the element that the failure names, {place} where it happened.
SENTENCES = {
    "a coordinate is not a finite number": (
        "Vertex {element} of the mesh is at no finite place",
        "move it, remove it, or use Repair mesh",
    ),
    "point # is repeated": ("Face {element} of the mesh has a vertex twice", "use Repair mesh"),
    "point # does not exist": ("A face of the mesh has a vertex that is not there", "use Repair mesh"),
    "no basin goes from [#, #, #] to [#, #, #] by #": (
        "Spacing: it does not fit the domain",
        "let it be less than each side, and more than some thousandth of it",
    ),
    "a place or velocity of a particle is not finite": (
        "Velocity: it is not a finite number",
        "set it anew; else a vertex of the fill is at no finite place",
    ),
    "its height is out of range": ("Height: it is out of range", "use -60000 to 60000"),
    "voxels of [#, #, #] m cannot be": ("Element size: elements of this size cannot be", "use 1e-7 to 1e6 m"),
    "no voxel has enough samples inside": ("Element size: no element has enough of a volume inside", "make it smaller"),
    "no node is near it": (
        "{place}: no tissue is near it",
        "place it within the size of an element, its normals out of the tissue",
    ),
    "the upward direction is not finite or points along the normal": (
        "Up: it is not finite, or points out of the surface there",
        "give another direction",
    ),
    "point # is nowhere": ("A point of the stroke is at no finite place", "stay below 1e12"),
    "the collider reaches too far beyond the overlap to be voxelised": (
        "What presses reaches too far beyond what it dents",
        "cut it down, or make both closer in size",
    ),
    "the file has other triangles or vertices than the crowd model": (
        "The meshes have other faces or vertices than the crowd model",
        "use Build crowd model",
    ),
    "vertex # is no longer at the place of a vertex that it was joined to": (
        "Vertices of the meshes that were at one place are apart",
        "use Build crowd model",
    ),
    "the format of the file is not known": (
        "{place}: the file is damaged, or of another kind",
        "make it again, or choose another one",
    ),
}
# What the library says to programs, and what it comes to for artists.
SAID = [
    (re.compile(r"\brlv_repair_\w+ (?:may mend it|lists those without)"), "Repair mesh may mend it"),
    (re.compile(r"`relievo mesh repair [^`]*`(?:, or rlv_\w+)?"), "Repair mesh"),
    (re.compile(r"[;,]? ?(?:or |and )?[^;,:]*\brlv_\w+[^;,:]*"), ""),
    (re.compile(r" ?\(os error \d+\)|\[Errno -?\d+\] "), ""),
    (re.compile(r"\[((?:[-+.\w]+, )+[-+.\w]+)\]"), r"\1"),
    (re.compile(r"-?\d{10,}(?:\.\d+)?"), lambda found: f"{float(found[0]):g}"),
    (re.compile(r"\bobject units\b"), "units"),
    (re.compile(r"\bshear modulus\b"), "stiffness (its shear modulus)"),
    (re.compile(r"\b(?:NaN|nan)\b"), "no number"),
]
# What stays: names in quotes, and paths.
KEPT = re.compile(r"`[^`]*`|'[^']*'|\"[^\"]*\"|(?:[\w.~-]*/)+[\w.#-]*")
FIELD = re.compile(r"\b[a-z]+(?:_[a-z]+)+\b")
FUNCTION = re.compile(r"rlv_[a-z]+")


def code_of(sentence):
    """Returns the code of a sentence of the library, as `rlv_error_get` gives it: FNV-1a of 32 bits."""
    code = 0x811C9DC5
    for byte in sentence.encode():
        code = (code ^ byte) * 0x01000193 % 2**32
    return code


CODES = {code_of(sentence): told for sentence, told in SENTENCES.items()}


def shown(nouns, name):
    """Returns what panels call a setting of the library, or the name in words."""
    groups = [group for noun in nouns for group in GROUPS.get(noun, ())]
    kinds = {kind.__name__: kind for kind in bpy.types.PropertyGroup.__subclasses__()}
    for group in groups or [group for found in GROUPS.values() for group in found]:
        told = getattr(kinds.get(group), "__annotations__", {}).get(name)
        if told is not None and told.keywords.get("name"):
            return told.keywords["name"]
    return TERMS.get(name, name.replace("_", " "))


def plain(text, nouns=()):
    """Returns a text of the library without names of its functions, with those of settings as panels have them."""
    if text.startswith("could not convert"):
        return "a value is no number"
    made, last = [], 0
    for span in [*((found.start(), found.end()) for found in KEPT.finditer(text)), (len(text), len(text))]:
        between = text[last : span[0]]
        for pattern, to in SAID:
            between = pattern.sub(to, between)
        made += [FIELD.sub(lambda found: shown(nouns, found[0]), between), text[span[0] : span[1]]]
        last = span[1]
    return "".join(made)


def place_of(failure, nouns):
    """Returns where a failure happened, without functions: settings as panels call them, elements and names."""
    parts = []
    for part in failure.place.split(": "):
        if part and not part.startswith("rlv_"):
            is_field = re.fullmatch(r"[a-z]+(?:_[a-z]+)*", part)
            parts.append(shown(nouns, part).capitalize() if is_field else plain(part, nouns))
    # The place of a volume is said twice where both the function and the model know it.
    return ": ".join(dict.fromkeys(parts))


def sentence(failure):
    """Returns a failure of the library as a sentence: where, what, and what to do."""
    nouns = FUNCTION.findall(failure.place)
    place = place_of(failure, nouns)
    if failure.code in CODES:
        what, remedy = (text.format(element=failure.element, place=place) for text in CODES[failure.code])
        return f"{what}; {remedy}"
    told = [plain(failure.what, nouns), plain(failure.remedy, nouns)]
    return (f"{place}: " if place else "") + "; ".join(text for text in told if text)
