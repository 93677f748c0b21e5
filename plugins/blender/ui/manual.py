# SPDX-License-Identifier: GPL-3.0-or-later
"""Documentation and reports: the manual that the add-on brings, opened at the part of an operator or setting, and what a report of
a problem should say. Both need no network."""

import html
import os
import platform
import re
import tempfile
import webbrowser
from pathlib import Path

import bpy

from ..core import native
from ..core.error import said

# The manual's Markdown and pictures, beside this file.
SOURCE = Path(__file__).resolve().parents[1] / "manual" / "blender.md"
# Parts of the manual by the names of operators and settings that begin so, most particular ones first.
PARTS = [
    ("bpy.ops.relievo.layer*", "layers"),
    ("bpy.ops.relievo.imprint*", "imprint"),
    ("bpy.ops.relievo.preview*", "imprint"),
    ("bpy.ops.relievo.result*", "results"),
    ("bpy.ops.relievo.export*", "results"),
    ("bpy.ops.relievo.levels*", "levels"),
    ("bpy.ops.relievo.repair*", "repair"),
    ("bpy.ops.relievo.decal*", "decals"),
    ("bpy.ops.relievo.tissue*", "soft-tissue"),
    ("bpy.ops.relievo.crowd*", "crowds"),
    ("bpy.ops.relievo.fluid*", "fluids"),
    ("bpy.ops.relievo.foam*", "fluids"),
    ("bpy.ops.relievo.server*", "fluids"),
    ("bpy.ops.relievo.cache*", "files"),
    ("bpy.ops.relievo.*", "paint-and-sculpt"),
    ("bpy.types.relievobrush*", "paint-and-sculpt"),
    ("bpy.types.relievoimprint*", "imprint"),
    ("bpy.types.relievoprogressive*", "levels"),
    ("bpy.types.relievofluid*", "fluids"),
    ("bpy.types.relievofoam*", "fluids"),
    ("bpy.types.relievotissue*", "soft-tissue"),
    ("bpy.types.relievodecal*", "decals"),
    ("bpy.types.relievo*", "relievo-in-blender"),
]
STYLE = (
    "body{max-width:46em;margin:2em auto;padding:0 1em;font:16px/1.5 sans-serif}img{max-width:100%}"
    "code,pre{background:#eee}pre{padding:.6em;overflow:auto}"
)


def anchor_of(title):
    """Returns the name by which links call a part of the manual."""
    return re.sub(r"[^a-z0-9]+", "-", title.lower()).strip("-")


def inline(text):
    """Returns Markdown within a paragraph as HTML: code, pictures, links, bold and slanted text."""
    kept = []

    def keep(match):
        kept.append(f"<code>{match[1]}</code>")
        return f"\0{len(kept) - 1}\0"

    text = re.sub(r"`([^`]+)`", keep, html.escape(text, quote=False))
    text = re.sub(r"!\[([^\]]*)\]\(([^)]+)\)", r'<img alt="\1" src="\2">', text)
    text = re.sub(r"\[([^\]]+)\]\(([^)]+)\)", r'<a href="\2">\1</a>', text)
    text = re.sub(r"\*\*([^*]+)\*\*", r"<b>\1</b>", text)
    text = re.sub(r"\*([^*]+)\*", r"<i>\1</i>", text)
    return re.sub("\0(\\d+)\0", lambda match: kept[int(match[1])], text)


def table(block):
    """Returns a table of Markdown as HTML."""
    rows = [[inline(cell.strip()) for cell in line.strip().strip("|").split("|")] for line in block.splitlines()]
    shown = ["<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in [rows[0], *rows[2:]]]
    return f"<table>{''.join(shown)}</table>"


def page(text):
    """Returns the manual as a page of HTML: of Markdown the headings, paragraphs, lists, tables and code blocks."""
    made = []
    for block in re.split(r"\n\s*\n", text.strip()):
        heading = re.fullmatch(r"(#+) (.+)", block.strip())
        if heading:
            level = len(heading[1])
            made.append(f'<h{level} id="{anchor_of(heading[2])}">{inline(heading[2])}</h{level}>')
        elif block.startswith("    "):
            lines = "\n".join(line[4:] for line in block.splitlines())
            made.append(f"<pre>{html.escape(lines, quote=False)}</pre>")
        elif block.lstrip().startswith("- "):
            entries = re.split(r"\n- ", block.lstrip()[2:])
            made.append("<ul>" + "".join(f"<li>{inline(entry)}</li>" for entry in entries) + "</ul>")
        elif block.startswith("|"):
            made.append(table(block))
        else:
            made.append(f"<p>{inline(block)}</p>")
    base = SOURCE.parent.as_uri()
    head = f'<meta charset="utf-8"><title>Relievo in Blender</title><base href="{base}/"><style>{STYLE}</style>'
    return f"<!doctype html><html><head>{head}</head><body>{''.join(made)}</body></html>"


def write():
    """Writes the page into a folder of temporary files, and returns its address. Raises OSError."""
    path = Path(bpy.app.tempdir or tempfile.gettempdir()) / "relievo_manual.html"
    path.write_text(page(SOURCE.read_text(encoding="utf-8")), encoding="utf-8")
    return path.as_uri()


def places():
    """Returns what Blender's own *Online Manual* opens: where the page is, and its parts by names."""
    try:
        address = write()
    except OSError:
        # Blender then says that there is no manual.
        return "", ()
    return f"{address}#", tuple(PARTS)


def about():
    """Returns what a report of a problem says of this machine, in lines."""
    lines = [f"Blender {bpy.app.version_string}, {platform.platform()}, {os.cpu_count()} cores"]
    problem = native.problem()
    lines.append(f"Relievo cannot be used: {problem}" if problem else f"Relievo {native.version()}")
    lines += [f"{one.name}: {one.backend}, {one.driver}" for one in native.adapters()]
    fallback = native.fallback()
    return lines + ([f"The processor works: {fallback}"] if fallback else [])


class RELIEVO_OT_manual(bpy.types.Operator):
    """Open the manual of Relievo, which the add-on brings, in the browser"""

    bl_idname = "relievo.manual"
    bl_label = "Documentation"

    def execute(self, _context):
        try:
            address = write()
        except OSError as failure:
            self.report({"ERROR"}, f"The manual cannot be opened: {said(failure)}")
            return {"CANCELLED"}
        if not bpy.app.background:
            webbrowser.open(address)
        return {"FINISHED"}


class RELIEVO_OT_report(bpy.types.Operator):
    """Put what a report of a problem needs into the clipboard and into the text Relievo report: versions, system and devices"""

    bl_idname = "relievo.report"
    bl_label = "Report a Problem"

    def execute(self, context):
        name = "Relievo report"
        text = bpy.data.texts.get(name) or bpy.data.texts.new(name)
        text.clear()
        text.write("\n".join([*about(), "", "What I did:", "What I expected:", "What happened:", ""]))
        context.window_manager.clipboard = text.as_string()
        self.report({"INFO"}, "Paste the clipboard into your report, and attach the .blend file if you can")
        return {"FINISHED"}


CLASSES = [RELIEVO_OT_manual, RELIEVO_OT_report]


def register():
    for kind in CLASSES:
        bpy.utils.register_class(kind)
    bpy.utils.register_manual_map(places)


def unregister():
    bpy.utils.unregister_manual_map(places)
    for kind in reversed(CLASSES):
        bpy.utils.unregister_class(kind)
