# SPDX-License-Identifier: GPL-3.0-or-later
"""The exception of operations that cannot be done, and failures as sentences for the user."""

import json

from . import words

# Exceptions of stored data with missing values or values of another kind; their texts are of Python.
STRANGE = (KeyError, IndexError, TypeError, AttributeError, json.JSONDecodeError)


class Refused(Exception):
    """An operation that cannot be done; the message says why, and what to do."""


def said(failure):
    """Returns a failure as a sentence in words of the panels."""
    if isinstance(failure, Refused):
        return str(failure)
    if getattr(failure, "place", "") or getattr(failure, "code", 0):
        return words.sentence(failure)
    if isinstance(failure, STRANGE):
        return "its stored data is damaged"
    if isinstance(failure, OSError) and failure.strerror:
        path = str(failure.filename or "").removesuffix(".part")
        return f"{path}: {failure.strerror}" if path else failure.strerror
    return words.plain(str(failure))
