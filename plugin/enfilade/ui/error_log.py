# SPDX-License-Identifier: GPL-3.0-or-later
"""Things that went wrong where nobody could be told at once; shown in the panel, each once with a count."""

from __future__ import annotations

from dataclasses import dataclass

MOST = 20


@dataclass
class Entry:
    where: str
    message: str
    count: int = 1


_entries: list[Entry] = []


def add(where: str, message: str) -> None:
    for entry in _entries:
        if entry.where == where and entry.message == message:
            entry.count += 1
            return
    _entries.append(Entry(where, message))
    del _entries[:-MOST]


def entries() -> list[Entry]:
    return list(_entries)


def clear() -> None:
    _entries.clear()
