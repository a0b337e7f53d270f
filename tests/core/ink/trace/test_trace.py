"""From pictures of paper to strokes."""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.ink.trace.gaps import bridged, is_closed
from bozzetto.ink.trace.photographed_page import aspect_ratio, find_page, homography
from bozzetto.ink.trace.placed_ink import (
    is_seen_square,
    page_drawing,
    strokes_in_view,
    strokes_on_picture,
)
from bozzetto.ink.trace.threshold import gray_of
from bozzetto.ink.trace.trace import TracedLine, sheet_of, trace
from bozzetto.view import Camera
from tests.core.ink.trace.distances import hausdorff
from tests.core.ink.trace.pencil_paper import FAINT, PHONE, TABLE, paper_picture

SIZE = (800, 600)


def circle(x: float, y: float, radius: float) -> np.ndarray:
    angle = np.linspace(0.0, 2.0 * np.pi, 120)
    return np.column_stack((x + radius * np.cos(angle), y + radius * np.sin(angle)))


def line(start, end) -> np.ndarray:
    return np.linspace(start, end, 60)


def found(lines, conditions=PHONE, seed=1, **more):
    pixels, _ = paper_picture([np.asarray(one, float) for one in lines], SIZE, conditions, seed)
    return trace(sheet_of(pixels), **more)


@pytest.mark.parametrize("conditions", [PHONE, FAINT])
def test_an_outline_comes_back_as_one_closed_line(conditions):
    ring = circle(400, 300, 180)
    (one,) = found([ring], conditions)
    assert one.is_closed
    assert hausdorff(ring, one.points) < 0.01 * 360
    assert one.pressure.min() > 0.0
    assert one.pressure.max() <= 1.0


def test_crossing_lines_go_straight_on():
    one, other = line((100, 120), (700, 480)), line((120, 500), (690, 100))
    lines = found([one, other])
    assert len(lines) == 2
    for drawn in (one, other):
        assert min(hausdorff(drawn, each.points) for each in lines) < 8.0


def test_a_line_that_ends_on_another_ends_there():
    lines = found([line((100, 300), (700, 300)), line((400, 300), (400, 520))])
    assert len(lines) == 2
    stem = min(lines, key=lambda each: np.ptp(each.points[:, 0]))
    assert np.ptp(lines[0].points[:, 0]) > 580
    assert np.abs(stem.points[[0, -1]] - (400, 300)).max(axis=1).min() < 6.0


def test_open_lines_end_at_corners_and_closed_ones_keep_them():
    bent = np.vstack((line((100, 100), (400, 130)), line((400, 130), (380, 450))))
    square = np.array([(500, 200), (700, 210), (690, 420), (495, 400), (500, 200)], float)
    lines = found([bent, square])
    assert sorted(each.is_closed for each in lines) == [False, False, True]
    (outline,) = [each for each in lines if each.is_closed]
    assert hausdorff(square, outline.points) < 6.0


def test_dashes_that_touch_in_a_corner_are_two() -> None:
    corner = [line((300, 300), (340, 300)), line((342, 302), (342, 345))]
    lines = found([line((100, 100), (700, 130)), *corner])
    assert len(lines) == 3
    for dash in corner:
        assert min(hausdorff(dash, each.points) for each in lines) < 8.0


def test_a_slight_bend_is_a_corner_where_another_line_ends_and_none_elsewhere() -> None:
    slope = np.tan(np.deg2rad(24.0))
    bent = np.vstack((line((100, 300), (400, 300)), line((400, 300), (700, 300 + 300 * slope))[1:]))
    alone = found([bent])
    met = found([bent, line((400, 120), (400, 300))])
    assert len(alone) == 1
    assert len(met) == 3
    assert min(hausdorff(bent[:60], each.points) for each in met) < 8.0


def test_an_arc_stays_whole_where_another_line_ends() -> None:
    arc = circle(400, 400, 250)[60:120]
    lines = found([arc, line((400, 20), (400, 150))])
    assert len(lines) == 2
    assert min(hausdorff(arc, each.points) for each in lines) < 8.0


def test_gaps_are_bridged_and_dashes_stay():
    broken = [circle(250, 300, 150)[:59], circle(250, 300, 150)[59:]]
    dashes = [line((600, 60 + 60 * k), (600, 95 + 60 * k)) for k in range(8)]
    lines = found([*broken, *dashes])
    assert sum(each.is_closed for each in lines) == 1
    assert len(lines) == 9


def square_with_gaps(gap: float) -> list[np.ndarray]:
    """Four sides of a square, each from beside one corner to beside the next."""
    corners = np.array([(100, 100), (300, 100), (300, 300), (100, 300), (100, 100)], float)
    along = np.diff(corners, axis=0) / 200.0
    return [
        np.linspace(start + gap * way, end - gap * way, 90)
        for start, end, way in zip(corners[:-1], corners[1:], along, strict=True)
    ]


def closed_of(lines) -> list[bool]:
    return [is_closed(each) for each in bridged(lines, 10.0, 3.0)]


@pytest.mark.parametrize("turn", [0.0, 0.4])
def test_an_outline_with_gaps_at_its_corners_is_closed(turn: float) -> None:
    cosine, sine = np.cos(turn), np.sin(turn)
    sides = [side @ [[cosine, sine], [-sine, cosine]] for side in square_with_gaps(5.0)]
    sides[1] = sides[1][::-1]
    (outline,) = bridged(sides, 10.0, 3.0)
    assert is_closed(outline)
    assert set(map(tuple, np.vstack(sides))) == set(map(tuple, outline))


def test_a_short_piece_between_two_gaps_of_an_outline_is_no_dash() -> None:
    ring = circle(200, 200, 100)
    pieces = [ring[:56], ring[58:63], ring[65:]]
    assert closed_of(pieces) == [True]


def test_what_is_no_ring_is_not_closed_over_gaps_at_corners() -> None:
    sides = square_with_gaps(5.0)
    assert closed_of(sides[:3]) == [False] * 3
    third = line((300, 90), (300, 20))
    assert closed_of([*sides, third]) == [False] * 5
    passing = line((305, 20), (305, 380))
    assert closed_of([*square_with_gaps(8.0)[:1], passing]) == [False] * 2
    dashes = [circle(200, 200, 100)[k : k + 7] for k in range(0, 120, 10)]
    assert not any(closed_of(dashes))


def test_an_outline_in_pencil_that_skips_is_closed() -> None:
    ring = circle(400, 300, 180)
    pieces = [ring[:41], ring[42:45], ring[46:90], ring[91:]]
    (one,) = found(pieces)
    assert one.is_closed
    assert hausdorff(ring, one.points) < 0.01 * 360


def test_a_lighter_line_has_less_pressure():
    lines = [line((100, 200), (700, 200)), line((100, 400), (700, 400))]
    pressures = [np.full(60, 0.9), np.full(60, 0.3)]
    pixels, _ = paper_picture(lines, SIZE, PHONE, 3, pressures)
    traced = sorted(trace(sheet_of(pixels)), key=lambda each: each.points[:, 1].mean())
    assert len(traced) == 2
    assert np.median(traced[0].pressure) > 1.5 * np.median(traced[1].pressure)


def test_light_lines_on_a_dark_ground_are_found():
    pixels, _ = paper_picture([circle(400, 300, 180)], SIZE, PHONE, 4)
    pixels = pixels.copy()
    pixels[..., :3] = 255 - pixels[..., :3]
    (one,) = trace(sheet_of(pixels))
    assert one.is_closed


@pytest.mark.parametrize("ground", [0.3, 0.55])
@pytest.mark.parametrize("lines_are", ["lighter", "darker"])
def test_dark_paper_has_dark_or_light_lines(ground: float, lines_are: str) -> None:
    drawn = [circle(400, 300, 150 - 16 * k) for k in range(4)]
    pixels, _ = paper_picture(drawn, SIZE, PHONE, 1)
    level = pixels[..., :3].astype(float) / 255.0
    if lines_are == "darker":
        level = ground * level
    else:
        level = ground + (0.95 - ground) * (1.0 - level)
    pixels = pixels.copy()
    pixels[..., :3] = np.round(255.0 * level)
    lines = trace(sheet_of(pixels))
    assert len(lines) == 4
    for ring in drawn:
        assert min(hausdorff(ring, each.points) for each in lines if each.is_closed) < 5.0


def test_a_page_on_a_table_is_found_and_straightened():
    pixels, corners = paper_picture([circle(400, 300, 180)], SIZE, TABLE, 5)
    sheet = sheet_of(pixels)
    assert sheet.corners is not None
    assert np.linalg.norm(sheet.corners - corners, axis=1).max() < 2.0
    (one,) = trace(sheet)
    assert one.is_closed
    assert sheet_of(pixels, page=False).corners is None


@pytest.mark.parametrize("seed", range(6))
def test_a_sheet_that_fills_the_picture_has_no_page_in_it(seed):
    pixels, _ = paper_picture([circle(400, 300, 180)], SIZE, PHONE, seed)
    assert find_page(gray_of(pixels)) is None


def test_the_ratio_of_a_photographed_page_is_its_own():
    page = np.array([(-105, -148, 0), (105, -148, 0), (105, 148, 0), (-105, 148, 0)], float)
    turn, tilt = np.radians((12, 35))
    about = np.array([(np.cos(turn), -np.sin(turn), 0), (np.sin(turn), np.cos(turn), 0), (0, 0, 1)])
    over = np.array([(1, 0, 0), (0, np.cos(tilt), -np.sin(tilt)), (0, np.sin(tilt), np.cos(tilt))])
    seen = page @ about.T @ over.T + (20, -10, 700)
    corners = 1500 * seen[:, :2] / seen[:, 2:] + (800, 600)
    assert aspect_ratio(corners, (1600, 1200)) == pytest.approx(210 / 296, rel=1e-6)


def test_a_homography_takes_four_places_to_four_others():
    source = np.array([(0, 0), (4, 0), (4, 3), (0, 3)], float)
    target = np.array([(1, 1), (9, 2), (8, 7), (0, 5)], float)
    image = np.column_stack((source, np.ones(4))) @ homography(source, target).T
    assert image[:, :2] / image[:, 2:] == pytest.approx(target, abs=1e-9)


def test_empty_paper_black_paper_and_grain_are_refused_with_advice():
    blank, _ = paper_picture([], SIZE, PHONE, 6)
    with pytest.raises(UserError, match="no line"):
        trace(sheet_of(blank))
    rng = np.random.default_rng(1)
    noise = np.full((300, 400, 4), 255, np.uint8)
    noise[..., :3] = rng.integers(0, 2, (300, 400, 1)) * 255
    with pytest.raises(UserError):
        trace(sheet_of(noise))


@pytest.mark.parametrize("shape", [(1, 1), (1, 900), (900, 2), (3, 3)])
def test_tiny_pictures_do_no_harm(shape):
    pixels = np.full((*shape, 4), 255, np.uint8)
    with pytest.raises(UserError):
        trace(sheet_of(pixels))


def test_what_is_no_picture_is_a_mistake_of_the_caller():
    with pytest.raises(ValueError, match="shape"):
        sheet_of(np.zeros((4, 4, 3), np.uint8))


# -- strokes --


@pytest.fixture
def cross():
    return (TracedLine(np.array([(0.0, 0.0), (800.0, 600.0)]), np.array([0.4, 0.8])),)


def test_a_drawing_is_a_front_view_of_the_page(cross):
    drawing = page_drawing(cross, SIZE, "cross")
    (stroke,) = drawing.strokes
    assert drawing.camera.viewport == SIZE
    assert stroke.points == pytest.approx(np.array([(0, 0), (800, 600)]))
    assert stroke.pressure == pytest.approx([0.4, 0.8])
    seen, _ = drawing.camera.project([(-100.0, 0.0, 150.0), (100.0, 0.0, 0.0)])
    assert seen == pytest.approx(np.array([(0, 0), (800, 600)]), abs=1e-6)


def test_a_page_fills_a_view_and_keeps_its_shape(cross):
    (stroke,) = strokes_in_view(cross, SIZE, Camera(viewport=(1000.0, 500.0)))
    span = stroke.points[1] - stroke.points[0]
    assert span[0] / span[1] == pytest.approx(800 / 600)
    assert stroke.points.mean(0) == pytest.approx([500, 250])
    assert span[1] < 500


def test_ink_along_a_picture_lies_on_it_in_any_view(cross):
    place = ((-100.0, 0.0, 150.0), (200.0, 0.0, 0.0), (0.0, 0.0, -150.0))
    for camera in (Camera(), Camera(eye=(300.0, -400.0, 250.0))):
        (stroke,) = strokes_on_picture(cross, SIZE, place, camera)
        seen, _ = camera.project([(-100.0, 0.0, 150.0), (100.0, 0.0, 0.0)])
        assert stroke.points == pytest.approx(seen, abs=1e-3)


def test_a_view_from_the_side_is_not_square():
    place = ((-100.0, 0.0, 150.0), (200.0, 0.0, 0.0), (0.0, 0.0, -150.0))
    front = Camera(eye=(0.0, -500.0, 75.0), target=(0.0, 0.0, 75.0))
    assert is_seen_square(SIZE, place, front)
    assert not is_seen_square(SIZE, place, Camera(eye=(300.0, -400.0, 250.0)))


def test_joining_many_lines_takes_time_in_proportion():
    """A picture of fur, 512 × 512, took 16 s: every join went through all ends."""

    def seconds(count):
        at = np.arange(count)
        begins = np.column_stack((at % 100 * 10.0, at // 100 * 10.0))
        steps = np.array([(k, 0.0) for k in range(9)])
        lines = [begin + steps for begin in begins]
        begun = process_time()
        joined = bridged(lines, 3.0, 1.0)
        took = process_time() - begun
        assert len(joined) == count / 100
        return took

    seconds(1000)
    assert seconds(8000) < 16 * max(seconds(1000), 1e-3)


@pytest.mark.parametrize("quarter", range(4))
def test_a_rim_of_the_table_is_no_line_and_one_that_leaves_the_page_stays(quarter):
    picture = np.full((700, 900), 235, np.uint8)
    row, column = np.mgrid[:700, :900]
    picture[row < 9 - column / 60] = 70  # the page lies a little askew
    picture[300:304, 200:] = 60
    picture[:500, 600:604] = 60
    picture = np.rot90(picture, quarter)
    pixels = np.dstack([picture, picture, picture, np.full_like(picture, 255)])
    lines = [one.points for one in trace(sheet_of(pixels))]
    drawn = sum(np.linalg.norm(np.diff(one, axis=0), axis=1).sum() for one in lines)
    assert drawn == pytest.approx(1200, rel=0.06)  # one of 700, one of 500
