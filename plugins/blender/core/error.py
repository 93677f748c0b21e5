# SPDX-License-Identifier: GPL-3.0-or-later
"""The exception of operations that cannot be done, and failures as sentences for the user."""

import re


class Refused(Exception):
    """An operation that cannot be done; the message says why, and what to do."""


def said(failure):
    """Returns the sentence of a failure, without the name of the library's function that it begins with."""
    return re.sub(r"^rlv_\w+: ", "", str(failure))
