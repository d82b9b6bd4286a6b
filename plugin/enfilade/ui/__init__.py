# SPDX-License-Identifier: GPL-3.0-or-later
"""What a person sees: panels, the overlay, the list of things that went wrong."""
