# SPDX-License-Identifier: GPL-3.0-or-later
"""The operators of each system, their settings, and the handlers of Blender."""
