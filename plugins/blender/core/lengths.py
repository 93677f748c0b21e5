# SPDX-License-Identifier: GPL-3.0-or-later
"""Lengths that follow the size of objects: the defaults of settings are for an object that is 2 units long, and those of an
object of another size are in proportion. A length that was set by hand or by a script stays."""

import json
import math

# The length of the object that defaults are for.
USUAL = 2.0
# Lengths of a scene by their groups, those in world units apart from those in object units.
WORLD = (("brush.settings", "radius"),)
OBJECT = (
    ("brush", "height"),
    ("handle", "radius"),
    ("imprint", "max_displacement"),
    ("imprint", "rim_width"),
)
# The same of an object's own decal.
DECAL = ("width", "height", "offset")


def follow(scene, target):
    """Gives settings that nobody has set the lengths that suit an object, whose mesh is in the scene."""
    corners = list(target.bound_box)
    own = max(max(corner[axis] for corner in corners) - min(corner[axis] for corner in corners) for axis in range(3))
    world = max(target.dimensions)
    if not (0.0 < own < math.inf and 0.0 < world < math.inf):
        return
    options, before = scene.relievo, _lengths(scene.relievo.lengths)
    for names, length in ((WORLD, world), (OBJECT, own)):
        for path, name in names:
            group = options
            for part in path.split("."):
                group = getattr(group, part)
            _suit(group, name, length, before, f"{path}.{name}")
    text = json.dumps(before)
    if options.lengths != text:
        options.lengths = text


def follow_decal(target):
    """Does the same for the decal of an object."""
    corners = list(target.bound_box)
    own = max(max(corner[axis] for corner in corners) - min(corner[axis] for corner in corners) for axis in range(3))
    if 0.0 < own < math.inf:
        for name in DECAL:
            _suit(target.relievo.decal, name, own, {}, name)


def _suit(group, name, length, before, key):
    """Sets a length that is still its default or what was set here before, and notes it."""
    current = getattr(group, name)
    if group.is_property_set(name) and before.get(key) != current:
        before.pop(key, None)
        return
    default = group.bl_rna.properties[name].default
    suited = float(f"{default * length / USUAL:.2g}")
    if not math.isclose(suited, current, rel_tol=1e-6):
        setattr(group, name, suited)
        # It is read back, since properties have 32 bits and ranges.
        before[key] = getattr(group, name)


def _lengths(text):
    """Returns the lengths that were set here, none if they cannot be understood."""
    try:
        found = json.loads(text or "{}")
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}
