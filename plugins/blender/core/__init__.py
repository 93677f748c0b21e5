# SPDX-License-Identifier: GPL-3.0-or-later
"""What all folders rest on: settings, errors, jobs, lengths, and the native library."""
