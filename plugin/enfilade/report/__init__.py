# SPDX-License-Identifier: GPL-3.0-or-later
"""The report: pictures, tables and figures of an `Analysis`. Plain Python and numpy, OpenImageIO for pictures; no bpy.

    write_report(analysis, "out")  ->  report.html, report.json, *.csv, plan_*.png, plan_*.svg, plan_*.dxf, preview.png
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..rules.results import Analysis
from ..rules.whole_file import whole_file

Progress = Callable[[float, str], Any]  # (fraction done, what is going on); returning False stops

# Budgets: a report stays something that opens. What is left out is named in the page.
MOST_PAGE_SVG = 10_000_000  # bytes of plans inlined in report.html
MOST_STOREYS = 30  # with plans of sightlines and figures
MOST_CAMERA_PLANS = 80  # pictures of single cameras
THUMBNAIL = 480  # pixels: width of a plan in preview.png
MOST_THUMBNAILS = 24
PICTURE_SCALE = 2.0  # pixels of a PNG a page unit


def file_name(text: str, used: set[str]) -> str:
    """A name that every file system takes, not yet in `used` (case ignored): letters, digits, dash, dot, underscore."""
    plain = unicodedata.normalize("NFKD", text).encode("ascii", "ignore").decode()
    name = "".join(c if c.isalnum() or c in "-." else "-" for c in plain)
    name = "-".join(p for p in name.split("-") if p).strip(".")[:40] or "unnamed"
    base, k = name, 2
    while name.lower() in used:
        name, k = f"{base}-{k}", k + 1
    used.add(name.lower())
    return name


@dataclass
class Sheet:
    """A drawing of the page."""

    file: str
    svg: str  # empty: the page had no room left for it


class Sheets:
    """Drawings on their way into files and, as long as it stays something that opens, into the page."""

    def __init__(self, out: Path, paths: list[Path]):
        self._out, self._paths, self._inlined = out, paths, 0

    def path(self, name: str) -> Path:
        """Where a file goes that is written now."""
        self._paths.append(self._out / name)
        return self._paths[-1]

    def put(self, drawn: Any, name: str, page: list[Sheet] | None = None, picture: bool = True) -> Any:
        """Writes name.svg and, as a picture, name.png; adds it to the page's list. drawn None: there is nothing to draw. The picture's
        pixels, if one was made."""
        from . import images, raster, svg

        if drawn is None:
            return None
        text = svg.write(drawn, self.path(f"{name}.svg"))
        pixels = None
        if picture:
            pixels = raster.paint(drawn, PICTURE_SCALE)
            images.write_png(self.path(f"{name}.png"), pixels)
        if page is not None:
            fits = self._inlined + len(text) <= MOST_PAGE_SVG
            self._inlined += len(text) if fits else 0
            page.append(Sheet(f"{name}.svg", text if fits else ""))
        return pixels


def _plans_to_draw(model: Any, plans: list[Any], names: list[str]) -> list[tuple[Any, int | None, str, float]]:
    """(plan, camera or None for all of them, file name, width of the sheet): storeys first, then each camera's, the storey where it stands
    before others and large."""
    from .plan_drawing import WIDE, sheet_width

    jobs = [(p, None, f"plan_{name}", sheet_width(len(plans))) for p, name in zip(plans, names, strict=True)]
    used: set[str] = set()
    for g, group in enumerate(model.cameras):
        camera = file_name(group.name, used)
        own, others = [], []
        for p, name in zip(plans, names, strict=True):
            job = p, g, f"plan_{name}_{camera}"
            if any(c.group == g for c in p.cameras):
                own.append(job)
            elif any(r.index in group.rooms for r in p.rooms if r.resident):
                others.append(job)
        drawn = own + others
        jobs += [(*job, WIDE if k == 0 else sheet_width(len(drawn))) for k, job in enumerate(drawn)]
    return jobs


def write_report(analysis: Analysis, out_dir: str | Path, progress: Progress | None = None) -> list[Path]:
    """Writes the whole report into `out_dir` (made if absent) and returns the paths, report.html first.

    Every file is written whole or not at all. When `progress` returns False it stops and keeps what there is.
    """
    out = Path(out_dir)
    out.mkdir(parents=True, exist_ok=True)
    paths: list[Path] = []
    for fraction, text in _write(analysis, out, paths):
        if progress is not None and progress(fraction, text) is False:
            break
    return paths


Steps = Iterator[tuple[float, str]]  # (fraction done, what comes next): between two of them a report may be stopped


def _write(analysis: Analysis, out: Path, paths: list[Path]) -> Steps:
    from . import html, metrics, plan, tables, view_maps

    yield 0.0, "cutting plans"
    model = plan.Model(analysis)
    plans = [p for p in plan.storey_plans(model) if p.rooms]
    picture_areas = {(model.cameras[c.group].name, frame): i.area
                     for p in plans for c in p.cameras for frame, i in zip(c.frames, c.isovists, strict=True) if i.pieces}
    yield 0.1, "measuring rooms"
    figures = metrics.room_figures(model)
    yield 0.2, "tables"
    paths += tables.write_tables(model, figures, out, picture_areas)
    paths.append(tables.write_json(model, figures, out, picture_areas))
    if analysis.measures is not None:
        paths += view_maps.write_tables(model, analysis.measures, out)
    page = html.Page(model, figures, picture_areas)
    sheets = Sheets(out, paths)
    used: set[str] = set()
    names = [file_name(p.name, used) for p in plans]
    yield from _plans(page, plans, names, sheets)
    yield 0.9, "matrix"
    _matrix(page, sheets)
    yield from _maps(page, list(zip(plans, names, strict=True))[:MOST_STOREYS], sheets)
    text = page.assemble(sorted(p.name for p in paths))
    path = out / "report.html"
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8", errors="replace")
    paths.insert(0, path)
    yield 1.0, "done"


def _plans(page: Any, plans: list[Any], names: list[str], sheets: Sheets) -> Steps:
    """The storeys, and as each camera sees them."""
    from . import dxf, images, plan_drawing

    model = page.model
    jobs = _plans_to_draw(model, plans, names)
    most = len(plans) + MOST_CAMERA_PLANS
    page.plans_left_out = max(0, len(jobs) - most)
    thumbnails = []
    for k, (p, g, name, width) in enumerate(jobs[:most]):
        yield 0.25 + 0.65 * k / min(len(jobs), most), f"plan {k + 1} of {min(len(jobs), most)}"
        drawn = plan_drawing.overview(model, p, width) if g is None else plan_drawing.camera_plan(model, p, g, width)
        picture = sheets.put(drawn, name, page.overviews if g is None else page.camera_plans.setdefault(g, []))
        if g is None:
            dxf.write(model, p, sheets.path(f"{name}.dxf"))
        if len(thumbnails) < MOST_THUMBNAILS:
            thumbnails.append((drawn.title, images.shrink(picture, THUMBNAIL)))
    if len(thumbnails) > 1:
        images.write_png(sheets.path("preview.png"), images.contact_sheet(thumbnails, cell=THUMBNAIL))


def _matrix(page: Any, sheets: Sheets) -> None:
    from . import images, matrix_picture

    if page.status is None:
        return
    if len(page.status) <= matrix_picture.LABELLED:
        sheets.put(matrix_picture.labelled(page.model, page.status), "matrix")
    else:
        images.write_png(sheets.path("matrix.png"), matrix_picture.pixels(page.model, page.status)[0])


def _maps(page: Any, storeys: list[tuple[Any, str]], sheets: Sheets) -> Steps:
    """Sightlines, rooms by what they see, floors by what is seen from them."""
    from . import plan_drawing, view_maps

    model, measures = page.model, page.model.analysis.measures
    width = plan_drawing.sheet_width(len(storeys))
    seen = np.where(page.f.rooms_seen >= 0, page.f.rooms_seen, np.nan).astype(float)
    for k, (p, name) in enumerate(storeys):
        yield 0.91 + 0.04 * k / len(storeys), f"sightlines of {p.name}"
        sheets.put(plan_drawing.sightline_plan(model, p, width), f"sightlines_{name}", page.sight_plans)
        sheets.put(plan_drawing.measure_plan(model, p, seen, "rooms seen", width), f"rooms_seen_{name}", page.measures)
    # measure by measure over all storeys, those of the page first: the page's budget then keeps whole sets
    keys = sorted((m.key for m in measures.definitions), key=lambda key: key not in view_maps.ON_PAGE) if measures is not None else []
    for k, key in enumerate(keys):
        for p, name in storeys:
            yield 0.95 + 0.05 * k / len(keys), f"maps of {key.replace('_', ' ')}"
            into = page.view_maps.setdefault(key, []) if key in view_maps.ON_PAGE else None
            sheets.put(view_maps.plan_map(model, p, measures, key), f"view_{key}_{name}", into, picture=into is not None)
