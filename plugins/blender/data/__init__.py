# SPDX-License-Identifier: GPL-3.0-or-later
"""What objects keep in the file, and what is made of it: documents, strokes, layers, results, caches, levels."""
