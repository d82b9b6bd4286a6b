# SPDX-License-Identifier: GPL-3.0-or-later
"""The only part of the add-on that reads and writes Blender's data: scene in, arrays out, and back."""
