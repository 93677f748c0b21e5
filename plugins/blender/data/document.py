# SPDX-License-Identifier: GPL-3.0-or-later
"""Storage of documents: the bytes of a document's file as custom properties of its object, in pieces.

A document's file only grows, by a record for each edit, undo and redo. After each edit the bytes that were appended go
into the object, so that an edit costs what it changed, and every copy that Blender makes of the object has the document
of that moment: steps of undo, autosave, recovery, copy and paste, and `bpy.data.libraries.write`.

Beside the file, which lies in the session's temporary folder, a small JSON file has the revisions. Where an object has
lost its document, `left_behind` looks for the file that a session that crashed has left there.
"""

import contextlib
import json
import os
import re
import tempfile
import zlib
from collections import namedtuple

import bpy

from ..core.error import Refused, said

# Names of custom properties: the pieces' common beginning and the revisions; the whole document, of formats 1 and 2.
PIECES, HISTORY, WHOLE = "relievo_document_", "relievo_history", "relievo_document"
# A piece grows to so many bytes before the next one begins: what an edit writes at most besides its own bytes.
GROWING = 2**18
# Bytes of a piece at most; Blender's limit is 2 GiB.
LARGEST = 2**28

# The bytes of a document's file, the numbers of its revisions, and which of them it is at.
Document = namedtuple("Document", ["data", "revisions", "position"])


def folder():
    """Returns the session's temporary folder."""
    return bpy.app.tempdir or tempfile.gettempdir()


def path_of(uid):
    """Returns the path of the file that a document works on. Raises Refused where the uid is not the name of a file."""
    if not re.fullmatch(r"[\w-]{1,64}", uid):
        raise Refused("The name of the document in this file is damaged; clear the detail")
    return os.path.join(folder(), f"{uid}.relievo")


def _history(text):
    """Returns the revisions, the position and the rest of a history. Raises ValueError."""
    try:
        kept = json.loads(text)
        revisions, position = [int(revision) for revision in kept["revisions"]], int(kept["position"])
    except (KeyError, TypeError):
        raise ValueError("a value is missing or of another kind") from None
    if not 0 <= position < len(revisions):
        raise ValueError("a position that does not exist")
    return revisions, position, kept


def _names(target):
    """Returns the names of the pieces of an object, in their order."""
    return sorted(name for name in target.keys() if re.fullmatch(PIECES + r"\d{6}", name))


def _stored(target):
    """Returns the length and the checksum of an object's pieces and the revision they are at, or None."""
    try:
        revisions, position, kept = _history(target.get(HISTORY))
        return int(kept["length"]), int(kept["checksum"]), revisions[position]
    except (ValueError, KeyError, TypeError):
        return None


def read(target):
    """Returns the document that an object has, or None. Raises Refused where it is damaged."""
    names, text = _names(target), target.get(HISTORY)
    if text is None or not (names or WHOLE in target):
        return None
    try:
        revisions, position, kept = _history(text)
        if not names:
            data = target[WHOLE]
        else:
            data = b"".join(target[name] for name in names)
            if (len(data), zlib.crc32(data)) != (kept.get("length"), kept.get("checksum")):
                raise ValueError("bytes are missing or wrong")
        if not isinstance(data, bytes):
            raise ValueError("a document that is not bytes")
    except (ValueError, TypeError) as failure:
        raise Refused(
            f"The document of {target.name} is damaged: {said(failure)}; make its strokes again, or clear the detail"
        ) from None
    return Document(data, revisions, position)


def is_of(target, path, marks):
    """Returns whether the document in an object is a beginning of a file, or the object has none with a checksum. Objects
    of two files, one saved as the other, have one uid and may have one revision, but not one document."""
    stored = _stored(target)
    if stored is None:
        return True
    length, checksum, _revision = stored
    if length not in marks:
        with open(path, "rb") as file:
            data = file.read(length)
        marks[length] = zlib.crc32(data) if len(data) == length else None
    return marks[length] == checksum


def write(target, path, marks, revisions, position):
    """Appends to the document in an object what its file has more.

    `marks` has the checksums of the file's beginnings by their lengths; an object with other pieces gets the whole
    file. Raises OSError where the file cannot be read."""
    length, checksum, revision = _stored(target) or (0, 0, None)
    is_beginning = length > 0 and is_of(target, path, marks)
    if is_beginning and revision == revisions[position]:
        return
    if not is_beginning:
        length = checksum = 0
    with open(path, "rb") as file:
        file.seek(length)
        added = file.read()
    length, checksum = length + len(added), zlib.crc32(added, checksum)
    if not is_beginning:
        clear(target)
    names = _names(target)
    number = len(names)
    if names and len(target[names[-1]]) < GROWING:
        # Blender 5.0 cuts bytes that are put over others at the first zero.
        added, number = target[names[-1]] + added, number - 1
        del target[names[-1]]
    for first in range(0, len(added), LARGEST):
        target[f"{PIECES}{number:06d}"] = added[first : first + LARGEST]
        number += 1
    history = {"revisions": revisions, "position": position, "length": length, "checksum": checksum}
    target[HISTORY] = json.dumps(history)
    marks[length] = checksum


def clear(target):
    """Removes the document from an object."""
    for name in [*_names(target), HISTORY, WHOLE]:
        if name in target:
            del target[name]


def marks_of(path, data):
    """Returns the marks of a file that was opened from bytes: none where opening has changed them."""
    with open(path, "rb") as file:
        checksum = zlib.crc32(file.read(len(data)))
    return {len(data): checksum} if checksum == zlib.crc32(data) else {}


def note(path, revisions, position):
    """Writes the revisions beside a document's file, if that can be done: only a crash makes them needed."""
    part = f"{path}.part"
    with contextlib.suppress(OSError):
        with open(part, "w") as file:
            json.dump({"revisions": revisions, "position": position}, file)
        os.replace(part, f"{path}.json")


def remove(path):
    """Removes a document's file, its revisions and what a failed write has left."""
    for name in (path, f"{path}.json", f"{path}.part"):
        if os.path.exists(name):
            os.remove(name)


def left_behind(uid, revision):
    """Returns the document that an ended session has left in a temporary folder, or None if none has the revision."""
    own, found = os.path.basename(path_of(uid)), []
    above = os.path.dirname(os.path.normpath(folder()))
    for entry in os.scandir(above):
        path = os.path.join(entry.path, own)
        if entry.name.startswith("blender") and os.path.isfile(path) and _is_ours(path):
            found.append((os.stat(path).st_mtime_ns, path))
    for _time, path in sorted(found, reverse=True):
        try:
            with open(f"{path}.json") as file:
                revisions, position, _rest = _history(file.read())
            if revision in revisions:
                with open(path, "rb") as file:
                    return Document(file.read(), revisions, position)
        except (OSError, ValueError):
            continue
    return None


def _is_ours(path):
    """Returns whether a file belongs to the user of this session; temporary folders are everybody's."""
    return not hasattr(os, "getuid") or os.stat(path).st_uid == os.getuid()
