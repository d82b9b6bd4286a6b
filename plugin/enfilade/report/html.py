# SPDX-License-Identifier: GPL-3.0-or-later
"""report.html: one file that opens from disk and asks the network for nothing. Pictures first, then tables.

Every text from the model goes through `svg.clean`. A content security policy forbids every request, so that even a
mistake here could not make one.
"""

from __future__ import annotations

import base64
import math
from collections import Counter
from collections.abc import Iterable
from typing import TYPE_CHECKING
from urllib.parse import quote

import numpy as np

from ..rules.building import ERROR, INFO, WARNING, Problem
from ..rules.names import sentence
from ..rules.results import unculled
from . import images, matrix_picture, metrics, tables, view_maps
from .drawing import GRAZING, IN_PICTURE, NOT_SEEN, OWN_ROOM, SEEN, SELF, UNDECIDED, VISIBLE, shorten
from .html_assets import SCRIPT, STYLE
from .matrix_picture import EMPTY
from .metrics import RoomFigures
from .plan import Model
from .plan_drawing import HOUSE_SIZED
from .svg import clean, fragment

if TYPE_CHECKING:
    from . import Sheet

# What goes into the page at most; beyond, the page says so and names the file that holds everything.
MOST_ROWS = 4000  # of one table
MOST_SIGHTLINES = 400
MOST_CAMERAS = 200
MOST_ALIKE = 60  # problems of one kind
MOST_WAYS = 60  # of one camera
MOST_NEIGHBOURS = 16_000  # rooms named in the "who sees whom" table: fewer a row where there are many rows
MOST_PER_ROOM, LEAST_PER_ROOM = 40, 8  # in one row
MOST_PRINTED = 60  # rows of one table on paper: html_assets.py's style counts the same
LONG = 30  # rows: longer tables scroll in themselves and can be searched
MOST_NAME = 120  # characters of one name
PLURALS = {"door": "doors", "window": "windows", "hole": "holes", "virtual": "virtual openings (no wall between the rooms)"}
ON_SCREEN = ("files", "statistics")  # sections that say nothing on paper


def esc(text) -> str:
    return clean(shorten(str(text), MOST_NAME))


def figure(x, digits: int = 1) -> str:
    """A number for people; empty where it doesn't apply."""
    if x is None or (isinstance(x, float | np.floating) and math.isnan(x)):
        return ""
    if isinstance(x, float | np.floating):
        return "∞" if math.isinf(x) else f"{float(x):,.{digits}f}"
    return f"{int(x):,}"


def cell(x, digits: int = 1) -> str:
    raw = "" if x is None or (isinstance(x, float | np.floating) and math.isnan(x)) else \
        "1e308" if isinstance(x, float | np.floating) and math.isinf(x) else f"{float(x):.9g}"
    return f'<td class="n" data-v="{raw}">{figure(x, digits)}</td>'


class Page:
    def __init__(self, model: Model, figures: RoomFigures, picture_areas: dict):
        self.model, self.f, self.picture_areas = model, figures, picture_areas
        self.overviews: list[Sheet] = []  # one a storey
        self.camera_plans: dict[int, list[Sheet]] = {}
        self.plans_left_out = 0
        self.sight_plans: list[Sheet] = []
        self.measures: list[Sheet] = []
        self.view_maps: dict[str, list[Sheet]] = {}  # by measure, one a storey
        self.status = metrics.pair_status(model)
        self.lines = metrics.sightlines_by_pair(model)

    # -- small parts ----------------------------------------------------------------------------------------
    def way(self, openings: Iterable[int]) -> str:
        known = self.model.building.openings
        names = []
        for o in openings:
            label = shorten(self.model.names.opening(o), 40) if 0 <= o < len(known) else f"#{o}"
            full = f' title="{esc(known[o].name)}"' if 0 <= o < len(known) and label != known[o].name else ""
            names.append(f"<b{full}>{esc(label)}</b>")
        if not names:
            return '<span class="none">in its own room</span>'
        return '<span class="way">' + ' <i>›</i> '.join(names) + "</span>"

    def room(self, i: int) -> str:
        return esc(self.model.names.room(i)) if 0 <= i < len(self.model.building.rooms) else "?"

    @staticmethod
    def table(header: list[str], rows: list[str], file: str, classes: str = "") -> str:
        """file: where all rows are."""
        more = ""
        if len(rows) > MOST_ROWS:
            more = f'<p class="note">{len(rows) - MOST_ROWS:,} more rows are in {_link(file)}.</p>'
        if len(rows) > MOST_PRINTED:
            more += f'<p class="note printed">The first {MOST_PRINTED} of {len(rows):,} rows; all are in {clean(file)}.</p>'
        long = len(rows) > LONG
        frame = ' tall" tabindex="0" role="region" aria-label="Table' if long else ""  # to be scrolled by keys it must take the focus
        return (f'<div class="wide{frame}"><table class="sort{" long" if long else ""} {classes}"><thead><tr>{"".join(header)}</tr></thead>'
                f'<tbody>{"".join(rows[:MOST_ROWS])}</tbody></table></div>{more}')

    @staticmethod
    def head(label: str, unit: str = "", numeric: bool = False, title: str = "") -> str:
        small = f"<small>{clean(unit)}</small>" if unit else ""
        tip = f' title="{clean(title)}"' if title else ""
        return f'<th scope=col{" class=n" if numeric else ""}{tip}>{clean(label)}{small}</th>'

    # -- sections -------------------------------------------------------------------------------------------
    def summary(self) -> str:
        m, b = self.model, self.model.building
        inside = len(b.rooms) - len(m.exterior)
        seen = len(set().union(*(g.rooms for g in m.cameras)) - m.exterior) if m.cameras else 0
        numbers = [(inside, "rooms"), (len(m.storeys), "storeys"), (len(b.openings), "openings"), (len(b.objects), "objects"),
                   (len(m.cameras), "cameras")]
        if m.cameras:
            numbers.append((seen, "rooms seen by a camera"))
        if self.status is not None:
            index = [i for i in range(len(b.rooms)) if i not in m.exterior]
            sub = self.status[np.ix_(index, index)] > 0
            numbers.append(((int(sub.sum()) - len(index)) // 2, "pairs of rooms see each other"))
        numbers.append((sum(p.severity != INFO for p in b.problems), "problems found"))  # as Detect counts them
        items = "".join(f"<li><b>{n:,}</b><span>{clean(t)}</span></li>" for n, t in numbers)
        found = f" Found by Detect: {esc(m.analysis.detected)}." if m.analysis.detected else ""
        source = {"ifc": "an IFC model", "annotated": "an annotated scene", "geometry": "bare geometry"}.get(b.source, b.source)
        return (f'<header><h1>{esc(m.analysis.title or "Visibility report")}</h1>'
                f'<p class="sub">What can be seen through the doors and windows. Rooms and openings come from {esc(source)}.{found}</p>'
                f'<ul class="figures">{items}</ul></header>')

    def overview(self) -> str:
        if not self.overviews:
            return '<p class="none">No storey has rooms that could be drawn.</p>'
        colours = "Rooms are coloured by the number of cameras that see them. " if len(self.model.cameras) > 1 else ""
        doors = ("Cut walls are dark. Doors are gaps, with a bar where shut; glass is a blue line; holes in floors are crossed, "
                 "holes in ceilings dashed. A room too small for its name shows its number in the table of rooms.")
        return f"<p>{colours}{doors}</p>{self._plans(self.overviews)}"

    @staticmethod
    def _plans(sheets: list[Sheet], wide: int = HOUSE_SIZED) -> str:
        """One a row where there are at most `wide`, else two; those the page has no room for are named."""
        drawn = [s.svg for s in sheets if s.svg]
        missing = [s.file for s in sheets if not s.svg]
        few = " few" if len(drawn) <= wide else ""
        figures = "".join(f"<figure>{svg}</figure>" for svg in drawn)
        note = f'<p class="note">Not in this page, which would grow too large: {", ".join(map(_link, missing))}.</p>' if missing else ""
        return (f'<div class="plans{few}">{figures}</div>' if drawn else "") + note

    def cameras(self) -> str:
        m = self.model
        if not m.cameras:
            return '<p class="none">The analysis holds no cameras. Put one into the scene to see what it sees.</p>'
        out = [_key([(OWN_ROOM, "the camera's own room"), (SEEN, "room seen, in part or whole"),
                     (IN_PICTURE, "in the picture, at the camera's eye height"), (NOT_SEEN, "not seen")])]
        rooms_inside = len(m.building.rooms) - len(m.exterior)
        for g, group in enumerate(m.cameras[:MOST_CAMERAS]):
            inside = group.rooms - m.exterior
            areas = [a for (name, _), a in self.picture_areas.items() if name == group.name]
            facts = [f"sees {len(inside):,} of {rooms_inside:,} rooms" + (" and the outdoors" if group.rooms & m.exterior else ""),
                     f"{len(group.objects):,} of {len(m.building.objects):,} objects"]
            if areas and max(areas) > 0:
                facts.append(f"{figure(float(np.median(areas)))} m² of floor in the picture" + (" (median)" if len(areas) > 1 else ""))
            times = [v.microseconds for v in group.views if v.microseconds > 0]
            if len(group.views) > 1:
                facts.append(f"{len(group.views):,} frames, {group.views[0].frame}–{group.views[-1].frame}")
            if times:
                facts.append(f"found in {figure(float(np.median(times)), 0)} µs" + (" a frame" if len(times) > 1 else ""))
            out.append(f'<h3 id="camera-{g}">{esc(group.name)}</h3><p class="sub">{" · ".join(facts)}</p>')
            out += [f'<p class="note">{esc(sentence)}.</p>' for sentence in unculled(group.views)]
            drawn = self.camera_plans.get(g, [])
            if len(drawn) > HOUSE_SIZED:  # where it stands large, the other storeys small
                out += [self._plans(drawn[:1]), self._plans(drawn[1:], 0)]
            else:
                out.append(self._plans(drawn) or '<p class="none">No plan of this camera was drawn.</p>')
            out.append(self._ways(group))
        if self.plans_left_out:
            out.append(f'<p class="note">{self.plans_left_out:,} more plans of single cameras were not drawn.</p>')
        if len(m.cameras) > MOST_CAMERAS:
            out.append(f'<p class="note">{len(m.cameras) - MOST_CAMERAS:,} more cameras are in views.csv and view_rooms.csv.</p>')
        return "".join(out)

    def _ways(self, group) -> str:
        """One row per opening sequence: rooms and objects first seen that way."""
        ways: dict[tuple[int, ...], tuple[dict[int, None], set[int]]] = {}
        for view in group.views:
            for r in view.rooms:
                ways.setdefault(tuple(view.room_why.get(r, ())), ({}, set()))[0][r] = None
            for o in view.objects:
                if o in view.why:
                    ways.setdefault(tuple(view.why[o]), ({}, set()))[1].add(o)
        rows = []
        for way, (rooms, objects) in sorted(ways.items(), key=lambda w: (len(w[0]), w[0])):
            named = ", ".join(self.room(r) for r in list(rooms)[:MOST_PER_ROOM])
            if len(rooms) > MOST_PER_ROOM:
                named += f" and {len(rooms) - MOST_PER_ROOM} more"
            rows.append(f"<tr><td>{self.way(way)}</td><td>{named or '<span class=none>none</span>'}</td>{cell(len(objects))}</tr>")
        more = ""
        if len(rows) > MOST_WAYS:
            more = f'<p class="note">{len(rows) - MOST_WAYS:,} longer sequences are in {_link("view_rooms.csv")} and {_link("view_objects.csv")}.</p>'
        return self.table([self.head("Through"), self.head("Rooms seen first this way"),
                           self.head("Objects", "first seen", True)], rows[:MOST_WAYS], "view_rooms.csv") + more

    def matrix(self) -> str:
        m, a = self.model, self.model.analysis
        if self.status is None:
            return '<p class="none">The room-to-room matrix was not computed.</p>'
        n = len(self.status)
        method = a.matrix.method
        upper = np.triu(self.status, 1)
        counts = {k: int((upper == k).sum()) for k in (metrics.SEEN, metrics.GRAZING, metrics.UNPROVEN)}
        outdoors = int((upper[:, sorted(m.exterior)] == metrics.SEEN).sum() + (upper[sorted(m.exterior)] == metrics.SEEN).sum())
        words = [f"{counts[metrics.SEEN]:,} pairs proven by a sightline" + (f", {outdoors:,} of them with the outdoors" if outdoors else "")]
        if counts[metrics.GRAZING]:
            keep = a.matrix.statistics.get("clearance")
            far = f"{1000 * keep:.2g} mm" if keep else "the clearance asked for"
            words.append(f"{counts[metrics.GRAZING]:,} grazing (lines pass, none keeps {far} from every edge)")
        if counts[metrics.UNPROVEN]:
            words.append(f"{counts[metrics.UNPROVEN]:,} "
                         + ("undecided, counted as visible" if method == "exact" else "visible without a proof"))
        out = [f'<p>Which rooms see which, from anywhere inside them. <b>{clean(metrics.HONESTY.get(method, shorten(method, 80)))}</b> '
               f'{clean("; ".join(words))}.</p>',
               _key([(VISIBLE, "visible, with a sightline"), *([(GRAZING, "grazing")] if counts[metrics.GRAZING] else []),
                     *([(UNDECIDED, "counts as visible, not proven")] if counts[metrics.UNPROVEN] else []),
                     (EMPTY, "not found" if method == "sample" else "hidden"), (SELF, "itself")])]
        if n <= matrix_picture.LABELLED:
            drawn = matrix_picture.labelled(m, self.status)
            out.append(f'<figure class="matrix"><div style="max-width:{drawn.width * 1.25:.0f}px">{fragment(drawn)}</div></figure>')
        else:
            picture, block = matrix_picture.pixels(m, self.status)
            data = base64.b64encode(images.png_bytes(picture)).decode()
            bands = ", ".join(f"{esc(name)} ({count})" for name, count in matrix_picture.bands(m)[:60])
            each = f"Each square stands for {block} × {block} pairs of rooms, coloured by the most visible of them." if block > 1 \
                else "Each square is a pair of rooms."
            out.append(f'<figure class="matrix"><img alt="Room-to-room matrix: the rows below tell the same in words" src="data:image/png;base64,{data}">'
                       f'<figcaption>{each} Rooms by storey, top to bottom and left to right: {bands}.</figcaption></figure>')
        out.append(self._neighbours())
        return "".join(out)

    def _neighbours(self) -> str:
        m, rows = self.model, []
        shown = matrix_picture.order(m)[:MOST_ROWS]
        most = min(max(MOST_NEIGHBOURS // max(len(shown), 1), LEAST_PER_ROOM), MOST_PER_ROOM)
        sightlines = m.analysis.matrix.sightlines
        for i in shown:
            others = [int(j) for j in np.nonzero(self.status[i])[0] if j != i]
            if len(others) > most:  # seen through the fewest openings first
                first = {j: self.lines.get((min(i, j), max(i, j))) for j in others}
                others.sort(key=lambda j, first=first: (len(sightlines[first[j][0]].openings) if first[j] else 99, j))
            parts = []
            for j in others[:most]:
                pair = self.lines.get((min(i, j), max(i, j)))
                tag = {metrics.GRAZING: ' <span class="tag grazing">grazing</span>',
                       metrics.UNPROVEN: ' <span class="tag unproven">not proven</span>'}.get(int(self.status[i, j]), "")
                way = ""
                if pair:
                    line = sightlines[pair[0]]
                    order = line.openings if line.rooms[0] == i else list(line.openings)[::-1]
                    way = f" {self.way(order)}" if order else ""
                parts.append(f"<div>{self.room(j)}{way}{tag}</div>")
            if len(others) > most:
                parts.append(f'<div class="none">and {len(others) - most:,} more, in pairs.csv</div>')
            rows.append(f'<tr data-room="{i}"><td class="one">{self.room(i)}</td>{cell(len(others))}'
                        f'<td>{"".join(parts) or "<span class=none>no other room</span>"}</td></tr>')
        table = self.table([self.head("Room"), self.head("Sees", "rooms", True), self.head("Which, and through which openings")], rows,
                           "pairs.csv", "full")
        more = f'<p class="note">{len(self.status) - len(shown):,} more rooms are in pairs.csv.</p>' \
            if len(self.status) > len(shown) else ""
        folded = len(shown) > 30
        return (f"<details><summary>Who sees whom, room by room</summary>{table}{more}</details>" if folded
                else f"<h3>Room by room</h3>{table}{more}")

    def rooms(self) -> str:
        m, f = self.model, self.f
        if not m.building.rooms:
            return '<p class="none">No rooms were found.</p>'
        d = {x.key: x for x in metrics.DEFINITIONS}
        keys = ["area_m2", "volume_m3", "seen_by", "sees_outdoors", "glazed_openings", "rooms_seen", "visual_mean_depth",
                "visual_integration", "control", "clustering", "entrance_depth"]
        header = [self.head("No.", "", True), self.head("Room"), self.head("Storey"),
                  *(self.head(d[k].label, d[k].unit, k != "sees_outdoors", d[k].text) for k in keys)]
        rows = []
        for i in matrix_picture.order(m):  # by storey, lowest first
            if i in m.exterior:
                continue
            out = {True: "yes", False: "–", None: ""}[f.sees_outdoors[i]]
            nan = math.nan
            rows.append(
                f'<tr data-room="{i}">{cell(i + 1)}<td class="one">{self.room(i)}</td><td class="one">{esc(m.storey_name(i))}</td>{cell(f.area[i])}'
                f'{cell(f.volume[i])}{cell(len(f.seen_by[i]))}<td>{out}</td>{cell(len(f.glazed[i]))}'
                f'{cell(int(f.rooms_seen[i]) if f.rooms_seen[i] >= 0 else None)}{cell(f.mean_depth[i], 2)}'
                f'{cell(f.integration[i], 2)}{cell(f.control[i], 2)}{cell(f.clustering[i], 2)}'
                f'{cell(int(f.entrance_depth[i]) if f.entrance_depth[i] >= 0 else nan)}</tr>')
        note = f'<p class="note">{clean(f.note)}</p>' if f.note else ""
        return (f'<p>Click a heading to sort, point at a row to find the room in the plans. '
                f'<a href="#definitions">What the figures mean</a>.</p>{self._plans(self.measures)}{self.table(header, rows, "rooms.csv", "tight")}{note}')

    def views(self) -> str:
        m, found = self.model, self.model.analysis.measures
        if found is None or not len(found.grid.points):
            return '<p class="none">View measures were not made.</p>'
        share = view_maps.building_shares(found)
        facts = [(share["sees_out"], "of the floor sees outdoors"), (share["minimum"], "reaches EN 17037's minimum sight angle, 14°"),
                 (share["medium"], "its medium, 28°"), (share["high"], "its high, 54°"),
                 (share["two_ways"], "sees out in two directions at least 90° apart (LEED v4, Quality Views)")]
        items = "".join(f"<li><b>{n:.0f} %</b><span>{clean(t)}</span></li>" for n, t in facts)
        out = [f'<p>What a person sees from each place, eye {found.eye:g} m above the floor (seated), all around: {len(found.grid.points):,} '
               f'places, {found.grid.spacing:g} m apart. Doors as they stand; furniture and what stands outdoors are not counted, so that these '
               f'figures are the most the building allows. <a href="#definitions">What the figures mean</a>.</p>',
               f'<ul class="figures">{items}</ul>']
        if found.cut_short:
            out.append('<p class="note">Stopped before all rooms were measured.</p>')
        for measure in found.definitions:
            if self.view_maps.get(measure.key):
                source = f" <i>{clean(measure.source)}</i>" if measure.source else ""
                _, colours, words = view_maps.classes(found, measure.key)
                out.append(f'<h3>{clean(measure.label)}, {clean(measure.unit)}</h3><p class="sub">{clean(measure.text)}{source}</p>'
                           + _key(zip(colours, words, strict=True)) + self._plans(self.view_maps[measure.key], 0))
        header = [self.head("Room"), self.head("Storey"),
                  *(self.head(k.label, k.unit, True, k.text) for k in found.definitions), self.head("Sees out", "% of floor", True),
                  self.head("EN 17037", "% at minimum", True), self.head("Two ways out", "% of floor", True)]
        rows = []
        for i in matrix_picture.order(m):
            if math.isfinite(found.rooms["points"][i]):
                rows.append(f'<tr data-room="{i}"><td class="one">{self.room(i)}</td><td class="one">{esc(m.storey_name(i))}</td>'
                            + "".join(cell(found.rooms[k.key][i]) for k in found.definitions)
                            + "".join(cell(v, 0) for v in (found.rooms["with_view"][i], found.rooms["en17037"][i],
                                                           100.0 * found.rooms["two_ways"][i])) + "</tr>")
        out.append("<h3>Room by room</h3><p>Means over the room's places; of the longest view the longest.</p>" + self.table(header, rows, "view_measures.csv", "tight"))
        if found.cameras:
            header = [self.head("Camera"), self.head("Stands in"), *(self.head(k.label, k.unit, True, k.text) for k in found.definitions),
                      self.head("Floor seen", "m²", True, "Floor in view from the camera's place, all around.")]
            rows = [f'<tr><td class="one">{esc(c["camera"])}</td><td class="one">{self.room(c["room"])}</td>'
                    + "".join(cell(c[k.key]) for k in found.definitions) + cell(c["floor_area"]) + "</tr>" for c in found.cameras]
            out.append("<h3>From the cameras' places</h3><p>All around each camera's eye, whichever way it looks.</p>"
                       + self.table(header, rows, "view_cameras.csv", "tight"))
        return "".join(out)

    def openings(self) -> str:
        m = self.model
        if not m.building.openings:
            return '<p class="none">No openings were found.</p>'
        looking = tables.looking_through(m)
        rows = []
        kinds: dict[str, Counter[str]] = {}
        for i, o in enumerate(m.building.openings):
            kinds.setdefault(o.kind, Counter())[o.state] += 1
            joined = sorted(o.rooms or (), key=lambda r: r in m.exterior)  # "Bath – Exterior", always this way round
            sides = " – ".join(map(self.room, joined)) or '<span class="tag warning">leads nowhere</span>'
            w, h, sill, depth = tables.opening_size(o)
            by = looking.get(i, [])
            seen = ", ".join(map(esc, by[:12])) + (f" and {len(by) - 12} more" if len(by) > 12 else "")
            rows.append(f'<tr>{cell(i + 1)}<td title="{esc(o.name)}">{esc(m.names.opening(i))}</td><td>{esc(o.kind)}</td><td>{esc(o.state)}</td>'
                        f"<td>{sides}</td>{cell(w, 2)}{cell(h, 2)}{cell(sill - m.level(joined), 2)}{cell(depth, 2)}<td>{seen}</td></tr>")
        many = [f"{counts.total():,} {PLURALS.get(kind, kind)} ({', '.join(f'{n:,} {state}' for state, n in counts.most_common())})"
                for kind, counts in sorted(kinds.items())]
        return f"<p>{clean('; '.join(many))}.</p>" + self.table(
            [self.head("No.", "", True), self.head("Opening"), self.head("Kind"), self.head("State"), self.head("Joins"),
             self.head("Width", "m", True), self.head("Height", "m", True),
             self.head("Sill", "m", True, "Height of the lower edge above the floor of the lower of its rooms."), self.head("Depth", "m", True),
             self.head("Looked through by", "", False, "Cameras whose view passes it, whatever it shows; the plans of the cameras mark the same openings.")], rows, "openings.csv", "tight")

    def privacy(self) -> str:
        found = metrics.overlooked(self.model)
        how = ("Rooms people expect not to be looked into (bedrooms, bathrooms, toilets, changing and treatment rooms, by their "
               "names) and who can see into them. ")
        if not found:
            return f'<p>{how}</p><p class="none">None is overlooked, or no room has such a name.</p>'
        rows = [f'<tr data-room="{o.room}"><td>{self.room(o.room)}</td><td>{esc(o.from_name)}</td>'
                f'<td>{self.way(o.openings) if o.openings else ""}</td><td>{esc(o.status)}</td><td>{esc(o.advice)}</td></tr>'
                for o in found]
        return f"<p>{how}</p>" + self.table([self.head("Room"), self.head("Seen from"), self.head("Through"),
                                             self.head("How sure"), self.head("What would close it")], rows, "pairs.csv")

    def sightlines(self) -> str:
        matrix = self.model.analysis.matrix
        if matrix is None or not matrix.sightlines:
            return '<p class="none">No sightlines are recorded.</p>'
        rows = []
        for s in matrix.sightlines[:MOST_SIGHTLINES]:
            ends = [", ".join(f"{float(v):.2f}" for v in p) for p in (s.start, s.end)]
            rows.append(f"<tr><td>{self.room(s.rooms[0])}</td><td>{self.room(s.rooms[1])}</td><td>{self.way(s.openings)}</td>"
                        f"{cell(math.dist(s.start, s.end), 2)}<td>{ends[0]}</td><td>{ends[1]}</td></tr>")
        more = f'<p class="note">{len(matrix.sightlines) - MOST_SIGHTLINES:,} more are in {_link("sightlines.csv")}.</p>' \
            if len(matrix.sightlines) > MOST_SIGHTLINES else ""
        table = self.table([self.head("From"), self.head("To"), self.head("Through"), self.head("Length", "m", True),
                            self.head("Start", "x, y, z in m"), self.head("End", "x, y, z in m")], rows, "sightlines.csv")
        return ("<p>A sightline is a straight segment from one room to another that passes through openings only: proof that "
                "they see each other. Each is drawn on the storeys it passes."
                f"</p>{self._plans(self.sight_plans)}<details><summary>{len(matrix.sightlines):,} sightlines</summary>{table}{more}</details>")

    def problems(self) -> str:
        """Those of a kind in one row: the first as it is, the others in a fold."""
        alike: dict[tuple[int, str], list[Problem]] = {}
        rank = {ERROR: 0, WARNING: 1}
        for p in self.model.building.problems:
            alike.setdefault((rank.get(p.severity, 2), p.code), []).append(p)
        if not alike:
            return '<p class="none">None.</p>'
        rows = []
        for _, (first, *others) in sorted(alike.items(), key=lambda kind: kind[0][0]):
            told = clean(shorten(sentence(first.message), 400))
            if others:
                more = "".join(f"<li>{clean(shorten(sentence(p.message), 400))}</li>" for p in others[:MOST_ALIKE])
                rest = f"<li>and {len(others) - MOST_ALIKE:,} more</li>" if len(others) > MOST_ALIKE else ""
                told += f"<details><summary>and {len(others):,} more alike</summary><ul>{more}{rest}</ul></details>"
            where = ", ".join(f"{float(v):.2f}" for v in first.position) if first.position is not None else ""
            names = ", ".join(esc(n) for n in first.names[:8]) + (f" and {len(first.names) - 8} more" if len(first.names) > 8 else "")
            rows.append(f'<tr><td><span class="tag {esc(first.severity)}">{esc(first.severity)}</span></td>{cell(1 + len(others))}'
                        f"<td>{told}</td><td>{names}</td><td>{where}</td><td>{clean(shorten(sentence(first.remedy), 400))}</td></tr>")
        table = self.table([self.head("Severity"), self.head("How often", "", True), self.head("What"), self.head("Where", "first"),
                            self.head("Position", "x, y, z in m"), self.head("What you can do")], rows, "problems.csv")
        return table + f'<p class="note">Each with its place and remedy: {_link("problems.csv")}.</p>'

    def statistics(self) -> str:
        parts = [("Analysis", self.model.analysis.statistics), ("Extraction", getattr(self.model.building, "statistics", {}))]
        if self.model.analysis.matrix is not None:
            parts.append(("Room-to-room matrix", self.model.analysis.matrix.statistics))
        out = []
        for name, values in parts:
            if values:
                rows = "".join(f"<dt>{esc(k)}</dt><dd>{_statistic(v)}</dd>" for k, v in sorted(values.items(), key=lambda kv: str(kv[0])))
                out.append(f'<details><summary>{clean(name)}</summary><dl class="counters">{rows}</dl></details>')
        return "<p>What the engines counted: for those who measure them.</p>" + "".join(out) if out else '<p class="none">None recorded.</p>'

    def definitions(self) -> str:
        measures = self.model.analysis.measures
        known = [*metrics.DEFINITIONS, *(measures.definitions if measures is not None else ())]
        rows = "".join(f"<dt>{clean(d.label)}{f' [{clean(d.unit)}]' if d.unit else ''}</dt><dd>{clean(d.text)}"
                       f"{f' <i>{clean(d.source)}</i>' if d.source else ''}</dd>" for d in known)
        return f"<dl>{rows}</dl>"

    def assemble(self, files: list[str]) -> str:
        sections = [
            ("plans", "Plans", self.overview()), ("cameras", "What each camera sees", self.cameras()),
            ("matrix", "Who sees whom", self.matrix()), ("rooms", "Rooms", self.rooms()),
            ("views", "Views", self.views()),
            ("openings", "Openings", self.openings()), ("privacy", "Privacy", self.privacy()),
            ("sightlines", "Sightlines", self.sightlines()), ("problems", "Problems found", self.problems()),
            ("definitions", "Definitions", self.definitions()), ("files", "Files", _files(files)),
            ("statistics", "Statistics", self.statistics()),
        ]
        nav = "".join(f'<a href="#{i}">{clean(t)}</a>' for i, t, _ in sections)
        body = "".join(f'<section{" class=screen" if i in ON_SCREEN else ""}><h2 id="{i}">{clean(t)}</h2>{c}</section>' for i, t, c in sections)
        policy = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
        title = esc(self.model.analysis.title or "Visibility report")
        return ('<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
                f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
                '<meta name="viewport" content="width=device-width,initial-scale=1">'
                f"<title>{title}</title><style>{STYLE}</style></head><body>{self.summary()}<nav aria-label=Sections><div>{nav}</div></nav>"
                f"<main>{body}</main><footer>Enfilade visibility report. Lengths in metres, areas in square metres, z up."
                f"</footer><script>{SCRIPT}</script></body></html>\n")


def _statistic(v) -> str:
    if isinstance(v, int | float | np.integer | np.floating) and not isinstance(v, bool) and math.isfinite(v):
        return f"{int(v):,}" if float(v) == int(v) and abs(v) < 1e15 else f"{v:,.2f}" if abs(v) >= 1 else f"{v:.3g}"
    return esc(v)


def _key(entries: Iterable[tuple[str, str]]) -> str:
    """What colours mean: (colour, words)."""
    return '<p class="key">' + "".join(f'<span><i style="background:{c}"></i>{clean(w)}</span>' for c, w in entries) + "</p>"


def _link(file: str) -> str:
    return f'<a href="{quote(file)}">{clean(file)}</a>'


# What lies beside the page, by the beginnings of the names. The first that fits counts.
FILES = (
    ("What each camera sees", ("views.csv", "view_rooms.csv", "view_objects.csv")),
    ("Views from everywhere", ("view_",)),
    ("Plans", ("plan_", "preview.")),
    ("Who sees whom", ("matrix.", "pairs.", "sightlines", "rooms_seen_")),
    ("Rooms, openings, problems, everything", ("",)),
)


def _files(files: list[str]) -> str:
    """Links by subject; the formats of one drawing on one line."""
    left, out = list(files), []
    for subject, starts in FILES:
        own = [f for f in left if f.startswith(starts)]
        left = [f for f in left if f not in own]
        stems: dict[str, list[str]] = {}
        for f in own:
            stems.setdefault(f.rpartition(".")[0], []).append(f)
        items = "".join(f"<li>{_link(same[0])}" + "".join(f', <a href="{quote(f)}">.{clean(f.rpartition(".")[2])}</a>' for f in same[1:]) + "</li>"
                        for same in stems.values())
        if items:
            out.append(f"<h3>{clean(subject)}</h3><ul class=\"files\">{items}</ul>")
    return "<p>In the folder that this page was written to.</p>" + "".join(out)
