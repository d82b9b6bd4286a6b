# SPDX-License-Identifier: GPL-3.0-or-later
"""The report: pictures, tables and figures of an `Analysis`. Plain Python and numpy, OpenImageIO for pictures; no bpy.

    write_report(analysis, "out")  ->  report.html, report.json, *.csv, plan_*.png, plan_*.svg, plan_*.dxf, preview.png
"""

from __future__ import annotations

import unicodedata
from collections.abc import Callable
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
PICTURE_WIDTH = 2000  # pixels of a plan as PNG


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

    def put(self, drawn: Any, name: str, page: list[Sheet] | None = None, picture: bool = True) -> None:
        """Writes name.svg and, as a picture, name.png; adds it to the page's list. drawn None: there is nothing to draw."""
        from . import images, raster, svg

        if drawn is None:
            return
        svg.write(drawn, self._out / f"{name}.svg")
        self._paths.append(self._out / f"{name}.svg")
        if picture:
            images.write_png(self._out / f"{name}.png", raster.paint(drawn, PICTURE_WIDTH / drawn.width))
            self._paths.append(self._out / f"{name}.png")
        if page is None:
            return
        text = svg.fragment(drawn)
        fits = self._inlined + len(text) <= MOST_PAGE_SVG
        self._inlined += len(text) if fits else 0
        page.append(Sheet(f"{name}.svg", text if fits else ""))


def _plans_to_draw(model: Any, plans: list[Any], names: list[str]) -> list[tuple[Any, int | None, str]]:
    """(plan, camera or None for all of them, file name): storeys first, then each camera's, the storey where it stands before others."""
    jobs: list[tuple[Any, int | None, str]] = [(p, None, f"plan_{name}") for p, name in zip(plans, names, strict=True)]
    used: set[str] = set()
    for g, group in enumerate(model.cameras):
        camera = file_name(group.name, used)
        own, others = [], []
        for p, name in zip(plans, names, strict=True):
            job = (p, g, f"plan_{name}_{camera}")
            if any(c.group == g for c in p.cameras):
                own.append(job)
            elif any(r.index in group.rooms for r in p.rooms if r.resident):
                others.append(job)
        jobs += own + others
    return jobs


def write_report(analysis: Analysis, out_dir: str | Path, progress: Progress | None = None) -> list[Path]:
    """Writes the whole report into `out_dir` (made if absent) and returns the paths, report.html first.

    Every file is written whole or not at all. When `progress` returns False it stops and keeps what there is.
    """
    from . import (
        dxf,
        html,
        images,
        matrix_picture,
        metrics,
        plan,
        plan_drawing,
        raster,
        tables,
        view_maps,
    )

    out = Path(out_dir)
    out.mkdir(parents=True, exist_ok=True)

    def tell(fraction: float, text: str) -> bool:
        return progress is None or progress(fraction, text) is not False

    tell(0.0, "cutting plans")
    model = plan.Model(analysis)
    plans = [p for p in plan.storey_plans(model) if p.rooms]
    picture_areas = {(model.cameras[c.group].name, frame): i.area
                     for p in plans for c in p.cameras for frame, i in zip(c.frames, c.isovists, strict=True) if i.pieces}
    if not tell(0.1, "measuring rooms"):
        return []
    figures = metrics.room_figures(model)
    if not tell(0.2, "tables"):
        return []
    paths = tables.write_tables(model, figures, out, picture_areas)
    paths.append(tables.write_json(model, figures, out, picture_areas))
    if analysis.measures is not None:
        paths += view_maps.write_tables(model, analysis.measures, out)

    used: set[str] = set()
    names = [file_name(p.name, used) for p in plans]
    jobs = _plans_to_draw(model, plans, names)
    overviews = [j for j in jobs if j[1] is None]
    left_out = max(0, len(jobs) - len(overviews) - MOST_CAMERA_PLANS)
    jobs = jobs[: len(overviews) + MOST_CAMERA_PLANS]

    inlined: list[Sheet] = []
    by_camera: dict[int, list[Sheet]] = {}
    sheets = Sheets(out, paths)
    thumbnails = []
    for k, (p, g, name) in enumerate(jobs):
        if not tell(0.25 + 0.65 * k / max(len(jobs), 1), f"plan {k + 1} of {len(jobs)}"):
            return paths
        drawn = plan_drawing.overview(model, p) if g is None else plan_drawing.camera_plan(model, p, g)
        sheets.put(drawn, name, inlined if g is None else by_camera.setdefault(g, []))
        if g is None:
            dxf.write(model, p, out / f"{name}.dxf")
            paths.append(out / f"{name}.dxf")
        if len(thumbnails) < 24:
            thumbnails.append((drawn.title, images.halve(raster.paint(drawn, 2 * THUMBNAIL / drawn.width))))
    if len(thumbnails) > 1:
        images.write_png(out / "preview.png", images.contact_sheet(thumbnails, cell=THUMBNAIL))
        paths.append(out / "preview.png")
    if not tell(0.90, "matrix"):
        return paths
    page = html.Page(model, figures, picture_areas)
    if page.status is not None:
        if len(page.status) <= matrix_picture.LABELLED:
            sheets.put(matrix_picture.labelled(model, page.status), "matrix")
        else:
            images.write_png(out / "matrix.png", matrix_picture.pixels(model, page.status)[0])
            paths.append(out / "matrix.png")
    seen = np.where(figures.rooms_seen >= 0, figures.rooms_seen, np.nan).astype(float)
    storeys = list(zip(plans[:MOST_STOREYS], names[:MOST_STOREYS], strict=True))
    for k, (p, name) in enumerate(storeys):
        if not tell(0.91 + 0.04 * k / len(storeys), f"sightlines of {p.name}"):
            return paths
        sheets.put(plan_drawing.sightline_plan(model, p), f"sightlines_{name}", page.sight_plans)
        sheets.put(plan_drawing.measure_plan(model, p, seen, "rooms seen"), f"rooms_seen_{name}", page.measures)
    # measure by measure over all storeys, those of the page first: the page's budget then keeps whole sets
    measures = analysis.measures.definitions if analysis.measures is not None else []
    keys = sorted((m.key for m in measures), key=lambda key: key not in view_maps.ON_PAGE)
    for k, key in enumerate(keys):
        for p, name in storeys:
            if not tell(0.95 + 0.05 * k / len(keys), f"maps of {key.replace('_', ' ')}"):
                return paths
            into = page.view_maps.setdefault(key, []) if key in view_maps.ON_PAGE else None
            sheets.put(view_maps.plan_map(model, p, analysis.measures, key), f"view_{key}_{name}", into, picture=into is not None)
    listed = sorted(p.name for p in paths)
    text = page.assemble(inlined, left_out, by_camera, listed)
    path = out / "report.html"
    with whole_file(path) as partial:
        partial.write_text(text, encoding="utf-8", errors="replace")
    tell(1.0, "done")
    return [path, *paths]
