# SPDX-License-Identifier: GPL-3.0-or-later
"""Tools of the toolbar, with what they draw over the view."""
