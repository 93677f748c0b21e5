# SPDX-License-Identifier: GPL-3.0-or-later
"""Progressive meshes of objects: the level that an object shows, and the edits that were made at any level.

An object keeps the file of its progressive mesh (.rlvpm) as it was built, which never changes, and a list of edits, each
with the level that it was made at. Blender's undo brings back the list and the mesh; `Shown.follow` then takes native
edits back, or makes them again, until they are those of the list. So objects that are duplicated share a progressive
mesh and have levels and edits of their own.
"""

import json
import os
import tempfile

import bpy
import librelievo as rl
import numpy

from ..core import job, native, settings
from ..core.error import Refused, said
from . import attribute, mesh, pose, state, stroke

# Version of what objects keep; a file with a newer one is refused with a message. Edits of the first are handles alone,
# and only the third has hooks.
FORMAT = 3
PACKED = "relievo_progressive"
# What the names of kept stamps begin with; see `stroke.pack_array`.
STAMPS = "relievo_stamp_"
# Bytes that Blender can keep of one property.
MAX_BYTES = 2**31 - 64
# What JSON of another shape than expected may raise, besides ValueError.
STRANGE = (KeyError, TypeError, AttributeError, OverflowError, RecursionError)
# What edits and changes of the level may raise.
FAILURES = (Refused, rl.RelievoError, OSError)

# Progressive meshes by the uid that objects keep, and what objects show by that uid and their name. The second only saves
# work: what is there is brought to the object's list before it is used.
_wholes, _shown = {}, {}
# Why the level of an object could not be shown, by its name.
_troubles = {}
# Names of objects that are edited by the pointer: their hooks rest meanwhile.
resting = set()


def place_of(uid):
    """A file of the session for a progressive mesh, to and from which bytes go."""
    return os.path.join(bpy.app.tempdir or tempfile.gettempdir(), f"{uid}.rlvpm")


def bytes_of(whole, path):
    """The file of a progressive mesh, by way of a path; without Blender's data."""
    try:
        whole.write(path)
        with open(path, "rb") as file:
            packed = file.read()
    finally:
        if os.path.exists(path):
            os.remove(path)
    return fitting(packed)


def fitting(packed):
    """The bytes of a file, refused where Blender cannot keep them."""
    if len(packed) > MAX_BYTES:
        raise Refused(f"The progressive mesh takes {len(packed) >> 20} MiB, and Blender keeps no more than 2047 of one")
    return packed


def of_bytes(packed, path, name):
    """The progressive mesh that an object keeps; without Blender's data."""
    with open(path, "wb") as file:
        file.write(packed)
    try:
        return rl.Progressive.read(native.context(), path)
    except rl.Invalid as failure:
        raise Refused(
            f"What the file keeps of the levels of {name} is damaged: {failure.what}; take an older copy of the file, or "
            "clear the levels"
        ) from None
    finally:
        os.remove(path)


class Shown:
    """A level of a progressive mesh with edits, as an object shows it. Needs nothing of Blender."""

    def __init__(self, whole):
        self.whole, self.level = whole, rl.Level(whole)
        # The texts of edits that are made, and of edits that were taken back and can be made again, the last one first.
        self.edits, self.undone = [], []
        # The pixels of the stamps of strokes, by the names that strokes have of them.
        self.stamps = {}

    def adapt(self, measure):
        """Goes to a level: `{"error": …}` or `{"triangles": …}`."""
        if "error" in measure:
            self.level.set_error(measure["error"])
        else:
            self.level.set_triangles(measure["triangles"])

    def edit(self, text):
        """Makes an edit at its level. Returns how many vertices were reached."""
        kept = read(text)
        self.adapt(kept["level"])
        if "stroke" in kept:
            reached = self.sculpt(kept["stroke"])
        else:
            handles, anchors = map(grip, kept["handles"]), map(region, kept["anchors"])
            reached = self.level.edit(list(handles), list(anchors))
        self.edits.append(text)
        self.undone.clear()
        return reached

    def sculpt(self, kept):
        """Makes a stroke. Returns how many vertices moved."""
        key = kept.get("stamp_key")
        if key is not None and key not in self.stamps:
            raise ValueError(f"its stamp {kept.get('stamp')} is gone")
        with stroke.brush(kept, self.stamps.get(key)) as brush:
            return self.level.sculpt(brush, kept["points"]).vertices

    def undo(self):
        """Takes the last edit back."""
        self.level.undo()
        self.undone.append(self.edits.pop())

    def follow(self, wanted, progress=None):
        """Takes edits back and makes edits until they are those of a list."""
        same = 0
        while same < min(len(self.edits), len(wanted)) and self.edits[same] == wanted[same]:
            same += 1
        while len(self.edits) > same:
            self.undo()
        for number, text in enumerate(wanted[same:], same + 1):
            if progress is not None and progress(number / len(wanted)) is False:
                return
            if self.undone and self.undone[-1] == text:
                self.level.redo()
                self.edits.append(self.undone.pop())
                continue
            try:
                self.edit(text)
            except (ValueError, *STRANGE, rl.RelievoError) as failure:
                raise Refused(f"Edit {number} cannot be made again: {said(failure)}; undo it, or clear the levels") from None

    def bring(self, measure):
        """Goes to a level, and has its points and triangles."""
        self.adapt(measure)
        return self.level.update()

    def pick(self):
        """A caster of the mesh as it is now."""
        with self.level.mesh() as made:
            return rl.Caster(native.context(), made)

    def release(self):
        self.level.release()


def finest(whole):
    """The finest level of a progressive mesh."""
    shown = Shown(whole)
    shown.bring({"triangles": whole.info.triangle_count})
    return shown


def text_of(measure, handles=(), anchors=(), stroke=None):
    """An edit as an object keeps it: the level that it is made at, and handles and anchors as dictionaries of what
    `librelievo.Grip` and `Region` have, or a stroke as `stroke.describe` has it with its points; object units and
    radians."""
    if stroke is not None:
        return json.dumps({"level": measure, "stroke": stroke})
    return json.dumps({"level": measure, "handles": list(handles), "anchors": list(anchors)})


def read(text):
    """An edit that an object keeps; ValueError if it cannot be understood."""
    try:
        kept = json.loads(text)
        check_measure(kept["level"])
        if "stroke" in kept:
            stroke.check(kept["stroke"])
            return kept
        if not kept["handles"]:
            raise ValueError("no handle")
        for handle in kept["handles"]:
            grip(handle)
        for held in kept["anchors"]:
            region(held)
    except STRANGE:
        raise ValueError("a value is missing or of another kind") from None
    return kept


def check_measure(level):
    """Whether a level can be understood; ValueError if not, or what `STRANGE` has."""
    if set(level) == {"error"}:
        level["error"] = float(level["error"])
    elif set(level) != {"triangles"} or not isinstance(level["triangles"], int) or level["triangles"] < 0:
        raise ValueError("no level")


def _numbers(values):
    numbers = tuple(float(value) for value in values)
    if len(numbers) != 3:
        raise ValueError("three numbers are needed")
    return numbers


def region(kept):
    """A region as the library takes it."""
    return rl.Region(_numbers(kept["center"]), float(kept["radius"]), str(kept.get("falloff", "smooth")))


def grip(kept):
    """A handle as the library takes it."""
    turn = _numbers(kept.get("axis", (0, 0, 1))), float(kept.get("angle", 0.0))
    return rl.Grip(region(kept), _numbers(kept.get("translation", (0, 0, 0))), *turn)


def is_there(target):
    """Whether an object has levels."""
    return target is not None and target.type == "MESH" and bool(target.relievo.progressive.uid)


def check_kept(target):
    """Refuses objects whose levels cannot be changed at all."""
    if target is None or target.type != "MESH":
        raise Refused("Select a mesh object")
    if target.library is not None or target.override_library is not None or target.data.library is not None:
        raise Refused(
            f"{target.name} is linked from another file; make it local first (Object > Relations > Make Local, All)"
        )
    if target.relievo.progressive.format > FORMAT:
        raise Refused(f"The levels of {target.name} are of a newer Relievo add-on; update it to edit this object")


def check(target):
    """Refuses objects whose mesh cannot be written to."""
    check_kept(target)
    if state.source_of(target) != target:
        raise Refused(f"{target.name} is the result of {target.relievo.source.name}, which writes to its mesh")
    if target.relievo.uid:
        raise Refused(f"{target.name} has detail, which needs the faces that are there; clear the detail first")
    if target.data.shape_keys is not None:
        raise Refused(f"{target.name} has shape keys, which need the points that are there; remove them first")
    if target.mode != "OBJECT":
        raise Refused("Go to object mode first")


def measure_of(options):
    """The level that the settings of an object say."""
    if options.measure == "ERROR":
        return {"error": options.error}
    if options.measure == "TRIANGLES":
        return {"triangles": options.triangles}
    return {"triangles": max(1, round(options.ratio * options.finest))}


def _prune():
    """Releases what no object has any more. What undo brings back is made anew of what objects keep."""
    for uid, name in list(_shown):
        target = bpy.data.objects.get(name)
        if target is None or target.relievo.progressive.uid != uid:
            _shown.pop((uid, name)).release()
    kept = {target.relievo.progressive.uid for target in bpy.data.objects}
    for uid in set(_wholes) - kept:
        _wholes.pop(uid).release()


def posed(target, graph=None):
    """The edit that the hooks of an object make, as objects keep edits; None where they rest."""
    options = target.relievo.progressive
    moved, held = pose.handles(target, graph)
    if not moved:
        return None
    try:
        level = json.loads(options.hooked_at)
        check_measure(level)
    except (ValueError, *STRANGE) as failure:
        raise Refused(f"The level of the hooks of {target.name} is damaged: {said(failure)}; release them") from None
    return text_of(level, moved, held)


def wanted_of(target, graph=None):
    """The edits of an object with what its hooks make."""
    made = posed(target, graph)
    return [entry.text for entry in target.relievo.progressive.edits] + ([] if made is None else [made])


def is_shown(target, graph=None):
    """Whether what an object shows has its edits, and its hooks as they are now, unless they rest."""
    if target.name in resting:
        return True
    shown = _shown.get((target.relievo.progressive.uid, target.name))
    return shown is not None and shown.edits == wanted_of(target, graph)


def opening(target, wanted=None):
    """Steps (see `job`) that make what an object shows where there is none yet, and bring it to the object's edits, or
    to the wanted edits; they return it."""
    check(target)
    if not is_there(target):
        raise Refused(f"{target.name} has no levels; build them first")
    uid, name = target.relievo.progressive.uid, target.name
    if wanted is None:
        wanted = [entry.text for entry in target.relievo.progressive.edits]
    native.context()
    if (uid, name) not in _shown:
        _prune()
        packed, path = target.get(PACKED), place_of(uid)
        if uid not in _wholes and not isinstance(packed, bytes):
            raise Refused(f"The file keeps no levels of {name}; take an older copy of it, or clear the levels")

        def work(_progress):
            if uid not in _wholes:
                _wholes[uid] = of_bytes(packed, path, name)
            _shown[uid, name] = Shown(_wholes[uid])

        yield 0.0, 0.5, work
    shown = _shown[uid, name]
    for key in [key for key in target.keys() if key.startswith(STAMPS) and key not in shown.stamps]:
        try:
            shown.stamps[key] = stroke.kept_array(target, key)
        except ValueError as failure:
            print(f"Relievo: a stamp of {name} is lost: {said(failure)}")
    yield 0.5, 0.9, lambda progress: shown.follow(wanted, progress)
    return shown


def keep(target, text, stamp=None):
    """Keeps an edit that was made in an object, with the stamp that it names, packed."""
    if stamp is not None:
        stroke.keep_array(target, *stamp)
    options = target.relievo.progressive
    options.edits.add().text = text
    options.format = FORMAT


def showing(target, graph=None, is_resting=False):
    """Steps that bring the mesh of an object to the level that its settings say, and to where its hooks are unless it is
    to be at rest; they return what it shows."""
    wanted = None if is_resting else wanted_of(target, graph)
    shown, measure = (yield from opening(target, wanted)), measure_of(target.relievo.progressive)
    yield 0.9, 1.0, lambda _progress: shown.bring(measure)
    write(target, shown)
    return shown


def write(target, shown):
    """Writes the points, triangles and attributes of the last update to the mesh of an object. Its materials stay, and most
    faces' shading becomes that of all; so does their material, if levels have none."""
    if target.data.users > 1:
        # Linked duplicates share their mesh; what is written here is this object's own.
        target.data = target.data.copy()
    data, points = target.data, shown.level.points
    corners = shown.level.triangles.reshape(-1)
    if len(data.vertices) != len(points) or not numpy.array_equal(mesh.get_corners(data), corners):
        is_smooth, materials = mesh.is_smooth(data), mesh.get_materials(data)
        original = target.relievo.progressive.original
        names = attribute.active_names(original or data)
        data.clear_geometry()
        mesh.Filling(corners.view(numpy.int32), len(points)).fill(data, is_smooth)
        if not attribute.put(data, shown.level, shown.whole.attributes(), names):
            if materials is not None and len(materials):
                mesh.set_materials(data, numpy.bincount(numpy.maximum(materials, 0)).argmax())
    mesh.set_points(data, points)
    attribute.put_normals(data, shown.level, shown.whole.attributes())


def write_moved(target, shown):
    """Writes what has changed since the last time, where nobody else has written meanwhile: mostly points alone."""
    if shown.level.update().changed_triangle_count:
        write(target, shown)
    else:
        mesh.set_points(target.data, shown.level.points)
        attribute.put_normals(target.data, shown.level, shown.whole.attributes())


def left_out(target):
    """What an object has that its levels will not, beside layers, as words."""
    return ["vertex groups"] if len(target.vertex_groups) else []


# Set while the settings of levels are written by the add-on itself.
_is_quiet = False


def changed(target):
    """Follows the settings of an object; the panel shows what fails, since a setting cannot fail."""
    if _is_quiet or not is_there(target):
        return
    try:
        job.run(showing(target))
        tell(target, "")
    except FAILURES as failure:
        tell(target, said(failure))


def tell(target, trouble):
    """Says why the level of an object could not be shown; "" if it could."""
    if trouble:
        print(f"Relievo: {target.name}: {trouble}")
    _troubles[target.name] = trouble


def trouble(target):
    """Why the level of an object could not be shown, or ""."""
    return _troubles.get(target.name, "")


def adopt(target, uid, shown, packed):
    """Gives an object levels and the bytes of their file, and shows the finest, which `shown` has."""
    global _is_quiet
    options, finest, points = target.relievo.progressive, shown.whole.info.triangle_count, shown.level.points
    options.uid, options.format, options.finest = uid, FORMAT, finest
    options.edits.clear()
    options.hooks.clear()
    _is_quiet = True
    try:
        options.measure, options.ratio, options.triangles = "RATIO", 1.0, finest
        options.error = float(numpy.linalg.norm(points.max(0) - points.min(0))) / 1000
    finally:
        _is_quiet = False
    # Blender 5.0 cuts bytes that are put over others at the first zero.
    if PACKED in target:
        del target[PACKED]
    target[PACKED] = packed
    _wholes[uid], _shown[uid, target.name] = shown.whole, shown
    write(target, shown)


def clear(target):
    """Forgets the levels of an object; its mesh stays."""
    options = target.relievo.progressive
    options.uid, options.original = "", None
    options.edits.clear()
    options.hooks.clear()
    for name in [name for name in target.keys() if name == PACKED or name.startswith(STAMPS)]:
        del target[name]


def forget_all():
    """Releases everything: another file was loaded, or the add-on ends."""
    while _shown:
        _shown.popitem()[1].release()
    while _wholes:
        _wholes.popitem()[1].release()
    _troubles.clear()


def settings_changed(options, _context):
    """Shows the level that the settings of an object ask for."""
    changed(options.id_data)


def register():
    settings.listeners["level"].append(settings_changed)


def unregister():
    settings.listeners["level"].remove(settings_changed)
