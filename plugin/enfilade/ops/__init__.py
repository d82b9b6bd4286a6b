# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators, one verb each: collect inputs, call one function, report. All run without a window."""
