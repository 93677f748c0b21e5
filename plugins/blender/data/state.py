# SPDX-License-Identifier: GPL-3.0-or-later
"""The native state of objects: surface, detail and document, found by the uid that the object keeps.

The object's `revision` names a state of the document. Blender's undo brings old numbers back, and `follow` then undoes
or makes again in the document until it is at that revision. A document works on a file in the session's temporary
folder; every edit puts what it appended there into the object (see `document`). An object that has the uid of another,
since it was duplicated or appended, gets a document of its own, made of its own bytes, before anything is done to it.
"""

import contextlib
import json
import uuid

import bpy
import librelievo as rl
import numpy

from ..core import job, native, settings
from ..core.error import Refused, said
from . import attribute, document, material, mesh, stroke

# Version of what objects keep; a file with a newer one is refused with a message. 2 has with every stroke where the
# object was, pressure curves and its revision, and the layers; 3 has the document in pieces.
FORMAT = 3
# The attribute that numbers the faces of a cage.
FACE = "cage face"
# Modifiers that make faces which the surface of a cage has not.
GENERATING = {
    "ARRAY", "BEVEL", "BOOLEAN", "BUILD", "DECIMATE", "EDGE_SPLIT", "MASK", "MESH_TO_VOLUME", "MIRROR", "REMESH", "SCREW",
    "SKIN", "SOLIDIFY", "TRIANGULATE", "VOLUME_TO_MESH", "WELD", "WIREFRAME",
}
# Triangles of the picture of a surface that the pointer meets.
PICK_CELLS = 2**19

_states = {}


class State:
    """A detail with its document, and the revisions that the document can go to. It is made in two parts: what Blender
    has of it on the main thread, and the native objects by `build` on any."""

    def __init__(self, target, uid, found=None):
        options, cage = target.relievo, target.data
        self.uid, self.owner = uid, target.name
        self.settings = settings_key(target)
        self.topology = topology_of(cage)
        self.cage, self.kind = mesh.Source(cage), options.kind
        carried = attribute.of_cage(target)
        self.cage.attributes = [(entry.key, entry.values, entry.domain) for entry in carried if entry.values is not None]
        self.cage.attributes.append((FACE, numpy.arange(len(cage.polygons), dtype=numpy.uint32), "face"))
        # What the result takes from the cage, the values aside, and the face of the cage of each of its triangles.
        self.carried, self.faces = [entry._replace(values=None) for entry in carried], None
        self.rest = self.pose = self.cage.points
        triangles = options.kind == "TRIANGLES"
        self.tile_size = int(options.segments if triangles else options.tile_size)
        self.ground = tuple(options.ground)
        self.with_traces = bpy.context.scene.relievo.traces
        self.path = document.path_of(uid)
        # The document that is opened, if there is one, and the marks of its file (see `document.write`).
        self.found, self.marks, self.replayed = found, {}, None
        if found is None:
            self.revisions, self.position = [options.revision], 0
        else:
            self.revisions, self.position = list(found.revisions), found.position
        self.counter = max(self.revisions)
        self.notes = []
        self.surface = self.detail = self.document = None
        self.tessellation = self.cells = self.positions = self.colors = self.filling = None
        # What the result object shows, and what the caster was made of.
        self.seen = self.caster = None

    def replay(self, target):
        """Has the strokes that the object keeps made again by `build`."""
        self.replayed = *stroke.read_all(target), kept_layers(target), target.relievo.revision
        self.revisions = [0]

    def build(self, progress=None):
        """Makes the native objects, without Blender's data."""
        context = native.context()
        with self.cage.build() as cage:
            self.surface = rl.Surface(context, cage, kind=self.kind.lower())
        self.cage = None
        if progress is not None:
            progress(0.5, "surface")
        self.detail = rl.Detail(self.surface, tile_size=self.tile_size)
        size = {} if self.kind == "TRIANGLES" else {"tile_size": self.tile_size}
        self.detail.add_paint(color=(*self.ground, 1.0), **size)
        if self.with_traces:
            self.detail.add_traces()
        if self.found is None:
            self.document = rl.Document(self.detail, self.path)
        else:
            with open(self.path, "wb") as file:
                file.write(self.found.data)
            self.document = rl.Document.open(self.detail, self.path)
            self.marks = document.marks_of(self.path, self.found.data)
            if self.document.info.undo_count != self.position:
                raise Refused(
                    f"The document of {self.owner} was cut; take an older copy of the file, make its strokes again, or "
                    "clear the detail"
                )
        self.detail.commit()
        self.found = None
        if self.replayed is not None:
            self._make_again(*self.replayed)
            self.replayed = None
        document.note(self.path, self.revisions, self.position)

    def _make_again(self, strokes, lost, layers, revision):
        """Strokes that were kept, each an edit again, on layers of their names."""
        made = 0
        if any(stroke.bends(kept) for kept, _pixels, _pose in strokes):
            self.add_vectors()
        for kept, pixels, pose in strokes:
            if "matrix" in kept:
                self.detail.set_transform(numpy.asarray(kept["matrix"], numpy.float64))
            self.set_pose(self.rest if pose is None else pose)
            self._arrange(kept.get("layers", []))
            try:
                with self.document.edit("stroke"):
                    rl.stroke.run(self.detail, stroke.brush(kept, pixels), kept["points"])
            except rl.RelievoError as failure:
                lost += 1
                print(f"Relievo: a stroke of {self.owner} cannot be made again: {said(failure)}")
                continue
            made += 1
            self.detail.commit()
            self._advance(kept.get("revision"))
        self._arrange(layers)
        self.detail.commit()
        # The object is at the revision that it was left at.
        self.revisions[-1] = revision
        self.counter = max(self.counter, revision)
        gone = f"; {lost} cannot be (see the console)" if lost else ""
        self.notes.append(
            f"{made} strokes of {self.owner} were made again{gone}. Imprints are not kept as strokes; make them again"
        )

    def _arrange(self, wanted):
        """Brings the layers to what was kept of them. It matters when: what is sculpted goes to a layer by its opacity."""
        if layers_of(self.detail) == wanted:
            return
        with self.document.edit("layers"):
            there = {layer.name: layer.id for layer in self.detail.layers}
            for layer in wanted:
                name = layer["name"]
                if name not in there:
                    there[name] = self.detail.layers.add(name, kind=layer["kind"])
                options = {option: layer[option] for option in ("opacity", "blend", "is_visible")}
                self.detail.layers.set(there[name], **options)
                if layer["is_active"]:
                    self.detail.layers.set_active(there[name])
        self.detail.commit()
        self._advance(None)

    def _advance(self, revision):
        """A revision more than there were. One that belongs to no step of Blender's has a number that no step has."""
        if self.document.info.undo_count > self.position:
            self.position += 1
            known = isinstance(revision, int) and revision not in self.revisions
            self.revisions.append(revision if known else -self.position)

    @property
    def is_built(self):
        return self.document is not None

    @property
    def revision(self):
        return self.revisions[self.position]

    def take_notes(self):
        """What the user should be told, once."""
        notes, self.notes = self.notes, []
        return notes

    @contextlib.contextmanager
    def edit(self, text):
        """One edit, and one step of Blender's undo if an operator with undo makes it: `record` then puts its revision
        into the object. Needs nothing of Blender."""
        self.document.begin(text)
        try:
            yield
        except BaseException:
            self.abandon()
            raise
        self.end()

    def end(self):
        """Ends an edit that was begun; what was done has a new revision."""
        changes = self.document.end()
        self.detail.commit()
        if changes.is_done:
            self.counter += 1
            self.revisions[self.position + 1 :] = [self.counter]
            self.position += 1
            document.note(self.path, self.revisions, self.position)

    def abandon(self):
        """Takes an edit that was begun back."""
        self.document.abandon()
        self.detail.commit()

    def record(self, target):
        """Puts into the object the state that it is in: the document, its revision and the layers."""
        options = target.relievo
        if self.revisions != [0]:
            document.write(target, self.path, self.marks, self.revisions, self.position)
        if options.revision != self.revision:
            options.revision = self.revision
        if options.format < FORMAT:
            options.format = FORMAT
        layers = json.dumps(layers_of(self.detail))
        if options.layers != layers:
            options.layers = layers
        for function in settings.listeners["recorded"]:
            function(target, self)

    def add_vectors(self):
        """Gives the detail vector displacement, whose frame is that of the mesh at rest."""
        if self.detail.channel_info("vectors").is_there:
            return
        posed = self.pose
        self.set_pose(self.rest)
        self.detail.add_vectors(**({} if self.kind == "TRIANGLES" else {"tile_size": self.tile_size}))
        self.set_pose(posed)
        self.detail.commit()

    def set_pose(self, points):
        """Poses the surface; commit to see it."""
        if points is not self.pose and not numpy.array_equal(points, self.pose):
            self.detail.set_points(points)
            self.pose = points

    def follow(self, wanted):
        """Goes to a revision; says whether that is possible."""
        if wanted == self.revision:
            return True
        if wanted not in self.revisions:
            return False
        place = self.revisions.index(wanted)
        while self.position != place:
            back = self.position > place
            changes = self.document.undo() if back else self.document.redo()
            if not changes.is_done:
                return False
            self.position += -1 if back else 1
        self.detail.commit()
        document.note(self.path, self.revisions, self.position)
        return True

    def data(self):
        """Returns the bytes and revisions of the document."""
        self.document.sync()
        with open(self.path, "rb") as file:
            return document.Document(file.read(), list(self.revisions), self.position)

    def pick(self):
        """A caster of the surface as it is: of the triangles that are seen, where they are fine enough."""
        now = self.now()
        if self.caster is None or not _is_same(self.caster[0], now):
            triangles = self.kind == "TRIANGLES"
            fine = settings.automatic_cells(self.detail.info.tile_count, PICK_CELLS)
            coarse = max(1, fine // 2)
            if _is_same(self.seen, now) and (triangles or self.cells >= coarse):
                with self.tessellation.mesh() as made:
                    caster = rl.Caster(native.context(), made)
            else:
                options = {} if triangles else {"fine": fine, "coarse": coarse}
                caster = rl.Caster.of_detail(self.detail, **options)
            self.caster = now, caster
        return self.caster[1]

    def now(self):
        """The revision of the detail, and its pose."""
        return self.detail.info.revision, self.pose

    def try_pick(self):
        """As `pick`, where there is nobody to tell a failure: the next press makes it, and tells."""
        with contextlib.suppress(rl.RelievoError):
            self.pick()

    def release(self):
        for part in (self.tessellation, self.document, self.detail, self.surface):
            if part is not None:
                part.release()
        with contextlib.suppress(OSError):
            document.remove(self.path)


def _is_same(before, now):
    """Whether a revision and a pose are the same as before."""
    return before is not None and before[0] == now[0] and before[1] is now[1]


def layers_of(detail):
    """The layers of a detail as an object keeps them."""
    return [
        {
            "name": layer.name,
            "kind": rl.abi.RlvLayerKind(layer.kind).name.lower(),
            "blend": rl.abi.RlvBlend(layer.blend).name.lower(),
            "opacity": layer.opacity,
            "is_visible": int(layer.is_visible),
            "is_active": int(layer.is_active),
        }
        for layer in detail.layers
    ]


def kept_layers(target):
    """The layers that an object keeps, none if they cannot be understood."""
    try:
        return stroke.checked_layers(json.loads(target.relievo.layers or "[]"))
    except ValueError as failure:
        print(f"Relievo: the layers that {target.name} keeps are damaged: {said(failure)}")
        return []


def settings_key(target):
    """What a state was made with that cannot be changed in it."""
    options = target.relievo
    return options.kind, options.tile_size if options.kind == "CATMULL_CLARK" else options.segments


def topology_of(cage):
    """What must stay the same of a mesh."""
    corners = mesh.get_corners(cage)
    return len(cage.vertices), len(cage.polygons), hash(corners.tobytes())


def is_used(target):
    """Whether an object is in a scene: pointers keep deleted objects."""
    return target is not None and bool(target.users_scene)


def source_of(target):
    """The object that a result belongs to, or the object itself. A copy of a result is an object of its own."""
    if target is not None and is_used(target.relievo.source) and target.relievo.source.relievo.result == target:
        return target.relievo.source
    return target


def is_editable(context):
    """Whether operators may edit what is active."""
    active = source_of(context.active_object)
    return active is not None and active.type == "MESH" and active.mode == "OBJECT"


def of(target):
    """The state of an object, made where there is none yet."""
    return job.run(opening(target))


def check(target):
    """Refuses objects that cannot be edited."""
    if target is None or target.type != "MESH":
        raise Refused("Select a mesh object")
    if target.library is not None or target.override_library is not None:
        raise Refused(
            f"{target.name} is linked from another file; make it local first (Object > Relations > Make Local, All)"
        )
    if target.relievo.format > FORMAT:
        raise Refused(f"{target.name} was edited with a newer Relievo add-on; update it to edit this object")
    if not target.relievo.kind:
        raise Refused(f"{target.name} is of a kind that this Relievo add-on does not know; update it")
    if target.mode == "EDIT":
        raise Refused("Leave edit mode first")


def check_modifiers(target):
    """Refuses an object whose modifiers make faces, before its first edit: the surface is that of its mesh alone, and what
    a mirror or an array adds would vanish."""
    names = [
        modifier.name
        for modifier in target.modifiers
        if modifier.type in GENERATING and (modifier.show_viewport or modifier.show_render)
    ]
    if names:
        raise Refused(
            f"{target.name} has the modifier {', '.join(names)}, whose faces would vanish: apply it first (its menu > Apply), "
            "or remove it"
        )


def opening(target):
    """Steps (see `job`) that make the state of an object where there is none yet, and return it."""
    check(target)
    options = target.relievo
    native.context()
    if options.uid:
        _separate(target)
    _follow_result(target)
    state, wanted, came = existing(target), options.revision, []
    if state is not None:
        if state.topology != topology_of(target.data):
            raise Refused(f"The mesh of {target.name} has other faces than its detail; undo that, or clear the detail")
        state.owner = target.name
        is_same = document.is_of(target, state.path, state.marks)
        yield 0.9, 1.0, lambda _progress: came.append(is_same and state.follow(wanted))
        if came[0]:
            return state
    # There is none, or its history is gone, say from before the file was loaded: what the object has is what there is.
    found = _found(target)
    if state is not None:
        state.release()
        del _states[state.uid]
    if not options.uid:
        check_modifiers(target)
        options.uid, options.format, options.ground = uuid.uuid4().hex, FORMAT, material.ground_of(target)
    state = State(target, options.uid, found)
    yield from _building(state)
    yield 0.9, 1.0, lambda _progress: came.append(state.follow(wanted))
    if not came[-1]:
        raise Refused(f"The document of {target.name} cannot go to this step; undo or redo further, or clear the detail")
    return state


def _follow_result(target):
    """Moves an object to where its result was moved, since that is what is seen. Raises Refused where the object would not
    stay there."""
    result = target.relievo.result
    if not is_used(result) or result.relievo.source != target:
        return
    if result.parent == target:
        away = mesh.matrix_of(result.matrix_parent_inverse @ result.matrix_basis)
        if numpy.allclose(away, numpy.eye(4), atol=1e-6):
            return
    elif numpy.allclose(world(result), world(target), atol=1e-6):
        return
    animation = target.animation_data
    if len(target.constraints) or (animation is not None and (animation.action is not None or len(animation.drivers))):
        raise Refused(
            f"{result.name} was moved away from {target.name}, which is animated: clear its location, rotation and scale, or "
            f"move {target.name}"
        )
    place = result.matrix_world.copy()
    result.parent = target
    result.matrix_parent_inverse.identity()
    result.matrix_basis.identity()
    target.matrix_world = place
    bpy.context.view_layer.update()


def _found(target):
    """Returns the document of an object, or None for an object that nothing was done to. Raises Refused where it is lost:
    what the object shows is not replaced by less unasked."""
    options, damage = target.relievo, None
    try:
        found = document.read(target)
    except Refused as failure:
        found, damage = None, failure
    if found is not None and options.revision in found.revisions:
        return found
    left = document.left_behind(options.uid, options.revision) if options.uid else None
    if left is not None:
        return left
    if damage is not None:
        raise damage
    if found is not None:
        raise Refused(
            f"The history of {target.name} does not reach to this step; undo or redo further, make its strokes again, or "
            "clear the detail"
        )
    if options.revision or len(options.strokes):
        raise Refused(
            f"The document of {target.name} is gone; take an older copy of the file, make its strokes again, which leaves "
            "imprints out, or clear the detail"
        )
    return None


def replaying(target):
    """Steps that make a new document of an object from its strokes and put it in the place of the old one; they return
    the state. The uid is another one, so that undo finds the old document."""
    check(target)
    native.context()
    made = State(target, uuid.uuid4().hex)
    made.replay(target)
    yield from _replacing(target, made)
    return made


def replacing(target, uid, found):
    """Steps that put a document in the place of an object's own, under another uid; they return the state."""
    made = State(target, uid, found)
    yield from _replacing(target, made)
    return made


def _replacing(target, made):
    """Builds a state and puts it in the place of an object's."""
    yield from _building(made)
    forget(target)
    target.relievo.uid = made.uid


def _building(state):
    """Builds a state; it is there for others when it is whole."""
    try:
        yield 0.0, 0.9, state.build
    except BaseException:
        state.release()
        raise
    _states[state.uid] = state


def _owner(target):
    """The object that has the document of a uid: the one that was edited last, else the first by name."""
    uid = target.relievo.uid
    state = _states.get(uid)
    if state is not None and state.owner == target.name:
        return target.name
    holders = [other.name for other in bpy.data.objects if other.relievo.uid == uid and other.library is None]
    if state is not None and state.owner in holders:
        return state.owner
    owner = min(holders)
    if state is not None:
        # It was renamed.
        state.owner = owner
    return owner


def _separate(target):
    """Gives an object a uid of its own if another one has the same."""
    options = target.relievo
    if _owner(target) == target.name:
        return
    options.uid = uuid.uuid4().hex
    if options.result is not None and options.result.relievo.source != target:
        options.result = None


def existing(target):
    """The state of an object if there is one in this session."""
    return _states.get(target.relievo.uid) if target.relievo.uid else None


def has_detail(target):
    """Whether something was done to an object."""
    return target is not None and target.type == "MESH" and bool(target.relievo.uid)


def follow_all():
    """After undo or redo: every document goes to the revision of its object. What cannot go waits until it is asked
    for, so that the message reaches the user."""
    for target in bpy.data.objects:
        state = existing(target)
        if state is not None and _owner(target) == target.name:
            try:
                state.follow(target.relievo.revision)
            except rl.RelievoError as failure:
                print(f"Relievo: {target.name}: {said(failure)}")


def forget(target):
    """Releases the document of an object and removes it from the object; its strokes stay."""
    state = _states.pop(target.relievo.uid, None)
    if state is not None:
        state.release()
    document.clear(target)


def clear(target):
    """Forgets the detail of an object."""
    forget(target)
    target.relievo.uid = target.relievo.layers = target.relievo.cache = ""
    target.relievo.revision = 0
    target.relievo_layers.rows.clear()
    target.relievo_press.is_there = False
    stroke.forget(target)


def forget_all():
    """Releases everything: another file was loaded, or the add-on ends."""
    while _states:
        _states.popitem()[1].release()


def posed_points(target, depsgraph):
    """The points of an object as its modifiers pose it, if they keep its topology, else those of its mesh."""
    if not target.modifiers and target.data.shape_keys is None:
        return mesh.get_points(target.data)
    evaluated = target.evaluated_get(depsgraph)
    posed = evaluated.to_mesh()
    try:
        if posed is not None and len(posed.vertices) == len(target.data.vertices):
            return mesh.get_points(posed)
    finally:
        evaluated.to_mesh_clear()
    return mesh.get_points(target.data)


def world(target):
    """Where an object is: rows of doubles."""
    return mesh.matrix_of(target.matrix_world)


def placing(state, target, depsgraph):
    """Steps that bring the detail to where the object is, and to its pose."""
    place, pose = world(target), posed_points(target, depsgraph)

    def work(_progress):
        state.detail.set_transform(place)
        state.set_pose(pose)
        state.detail.commit()

    yield 0.0, 0.0, work
