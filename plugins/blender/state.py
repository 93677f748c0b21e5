# SPDX-License-Identifier: GPL-3.0-or-later
"""The native state of objects: surface, detail and document, found by the uid that the object keeps.

The object's `revision` names a state of the document. Blender's undo brings old numbers back, and `follow` then undoes
or makes again in the document until it is at that revision. A document works on a file in the session's temporary
folder; saving the .blend puts its bytes into the object, loading takes them from there. An object that has the uid of
another, since it was duplicated or appended, gets a document of its own before anything is done to it.
"""

import contextlib
import json
import os
import tempfile
import uuid

import bpy
import librelievo as rl
import numpy

from . import mesh, native

# Version of what objects keep; a file with a newer one is refused with a message.
FORMAT = 1
DOCUMENT, HISTORY = "relievo_document", "relievo_history"

_states = {}


class Refused(Exception):
    """What the user asked for cannot be done; the message says why."""


class State:
    """A detail with its document, and the revisions that the document can go to."""

    def __init__(self, target, uid, packed=None, history=None):
        self.uid, self.owner = uid, target.name
        self.settings = settings_key(target)
        cage = target.data
        self.topology = topology_of(cage)
        options = target.relievo
        with mesh.to_native(cage) as made:
            self.surface = rl.Surface(native.context(), made, kind=options.kind.lower())
        triangles = options.kind == "TRIANGLES"
        self.detail = rl.Detail(self.surface, tile_size=int(options.segments if triangles else options.tile_size))
        size = {} if triangles else {"tile_size": int(options.tile_size)}
        self.detail.add_paint(color=(0.8, 0.8, 0.8, 1.0), **size)
        if bpy.context.scene.relievo.traces:
            self.detail.add_traces()
        self.path = os.path.join(bpy.app.tempdir or tempfile.gettempdir(), f"{uid}.relievo")
        if packed is None:
            self.document = rl.Document(self.detail, self.path)
            self.revisions, self.position = [target.relievo.revision], 0
        else:
            with open(self.path, "wb") as file:
                file.write(packed)
            self.document = rl.Document.open(self.detail, self.path)
            self.revisions, self.position = history["revisions"], history["position"]
            if self.document.info.undo_count != self.position:
                raise Refused(f"The document of {target.name} was cut; take an older copy of the file, or clear the detail")
        self.detail.commit()
        self.counter = max(self.revisions)
        self.tessellation = self.cells = self.positions = self.colors = self.caster = None
        self.packed_revision = target.relievo.revision if packed is not None else None

    @property
    def revision(self):
        return self.revisions[self.position]

    @contextlib.contextmanager
    def edit(self, target, text):
        """One edit, and one step of Blender's undo if an operator with undo makes it."""
        self.document.begin(text)
        try:
            yield
        except BaseException:
            self.document.abandon()
            self.detail.commit()
            raise
        self.end(target)

    def end(self, target):
        """Ends an edit that was begun: the object gets a new revision."""
        changes = self.document.end()
        self.detail.commit()
        if changes.is_done:
            self.counter += 1
            self.revisions[self.position + 1 :] = [self.counter]
            self.position += 1
            target.relievo.revision = self.counter

    def follow(self, target):
        """Goes to the revision that the object has; says whether that is possible."""
        wanted = target.relievo.revision
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
        return True

    def data(self):
        """The bytes of the document, and its revisions."""
        self.document.sync()
        with open(self.path, "rb") as file:
            return file.read(), {"revisions": list(self.revisions), "position": self.position}

    def pick(self):
        """A caster of the surface as it is."""
        revision = self.detail.info.revision
        if self.caster is None or self.caster[0] != revision:
            cells = {} if self.settings[0] == "TRIANGLES" else {"fine": 16, "coarse": 8}
            self.caster = revision, rl.Caster.of_detail(self.detail, **cells)
        return self.caster[1]

    def release(self):
        for part in (self.tessellation, self.document, self.detail, self.surface):
            if part is not None:
                part.release()
        with contextlib.suppress(OSError):
            os.remove(self.path)


def settings_key(target):
    """What a state was made with that cannot be changed in it."""
    options = target.relievo
    return options.kind, options.tile_size if options.kind == "CATMULL_CLARK" else options.segments


def topology_of(cage):
    """What must stay the same of a mesh."""
    corners = mesh.get_corners(cage)
    return len(cage.vertices), len(cage.polygons), hash(corners.tobytes())


def source_of(target):
    """The object that a result belongs to, or the object itself."""
    if target is not None and target.relievo.source is not None:
        return target.relievo.source
    return target


def is_editable(context):
    """Whether operators may edit what is active."""
    active = source_of(context.active_object)
    return active is not None and active.type == "MESH" and active.mode == "OBJECT"


def of(target):
    """The state of an object, made where there is none yet."""
    if target is None or target.type != "MESH":
        raise Refused("Select a mesh object")
    options = target.relievo
    if options.format > FORMAT:
        raise Refused(f"{target.name} was edited with a newer Relievo add-on; update it to edit this object")
    if target.mode == "EDIT":
        raise Refused("Leave edit mode first")
    if options.uid:
        _separate(target)
    state = _states.get(options.uid) if options.uid else None
    if state is None:
        state = _opened(target)
    if state.topology != topology_of(target.data):
        raise Refused(f"The mesh of {target.name} has other faces than its detail; undo that, or clear the detail")
    state.owner = target.name
    if not state.follow(target):
        # A step whose history is gone, say from before the file was loaded: what was saved is what there is.
        state = _reopened(target, state)
    return state


def kept(target):
    """The document that the file keeps for an object and its revisions, or None twice."""
    packed, history = target.get(DOCUMENT), target.get(HISTORY)
    if packed is None or history is None:
        return None, None
    try:
        history = json.loads(history)
        revisions, position = [int(revision) for revision in history["revisions"]], int(history["position"])
        if not 0 <= position < len(revisions) or not isinstance(packed, bytes):
            raise ValueError("a position that does not exist")
    except (ValueError, KeyError, TypeError) as failure:
        raise Refused(f"What the file keeps of {target.name} is damaged: {failure}") from None
    return packed, {"revisions": revisions, "position": position}


def _opened(target):
    options = target.relievo
    packed, history = kept(target)
    if not options.uid:
        options.uid = uuid.uuid4().hex
        options.format = FORMAT
    if packed is not None:
        state = State(target, options.uid, packed, history)
    else:
        if options.revision:
            print(f"Relievo: {target.name} has lost its document; it begins anew")
        state = State(target, options.uid)
    _states[options.uid] = state
    return state


def _reopened(target, state):
    packed, history = kept(target)
    if packed is not None and target.relievo.revision in history["revisions"]:
        state.release()
        state = _states[state.uid] = State(target, state.uid, packed, history)
        if state.follow(target):
            return state
    raise Refused(f"The history of {target.name} does not reach back to this step; undo or redo further")


def _separate(target):
    """Gives an object a document of its own if another one has the same uid."""
    uid = target.relievo.uid
    others = [other for other in bpy.data.objects if other.relievo.uid == uid and other != target]
    if not others:
        return
    state = _states.get(uid)
    owner = state.owner if state else min(other.name for other in [*others, target])
    if target.name == owner:
        return
    target.relievo.uid = uuid.uuid4().hex
    target.relievo.result = None
    if state is None or target.relievo.revision not in state.revisions:
        packed, history = kept(target)
        if packed is None:
            return
    else:
        packed, history = state.data()
    _states[target.relievo.uid] = State(target, target.relievo.uid, packed, history)


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
        if state is not None and state.owner == target.name:
            state.follow(target)


def pack_all():
    """Before saving: puts documents into their objects."""
    for target in bpy.data.objects:
        if not target.relievo.uid:
            continue
        try:
            _separate(target)
        except (Refused, rl.RelievoError) as failure:
            print(f"Relievo: {target.name}: {failure}")
        state = existing(target)
        if state is None or state.owner != target.name or state.packed_revision == state.revision:
            continue
        packed, history = state.data()
        target[DOCUMENT], target[HISTORY] = packed, json.dumps(history)
        state.packed_revision = state.revision


def clear(target):
    """Forgets the detail of an object."""
    state = _states.pop(target.relievo.uid, None)
    if state is not None:
        state.release()
    for name in (DOCUMENT, HISTORY):
        if name in target:
            del target[name]
    target.relievo.uid = ""
    target.relievo.revision = 0
    target.relievo.strokes.clear()


def forget_all():
    """Releases everything: another file was loaded, or the add-on ends."""
    while _states:
        _states.popitem()[1].release()


def posed_points(target, depsgraph):
    """The points of an object as its modifiers pose it, if they keep its topology, else those of its mesh."""
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


def place(state, target, points=None):
    """Brings the detail to where the object is, and to its pose."""
    state.detail.set_transform(world(target))
    if points is not None:
        state.detail.set_points(points)
    state.detail.commit()


def inverse(matrix):
    """The inverse of an affine matrix."""
    return numpy.linalg.inv(matrix)
