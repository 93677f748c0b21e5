# SPDX-License-Identifier: GPL-3.0-or-later
"""The exception of operations that cannot be done."""


class Refused(Exception):
    """An operation that cannot be done; the message says why, and what to do."""
