# SPDX-License-Identifier: GPL-3.0-or-later
"""A storey plan laid out on a page: poche, rooms, openings by kind and state, cameras, labels, scale, legend.

Line weights follow drawing practice: cut walls are solid, cut openings have medium lines, what lies above or below
the cut is fine and dashed, dimensions and labels are finest.
"""

from __future__ import annotations

import math

import numpy as np

from ..rules.building import CLOSED, DOOR, HOLE, VIRTUAL, WINDOW
from ..rules.building import GLASS as GLASS_STATE
from . import drawing as d
from . import labels, shapes2d
from .drawing import Drawing
from .metrics import own_rooms
from .plan import Model, StoreyPlan, level_text

MOST_SIGHTLINES = 80  # on one plan: more is a cloud; the table and the CSV have all
THINNEST_LEAF = 0.03  # metres: slivers of openings cut by a neighbouring room have no leaf to draw
# Page units. A narrow sheet is one that the report shows two in a row: its letters are as large there as on a wide one.
WIDE, NARROW, MARGIN, FOOT, LEGEND_ROW = 1000.0, 600.0, 34.0, 58.0, 16.0
HOUSE_SIZED = 3
HEIGHT, TALL_HEIGHT = 0.76, 0.98  # at most, by the width: of buildings wider than deep, and of others
NARROW_HEIGHT = 1.35  # narrow sheets may be that much taller: width is what they lack
HEAVY, MEDIUM, FINE, HAIR = 2.2, 1.3, 0.8, 0.5


def sheet_width(sheets: int) -> float:
    """Of each of some sheets that the page shows together: a few stand one a row, more two."""
    return WIDE if sheets <= HOUSE_SIZED else NARROW


class Page:
    """Metres to page units."""

    def __init__(self, bounds, width: float, foot: float):
        x0, y0, x1, y1 = bounds
        dx, dy = max(x1 - x0, 0.5), max(y1 - y0, 0.5)
        most_height = width * (HEIGHT if dx >= dy else TALL_HEIGHT) * (NARROW_HEIGHT if width < WIDE else 1.0)
        self.scale = min((width - 2 * MARGIN) / dx, (most_height - 2 * MARGIN) / dy, 120.0)
        self.width, self.drawn = width, dy * self.scale + 2 * MARGIN
        self.height = self.drawn + foot
        self.left = (width - dx * self.scale) / 2 - x0 * self.scale
        self.bottom = MARGIN + y1 * self.scale

    def __call__(self, points) -> np.ndarray:
        p = np.asarray(points, dtype=np.float64)
        out = np.empty_like(p)
        out[..., 0] = self.left + p[..., 0] * self.scale
        out[..., 1] = self.bottom - p[..., 1] * self.scale
        return out


def overview(model: Model, plan: StoreyPlan, width: float = WIDE) -> Drawing:
    """The storey with all its cameras; rooms coloured by how many cameras see them."""
    counts = {r.index: sum(r.index in g.rooms for g in model.cameras) for r in plan.rooms}
    several = len(model.cameras) > 1
    fills = {i: d.RAMP[min(n, len(d.RAMP) - 1)] if several else d.SEEN if n else d.NOT_SEEN for i, n in counts.items()}
    if not model.cameras:
        fills = dict.fromkeys(counts, "#f4f1ea")
        legend = []
    elif several:
        most = min(max(counts.values(), default=0), len(d.RAMP) - 1)
        words = ["seen by no camera", "by 1 camera", *(f"by {n}" for n in range(2, len(d.RAMP) - 1)), "by 5 or more"]
        legend = [(d.RAMP[n], words[n]) for n in range(most + 1)]
    else:
        legend = [(d.SEEN, "seen"), (d.NOT_SEEN, "not seen")]
    seen_rooms = {i for i, n in counts.items() if n} if model.cameras else set(counts)
    return compose(model, plan, f"{plan.name}", fills, legend, seen_rooms, set(), list(range(len(model.cameras))), None, width=width)


def camera_plan(model: Model, plan: StoreyPlan, group: int, width: float = WIDE) -> Drawing:
    """The storey as one camera sees it: rooms seen / not seen, the area seen at eye height, openings it looks through."""
    cameras = model.cameras[group]
    own = set().union(*(own_rooms(model, v) for v in cameras.views))
    fills = {}
    for room in plan.rooms:
        seen = room.index in cameras.rooms
        fills[room.index] = d.OWN_ROOM if room.index in own and seen else d.SEEN if seen else d.NOT_SEEN
    isovists = [i for c in plan.cameras if c.group == group for i in c.isovists]
    legend = [(d.SEEN, "room seen"), (d.NOT_SEEN, "not seen")]
    if any(i.pieces for i in isovists):
        legend.insert(0, (d.IN_PICTURE, "in view at eye height"))
    return compose(model, plan, f"{plan.name} · {d.shorten(cameras.name, 60)}", fills, legend,
                   {i for i in fills if i in cameras.rooms}, cameras.openings, [group], group, width=width)


def sightline_plan(model: Model, plan: StoreyPlan, width: float = WIDE) -> Drawing | None:
    """The storey with the sightlines that pass through it; None when none does."""
    top = min((e for _, e in model.storeys if e > plan.elevation + 0.5), default=math.inf)
    residents = {r.index for r in plan.rooms if r.resident}
    found = []
    for k, s in enumerate(model.analysis.matrix.sightlines if model.analysis.matrix else ()):
        here = len(residents & set(s.rooms))
        if not here:
            continue
        inside = _between(np.array(s.start, dtype=np.float64), np.array(s.end, dtype=np.float64), plan.elevation - 0.1, top)
        if inside is not None:
            found.append((-here, len(s.openings), k, inside))
    if not found:
        return None
    # Within the storey and through few openings first: what a reader can follow. Of those alike some from all over the building
    # (a multiplicative hash), not those of its first rooms.
    found.sort(key=lambda f: (*f[:2], f[2] * 2654435761 % 2**32))
    lines = [(inside[:, :2], d.VISIBLE) for _, _, _, inside in found[:MOST_SIGHTLINES]]
    number = f"{len(lines):,} of {len(found):,} sightlines" if len(lines) < len(found) else "sightlines"
    fills = {r.index: "#f1f0ec" for r in plan.rooms}
    return compose(model, plan, f"{plan.name} · {number}", fills, [], set(fills), set(), [], None, lines, width=width)


def _between(a: np.ndarray, b: np.ndarray, low: float, high: float) -> np.ndarray | None:
    """The part of a segment between two heights, (2, 3)."""
    if not (np.isfinite(a).all() and np.isfinite(b).all()):
        return None
    t0, t1 = 0.0, 1.0
    rise = b[2] - a[2]
    for bound, sign in ((low, 1.0), (high, -1.0)):
        if not math.isfinite(bound):
            continue
        da, db = sign * (a[2] - bound), sign * (b[2] - bound)
        if da < 0 and db < 0:
            return None
        if da < 0:
            t0 = max(t0, (bound - a[2]) / rise)
        elif db < 0:
            t1 = min(t1, (bound - a[2]) / rise)
    return np.array([a + t0 * (b - a), a + t1 * (b - a)]) if t1 - t0 > 1e-6 else None


def measure_plan(model: Model, plan: StoreyPlan, values: np.ndarray, name: str, width: float = WIDE) -> Drawing | None:
    """The storey with rooms coloured by a figure, in five steps over the whole building; None without figures."""
    known = values[np.isfinite(values)]
    if len(known) == 0 or known.max() <= known.min():
        return None
    low, high = float(known.min()), float(known.max())
    counted = bool((known == np.round(known)).all())
    if counted:  # whole numbers get whole steps
        step = -(-int(high - low + 1) // len(d.STEPS))
        bounds = [low + step * k for k in range(len(d.STEPS) + 1)]
    else:
        bounds = np.linspace(low, high, len(d.STEPS) + 1).tolist()
    used = sum(b <= high for b in bounds[:-1])
    colours = [d.STEPS[round(k * (len(d.STEPS) - 1) / max(used - 1, 1))] for k in range(used)]
    fills = {}
    for room in plan.rooms:
        v = float(values[room.index])
        k = int(np.searchsorted(bounds, v, side="right")) - 1
        fills[room.index] = colours[min(k, used - 1)] if math.isfinite(v) else "#ffffff"
    legend = []
    for k, colour in enumerate(colours):
        first, last = bounds[k], min(bounds[k + 1] - 1, high)
        if counted:
            legend.append((colour, f"{first:.0f}" if last == first else f"{first:.0f} to {last:.0f}"))
        else:
            legend.append((colour, f"{first:.3g} to {bounds[k + 1]:.3g}"))
    return compose(model, plan, f"{plan.name} · {name}", fills, legend, set(fills), set(), [], None, width=width)


def compose(model: Model, plan: StoreyPlan, title: str, fills: dict[int, str], legend, seen_rooms: set[int],
            through: set[int], groups: list[int], focus: int | None, lines=(), patches=(), width: float = WIDE) -> Drawing:
    """A storey's sheet. patches: (polygon in metres, colour) laid over the rooms' floors; the other arguments as the plans above use them."""
    key = [(colour, word, _box) for colour, word in legend]
    key += [(d.CAMERA, "looked through", _stroke)] if through else []
    key += [(d.VISIBLE, "sightline", _stroke)] if lines else []
    rows = _legend_rows(key, width)
    page = Page(plan.bounds, width, FOOT + LEGEND_ROW * len(rows))
    out = Drawing(page.width, page.height, title)
    taken = labels.Occupied()
    area = (0.0, 0.0, page.width, page.drawn)

    for room in plan.rooms:  # walls first: rooms grown by the wall, then the rooms laid over them
        for piece in room.pieces:
            out.polygon(page(shapes2d.offset(piece, plan.wall)), d.WALL)
    for room in plan.rooms:
        name = model.names.room(room.index)
        state = "seen" if room.index in seen_rooms else "not seen"
        hint = d.shorten(name, 80) + (f" – {state}" if model.cameras else "")
        for piece in room.pieces:
            # A hair larger than it is, so that the pieces of one room leave no seam between them.
            out.polygon(page(shapes2d.offset(piece, 0.35 / page.scale)), fills.get(room.index, d.NOT_SEEN), 1.0,
                        room.index, hint)
    for patch, colour in patches:
        out.polygon(page(patch), colour)
    _openings_ground(model, plan, page, out)
    shown = [c for c in plan.cameras if c.group in groups]
    if focus is not None:
        for camera in shown:
            picked = camera.isovists[:: max(1, len(camera.isovists) // 24)]
            parts = [(int(model.analysis.cells.rooms[cell]) in model.exterior, piece)
                     for isovist in picked for cell, piece in isovist.pieces]
            for outdoors in (True, False):  # in two runs: svg and raster merge neighbours of one look without seams
                for _, piece in (p for p in parts if p[0] == outdoors):
                    out.polygon(_to_page(page(piece), area), d.ISOVIST, 0.18 if outdoors else 0.5)
    for room in plan.rooms:
        for segment in room.floor_outline:
            out.line(page(segment), d.FAINT_INK, FINE, (6, 3))
        for segment in room.outline:
            out.line(page(segment), d.WALL, FINE)
    _openings_lines(model, plan, page, out, through, taken)
    for line, colour in lines:
        inside = _segment_on(page(line), area)
        if inside is not None:
            out.line(inside, colour, FINE, round=True)
            for end in inside:
                out.polygon([(end[0] + 1.8 * math.cos(t), end[1] + 1.8 * math.sin(t))
                             for t in np.linspace(0, 2 * math.pi, 9)[:-1]], colour)
    for camera in shown:
        _camera_symbol(camera, page, out, taken, focus is not None)
    for camera in shown:
        _camera_name(model, camera, page, out, taken)
    _room_labels(model, plan, page, out, taken, seen_rooms, d.PAPER if patches or lines else "")
    _foot(out, page, title, plan, rows)
    return out


def _to_page(points: np.ndarray, box) -> np.ndarray:
    x0, y0, x1, y1 = box
    for point, normal in (((x0, y0), (1, 0)), ((x1, y1), (-1, 0)), ((x0, y0), (0, 1)), ((x1, y1), (0, -1))):
        points = shapes2d.clip(points, np.array(point, dtype=float), np.array(normal, dtype=float))
    return points


def _segment_on(segment: np.ndarray, box) -> np.ndarray | None:
    """The part of a segment inside a box (Liang & Barsky)."""
    t0, t1 = 0.0, 1.0
    p, v = segment[0], segment[1] - segment[0]
    for k in (0, 1):
        for bound, sign in ((box[k], -1.0), (box[k + 2], 1.0)):
            q, w = sign * (bound - p[k]), sign * v[k]
            if w == 0:
                if q < 0:
                    return None
            elif w < 0:
                t0 = max(t0, q / w)
            else:
                t1 = min(t1, q / w)
    return np.array([p + t0 * v, p + t1 * v]) if t1 > t0 else None


def _openings_ground(model: Model, plan: StoreyPlan, page: Page, out: Drawing) -> None:
    """Passages cut out of the walls, those of one colour together."""
    for o in sorted(plan.openings, key=lambda o: model.building.openings[o.index].kind == WINDOW):
        kind = model.building.openings[o.index].kind
        if o.level == "cut" and len(o.footprint) >= 3:
            ground = "#ffffff" if kind == WINDOW else "#f6f4ef"
            out.polygon(page(shapes2d.offset(shapes2d.hull(o.footprint), 0.4 / page.scale)), ground)


def _openings_lines(model: Model, plan: StoreyPlan, page: Page, out: Drawing, through: set[int], taken) -> None:
    for o in plan.openings:
        opening = model.building.openings[o.index]
        ends = [page(e) for e in o.ends]
        used = o.index in through
        if o.level in ("void", "void-above"):
            if opening.kind == VIRTUAL:  # rooms that touch without a slab between: nothing an architect would draw
                continue
            ring = page(o.footprint)
            dash = (5, 3) if o.level == "void-above" else ()
            out.line(ring, d.CAMERA if used else d.VOID, MEDIUM if used else FINE, dash, closed=True)
            for i in range(len(ring)):
                p, q = ring[i], ring[(i + 1) % len(ring)]
                taken.lines.append((*(np.minimum(p, q) - 1), *(np.maximum(p, q) + 1)))
            if o.level == "void":
                taken.lines.append((*ring.min(axis=0), *ring.max(axis=0)))
            if o.level == "void" and len(ring) >= 4:
                out.line(ring[[0, 2]], d.VOID, HAIR)
                out.line(ring[[1, 3]], d.VOID, HAIR)
            continue
        if o.level != "cut":
            if len(o.footprint) >= 3:
                out.line(page(o.footprint), d.FAINT_INK, HAIR, (3, 2), closed=True)
            elif len(o.footprint) == 2:
                out.line(page(o.footprint), d.FAINT_INK, HAIR, (3, 2))
            continue
        if len(ends) == 2 and len(o.footprint) >= 3:
            a, b = ends
            if min(np.linalg.norm(a[0] - a[1]), np.linalg.norm(b[0] - b[1])) < THINNEST_LEAF * page.scale:
                continue
            if np.linalg.norm(a[0] - b[0]) + np.linalg.norm(a[1] - b[1]) > \
               np.linalg.norm(a[0] - b[1]) + np.linalg.norm(a[1] - b[0]):
                b = b[::-1]
            middle = (a + b) / 2
            for side in (0, 1):  # jambs
                out.line(np.array([a[side], b[side]]), d.WALL, FINE)
            _leaf(out, opening, a, b, middle)
        else:
            middle = ends[0] if ends else page(o.footprint[:2])
            a = b = middle
            if opening.kind == VIRTUAL:
                out.line(middle, d.THRESHOLD, FINE, (2, 3))
            else:
                out.line(middle, "#f6f4ef", 4.0)
                _leaf(out, opening, a, b, middle)
        if used:
            out.line(middle, d.CAMERA, HEAVY, round=True)
        taken.add(*middle.min(axis=0) - 3, *middle.max(axis=0) + 3)


def _leaf(out: Drawing, opening, a, b, middle) -> None:
    if opening.state == CLOSED:
        out.line(middle, d.INK, 3.0)
    elif opening.kind == WINDOW or opening.state == GLASS_STATE:
        if opening.kind == WINDOW:
            out.line(a, d.WALL, HAIR)
            out.line(b, d.WALL, HAIR)
        out.line(middle, d.GLASS, MEDIUM)
    elif opening.kind == DOOR:
        out.line(a, d.THRESHOLD, HAIR)
        out.line(b, d.THRESHOLD, HAIR)
    elif opening.kind in (HOLE, VIRTUAL):
        out.line(a, d.THRESHOLD, HAIR, (3, 2))
        out.line(b, d.THRESHOLD, HAIR, (3, 2))


def _camera_symbol(camera, page: Page, out: Drawing, taken, focus: bool) -> None:
    if len(camera.path) > 1 and np.ptp(camera.path, axis=0).max() > 0.05:
        path = page(camera.path)
        out.line(path, "#ffffff", 3.2, round=True)
        out.line(path, d.CAMERA, MEDIUM, (1.5, 3.5), round=True)
        for p in path[:: max(1, len(path) // 40)]:
            taken.add(p[0] - 2, p[1] - 2, p[0] + 2, p[1] + 2)
    (x, y), outside = _on_sheet(camera, page)
    if outside:
        ring = [(x + 6 * math.cos(t), y + 6 * math.sin(t)) for t in np.linspace(0, 2 * math.pi, 25)[:-1]]
        out.line(ring, d.CAMERA, MEDIUM, closed=True)
        taken.add(x - 8, y - 8, x + 8, y + 8)
        return
    turn = -camera.heading if camera.heading is not None else None  # page y points down
    if turn is not None:
        if not focus or not any(i.pieces for i in camera.isovists):
            reach = min(max(1.6 * page.scale, 22.0), 60.0)
            half = min(camera.half, math.radians(179.9))
            arc = [(x + reach * math.cos(t), y + reach * math.sin(t))
                   for t in np.linspace(turn - half, turn + half, max(3, int(half * 16)))]
            if camera.half <= math.pi / 2 or len(arc) > 3:
                out.polygon([(x, y), *arc], d.CAMERA, 0.18)
                out.line([arc[0], (x, y), arc[-1]], d.CAMERA, FINE)
        tip = [(x + 10 * math.cos(turn + s), y + 10 * math.sin(turn + s)) for s in (-0.62, 0.62)]
        out.polygon([(x, y), *tip], d.CAMERA)
    ring = [(x + 4.6 * math.cos(t), y + 4.6 * math.sin(t)) for t in np.linspace(0, 2 * math.pi, 25)[:-1]]
    out.polygon([(x + 1.3 * (p - x), y + 1.3 * (q - y)) for p, q in ring], "#ffffff")
    out.polygon(ring, d.CAMERA)
    taken.add(x - 8, y - 8, x + 8, y + 8)


def _on_sheet(camera, page: Page) -> tuple[np.ndarray, bool]:
    """Where a camera is drawn, and whether it really stands outside the sheet."""
    at = page(camera.position)
    held = np.clip(at, 14.0, (page.width - 14.0, page.drawn - 14.0))
    return held, bool((np.abs(held - at) > 1.0).any())


def _camera_name(model: Model, camera, page: Page, out: Drawing, taken) -> None:
    (x, y), outside = _on_sheet(camera, page)
    name = d.shorten(model.cameras[camera.group].name, 28) + (" (off the sheet)" if outside else "")
    w = d.text_width(name, 10.5)
    spots = [(x + 12, y + 4, "start"), (x - 12, y + 4, "end"), (x, y + 21, "middle"), (x, y - 13, "middle"),
             (x + 12, y + 18, "start"), (x - 12, y + 18, "end"), (x + 12, y - 11, "start"), (x - 12, y - 11, "end"),
             (x, y + 35, "middle"), (x, y - 27, "middle"), (x + 12, y + 32, "start"), (x + 12, y - 25, "start")]
    best = None
    for px, py, anchor in spots:
        left = px if anchor == "start" else px - w if anchor == "end" else px - w / 2
        box = (left - 1, py - 10, left + w + 1, py + 3)
        outside = box[0] < 0 or box[2] > page.width
        cost = taken.overlap(*box) + (1e6 if outside else 0)
        if best is None or cost < best[0]:
            best = (cost, px, py, anchor, box)
        if cost == 0:
            break
    if best is not None:
        _, px, py, anchor, box = best
        out.text(px, py, name, 10.5, d.CAMERA, anchor, True, "#ffffff")
        taken.add(*box)


def _room_labels(model: Model, plan: StoreyPlan, page: Page, out: Drawing, taken, seen_rooms: set[int], halo: str = "") -> None:
    crowded = len(plan.rooms) > 60
    sizes = (9.5, 8.5, 7.5) if crowded else (13.0, 11.5, 10.0, 8.5, 7.5)
    order = sorted(plan.rooms, key=lambda r: -sum(abs(shapes2d.area(p)) for p in r.pieces))
    for room in order:
        size = sum(abs(shapes2d.area(p)) for p in room.pieces)
        pieces = [page(p)[::-1] for p in room.pieces]  # page y points down: reversing keeps them counter-clockwise
        wording = (model.names.room(room.index), f"{size:.1f} m²" if room.resident else "", str(room.index + 1))
        spot = labels.place(pieces, *wording, taken, sizes)
        if spot is None:
            continue
        down = -sum(s * labels.LEADING for _, s, _ in spot.lines) / 2
        colour = d.INK if room.index in seen_rooms else "#5b626b"
        for text, size_, bold in spot.lines:
            down += size_ * labels.LEADING
            at = down - size_ * 0.30
            x, y = (spot.x + at, spot.y) if spot.upright else (spot.x, spot.y + at)
            out.text(x, y, text, size_, colour if bold else "#4a5058", "middle", bold and room.index in seen_rooms,
                     halo=halo, upright=spot.upright)


def scale_length(pixels_per_metre: float, target: float = 240.0) -> float:
    """A round number of metres about `target` page units long."""
    wish = target / max(pixels_per_metre, 1e-9)
    base = 10.0 ** math.floor(math.log10(max(wish, 1e-9)))
    return next((m * base for m in (5.0, 2.0) if m * base <= wish), base)


def _foot(out: Drawing, page: Page, title: str, plan: StoreyPlan, legend: list[list[tuple]]) -> None:
    """Title, height of the cut, scale bar, where +Y is, and the legend's rows below."""
    out.line([(MARGIN, page.drawn + 6), (page.width - MARGIN, page.drawn + 6)], "#c9ccd1", HAIR)
    y = page.drawn + 26
    out.text(MARGIN, y, title, 13, d.INK, "start", True)
    out.text(MARGIN, y + 16, f"cut {plan.cut - plan.elevation:.2f} m above floor {level_text(plan.elevation)}", 9.5, d.FAINT_INK)
    metres = scale_length(page.scale, 0.24 * page.width)
    length = metres * page.scale
    x1 = page.width - MARGIN - 40
    x0 = x1 - length
    for i in range(4):
        a, b = x0 + length * i / 4, x0 + length * (i + 1) / 4
        ring = [(a, y - 5), (b, y - 5), (b, y), (a, y)]
        out.polygon(ring, d.INK if i % 2 == 0 else "#ffffff")
        out.line(ring, d.INK, HAIR, closed=True)
    out.text(x0, y + 13, "0", 9.5, d.INK, "middle")
    out.text(x0 + length / 2, y + 13, f"{metres / 2:g}", 9.5, d.INK, "middle")
    out.text(x1, y + 13, f"{metres:g} m", 9.5, d.INK, "middle")
    nx = page.width - MARGIN - 8
    out.polygon([(nx, y - 14), (nx - 5, y + 4), (nx, y)], d.INK)
    out.line([(nx, y - 14), (nx + 5, y + 4), (nx, y), (nx - 5, y + 4)], d.INK, HAIR, closed=True)
    out.text(nx, y + 15, "+Y", 9, d.FAINT_INK, "middle")
    for k, row in enumerate(legend):
        for x, colour, word, symbol in row:
            base = y + 20 + LEGEND_ROW * (k + 1)
            symbol(out, x, base, colour)
            out.text(x + 17, base - 1, word, 9.5, d.INK)


def _legend_rows(entries: list[tuple], width: float) -> list[list[tuple]]:
    """(colour, word, symbol) as rows of (x, colour, word, symbol) that fit the sheet."""
    rows: list[list[tuple]] = []
    x = width
    for colour, word, symbol in entries:
        wide = 29 + d.text_width(word, 9.5)
        if x + wide > width - MARGIN:
            rows.append([])
            x = MARGIN
        rows[-1].append((x, colour, word, symbol))
        x += wide
    return rows


def _box(out: Drawing, x: float, y: float, colour: str) -> None:
    ring = [(x, y - 9), (x + 12, y - 9), (x + 12, y), (x, y)]
    out.polygon(ring, colour)
    out.line(ring, "#9aa0a8", HAIR, closed=True)


def _stroke(out: Drawing, x: float, y: float, colour: str) -> None:
    out.line([(x, y - 4), (x + 12, y - 4)], colour, HEAVY)
