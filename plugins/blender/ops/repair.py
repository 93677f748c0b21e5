# SPDX-License-Identifier: GPL-3.0-or-later
"""Repair of the active mesh: points are welded, faces dropped and turned over, non-manifold edges split and holes filled.
Texture coordinates, colours, materials and smooth shading stay on the faces."""

import bpy
import librelievo as rl

from ..core import job, native, settings
from ..core.error import Refused
from ..data import attribute, mesh, progressive

# What a report says of the findings and of the changes, by the names of its fields.
FINDINGS = {
    "invalid_faces": "Invalid faces",
    "coincident_points": "Coincident points",
    "unused_points": "Unused points",
    "degenerate_faces": "Degenerate faces",
    "duplicate_faces": "Doubled faces",
    "non_manifold_edges": "Non-manifold edges",
    "non_manifold_points": "Non-manifold points",
    "misoriented_edges": "Misoriented edges",
    "inverted_components": "Inverted parts",
    "holes": "Holes",
}
CHANGES = {
    "turned_faces": "Faces turned over",
    "split_points": "Points added by splits",
    "filled_holes": "Holes filled",
    "filling_faces": "Faces added",
}


def lines_of(report):
    """Returns a report as lines: the defects, the changes, and the size of the repaired mesh."""
    found = [f"{label}: {getattr(report, name).count:,}" for name, label in FINDINGS.items() if getattr(report, name).count]
    changed = [f"{label}: {getattr(report, name):,}" for name, label in CHANGES.items() if getattr(report, name)]
    if report.open_holes.count:
        changed.append(f"Holes left open: {report.open_holes.count:,}")
    after = report.after
    is_closed = not after.boundary_edges and not after.non_manifold_edges
    parts = f"{after.components:,} part{'' if after.components == 1 else 's'}"
    state = f"{'Closed' if is_closed else 'Open'}: {after.points:,} points, {after.faces:,} faces, {parts}"
    return [*(found or ["No defects"]), *changed, state]


class Repaired:
    """A repaired mesh as arrays that need only be written."""

    def __init__(self, made):
        self.points = made.points()
        self.sizes, self.corners = made.faces()
        self.attributes = [made.attribute(name) for name in made.attribute_names()]

    def write(self, data, names):
        """Puts it into a mesh of Blender. `names` are those of active layers by their kinds."""
        data.clear_geometry()
        mesh.Filling(self.corners.astype("int32"), len(self.points), sizes=self.sizes).fill(data)
        attribute.put_faces(data, self.corners, self.attributes, names)
        mesh.set_points(data, self.points)


def check(target):
    """Refuses objects whose faces must not change."""
    progressive.check(target)
    if progressive.is_there(target):
        raise Refused(f"{target.name} shows a level, which the next one replaces; clear the levels first")
    if not len(target.data.polygons):
        raise Refused(f"{target.name} has no faces")


class RELIEVO_OT_repair(job.Steps, bpy.types.Operator):
    """Repair the active mesh: weld points, drop and turn over faces, split non-manifold edges and fill holes"""

    bl_idname = "relievo.repair"
    bl_label = "Repair mesh"
    bl_options = {"REGISTER", "UNDO"}
    failures = (Refused, rl.RelievoError)

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT" and context.active_object is not None and context.active_object.type == "MESH"

    def steps(self, context):
        target = context.active_object
        check(target)
        data = target.data
        arrays = mesh.get_points(data), mesh.get_corners(data), mesh.get_sizes(data)
        attributes, missing = attribute.of_faces(data)
        names, options = attribute.active_names(data), settings.values(context.scene.relievo.repair)
        native.context()
        made = []

        def work(progress):
            repaired, report = rl.repair.arrays(native.context(), *arrays, attributes, progress, **options)
            with repaired:
                made.extend([Repaired(repaired), report])

        yield 0.0, 1.0, work
        repaired, report = made
        if data.users > 1:
            # Linked duplicates share their mesh; what is repaired is this object's own.
            data = target.data = data.copy()
        repaired.write(data, names)
        lines = lines_of(report)
        target.relievo.repair_report = "\n".join(lines)
        if missing := missing + progressive.left_out(target):
            self.warn([f"The repaired mesh has no {' and no '.join(missing)}"])
        self.report({"INFO"}, "; ".join(lines))


def register():
    bpy.utils.register_class(RELIEVO_OT_repair)


def unregister():
    bpy.utils.unregister_class(RELIEVO_OT_repair)
