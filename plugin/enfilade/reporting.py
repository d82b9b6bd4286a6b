# SPDX-License-Identifier: GPL-3.0-or-later
"""A report from a building and its shots: looked at, measured, written. For the batch command and the button alike; no bpy, so that it
may run in a thread, with an analyser of its own (measuring shuts openings for a while, which a live view must not see)."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from . import view_measures
from .analysis import Analyser, AnalysisError, Shot
from .report import write_report
from .rules.building import WARNING, Building, Problem
from .rules.results import RoomMatrix, View, unculled

Progress = Callable[[float, str], Any]  # (fraction done, what is going on); returning False stops
# Shares of the whole, as they are in a house; larger buildings take longer for the first.
MATRIX, MEASURES = 0.2, 0.5


@dataclass
class Wanted:
    """What a report is to hold."""

    title: str = ""
    detected: str = ""  # what Detect found, and what it had found before, as a sentence
    method: str = "portal"
    matrix: str = "exact"  # or flow, sample, none
    known: RoomMatrix | None = None  # a matrix that is there already
    time_limit: float = 0.0  # seconds for the matrix; 0: none
    measures: bool = True
    grid: float = 0.0  # metres between points of the measures; 0: chosen
    occluders: str = "off"
    distance: float = math.inf  # metres that are looked at


@dataclass
class Report:
    paths: list[Path] = field(default_factory=list)
    views: list[View] = field(default_factory=list)
    matrix: RoomMatrix | None = None
    matrix_seconds: float = 0.0
    notes: list[str] = field(default_factory=list)  # what is missing, and why
    stopped: bool = False


def make(core: Any, building: Building, shots: list[Shot], folder: str | Path, wanted: Wanted, progress: Progress | None = None) -> Report:
    """OSError where it can't be written, AnalysisError where a shot can't be looked at. When progress
    returns False it stops; files written by then stay."""
    out = Report()

    def part(first: float, last: float) -> Progress:
        def tell(fraction: float, text: str) -> bool:
            if progress is not None and progress(first + (last - first) * fraction, text) is False:
                out.stopped = True
            return not out.stopped

        return tell

    Path(folder).mkdir(parents=True, exist_ok=True)  # refused now rather than when all is computed
    analyser = Analyser(core, building, wanted.occluders, wanted.distance)
    try:
        out.views = [analyser.look(shot, wanted.method) for shot in shots]
        out.notes += unculled(out.views)
        out.matrix = wanted.known
        begin = time.perf_counter()
        if out.matrix is None and wanted.matrix != "none":
            try:
                out.matrix = analyser.room_matrix(wanted.matrix, wanted.time_limit, part(0.0, MATRIX))
            except AnalysisError as error:
                out.notes.append(f"no room matrix: {error}")
                analyser.problems.append(Problem(WARNING, "no-matrix", f"The room-to-room matrix could not be made: {error}"))
        out.matrix_seconds = time.perf_counter() - begin
        analysis = analyser.analysis(out.views, out.matrix, wanted.title)
        analysis.detected = wanted.detected
        if wanted.measures and not out.stopped:
            try:
                analysis.measures = view_measures.survey(core, analyser, out.views, wanted.grid, part(MATRIX, MEASURES))
            except core.EnfError as error:
                out.notes.append(f"no view measures: {error}")
        if not out.stopped:
            out.paths = write_report(analysis, folder, part(MEASURES, 1.0))
    finally:
        analyser.close()
    return out
