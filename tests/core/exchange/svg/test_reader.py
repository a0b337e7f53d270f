"""SVG: shapes with known outlines, nested transforms, viewports, and the way back."""

from __future__ import annotations

import gzip
import math
from pathlib import Path

import numpy as np
import pytest
import shapely
import shapely.ops

from bozzetto.errors import FormatError
from bozzetto.exchange.export import export, write_drawing
from bozzetto.exchange.import_file import read_drawing
from bozzetto.exchange.svg.path_data import parse_path
from bozzetto.exchange.svg.reader import read_drawing as read_svg
from bozzetto.geometry import Curve, Shapes
from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.view import Camera

OUTLINES = sorted((Path(__file__).parents[5] / "shared/data/silhouettes").glob("*.svg"))


def read(body, attributes='viewBox="0 0 100 100"'):
    text = f'<svg xmlns="http://www.w3.org/2000/svg" {attributes}>{body}</svg>'
    return read_svg(text.encode(), "test")


def world(stroke):
    """Places on the front plane as the file's x and y."""
    places = stroke.camera.on_plane(stroke.points, (0, 0, 0), (0, 1, 0))
    np.testing.assert_allclose(places[:, 1], 0, atol=1e-9)
    return places[:, [0, 2]] * (1, -1)


def lines(body, **more):
    return [world(stroke) for stroke in read(body, **more).strokes]


def end_points(data):
    """Begin and end of every piece of the first subpath."""
    cubics = parse_path(data)[0].cubics
    return np.vstack((cubics[:1, 0], cubics[:, 3])).tolist()


# -- path data -----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("data", "points"),
    [
        ("M1 2L3 4", [[1, 2], [3, 4]]),
        ("M1,2 3,4 5,6", [[1, 2], [3, 4], [5, 6]]),
        ("m1 2 3 4 l1-1", [[1, 2], [4, 6], [5, 5]]),
        ("M0 0H5V6h-2v-3", [[0, 0], [5, 0], [5, 6], [3, 6], [3, 3]]),
        ("M0 0.5.5-1e1", [[0, 0.5], [0.5, -10]]),
        ("M0,0C1,1 2,1 3,0s2-1 3,0", [[0, 0], [3, 0], [6, 0]]),
        ("M0 0Q1 1 2 0t2 0", [[0, 0], [2, 0], [4, 0]]),
        ("M1 1h2v2z", [[1, 1], [3, 1], [3, 3], [1, 1]]),
        ("  M 1 1 L 2 2 \n", [[1, 1], [2, 2]]),
    ],
)
def test_end_points(data, points):
    np.testing.assert_allclose(end_points(data), points)


def test_a_new_subpath_after_closing_starts_where_the_old_one_did():
    paths = parse_path("M10 10h5v5z l1 0 m5 5 h1")
    assert [p.closed for p in paths] == [True, False, False]
    np.testing.assert_allclose(paths[1].cubics[0, [0, 3]], [[10, 10], [11, 10]])
    np.testing.assert_allclose(paths[2].cubics[0, [0, 3]], [[16, 15], [17, 15]])


def test_smooth_curves_go_on_in_the_same_direction():
    for data in ("M0 0C0 2 3 3 4 1S9 9 9 0", "M0 0Q3 3 4 1T9 0"):
        one, two = parse_path(data)[0].cubics
        incoming, outgoing = one[3] - one[2], two[1] - two[0]
        np.testing.assert_allclose(incoming, outgoing, atol=1e-12)
    # Only a curve of the same family is reflected (SVG 1.1, 8.3.6 and 8.3.7).
    for data in ("M0 0L4 1S9 9 9 0", "M0 0Q3 3 4 1S9 9 9 0", "M0 0C0 2 3 3 4 1T9 0"):
        one, two = parse_path(data)[0].cubics
        np.testing.assert_allclose(two[1], two[0])


def test_a_quadratic_is_raised_exactly():
    p = parse_path("M0 0Q5 10 10 0")[0].cubics[0]
    np.testing.assert_allclose(p[1:3], [[10 / 3, 20 / 3], [20 / 3, 20 / 3]])


@pytest.mark.parametrize("large", [0, 1])
@pytest.mark.parametrize("sweep", [0, 1])
@pytest.mark.parametrize("turn", [0, 30, -110])
def test_arcs_lie_on_their_ellipse_and_take_the_right_way(large, sweep, turn):
    (points,) = lines(f'<path d="M20 30 A 30 15 {turn} {large} {sweep} 50 40"/>')
    # Of the ellipse we know the half axes and that it goes through both ends: fit its centre.
    c, s = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    unit = points @ np.array([[c, -s], [s, c]]) / (30, 15)
    system = np.column_stack((2 * (unit[1:] - unit[0]),))
    center = np.linalg.lstsq(system, (unit[1:] ** 2).sum(1) - (unit[0] ** 2).sum(), rcond=None)[0]
    np.testing.assert_allclose(np.linalg.norm(unit - center, axis=1), 1, atol=1e-5)
    around = unit - center
    angle = np.unwrap(np.arctan2(around[:, 1], around[:, 0]))
    span = angle[-1] - angle[0]
    assert (abs(span) > np.pi) == bool(large)
    assert (span > 0) == bool(sweep)
    np.testing.assert_allclose(points[[0, -1]], [[20, 30], [50, 40]], atol=1e-5)


def test_arcs_that_cannot_reach_grow_and_flat_ones_are_lines():
    (points,) = lines('<path d="M0 50 A 1 1 0 0 1 100 50"/>')
    np.testing.assert_allclose(np.hypot(*(points - 50).T), 50, rtol=1e-5)
    (points,) = lines('<path d="M0 0 A 0 5 0 0 1 10 10"/>')
    np.testing.assert_allclose(points, [[0, 0], [10, 10]], atol=1e-6)
    (points,) = lines('<path d="M0 0a5 5 0 1110 0A5,5,0,0,1,0,0"/>')  # flags without blanks
    assert shapely.Polygon(points).area == pytest.approx(25 * np.pi, rel=1e-3)


@pytest.mark.parametrize(
    "data", ["L1 2", "M1", "M1 2 X", "M0 0 L1 1 2", "M0 0 A1 1 0 2 0 1 1", "M0 0 L1e99 0", "M--1 2",
             "M0 0z5 5", "M0 0L nan 0", "\x00"]
)  # fmt: skip
def test_broken_path_data_is_quoted(data):
    with pytest.raises(FormatError, match="path"):
        parse_path(data)


# -- shapes, flattening and transforms ----------------------------------------------------------


def test_basic_shapes_enclose_what_they_should():
    body = (
        '<rect x="10" y="10" width="20" height="10"/>'
        '<rect x="40" y="10" width="20" height="10" rx="3"/>'
        '<circle cx="50" cy="60" r="10"/><ellipse cx="80" cy="60" rx="5" ry="10"/>'
        '<polygon points="0,80 10,80 10,95"/>'
        '<polyline points="20 80 30 80 30 95"/><line x1="1" y1="2" x2="3" y2="4"/>'
        '<circle r="0"/><rect width="5"/><path d="M1 1"/>'
    )
    found = lines(body)
    closed = [p for p in found if (p[0] == p[-1]).all()]
    areas = [shapely.Polygon(p).area for p in closed]
    np.testing.assert_allclose(
        areas, [200, 200 - (4 - np.pi) * 9, np.pi * 100, np.pi * 50, 75], rtol=5e-3
    )
    assert [len(p) for p in found[-2:]] == [3, 2]


def test_flattening_stays_within_its_tolerance_and_is_not_wasteful():
    (points,) = lines('<circle cx="50" cy="50" r="50"/>')
    size = 100 * 2**0.5
    middles = (points[1:] + points[:-1]) / 2
    assert 50 - np.linalg.norm(middles - 50, axis=1).min() < 2e-4 * size + 1e-5
    assert len(points) < 100


def test_transforms_nest_and_read_from_the_right():
    body = (
        '<g transform="translate(10,20)"><g transform="scale(2) rotate(90)">'
        '<path d="M1 0L2 0" transform="matrix(1 0 0 1 0 5)"/></g></g>'
    )
    (points,) = lines(body)
    np.testing.assert_allclose(points, [[0, 22], [0, 24]], atol=1e-5)
    (points,) = lines('<path d="M1 0L2 0" transform="rotate(90 1 0), skewX(45)"/>')
    np.testing.assert_allclose(points, [[1, 0], [1, 1]], atol=1e-5)
    (points,) = lines('<path d="M1 1L2 0" transform="skewY(45)translate(1)"/>')
    np.testing.assert_allclose(points, [[2, 3], [3, 3]], atol=1e-5)


def test_a_curve_under_a_transform_is_the_transformed_curve():
    (plain,) = lines('<path d="M0 0C10 40 50 -40 60 0"/>')
    (turned,) = lines('<g transform="rotate(30) scale(1 3)"><path d="M0 0C10 40 50 -40 60 0"/></g>')
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    expected = shapely.LineString((plain * (1, 3)) @ np.array([[c, s], [-s, c]]))
    assert shapely.hausdorff_distance(shapely.LineString(turned), expected) < 0.05


def test_colours_are_inherited_and_styles_win():
    body = (
        '<g stroke="#f00"><path d="M0 0L1 1"/><path d="M0 0L1 1" stroke="navy"/>'
        '<path d="M0 0L1 1" stroke="navy" style="fill:none; stroke: rgb(1, 2, 3)"/>'
        '<path d="M0 0L1 1" stroke="none"/><path d="M0 0L1 1" stroke="url(#a)"/></g>'
        '<path d="M0 0L1 1"/>'
    )
    colors = [s.color for s in read(body).strokes]
    assert colors == [(255, 0, 0), (0, 0, 128), (1, 2, 3), None, None, None]


def test_what_is_not_drawn_is_passed_over():
    body = (
        '<defs><path d="M0 0L9 9"/></defs><clipPath><rect width="5" height="5"/></clipPath>'
        '<symbol><path d="M0 0L9 9"/></symbol><text>hello</text><image href="x.png"/>'
        '<g display="none"><path d="M0 0L9 9"/></g><style>path{}</style>'
        '<x:path xmlns:x="urn:other" d="M0 0L9 9"/><path d="M0 0L5 5"/>'
    )
    assert len(read(body).strokes) == 1


def test_what_is_shown_and_not_read_is_named():
    body = (
        '<path d="M0 0L5 5"/><text>one</text><g><text>two<tspan>!</tspan></text></g>'
        '<image href="x.png"/><text visibility="hidden">three</text>'
        '<g display="none"><text>four</text></g><defs><text id="t">five</text></defs>'
        '<use href="#t"/>'
    )
    (said,) = read(body).left_out
    assert "1 picture and 3 texts of this drawing are left out" in said
    assert "Turn text into paths" in said
    assert read('<path d="M0 0L5 5"/>').left_out == ()
    assert "1 picture of this drawing is left" in read('<path d="M0 0L5 5"/><image/>').left_out[0]
    with pytest.raises(FormatError, match=r"no lines .* Only lines are read; 1 text"):
        read("<text>alone</text>")


CLIP = '<clipPath id="c">{}</clipPath>'
BAR = '<g clip-path="url(#c)"><path d="M{} 20h40" stroke="red" fill="none"/></g>'


HALF = '<rect width="100" height="50"/>'
"""Up to x = 100, y = 50."""


@pytest.mark.parametrize(
    ("clip", "begin", "shown"),
    [
        (HALF, 30, [(30, 70)]),
        (HALF, 80, [(80, 100)]),
        (HALF, 120, []),
        ('<rect width="100" height="50" transform="translate(-90 0)"/>', 30, []),
        ('<rect width="30" height="50"/><rect x="50" width="50" height="50"/>', 20,
         [(20, 30), (50, 60)]),
        ('<path clip-rule="evenodd" d="M0 0h99v50h-99zM40 0h10v50h-10z"/>', 20,
         [(20, 40), (50, 60)]),
        ('<circle cx="50" cy="20" r="50"/>', 70, [(70, 100)]),
        ('<circle cx="50" cy="20" r="50"/>', 101, []),
        ('<rect width="80" height="40" rx="20"/>', 50, [(50, 80)]),
        ("", 30, []),
    ],
)  # fmt: skip
def test_a_clip_cuts_lines_and_hides_what_lies_outside(clip, begin, shown):
    frame = '<path d="M0 0h100v100h-100z" stroke="red" fill="none"/>'
    body = CLIP.format(clip) + BAR.format(begin) + frame
    assert read(body).left_out == ()
    *bars, _ = lines(body)
    assert [(one[0, 0], one[-1, 0]) for one in bars] == [
        pytest.approx(ends, abs=0.02) for ends in shown
    ]


def test_clips_within_clips_and_of_clips_cut_together():
    inner = '<clipPath id="d" clip-path="url(#c)"><rect x="10" width="60" height="90"/></clipPath>'
    bar = '<g clip-path="url(#e)"><path clip-path="url(#d)" d="M0 20h90" stroke="red"/></g>'
    outer = '<clipPath id="e"><rect x="20" width="99" height="99"/></clipPath>'
    clip = CLIP.format('<rect width="50" height="50"/>')
    (one,) = lines(clip + inner + outer + bar)
    assert (one[0, 0], one[-1, 0]) == pytest.approx((20, 50))


def test_a_clipped_area_ends_where_the_clip_does_and_a_stroke_stays_open():
    clip = CLIP.format('<rect x="-9" width="29" height="40"/>')
    area = '<rect clip-path="url(#c)" y="10" width="40" height="20" {}/>'
    (one,) = lines(clip + area.format('fill="red"'))
    assert one[0] == pytest.approx(one[-1])
    assert np.ptp(one, axis=0) == pytest.approx([20, 20], abs=1e-6)
    (other,) = lines(clip + area.format('fill="none" stroke="red"'))
    assert {*map(tuple, np.round(other[[0, -1]], 6))} == {(20.0, 10.0), (20.0, 30.0)}
    assert len(other) == 4


def test_a_clipped_line_that_crosses_itself_is_one_stroke():
    loop = "M0 0L40 40L40 0L0 40"
    clip = CLIP.format('<rect x="-9" y="-9" width="99" height="48"/>')
    (one,) = lines(clip + f'<path clip-path="url(#c)" d="{loop}" fill="none" stroke="red"/>')[:1]
    assert one[0] == pytest.approx([0, 0])
    assert (
        len(lines(clip + f'<path clip-path="url(#c)" d="{loop}" fill="none" stroke="red"/>')) == 2
    )


@pytest.mark.parametrize(
    "clip",
    ["<text>a</text>", '<use href="#x"/>', '<g><rect width="9" height="9"/></g>'],
)
def test_a_clip_that_is_not_understood_cuts_nothing_and_is_told(clip):
    drawing = read(CLIP.format(clip) + BAR.format(30))
    assert len(drawing.strokes) == 1
    assert any("cut by a mask or a clip" in said for said in drawing.left_out)


def test_a_filled_line_that_nearly_comes_round_is_a_border():
    """As in icons that were made small: their last side is left to the fill."""
    path = '<path {} d="M10 10h30v20h-30v-16"/>'
    (one,) = lines(2 * path.format('fill="red"'))  # drawn twice, too
    assert one[0] == pytest.approx(one[-1], abs=1e-9)
    (other,) = lines(path.format('fill="none" stroke="red"'))
    assert other[0] != pytest.approx(other[-1], abs=1)
    (arm,) = lines('<path fill="red" stroke="red" d="M10 10h30v20"/>')
    assert len(arm) == 3


def test_lengths_may_be_shares_of_the_page_and_letters_are_told():
    attributes = 'viewBox="0 0 100 50"'
    (one,) = lines('<ellipse cx="50%" cy="50%" rx="40%" ry="20%"/>', attributes=attributes)
    assert np.ptp(one, axis=0) == pytest.approx([80, 20], abs=0.1)
    assert one.mean(axis=0) == pytest.approx([50, 25], abs=1)
    drawing = read('<rect x="9" width="2em" height="9"/><rect width="9" height="9"/>')
    assert len(drawing.strokes) == 1
    assert "1 shape sized by letters" in drawing.left_out[0]


@pytest.mark.parametrize(
    "said",
    [
        'style="transform: translate(20px, 10px)"',
        'style="transform: translateX(20px) translateY(10px)"',
        'class="moved"',
        'transform="rotate(180)" transform-origin="35 25"',
        'style="transform: rotate(180deg); transform-origin: 35px 25px"',
        'style="transform: scale(-1); transform-origin: 35% 25%"',
        'style="transform: rotate(0.5turn); transform-origin: 35px 25px"',
        'style="transform: rotate(3.14159265358979rad); transform-origin: 35px 25px"',
        'style="transform: translate(20%, 10%)"',
    ],
)
def test_transforms_of_styles_count(said):
    style = "<style>.moved { transform: translate(20px, 10px) }</style>"
    (one,) = lines(f'{style}<rect x="10" y="10" width="30" height="20" {said}/>')
    assert one.min(axis=0) == pytest.approx([30, 20], abs=1e-6)
    assert one.max(axis=0) == pytest.approx([60, 40], abs=1e-6)


@pytest.mark.parametrize("said", ["translate3d(9px, 0, 0)", "rotate(1lap)", "var(--x)", "inherit"])
def test_a_transform_of_a_style_that_nobody_knows_is_told_and_does_not_count(said):
    plain = '<path d="M10 10h30v20"/>'
    styled = f'<path style="transform: {said}" d="M10 10h30v20"/>'
    known, drawing = read(plain), read(styled)
    np.testing.assert_array_equal(drawing.strokes[0].points, known.strokes[0].points)
    assert "not understood" in drawing.left_out[0]
    assert not read(styled.replace(said, "initial")).left_out
    with pytest.raises(FormatError, match="transform"):
        read(plain.replace("<path", f'<path transform="{said}"'))


def test_nested_svg_has_its_own_units():
    body = (
        '<svg x="10" y="20" width="40" height="20" viewBox="0 0 10 10"><path d="M0 0L10 10"/></svg>'
    )
    (points,) = lines(body)  # scale 2, centred in the wider box
    np.testing.assert_allclose(points, [[20, 20], [40, 40]], atol=1e-5)


@pytest.mark.parametrize(
    ("said", "low", "high"),
    [
        ("", (20, 20), (40, 40)),
        ("xMinYMid", (10, 20), (30, 40)),
        (" xMaxYMin meet ", (30, 20), (50, 40)),
        ("none", (10, 20), (50, 40)),
        ("xMinYMax slice", (10, 0), (50, 40)),
        ("xMidYMid slice", (10, 10), (50, 50)),
        ("middle", (20, 20), (40, 40)),  # not understood
    ],
)
def test_a_view_box_lies_in_its_viewport_as_it_says(said, low, high):
    frame = 'x="10" y="20" width="40" height="20" viewBox="0 0 10 10" overflow="visible"'
    (points,) = lines(f'<svg {frame} preserveAspectRatio="{said}"><path d="M0 0L10 10"/></svg>')
    np.testing.assert_allclose(points, [low, high], atol=1e-5)


@pytest.mark.parametrize(
    "box", ["0 0 9 1e-320", "0 0 1e-320 1e-320", "0 0 1e-300 9", "9e8 9e8 9 9"]
)
@pytest.mark.parametrize("said", ["none", "xMidYMid", "xMinYMin slice"])
def test_a_view_box_that_is_hardly_there_is_read_or_refused(box, said):
    frame = f'width="20" height="20" viewBox="{box}" preserveAspectRatio="{said}"'
    try:
        found = lines(f'<svg {frame} overflow="visible"><path d="M0 0L10 10"/></svg>')
    except FormatError:
        return
    assert all(np.isfinite(points).all() for points in found)


SQUARE = '<rect x="-10" y="-10" width="40" height="40" fill="green"/>'


@pytest.mark.parametrize(
    ("body", "low", "high"),
    [
        (f'<svg x="10" y="20" width="20" height="8">{SQUARE}</svg>', (10, 20), (30, 28)),
        (
            f'<svg x="10" y="20" width="20" height="8" viewBox="0 0 80 32">{SQUARE}</svg>',
            (10, 20),
            (17.5, 27.5),
        ),
        (f'<svg width="20" height="8" overflow="visible">{SQUARE}</svg>', (-10, -10), (30, 30)),
        (f'<svg width="20" height="8" style="overflow:auto">{SQUARE}</svg>', (-10, -10), (30, 30)),
        (
            f'<symbol id="s">{SQUARE}</symbol><use href="#s" x="5" width="9" height="50%"/>',
            (5, 0),
            (14, 30),
        ),
        (
            f'<defs><svg id="s" x="40" y="4" width="9" height="9">{SQUARE}</svg></defs>'
            '<use href="#s" x="5" y="1" height="20" transform="scale(2)"/>',
            (90, 10),
            (108, 50),
        ),
    ],
)
def test_an_inner_viewport_hides_what_lies_outside(body, low, high):
    (points,) = lines(body)
    np.testing.assert_allclose([points.min(axis=0), points.max(axis=0)], [low, high], atol=1e-3)


# -- where it stands ------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("attributes", "viewport"),
    [
        ('viewBox="-5 -5 110 90"', (110, 90)),
        ('width="300" height="200px"', (300, 200)),
        ('width="110px" height="3in" viewBox="-5,-5,110,76.2"', (110, 76.2)),
        ('width="96%" viewBox="-5,-5,110,90"', (110, 90)),
        ('width="1in" height="25.4mm"', (96, 96)),
    ],
)
def test_the_canvas_is_the_view_box_and_the_file_is_not_moved(attributes, viewport):
    drawing = read('<path d="M1 2L30 40"/>', attributes)
    np.testing.assert_allclose(drawing.camera.viewport, viewport)
    np.testing.assert_allclose(world(drawing.strokes[0]), [[1, 2], [30, 40]], atol=1e-4)
    stroke = drawing.strokes[0]
    assert (stroke.tool, stroke.has_pressure, stroke.has_time) == ("imported", False, False)


@pytest.mark.parametrize(
    ("attributes", "scale"),
    [
        ('width="100mm" height="50mm" viewBox="0 0 1000 500"', 0.1),
        ('width="10cm" viewBox="0 0 50 80"', 2.0),
        ('height="1in" viewBox="-7 3 10 10"', 2.54),
        ('width="96in" height="25.4mm" viewBox="-5,-5,110,90"', 25.4 / 90),
        ('width="72pt" height="6pc" viewBox="0 0 25.4 25.4"', 1.0),
        ('width="0mm" height="-3mm" viewBox="0 0 10 10"', 1.0),
        ('width="1e-300mm" viewBox="0 0 10 10"', 1.0),
        ('width="100.0000001mm" viewBox="0 0 100 100"', 1.0),
    ],
)
def test_a_view_box_with_a_size_on_paper_has_that_size(attributes, scale):
    drawing = read('<path d="M1 2L30 40"/>', attributes)
    places = scale * np.array([[1, 2], [30, 40]])
    np.testing.assert_allclose(world(drawing.strokes[0]), places, atol=1e-4)


def test_symbols_and_inner_frames_keep_their_place_on_paper():
    body = '<symbol id="s"><path d="M0 0L10 10"/></symbol><use href="#s" x="100" y="50"/>'
    plain, (half,) = (
        read(body, 'viewBox="0 0 200 100"'),
        read(body, 'width="100mm" viewBox="0 0 200 100"').strokes,
    )
    np.testing.assert_allclose(world(half), 0.5 * world(plain.strokes[0]), atol=1e-4)


def test_without_any_size_the_bounds_are_the_canvas():
    drawing = read('<path d="M-100 50L-60 70"/>', "")
    np.testing.assert_allclose(drawing.camera.viewport, (40, 20), rtol=1e-3)
    np.testing.assert_allclose(world(drawing.strokes[0]), [[-100, 50], [-60, 70]], atol=1e-4)


@pytest.mark.parametrize("far", [1e3, 1e6, 1e8])
@pytest.mark.parametrize("box", ["", 'viewBox="0 0 100 100"'])
def test_far_from_the_origin_places_stay_right(far, box):
    drawing = read(f'<path d="M{far} {far}l3 4 3 1"/>', box)
    expected = np.array([[0, 0], [3, 4], [6, 5]]) + far
    assert np.abs(world(drawing.strokes[0]) - expected).max() < 1e-5 * 6 + far * 1e-15


@pytest.mark.skipif(not OUTLINES, reason="the outlines are not here")
def test_every_icon_is_closed_and_has_the_area_that_was_measured():
    import csv

    folder = OUTLINES[0].parent
    measured = {row["name"]: row for row in csv.DictReader((folder / "manifest.csv").open())}
    for path in OUTLINES:
        rings = [world(s) for s in read_drawing(path).strokes]
        assert all((r[0] == r[-1]).all() for r in rings), path.stem
        if path.stem in measured and float(measured[path.stem]["area"]) > 0:
            polygons = sorted((shapely.Polygon(r) for r in rings), key=lambda p: -p.area)
            area = polygons[0].area - sum(p.area for p in polygons[1:])
            if int(measured[path.stem]["holes"]) == len(rings) - 1:
                assert area == pytest.approx(float(measured[path.stem]["area"]), rel=5e-3)


# -- painted areas --------------------------------------------------------------------------


def painted(body, **more):
    """The area inside the lines of a drawing: nested ones are holes."""
    region = shapely.Polygon()
    for line in lines(body, **more):
        ring = shapely.Polygon(line)
        assert ring.is_valid
        region = region.symmetric_difference(ring)
    return region


SQUARES = "M0 0h20v20h-20z M10 10h20v20h-20z"


@pytest.mark.parametrize(
    ("body", "area", "rings"),
    [
        (f'<path d="{SQUARES}"/>', 700, 1),
        (f'<path fill-rule="evenodd" d="{SQUARES}"/>', 600, 2),
        (f'<g style="fill-rule:evenodd"><path d="{SQUARES}"/></g>', 600, 2),
        ('<path d="M0 0h20v20h-20z M10 10v20h20v-20z"/>', 600, 2),  # they run opposite ways
        ('<rect width="20" height="20"/><rect x="10" y="10" width="20" height="20"/>', 700, 1),
        ('<rect width="20" height="20"/><rect x="20" width="20" height="20"/>', 800, 1),
        ('<rect width="20" height="20"/><rect width="20" height="20"/>', 400, 1),
        ('<rect width="20" height="20"/><rect x="5" y="5" width="9" height="9"/>', 319, 2),
        ('<rect width="20" height="20"/><rect x="5" y="5" width="9" height="15"/>', 400, 1),
        (f'<path d="{SQUARES} M2 2v4h4v-4z"/>', 684, 2),
        (f'<path d="{SQUARES}"/><rect x="50" width="9" height="9"/>', 781, 2),
    ],
)
def test_painted_areas_that_overlap_become_one(body, area, rings):
    assert len(lines(body)) == rings
    assert painted(body).area == pytest.approx(area, rel=1e-3)


@pytest.mark.parametrize("scale", [1e-3, 1, 1e4])
def test_joining_is_exact_at_any_scale_and_place(scale):
    body = (
        f'<g transform="translate({1e4 * scale} 7) scale({scale} {-scale})">'
        '<circle r="10"/><circle cx="12" r="10"/></g>'
    )
    disc = shapely.Point(0, 0).buffer(10, 256)
    expected = disc.union(shapely.Point(12, 0).buffer(10, 256)).area * scale**2
    assert painted(body).area == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("gap", [-1e-4, -1e-9, 0.0, 1e-9, 3e-6, 1e-5, 1.5e-5, 1e-3])
@pytest.mark.parametrize("turn", [0.0, 0.7, 2.0, 4.4])
def test_what_touches_by_a_hair_is_apart_or_one(gap, turn):
    """A pupil at the rim of an eye: smoothed, its outline crossed the other one."""
    size, eye, pupil = 200.0, 60.0, 25.0
    off = eye - pupil - gap * size
    body = (
        f'<path fill-rule="evenodd" d="M-100 -100H100V100H-100z M{eye} 0A{eye} {eye} 0 1 0 -{eye} 0'
        f'A{eye} {eye} 0 1 0 {eye} 0z"/>'
        f'<circle cx="{off * math.cos(turn)}" cy="{off * math.sin(turn)}" r="{pupil}"/>'
    )
    found = lines(body)
    distances = [
        shapely.LinearRing(one).distance(shapely.LinearRing(two))
        for number, one in enumerate(found) for two in found[:number]
    ]  # fmt: skip
    assert min(distances) > 2e-5 * size
    expected = size**2 - math.pi * (eye**2 - pupil**2)
    assert painted(body).area == pytest.approx(expected, rel=2e-3)


@pytest.mark.parametrize("wide", [1e-3, 0.01, 0.03])
def test_slivers_between_areas_that_lie_side_by_side_are_none(wide):
    """Two halves of a ring that nearly meet, and a bar over each end of the gap between them."""
    halves = f"M0 0H50V100H0z M{50 + wide} 0H100V100H{50 + wide}z"
    bars = "M40 0H60V9H40z M40 91H60V100H40z"
    body = f'<path d="{halves} {bars}"/>'
    assert len(lines(body)) == 1
    assert painted(body).area == pytest.approx(1e4, rel=1e-3)
    gap = f"M0 0H50V100H0z M52 0H100V100H52z {bars}"
    assert len(lines(f'<path d="{gap}"/>')) == 2


@pytest.mark.parametrize("wall", [0.0, 1e-3, 0.01])
def test_a_wall_that_is_thin_as_a_hair_is_none(wall):
    """A hole that points at the rim: nothing holds together by so little."""
    hole = f"M{wall} 50L50 20V80z"
    body = f'<path fill-rule="evenodd" d="M0 0H100V100H0z {hole}"/>'
    assert len(lines(body)) == 1
    assert len(lines(body.replace(hole, "M5 50L50 20V80z"))) == 2
    assert painted(body).area == pytest.approx(1e4 - 1500, rel=2e-3)


def test_a_slit_to_a_hole_is_none():
    keyhole = "M0 0H40V20H30V10H10V30H30V20H40V40H0z"
    assert painted(f'<path d="{keyhole}"/>').area == pytest.approx(1200, rel=1e-3)
    assert len(lines(f'<path d="{keyhole}"/>')) == 2
    two = "M0 0L20 0L20 10L10 5L0 10L10 5z"
    assert painted(f'<path d="{two}"/>').area == pytest.approx(100, rel=1e-2)


def test_a_flattened_drawing_has_no_area_and_says_so_later():
    assert len(lines('<circle r="9" transform="scale(1 0)"/><circle r="5"/>')) >= 1


def test_areas_piled_up_are_joined_or_refused():
    square = '<path d="M0 0h20v20h-20z"/>'
    assert len(lines(square * 3000)) == 1
    spread = "".join(f'<path d="M{k / 1000} {k % 7}h20v20h-20z"/>' for k in range(2000))
    with pytest.raises(FormatError, match="overlap"):
        read(spread)


def test_mere_lines_that_cross_stay_as_they_were_drawn():
    assert len(lines(f'<path fill="none" stroke="red" d="{SQUARES}"/>')) == 2
    (eight,) = lines('<path fill="none" stroke="red" d="M0 0L9 9V0L0 9z"/>')
    assert len(eight) == 5


def test_a_painted_line_that_crosses_itself_is_what_is_seen_of_it():
    """Stars of flags; the area by Shapely's union of the triangles and the pentagon."""
    tips = [(10 * math.sin(k * 0.8 * math.pi), -10 * math.cos(k * 0.8 * math.pi)) for k in range(5)]
    star = "M" + " ".join(f"{x},{y}" for x, y in tips) + "z"
    cells = list(shapely.ops.polygonize(shapely.unary_union(shapely.LinearRing(tips))))
    whole = sum(cell.area for cell in cells)
    inner = max(cells, key=lambda cell: cell.area).area
    assert len(cells) == 6
    assert len(lines(f'<path d="{star}"/>')) == 1
    assert painted(f'<path d="{star}"/>').area == pytest.approx(whole, rel=1e-6)
    assert len(lines(f'<path fill-rule="evenodd" d="{star}"/>')) == 5
    odd = painted(f'<path fill-rule="evenodd" d="{star}"/>')
    assert odd.area == pytest.approx(whole - inner, rel=1e-3)
    assert len(lines('<path d="M0 0L9 9V0L0 9z"/>')) == 2
    assert painted('<path d="M0 0L9 9V0L0 9z"/>').area == pytest.approx(40.5, rel=1e-3)


# -- what is to be seen ---------------------------------------------------------------------


def test_what_is_not_painted_is_passed_over_unless_there_is_nothing_else():
    frame = '<path stroke="none" fill="none" d="M0 0h24v24H0z"/>'
    assert len(lines(f'{frame}<path d="M1 1h5v5z"/>')) == 1
    assert len(lines(frame)) == 1
    hidden = '<g visibility="hidden"><path d="M0 0h9v9z"/><path visibility="visible" d="M0 0h5"/>'
    assert len(lines(f"{hidden}</g>")) == 1


def test_style_sheets_say_what_is_painted():
    sheet = (
        "<style>/* .b{display:inline} */ .a, .b { fill: none } path{stroke:#00f!important}"
        "#c{stroke:red;} .hidden{display:none} g > path {stroke:green}</style>"
    )
    body = (
        f'{sheet}<path class="a" d="M0 0h9"/><path id="c" fill="none" d="M0 0h9"/>'
        '<path class="x hidden" d="M0 0h9"/><path style="stroke:none" class="b" d="M0 0h9"/>'
    )
    assert [s.color for s in read(body).strokes] == [(0, 0, 255), (255, 0, 0)]


def test_repeated_elements_stand_where_they_are_named():
    body = (
        '<defs><path id="p" d="M0 0L1 2"/><symbol id="s" viewBox="0 0 10 10"><use href="#p"/>'
        '</symbol></defs><use xlink:href="#p" x="5" y="6" transform="scale(2)" '
        'xmlns:xlink="http://www.w3.org/1999/xlink"/>'
        '<use href="#s" x="1" width="20" height="20"/><use href="#s"/><use href="#missing"/>'
    )
    first, second, third = lines(body)
    np.testing.assert_allclose(first, [[10, 12], [12, 16]], atol=1e-5)
    np.testing.assert_allclose(second, [[1, 0], [3, 4]], atol=1e-5)
    np.testing.assert_allclose(third, [[0, 0], [10, 20]], atol=1e-5)  # as large as the canvas


# -- how it is written down -----------------------------------------------------------------


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_other_programs_heads_are_read(encoding):
    text = (
        f'<?xml version="1.0" encoding="{encoding.removesuffix("-sig")}" standalone="no"?>'
        '<!-- é --><!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" '
        '"http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd">'
        '<svg xmlns="http://www.w3.org/2000/svg" xmlns:i="&amp;ns_ai;" i:view="1">'
        '<metadata><rdf:RDF xmlns:rdf="urn:r"><path d="M0 0h1"/></rdf:RDF></metadata>'
        '<path d="M0 0L3 4"/></svg>'
    )
    drawing = read_svg(text.encode(encoding), "test")
    assert len(drawing.strokes) == 1


ILLUSTRATOR = """<?xml version="1.0" encoding="utf-8"?>
<!DOCTYPE svg PUBLIC "-//W3C//DTD SVG 1.1//EN" "http://www.w3.org/Graphics/SVG/1.1/DTD/svg11.dtd" [
    <!ENTITY ns_svg "http://www.w3.org/2000/svg">
    <!ENTITY ns_ai "http://ns.adobe.com/AdobeIllustrator/10.0/">
    <!ATTLIST svg xmlns:xlink CDATA #FIXED "http://www.w3.org/1999/xlink">
]>
<svg xmlns="&ns_svg;" xmlns:i='&ns_ai;' viewBox="0 0 9 9">
<switch>
<foreignObject requiredExtensions="&ns_ai;" width="1" height="1"><i:pgfRef/></foreignObject>
<g i:extraneous="self"><path d="M0 0L3 4"/><path d="M5 0L3 4"/></g>
<path d="M7 0L3 4"/>
</switch></svg>"""


def test_a_drawing_of_adobe_illustrator_is_read_whole():
    drawing = read_svg(ILLUSTRATOR.encode(), "test")
    assert len(drawing.strokes) == 2
    assert drawing.left_out == ()


def test_a_choice_of_languages_is_one_of_them():
    one, other = "<path d='M0 0L3 4' systemLanguage='{}'/>", "<path d='M0 0L6 8'/>"
    for languages, length in (("de, en-GB", 5.0), ("de", 10.0)):
        text = f"<svg viewBox='0 0 9 9'><switch>{one.format(languages)}{other}</switch></svg>"
        (stroke,) = read_svg(text.encode(), "test").strokes
        assert np.linalg.norm(np.ptp(stroke.points, axis=0)) == pytest.approx(length)


def test_names_of_namespaces_cannot_blow_a_file_up():
    head, _, body = ILLUSTRATOR.partition("<switch>")
    many = head + '<g a="&ns_ai;"/>' * 2_000 + "<switch>" + body
    with pytest.raises(FormatError, match="namespaces"):
        read_svg(many.encode(), "test")


@pytest.mark.parametrize(
    "definition",
    [
        '<!ENTITY ns_svg "http://a/&ns_ai;">',
        '<!ENTITY ns_svg SYSTEM "file:///etc/passwd">',
        '<!ENTITY % ns_svg "http://a/">',
        "<!ELEMENT svg ANY>",
    ],
)
def test_whatever_else_a_document_type_defines_is_refused(definition):
    text = ILLUSTRATOR.replace("<!ENTITY ns_svg", f"{definition}<!ENTITY ns_svg", 1)
    with pytest.raises(FormatError, match="document type"):
        read_svg(text.encode(), "test")


def test_a_name_of_a_namespace_is_no_text():
    text = ILLUSTRATOR.replace('<path d="M5', '<title>&ns_ai;</title><path d="M5')
    with pytest.raises(FormatError, match="well-formed"):
        read_svg(text.encode(), "test")


def packed(data, level=9):
    """A gzip stream that is the same at every time of day."""
    return gzip.compress(data, level, mtime=0)


def test_a_compressed_file_is_unpacked(tmp_path):
    plain = b'<svg xmlns="http://www.w3.org/2000/svg"><path d="M1 2L30 4"/></svg>'
    for name in ("a.svgz", "b.svg"):  # as they are called, and as people call them
        (tmp_path / name).write_bytes(packed(plain))
        (line,) = read_drawing(tmp_path / name).strokes
        (other,) = read_svg(plain, "test").strokes
        np.testing.assert_array_equal(line.x, other.x)


@pytest.mark.parametrize(
    ("make", "said"),
    [
        pytest.param(lambda: packed(bytes(65 << 20), 1), "64 MB when it is unpacked", id="large"),
        pytest.param(lambda: packed(b"<svg/>")[:-9], "cut short", id="cut"),
        pytest.param(lambda: packed(packed(b"<svg/>")), "twice", id="twice"),
        pytest.param(
            lambda: packed(b"<svg/>")[:-8] + bytes(8), "damaged", id="a wrong sum of its bytes"
        ),
    ],
)
def test_a_compressed_file_that_is_none_is_refused(make, said):
    with pytest.raises(FormatError, match=said):
        read_svg(make(), "test")


# -- refused --------------------------------------------------------------------------------

HUGE = "<g transform='scale(1e8)'>"

LAUGHS = (
    '<!DOCTYPE svg [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;&a;&a;&a;&a;">'
    '<!ENTITY c "&b;&b;&b;&b;&b;&b;&b;&b;&b;&b;">]><svg>&c;</svg>'
)

DOUBLINGS = (
    "<svg><g id='a0'/>"
    + "".join(f"<g id='a{k + 1}'>" + f"<use href='#a{k}'/>" * 9 + "</g>" for k in range(20))
    + "</svg>"
)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (LAUGHS, "document type"),
        ('<!DOCTYPE svg SYSTEM "x.dtd" []><svg/>', "document type"),
        ("<svg>&unknown;</svg>", "well-formed"),
        ("<svg><g></svg>", "well-formed"),
        ("<html/>", "not an SVG"),
        ("<svg/>", "no lines"),
        ('<svg><path d="M0 0L1 1" transform="spin(3)"/></svg>', "spin"),
        ('<svg><path d="M0 0L1 1" transform="scale(1e99)"/></svg>', "too large"),
        ('<svg><use href="other.svg#a"/></svg>', "another file"),
        ('<svg><g id="a"><use href="#a"/></g></svg>', "nesting"),
        (DOUBLINGS, "repeated elements"),
        ('<svg><rect width="1e30" height="1"/></svg>', "width"),
        ('<svg><polyline points="0 0 1e300 0"/></svg>', "further"),
        (f"<svg>{HUGE * 9}<path d='M0 0L1 1'/>{'</g>' * 9}</svg>", "further"),
        ("<svg>" + "<g>" * 200 + "</g>" * 200 + "</svg>", "nesting"),
        ('<?xml version="1.0" encoding="klingon"?><svg/>', "encoding|well-formed"),
        ("not xml", "well-formed"),
    ],
)  # fmt: skip
def test_what_is_refused_says_why(text, said):
    with pytest.raises(FormatError, match=said):
        read_svg(text.encode(), "test")


# -- writing --------------------------------------------------------------------------------


def test_a_front_view_drawing_comes_back_to_its_place(tmp_path):
    camera = Camera(
        kind="orthographic", eye=(30, -500, 40), target=(30, 0, 40), height=120, viewport=(800, 600)
    )
    rng = np.random.default_rng(1)
    strokes = [
        Stroke(rng.random(50) * 800, rng.random(50) * 600, camera, color=c, group="<&\x01>")
        for c in (None, (1, 2, 3))
    ]
    path = tmp_path / "a.svg"
    write_drawing(Drawing(Strokes(strokes), camera), path)
    back = read_drawing(path)
    for one, other in zip(strokes, back.strokes, strict=True):
        np.testing.assert_allclose(world(one), world(other), atol=1e-4)
    assert back.strokes[1].color == (1, 2, 3)


def test_any_other_view_is_written_in_its_pixels(tmp_path):
    camera = Camera()
    stroke = Stroke([1, 500, 700], [2, 600, 30], camera)
    path = tmp_path / "a.svg"
    write_drawing(Drawing(Strokes([stroke]), camera), path)
    back = read_drawing(path)
    assert back.camera.viewport == camera.viewport
    np.testing.assert_allclose(back.strokes[0].points, stroke.points)


def test_curves_are_written_as_seen(tmp_path):
    # A rational quarter circle in the front plane: every station must lie on it.
    quarter = Curve(
        2,
        [0, 0, 0, 1, 1, 1],
        [[10, 5, 0], [10, 5, 10], [0, 5, 10]],
        [1, 2**-0.5, 1],
        color=(9, 8, 7),
    )
    path = tmp_path / "a.svg"
    export(Shapes(curves=(quarter,)), path)
    (stroke,) = read_drawing(path).strokes
    points = world(stroke)
    np.testing.assert_allclose(np.linalg.norm(points, axis=1), 10, atol=1e-4)
    np.testing.assert_allclose(points[[0, -1]], [[10, 0], [0, -10]], atol=1e-4)
    assert stroke.color == (9, 8, 7)
