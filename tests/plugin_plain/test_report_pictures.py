# SPDX-License-Identifier: GPL-3.0-or-later
"""Plans, isovists, figures and pictures against values worked out by hand."""

from __future__ import annotations

import math
import signal

import numpy as np
import pytest
import report_samples as samples
from enfilade.report import drawing, isovist, labels, lettering, metrics, plan, plan_drawing, raster, shapes2d

images = pytest.importorskip("enfilade.report.images")
if images.oiio is None:
    pytest.skip("OpenImageIO's Python module is absent", allow_module_level=True)

SQUARE = np.array([(0, 0), (1, 0), (1, 1), (0, 1)], dtype=float)


def test_sections_of_convex_bodies():
    cube = samples.box(0, 0, 0, 2, 3, 4)
    assert shapes2d.area(shapes2d.section(cube, 1.0)) == pytest.approx(6)
    assert len(shapes2d.section(cube, 4.5)) == 0
    pyramid = np.array([(0, 0, 0), (2, 0, 0), (2, 2, 0), (0, 2, 0), (1, 1, 2)], dtype=float)
    assert shapes2d.area(shapes2d.section(pyramid, 1.0)) == pytest.approx(1)
    assert shapes2d.hull_volume(pyramid) == pytest.approx(8 / 3, rel=1e-4)
    assert shapes2d.hull_volume(cube) == pytest.approx(24, rel=1e-6)


def test_growing_clipping_and_outlining():
    assert shapes2d.area(shapes2d.offset(SQUARE, 0.5)) == pytest.approx(4)
    assert shapes2d.area(shapes2d.clip(SQUARE, np.array([0.25, 0]), np.array([1.0, 0]))) == pytest.approx(0.75)
    lines = shapes2d.outline([SQUARE, SQUARE + (1, 0)])
    assert sum(np.hypot(*(s[1] - s[0])) for s in lines) == pytest.approx(6), "the line between the two pieces is left out"


def test_the_isovist_passes_doors_and_stops_at_shut_ones():
    model = plan.Model(samples.house())
    ground = plan.storey_plans(model)[0]
    living = next(c for c in ground.cameras if model.cameras[c.group].name == "Cam living")
    seen = living.isovists[0]
    rooms = {int(model.analysis.cells.rooms[c]) for c, _ in seen.pieces} - {isovist.NONE}
    assert rooms == {0, 2, 3, 8}  # living, hall, study, outdoors; not the shut WC, not the kitchen
    names = {model.building.openings[o].name for o in seen.openings}
    # Of W1 only a jamb is seen: the wedge's lowest ray enters at x = 2.74 and is 3.26 where the recess, up to x = 3, ends.
    assert names == {"D1", "D3", "W3"}
    model.cameras[living.group].views[0].why.clear()
    model.cameras[living.group].views[0].room_why.clear()
    page = plan_drawing.camera_plan(model, ground, living.group)
    middles = [i.points.mean(axis=0) for i in page.items if isinstance(i, drawing.Line) and i.stroke == drawing.CAMERA]
    sheet = plan_drawing.Page(ground.bounds, page.width, page.height)
    for o in (o for o in ground.openings if o.level == "cut"):  # whatever was seen first through it
        drawn = any(np.hypot(*(m - sheet(np.concatenate(o.ends).mean(axis=0)))) < 3 for m in middles)
        assert drawn == (o.index in seen.openings), model.building.openings[o.index].name
    # By hand: the wedge of +-35 degrees from (0.6, 1.5) in the room 0..5 x 0..4 ends at the walls y = 0 and x = 5 and y = 4.
    t = math.tan(math.radians(35))
    up = 0.5 * 2.5 * 2.5 / t + (4.4 - 2.5 / t) * 2.5
    down = 0.5 * 1.5 * 1.5 / t + (4.4 - 1.5 / t) * 1.5
    inside = sum(abs(shapes2d.area(p)) for c, p in seen.pieces if c == 0)
    assert inside == pytest.approx(up + down, rel=1e-6)


def test_an_isovist_all_round_is_the_whole_convex_room():
    analysis = samples.house()
    section = isovist.Section(analysis.cells, set(), 1.5, set())
    hall = 3  # cell
    seen = isovist.trace(section, np.array([6.2, 3.0]), [hall], 0.3, math.pi, 1.5)
    assert sum(abs(shapes2d.area(p)) for c, p in seen.pieces if c == hall) == pytest.approx(14.0)
    assert seen.area >= 14.0


def test_rays_agree_with_the_isovist():
    """Random points: inside the isovist's pieces exactly when the segment from the eye passes open cells only."""
    analysis = samples.house()
    model = plan.Model(analysis)
    eye, direction, half = np.array([0.6, 1.5]), 0.0, math.radians(35)
    section = model.section(1.6)
    pieces = [p for c, p in isovist.trace(section, eye, [0], direction, half, 1.6).pieces if c != 8]
    free = [p for c, p in enumerate(section.polygons) if len(p) and not (
        int(analysis.cells.openings[c]) in model.closed if int(analysis.cells.openings[c]) != isovist.NONE else False)]
    random = np.random.default_rng(5)
    wrong = tested = 0
    for point in random.uniform((0, 0), (10, 7), (3000, 2)):
        if not any(shapes2d.contains(p, point, 0.02)[0] for p in free):
            continue
        d = point - eye
        if abs(abs(math.atan2(d[1], d[0])) - half) < 0.01:
            continue
        on_way = eye + d * np.linspace(0, 1, 400)[:, None]
        covered = np.zeros(400, dtype=bool)
        for p in free:
            covered |= shapes2d.contains(p, on_way, -1e-6)
        expected = bool(covered.all()) and abs(math.atan2(d[1], d[0])) < half
        near_edge = any(abs(shapes2d.contains(p, point, 0.03)[0] ^ shapes2d.contains(p, point, -0.03)[0]) for p in pieces)
        if near_edge:
            continue
        tested += 1
        wrong += expected != any(shapes2d.contains(p, point)[0] for p in pieces)
    assert tested > 1000 and wrong == 0


def test_graph_measures_of_a_row_of_three():
    """a sees b, b sees c: values from the definitions, by hand."""
    maker = samples.Maker()
    for k in range(3):
        maker.room("abc"[k], (k * 4, 0, 0, k * 4 + 3, 3, 2.5))
    visible = np.array([[1, 1, 0], [1, 1, 1], [0, 1, 1]], dtype=bool)
    analysis = maker.analysis(matrix=samples.RoomMatrix("exact", visible, visible))
    f = metrics.room_figures(plan.Model(analysis))
    assert f.rooms_seen.tolist() == [1, 2, 1]
    assert f.mean_depth.tolist() == [1.5, 1.0, 1.5]
    assert f.control.tolist() == [0.5, 2.0, 0.5]
    d3 = 2 * (3 * (math.log2(5 / 3) - 1) + 1) / 2
    assert f.integration[0] == pytest.approx(d3 / 1.0) and math.isinf(f.integration[1])
    assert f.clustering[1] == 0.0 and math.isnan(f.clustering[0])


def test_labels_stay_inside_their_room_and_apart():
    analysis = samples.house()
    model = plan.Model(analysis)
    for storey in plan.storey_plans(model):
        page = plan_drawing.overview(model, storey)
        boxes = []
        for item in page.items:
            if isinstance(item, drawing.Text) and item.y < page.height - plan_drawing.FOOT:
                w = drawing.text_width(item.text, item.size)
                left = item.x - {"start": 0, "middle": w / 2, "end": w}[item.anchor]
                boxes.append((left, item.y - item.size * 0.75, left + w, item.y + item.size * 0.1, item.text))
        for i, a in enumerate(boxes):
            assert 0 <= a[0] and a[2] <= page.width
            for c in boxes[:i]:
                assert not (a[0] < c[2] and c[0] < a[2] and a[1] < c[3] and c[1] < a[3]), (a, c)


def test_a_label_too_long_for_its_room_becomes_its_number():
    narrow = [np.array([(0, 0), (30, 0), (30, 30), (0, 30)], dtype=float)]
    spot = labels.place(narrow, "Extraordinarily long name", "3.0 m2", "17", labels.Occupied(), (12.0, 8.0))
    assert spot is not None and [t for t, _, _ in spot.lines] == ["17"] and not spot.whole


def test_a_name_too_long_to_lie_stands_upright_clear_of_what_is_taken():
    room = [np.array([(100, 0), (130, 0), (130, 60), (100, 60)], dtype=float)]
    taken = labels.Occupied()
    taken.add(100, 0, 130, 12)  # a door
    spot = labels.place(room, "West 07", "9 m2", "17", taken, (9.5, 8.5))
    assert spot is not None and spot.upright and spot.whole and spot.lines[0][0] == "West 07"
    x0, y0, x1, y1 = taken.boxes[-1]
    assert 100 <= x0 < x1 <= 130 and 12 <= y0 < y1 <= 60 and y1 - y0 > x1 - x0


def test_filled_pixels_measure_the_polygon():
    canvas = raster.Canvas(40, 30, "#000000")
    shape = np.array([(3.3, 4.1), (30.7, 8.2), (22.5, 25.9), (6.1, 20.4)])
    canvas.fill([shape], "#ffffff")
    assert canvas.pixels[..., 0].sum() == pytest.approx(shapes2d.area(shape), rel=2e-3)
    canvas = raster.Canvas(40, 30, "#000000")
    canvas.fill([np.array([(3.25, 4.5), (10.75, 4.5), (10.75, 9.0), (3.25, 9.0)])], "#ffffff")
    assert canvas.pixels[..., 0].sum() == pytest.approx(7.5 * 4.5, rel=1e-5)


def test_png_files_are_read_back_and_not_blank(tmp_path):
    model = plan.Model(samples.house())
    page = plan_drawing.camera_plan(model, plan.storey_plans(model)[0], 0)
    pixels = raster.paint(page, 1.0)
    images.write_png(tmp_path / "plan.png", pixels)
    back = images.read_image(tmp_path / "plan.png")
    assert back.pixels.shape == pixels.shape and back.channels[:3] == ["R", "G", "B"]
    assert np.array_equal(np.round(back.pixels * 255).astype(np.uint8), pixels)
    for colour in (drawing.WALL, drawing.NOT_SEEN, drawing.SEEN, drawing.OWN_ROOM):
        share = (np.abs(back.pixels - raster.colour(colour)).max(axis=2) < 0.01).mean()
        assert share > 0.01, colour
    (tmp_path / "own.png").write_bytes(images.png_bytes(pixels))
    assert np.array_equal(images.read_image(tmp_path / "own.png").pixels, back.pixels)


@pytest.mark.parametrize("with_font", [True, False])
def test_letters_are_drawn_with_and_without_a_font(with_font, monkeypatch):
    if with_font and lettering.font() is None:
        pytest.skip("no font that OpenImageIO reads")
    if not with_font:
        monkeypatch.setattr(lettering, "font", lambda bold=False: None)
    lettering.mask.cache_clear()
    lettering.advance.cache_clear()
    for text in ("Hall 12", "Küche é ñ", "23.4 m²", "台所", "a\x07b"):
        mask, _, _ = lettering.mask(text, 20.0, False)
        assert mask.max() > 0.5 and mask.sum() > 20
    assert lettering.advance("Hall", 20.0) < lettering.advance("Hall way", 20.0)
    assert not np.array_equal(lettering.mask("u", 24.0)[0], lettering.mask("ü", 24.0)[0][:, : lettering.mask("u", 24.0)[0].shape[1]])
    lettering.mask.cache_clear()
    lettering.advance.cache_clear()


def test_every_stroke_letter_reads_as_points():
    for letter, strokes in lettering.STROKES.items():
        for point in strokes.replace(";", " ").split():
            assert len(point) == 2 and 0 <= int(point[0]) <= 4 and 0 <= int(point[1]) <= 6, letter
    assert all(c.upper() in lettering.STROKES for c in map(chr, range(32, 127)))


def test_a_picture_that_is_none_is_named(tmp_path):
    with pytest.raises(images.ImageError, match="nowhere"):
        images.read_image(tmp_path / "nowhere.exr")
    (tmp_path / "text.png").write_text("not a picture")
    with pytest.raises(images.ImageError, match=r"text\.png"):
        images.read_image(tmp_path / "text.png")
    with pytest.raises(images.ImageError, match="missing"):
        images.write_png(tmp_path / "missing" / "x.png", np.zeros((2, 2, 3), dtype=np.uint8))


def test_a_disk_that_fills_up_leaves_no_half_picture(tmp_path):
    resource = pytest.importorskip("resource")
    noise = np.random.default_rng(1).integers(0, 255, (64, 64, 3), dtype=np.uint8)
    kept, limit = signal.signal(signal.SIGXFSZ, signal.SIG_IGN), resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (5000, limit[1]))  # bytes a file: what is beyond fails as on a full disk
    try:
        with pytest.raises(images.ImageError, match="noise"):
            images.write_png(tmp_path / "noise.png", noise)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limit)
        signal.signal(signal.SIGXFSZ, kept)
    assert list(tmp_path.iterdir()) == []


def test_a_contact_sheet_shows_each_picture():
    white = np.full((60, 100, 3), 255, dtype=np.uint8)
    red = white.copy()
    red[..., 1:] = 0
    sheet = images.contact_sheet([("one", red), ("two", red), ("three", red)], cell=50)
    assert (np.abs(sheet.astype(int) - (255, 0, 0)).max(axis=2) < 3).sum() == pytest.approx(3 * 50 * 30, rel=0.02)


def test_scale_bars_are_round_numbers():
    for scale in (0.013, 0.4, 7.0, 55.0, 119.0, 3000.0):
        metres = plan_drawing.scale_length(scale)
        digits = metres / 10 ** math.floor(math.log10(metres) + 1e-9)
        assert round(digits, 6) in (1, 2, 5) and 50 < metres * scale <= 240.001


def test_sightlines_are_cut_to_their_storey():
    whole = plan_drawing._between(np.array([0.0, 0, 1]), np.array([2.0, 0, 5]), 0.0, 3.0)
    assert np.allclose(whole, [(0, 0, 1), (1, 0, 3)])
    assert plan_drawing._between(np.array([0.0, 0, 4]), np.array([2.0, 0, 5]), 0.0, 3.0) is None
    assert plan_drawing._between(np.array([0.0, 0, np.nan]), np.array([2.0, 0, 5]), 0.0, 3.0) is None
    model = plan.Model(samples.house())
    pages = [plan_drawing.sightline_plan(model, p) for p in plan.storey_plans(model)]
    drawn = [sum(isinstance(i, drawing.Line) and i.stroke == drawing.VISIBLE for i in page.items) for page in pages]
    assert drawn == [6, 3], "the one through the stair hole lies on both storeys"


def test_a_figure_colours_rooms_in_whole_steps():
    model = plan.Model(samples.house())
    storey = plan.storey_plans(model)[0]
    page = plan_drawing.measure_plan(model, storey, np.array([0.0, 1, 2, 3, 4, 0, 0, 0, np.nan]), "n")
    fills = {i.room: i.fill for i in page.items if isinstance(i, drawing.Polygon) and i.room >= 0}
    assert [fills[k] for k in range(5)] == list(drawing.STEPS)
    assert {"0", "1", "2", "3", "4"} <= {i.text for i in page.items if isinstance(i, drawing.Text)}
    assert plan_drawing.measure_plan(model, storey, np.full(9, np.nan), "n") is None
