# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects for fluids: the box of a domain, a box that is full of fluid, and a disc that pours."""

import bpy
from bpy_extras import object_utils

ROLES = [
    ("DOMAIN", "Domain", "A box in which fluid is simulated"),
    ("FILL", "Fill", "A box that is full of fluid in the first frame"),
    ("EMITTER", "Emitter", "A square that fluid pours out of"),
]
# Names, half sides in halves of the size, and where the middle is above the cursor, in the same.
SHAPES = {
    "DOMAIN": ("Fluid domain", (1.0, 0.5, 0.5), 0.5),
    "FILL": ("Fluid fill", (0.3, 0.45, 0.3), 0.35),
    "EMITTER": ("Fluid emitter", (0.1, 0.1, 0.0), 0.8),
}
# Corners and faces of a box, which face outwards.
CORNERS = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


class RELIEVO_OT_fluid_add(bpy.types.Operator):
    """Add an object with a part in fluids at the 3D cursor"""

    bl_idname = "relievo.fluid_add"
    bl_label = "Add Fluid Object"
    bl_options = {"REGISTER", "UNDO"}

    role: bpy.props.EnumProperty(name="Part", description="What the object is for fluids", items=ROLES)
    size: bpy.props.FloatProperty(
        name="Size",
        description="How long the domain that it fits into is, metres",
        min=1e-3,
        soft_max=100,
        default=2,
        unit="LENGTH",
    )

    @classmethod
    def poll(cls, context):
        return context.mode == "OBJECT"

    def execute(self, context):
        name, sides, above = SHAPES[self.role]
        half = 0.5 * self.size
        data = bpy.data.meshes.new(name)
        if self.role == "EMITTER":
            points = [(half * sides[0] * x, half * sides[1] * y, half * above) for x, y, _z in CORNERS[:4]]
            data.from_pydata(points, [], [FACES[0]])
        else:
            points = [
                (half * sides[0] * x, half * sides[1] * y, half * (above + sides[2] * z)) for x, y, z in CORNERS
            ]
            data.from_pydata(points, [], FACES)
        made = object_utils.object_data_add(context, data, name=name)
        options = made.relievo.fluid
        options.role = self.role
        if self.role == "DOMAIN":
            made.display_type, options.spacing = "WIRE", self.size / 40
        elif self.role == "EMITTER":
            options.velocity = (0, 0, -1)
        return {"FINISHED"}


def register():
    bpy.utils.register_class(RELIEVO_OT_fluid_add)


def unregister():
    bpy.utils.unregister_class(RELIEVO_OT_fluid_add)
