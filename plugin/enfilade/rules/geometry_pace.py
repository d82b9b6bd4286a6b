# SPDX-License-Identifier: GPL-3.0-or-later
"""How long the search for rooms will take and how much memory, told beforehand; how far it is; and whether to go on."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

Report = Callable[[float, str], bool]

# Seconds a million voxels and a million triangles of a soup, of one core of a server of 2023 (tests/bench/geometry_growth.py).
STAGES = {
    "pieces": (0.0, 7.0),
    "voxels": (0.04, 0.6),
    "openings": (0.0, 3.8),
    "levels": (0.005, 0.2),
    "holes": (0.008, 0.2),
    "regions": (0.045, 0.0),
    "shapes": (0.006, 2.6),
    "rooms joined": (0.015, 3.6),
}
OPENING = 1.5e-3  # s for each that is known, to shut it and again to join its rooms
VOXEL_BYTES = 15.0  # at the peak: labels, and masks and runs that the storeys are told apart by
TRIANGLE_BYTES = 200.0  # as given, and what is kept of each
OFTEN = 0.1  # s between two asks whether to go on, where there is a choice


class Cancelled(RuntimeError):
    """The user stopped a long operation."""


@dataclass
class Progress:
    """A part of the work. report(fraction of all, label) -> False cancels: `at` and `over` raise Cancelled then."""

    report: Report | None = None
    label: str = ""
    start: float = 0.0
    end: float = 1.0

    def at(self, fraction: float) -> None:
        if self.report is not None and self.report(self.start + (self.end - self.start) * fraction, self.label) is False:
            raise Cancelled(self.label)

    def over(self, items: Sequence[Any], start: float = 0.0, end: float = 1.0) -> Iterator[Any]:
        """The items one by one, telling between them how far they are on the way from start to end of this part."""
        told = time.perf_counter()
        for i, item in enumerate(items):
            if time.perf_counter() - told > OFTEN:
                self.at(start + (end - start) * i / len(items))
                told = time.perf_counter()
            yield item


NOBODY = Progress()  # is told nothing


@dataclass
class Estimate:
    seconds: dict[str, float]  # by stage
    bytes: float

    @staticmethod
    def of(voxels: float, triangles: float, openings: int = 0) -> Estimate:
        """openings: how many are known; those of a soup are in what its triangles take."""
        seconds = {name: 1e-6 * (a * voxels + b * triangles) for name, (a, b) in STAGES.items()}
        for name in ("openings", "rooms joined"):
            seconds[name] += OPENING * openings
        return Estimate(seconds, VOXEL_BYTES * voxels + TRIANGLE_BYTES * triangles)

    @property
    def words(self) -> str:
        total = sum(self.seconds.values())
        return f"about {total:.0f} s, {max(self.bytes, 1e8) / 1e9:.1f} GB" if total >= 1.0 else "at once"


class Stages:
    """One stage after another, each with its share of what was expected."""

    def __init__(self, report: Report | None, estimate: Estimate) -> None:
        self.spent: dict[str, float] = {}  # seconds by stage
        self._report, self._expected = report, estimate.seconds
        self._clock, self._name, self._done = time.perf_counter(), "", 0.0

    def begin(self, name: str, words: str = "") -> Progress:
        """Tells the stage's name (and words beside it) and gives its part of the progress."""
        self._end()
        self._name = name
        total = max(sum(self._expected.values()), 1e-9)
        first, self._done = self._done, self._done + self._expected[name] / total
        part = Progress(self._report, f"{name}: {words}" if words else name, first, min(self._done, 1.0))
        part.at(0.0)
        return part

    def close(self) -> None:
        self._end()
        Progress(self._report, "done").at(1.0)

    def _end(self) -> None:
        now = time.perf_counter()
        if self._name:
            self.spent[self._name] = now - self._clock
        self._clock = now
