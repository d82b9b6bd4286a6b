# SPDX-License-Identifier: GPL-3.0-or-later
"""report.html: one file that opens from disk and asks the network for nothing. Pictures first, then tables.

Every text from the model goes through `svg.clean`. A content security policy forbids every request, so that even a
mistake here could not make one.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Iterable

import numpy as np

from ..rules.building import INFO
from ..rules.names import sentence
from ..rules.results import unculled
from . import images, matrix_picture, metrics, tables, view_maps
from .drawing import GRAZING, OWN_ROOM, SEEN, SELF, UNDECIDED, VISIBLE, shorten
from .html_assets import SCRIPT, STYLE
from .matrix_picture import EMPTY
from .metrics import RoomFigures
from .plan import Model
from .svg import clean, fragment

# What goes into the page at most; beyond, the page says so and names the file that holds everything.
MOST_ROWS = 4000  # of one table
MOST_SIGHTLINES = 400
MOST_NEIGHBOURS = 16_000  # rooms named in the "who sees whom" table: fewer a row where there are many rows
MOST_PER_ROOM, LEAST_PER_ROOM = 40, 8  # in one row
LONG = 30  # rows: longer tables scroll in themselves and can be searched
MOST_NAME = 120  # characters of one name
HOUSE_SIZED = 3  # storeys: fewer get one plan a row


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
        self.sight_plans: list[str] = []  # SVG, one a storey
        self.measures: list[str] = []
        self.view_maps: dict[str, list[str]] = {}  # SVG by measure, one a storey
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
    def table(header: list[str], rows: list[str], sort: bool = True, classes: str = "") -> str:
        more = ""
        if len(rows) > MOST_ROWS:
            more = f'<p class="note">{len(rows) - MOST_ROWS:,} more rows are in the CSV file.</p>'
        long = len(rows) > LONG
        names = f'{"sort " if sort else ""}{"long " if long else ""}{classes}'.strip()
        return (f'<div class="wide{" tall" if long else ""}"><table class="{names}"><thead><tr>{"".join(header)}</tr></thead><tbody>'
                f'{"".join(rows[:MOST_ROWS])}</tbody></table></div>{more}')

    @staticmethod
    def head(label: str, unit: str = "", numeric: bool = False, title: str = "") -> str:
        small = f"<small>{clean(unit)}</small>" if unit else ""
        tip = f' title="{clean(title)}"' if title else ""
        return f'<th{" class=n" if numeric else ""}{tip}>{clean(label)}{small}</th>'

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

    def overview(self, svgs: list[str], dropped: int) -> str:
        if not svgs:
            return '<p class="none">No storey has rooms that could be drawn.</p>'
        colours = "Rooms are coloured by the number of cameras that see them. " if len(self.model.cameras) > 1 else ""
        more = f'<p class="note">{dropped} more plans would not fit into the page; they lie beside it as files.</p>' if dropped else ""
        doors = ("Cut walls are dark. Doors are gaps, with a bar where shut; glass is a blue line; holes in floors are crossed, "
                 "holes in ceilings dashed.")
        return f"<p>{colours}{doors}</p>{self._by_storey(svgs)}{more}"

    @staticmethod
    def _by_storey(svgs: list[str]) -> str:
        if not svgs:
            return ""
        few = " few" if len(svgs) <= HOUSE_SIZED else ""
        return f'<div class="plans{few}">' + "".join(f"<figure>{s}</figure>" for s in svgs) + "</div>"

    def cameras(self, plans: dict[int, list[str]]) -> str:
        m = self.model
        if not m.cameras:
            return '<p class="none">The analysis holds no cameras. Put one into the scene to see what it sees.</p>'
        out = [f'<p class="key"><span><i style="background:{OWN_ROOM}"></i>the camera\'s own room</span>'
               f'<span><i style="background:{SEEN}"></i>room seen, in part or whole</span>'
               '<span><i style="background:#f0c36b"></i>in the picture, at the camera\'s eye height</span>'
               '<span><i style="background:#dfe3e8"></i>not seen</span></p>']
        rooms_inside = len(m.building.rooms) - len(m.exterior)
        for g, group in enumerate(m.cameras[:200]):
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
            drawn = plans.get(g, [])
            if drawn:
                rest = "".join(f"<figure>{s}</figure>" for s in drawn[1:])
                out.append(f'<div class="plans few"><figure>{drawn[0]}</figure></div>'
                           + (f'<div class="plans">{rest}</div>' if rest else ""))
            else:
                out.append('<p class="none">No plan of this camera in the page.</p>')
            out.append(self._ways(group))
        if len(m.cameras) > 200:
            out.append(f'<p class="note">{len(m.cameras) - 200:,} more cameras are in views.csv and view_rooms.csv.</p>')
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
            rows.append(f"<tr><td>{self.way(way)}</td><td>{named}</td>{cell(len(objects))}</tr>")
        if len(rows) > 60:
            more = f'<p class="note">{len(rows) - 60:,} longer sequences are in view_rooms.csv and view_objects.csv.</p>'
            rows = rows[:60]
        else:
            more = ""
        return self.table([self.head("Through"), self.head("Rooms seen first this way"),
                           self.head("Objects", "first seen", True)], rows) + more

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
               f'<p class="key"><span><i style="background:{VISIBLE}"></i>visible, with a sightline</span>'
               f'<span><i style="background:{GRAZING}"></i>grazing</span><span><i style="background:{UNDECIDED}"></i>'
               f'counts as visible, not proven</span><span><i style="background:{EMPTY}"></i>'
               f'{"not found" if method == "sample" else "hidden"}</span><span><i style="background:{SELF}"></i>itself</span></p>']
        if n <= matrix_picture.LABELLED:
            drawn = matrix_picture.labelled(m, self.status)
            out.append(f'<figure class="matrix"><div style="max-width:{drawn.width * 1.25:.0f}px">{fragment(drawn)}</div></figure>')
        else:
            picture, block = matrix_picture.pixels(m, self.status)
            data = base64.b64encode(images.png_bytes(picture)).decode()
            bands = ", ".join(f"{esc(name)} ({count})" for name, count in matrix_picture.bands(m)[:60])
            each = f"Each square stands for {block} × {block} pairs of rooms, coloured by the most visible of them." if block > 1 \
                else "Each square is a pair of rooms."
            out.append(f'<figure class="matrix"><img alt="Room-to-room matrix" src="data:image/png;base64,{data}">'
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
                           classes="full")
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
                f'<a href="#definitions">What the figures mean</a>.</p>{self._by_storey(self.measures)}{self.table(header, rows, classes="tight")}{note}')

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
            if measure.key in self.view_maps:
                source = f" <i>{clean(measure.source)}</i>" if measure.source else ""
                _, colours, words = view_maps.classes(found, measure.key)
                key = "".join(f'<span><i style="background:{c}"></i>{clean(w)}</span>' for c, w in zip(colours, words, strict=True))
                out.append(f'<h3>{clean(measure.label)}, {clean(measure.unit)}</h3><p class="sub">{clean(measure.text)}{source}</p>'
                           f'<p class="key">{key}</p>'
                           + '<div class="plans">' + "".join(f"<figure>{svg}</figure>" for svg in self.view_maps[measure.key]) + "</div>")
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
        out.append("<h3>Room by room</h3><p>Means over the room's places; of the longest view the longest.</p>" + self.table(header, rows, classes="tight"))
        if found.cameras:
            header = [self.head("Camera"), self.head("Stands in"), *(self.head(k.label, k.unit, True, k.text) for k in found.definitions),
                      self.head("Floor seen", "m²", True, "Floor in view from the camera's place, all around.")]
            rows = [f'<tr><td class="one">{esc(c["camera"])}</td><td class="one">{self.room(c["room"])}</td>'
                    + "".join(cell(c[k.key]) for k in found.definitions) + cell(c["floor_area"]) + "</tr>" for c in found.cameras]
            out.append("<h3>From the cameras' places</h3><p>All around each camera's eye, whichever way it looks.</p>"
                       + self.table(header, rows, classes="tight"))
        return "".join(out)

    def openings(self) -> str:
        m = self.model
        if not m.building.openings:
            return '<p class="none">No openings were found.</p>'
        used = tables.used_by(m)
        rows = []
        for i, o in enumerate(m.building.openings):
            sides = " – ".join(self.room(r) for r in o.rooms) if o.rooms else '<span class="tag warning">leads nowhere</span>'
            w, h, sill, depth = tables.opening_size(o)
            seen = ", ".join(esc(m.cameras[g].name) for g in sorted(used.get(i, ()))[:12])
            rows.append(f"<tr>{cell(i + 1)}<td>{esc(o.name)}</td><td>{esc(o.kind)}</td><td>{esc(o.state)}</td><td>{sides}</td>"
                        f"{cell(w, 2)}{cell(h, 2)}{cell(depth, 2)}<td>{seen}</td></tr>")
        return self.table([self.head("No.", "", True), self.head("Opening"), self.head("Kind"), self.head("State"),
                           self.head("Joins"), self.head("Width", "m", True), self.head("Height", "m", True),
                           self.head("Depth", "m", True), self.head("Looked through by")], rows)

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
                                             self.head("How sure"), self.head("What would close it")], rows)

    def sightlines(self) -> str:
        matrix = self.model.analysis.matrix
        if matrix is None or not matrix.sightlines:
            return '<p class="none">No sightlines are recorded.</p>'
        rows = []
        for s in matrix.sightlines[:MOST_SIGHTLINES]:
            ends = [", ".join(f"{float(v):.2f}" for v in p) for p in (s.start, s.end)]
            rows.append(f"<tr><td>{self.room(s.rooms[0])}</td><td>{self.room(s.rooms[1])}</td><td>{self.way(s.openings)}</td>"
                        f"{cell(math.dist(s.start, s.end), 2)}<td>{ends[0]}</td><td>{ends[1]}</td></tr>")
        more = f'<p class="note">{len(matrix.sightlines) - MOST_SIGHTLINES:,} more are in sightlines.csv.</p>' \
            if len(matrix.sightlines) > MOST_SIGHTLINES else ""
        table = self.table([self.head("From"), self.head("To"), self.head("Through"), self.head("Length", "m", True),
                            self.head("Start", "x, y, z in m"), self.head("End", "x, y, z in m")], rows)
        return ("<p>A sightline is a straight segment from one room to another that passes through openings only: proof that "
                "they see each other. Each is drawn on the storeys it passes."
                f"</p>{self._by_storey(self.sight_plans)}<details><summary>{len(matrix.sightlines):,} sightlines</summary>{table}{more}</details>")

    def problems(self) -> str:
        b = self.model.building
        if not b.problems:
            return '<p class="none">None.</p>'
        rank = {"error": 0, "warning": 1}
        rows = []
        for p in sorted(b.problems, key=lambda p: rank.get(p.severity, 2)):
            where = ", ".join(f"{float(v):.2f}" for v in p.position) if p.position is not None else ""
            names = ", ".join(esc(n) for n in p.names[:8]) + (f" and {len(p.names) - 8} more" if len(p.names) > 8 else "")
            rows.append(f'<tr><td><span class="tag {esc(p.severity)}">{esc(p.severity)}</span></td>'
                        f"<td>{clean(shorten(sentence(p.message), 400))}</td><td>{names}</td><td>{where}</td>"
                        f"<td>{clean(shorten(sentence(p.remedy), 400))}</td></tr>")
        return self.table([self.head("Severity"), self.head("What"), self.head("Where"), self.head("Position", "x, y, z in m"),
                           self.head("What you can do")], rows)

    def statistics(self) -> str:
        parts = [("Analysis", self.model.analysis.statistics), ("Extraction", getattr(self.model.building, "statistics", {}))]
        if self.model.analysis.matrix is not None:
            parts.append(("Room-to-room matrix", self.model.analysis.matrix.statistics))
        out = []
        for name, values in parts:
            if values:
                rows = "".join(f"<tr><td>{esc(k)}</td>{_statistic(v)}</tr>" for k, v in sorted(values.items(), key=lambda kv: str(kv[0])))
                out.append(f'<h3>{clean(name)}</h3><div class="wide"><table><tbody>{rows}</tbody></table></div>')
        return "".join(out) or '<p class="none">None recorded.</p>'

    def definitions(self) -> str:
        measures = self.model.analysis.measures
        known = [*metrics.DEFINITIONS, *(measures.definitions if measures is not None else ())]
        rows = "".join(f"<dt>{clean(d.label)}{f' [{clean(d.unit)}]' if d.unit else ''}</dt><dd>{clean(d.text)}"
                       f"{f' <i>{clean(d.source)}</i>' if d.source else ''}</dd>" for d in known)
        return f"<dl>{rows}</dl>"

    def assemble(self, overview: list[str], dropped: int, plans: dict[int, list[str]], files: list[str]) -> str:
        sections = [
            ("plans", "Plans", self.overview(overview, dropped)), ("cameras", "What each camera sees", self.cameras(plans)),
            ("matrix", "Who sees whom", self.matrix()), ("rooms", "Rooms", self.rooms()),
            ("views", "Views", self.views()),
            ("openings", "Openings", self.openings()), ("privacy", "Privacy", self.privacy()),
            ("sightlines", "Sightlines", self.sightlines()), ("problems", "Problems found", self.problems()),
            ("statistics", "Statistics", self.statistics()), ("definitions", "Definitions", self.definitions()),
            ("files", "Files beside this page", "<p>" + ", ".join(f"<code>{clean(f)}</code>" for f in files) + "</p>"),
        ]
        nav = "".join(f'<a href="#{i}">{clean(t)}</a>' for i, t, _ in sections)
        body = "".join(f'<section><h2 id="{i}">{clean(t)}</h2>{c}</section>' for i, t, c in sections)
        policy = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; base-uri 'none'; form-action 'none'"
        title = esc(self.model.analysis.title or "Visibility report")
        return ('<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">'
                f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
                '<meta name="viewport" content="width=device-width,initial-scale=1">'
                f"<title>{title}</title><style>{STYLE}</style></head><body>{self.summary()}<nav><div>{nav}</div></nav>"
                f"<main>{body}</main><footer>Enfilade visibility report. Lengths in metres, areas in square metres, z up."
                f"</footer><script>{SCRIPT}</script></body></html>\n")


def _statistic(v) -> str:
    if isinstance(v, int | float | np.integer | np.floating) and not isinstance(v, bool) and math.isfinite(v):
        digits = 0 if float(v) == int(v) and abs(v) < 1e15 else 4 if abs(v) < 1 else 2
        return cell(float(v), digits)
    return f"<td>{esc(v)}</td>"
