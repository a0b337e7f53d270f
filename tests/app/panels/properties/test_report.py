"""Figures: reports in words."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtWidgets import QLabel

from bozzetto.plugin import Figure
from bozzetto_app.panels.properties.report import Figures, readable_key, rows_of
from bozzetto_car.report import FIGURES as CAR
from bozzetto_silhouette.analysis.figures import FIGURES as SILHOUETTE
from bozzetto_symmetry.report import FIGURES as SYMMETRY

YES_IS_GOOD = Figure("Watertight", "Without a gap.", good=True, bad=False)


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("volume_mm3", ("Volume", "mm³")),
        ("outline_deviation_px", ("Outline deviation", "px")),
        ("mean_iou", ("Mean IoU", "")),
        ("largestGap", ("Largest gap", "")),
        ("watertight", ("Watertight", "")),
        ("mm", ("Mm", "")),
        ("worst-angle-deg", ("Worst angle", "°")),
    ],
)
def test_keys_become_words(key, said):
    assert readable_key(key) == said


def test_verdicts_are_marked_and_said(qapp):
    figures = {"watertight": YES_IS_GOOD, "closed": YES_IS_GOOD}
    report = {"watertight": False, "closed": True, "mirrored": False}
    assert [(row.value, row.mark) for row in rows_of(report, figures)] == [
        ("no", "bad"),
        ("yes", "good"),
        ("no", ""),  # nobody said that this is a verdict
    ]


def test_an_expected_value_is_compared(qapp):
    good, bad = (list(rows_of({"genus": g, "expected_genus": 1}, SILHOUETTE)) for g in (1, 2))
    assert [(f.value, f.mark) for f in good] == [("1", "good")]
    assert [(f.value, f.mark) for f in bad] == [("2, expected 1", "bad")]


def test_parts_have_headings(qapp):
    rows = list(rows_of({"parts": [{"name": "Body", "genus": 0}, {"genus": 1}]}, SILHOUETTE))
    assert [(f.key, f.value, f.depth) for f in rows] == [
        ("Body", None, 0),
        ("Holes", "0", 1),
        ("Part 2", None, 0),
        ("Holes", "1", 1),
    ]


def test_usual_figures_are_said_in_a_designers_words(qapp):
    report = {
        "iou": 0.99969,
        "hausdorff": 0.0596,
        "hausdorff_share": 4.2e-4,
        "worst_place": [32.76, -45.07],
        "status": "NoError",
        "volume": 110741.9,
        "area_mm2": 15565.1,
        "genus": 1,
        "expected_genus": 1,
        "asymmetry": -1e-9,
    }
    rows = [(f.key, f.value, f.mark) for f in rows_of({"parts": [report]}, SILHOUETTE)]
    assert rows == [
        ("Match", "99.97\u202f%", "good"),
        ("Largest deviation", "0.06\u00a0mm", ""),
        ("Deviation by size", "0.04\u202f%", "good"),
        ("Worst place", "33, \u221245\u00a0mm", ""),
        ("Solid", "sound", "good"),
        ("Volume", "110.7\u00a0cm³", ""),
        ("Surface", "155.7\u00a0cm²", ""),
        ("Holes", "1", "good"),
        ("Asymmetry", "0.0\u202f%", ""),
    ]


CURVE = {
    "id": "n7", "name": "Rail", "reading": "pair", "margin": 6.345, "degree": 3, "closed": False,
    "knots": [0.0] * 8, "control_points": [[0.0, 1.0, 2.0]] * 4, "points": [[0.0, 0.0, 0.0]],
    "sigma": [0.5, 0.75, 0.75, 3.1, 0.6], "rms": 0.2338, "warnings": ["Mind the end. Draw it."],
}  # fmt: skip


def test_a_curve_is_told_in_figures_and_its_data_are_not(qapp):
    rows = [(f.key, f.value, f.mark) for f in rows_of({"curves": [CURVE], "unit": "mm"}, SYMMETRY)]
    assert rows == [
        ("Rail", None, ""),
        ("Read as", "left and right", ""),
        ("Next reading", "6.3\u00a0×", ""),
        ("Closed", "no", ""),
        ("Off per pixel", "0.75, at most 3.10\u00a0mm", ""),
        ("Off the ink", "0.23\u00a0px", ""),
        ("Mind the end. Draw it.", "", "bad"),
    ]


def test_what_is_warned_of_comes_first(qapp):
    report = {"closed": True, "parts": [{"name": "Lid", "area": 3}], "warnings": ["It folds."]}
    assert next(rows_of(report, {})).key == "It folds."


def test_without_another_reading_there_is_no_figure_for_it(qapp):
    (row,) = rows_of({"margin": 1000.0}, SYMMETRY)
    assert row.value == "none"


def test_of_many_parts_only_the_chosen_one_is_told(qapp):
    report = {"curves": [CURVE | {"id": f"n{k}", "name": f"Curve {k}"} for k in range(1, 4)]}
    told = [list(rows_of(report, SYMMETRY, part=part)) for part in ("n3", "x")]
    names = [[f.key for f in rows if f.value is None] for rows in told]
    assert names == [["Curve 3"], [f"Curve {k}" for k in range(1, 4)]]


def test_parts_beyond_three_are_counted_until_one_is_chosen(qapp):
    report = {"curves": [CURVE | {"id": f"n{k}", "name": f"Curve {k}"} for k in range(60)]}
    chosen = list(rows_of(report, SYMMETRY, part="n4"))
    assert [row.key for row in chosen if row.value is None] == ["Curve 4"]
    (counted,) = rows_of(report, SYMMETRY)
    assert (counted.key, counted.value) == ("Curves", "60")
    assert "Choose one" in counted.tip


def test_of_many_warnings_the_first_are_told_and_the_others_counted(qapp):
    report = {"warnings": [f"Number {k} is wrong." for k in range(40)]}
    told = [row.key for row in rows_of(report, {})]
    assert told[0] == "Number 0 is wrong."
    assert told[-1] == "And 32 more."
    assert len(told) == 9


@pytest.mark.parametrize("strange", [["a", None, "b", 3, 4], [[1.0]], [], [True, False]])
def test_strange_spreads_are_survived(qapp, strange):
    for figure in rows_of({"sigma": strange, "warnings": strange}, SYMMETRY):
        assert isinstance(figure.value, str)


def test_no_row_asks_for_more_room_than_the_panel_has(qtbot):
    figures = Figures()
    qtbot.addWidget(figures)
    figures.show_report(
        {"curves": [CURVE | {"warnings": ["No side has a partner there. " * 4]}]}, SYMMETRY
    )
    assert figures.minimumSizeHint().width() <= 220


def test_what_is_no_number_needs_no_unit(qapp):
    assert [f.value for f in rows_of({"iou": None, "hausdorff": None}, SILHOUETTE)] == ["–", "–"]


def test_a_value_is_marked_where_it_crosses_its_bounds(qapp):
    report = {"iou": 0.97, "hausdorff_share": 0.01, "thinnest_wall": 0.6}
    rows = [(row.value, row.mark) for row in rows_of(report, SILHOUETTE)]
    assert rows == [
        ("97.00\u202f%", "good"),
        ("1.00\u202f%", "bad"),
        ("0.60\u00a0mm", ""),
    ]


def test_a_figure_says_how_a_value_is_written(qapp):
    figures = {
        "gap": Figure("Gap", "Between two sides.", factor=1e-3),
        "kind": Figure("Kind", "What it is.", values={"a": "first"}, verdicts={"b": False}),
        "raw": Figure(""),
        "off": Figure("Off the line", "How far.", "mm", digits=1, spread=True, good=1.0, bad=2.0),
        "box": Figure("Bounding box", "Around all of it."),
    }
    report = {
        "gap_mm": 1500.0, "kind": "a", "raw": 3, "off_mm": [0.5, 1.0, 0.2], "box": {"x_mm": 1},
        "more": {"kind": "b", "off": {"one": 0.0, "two": 7.0}, "raw": {"x": 1}},
    }  # fmt: skip
    rows = [(row.key, row.value, row.mark, row.tip) for row in rows_of(report, figures)]
    assert rows == [
        ("Gap", "1.5\u00a0mm", "", "Between two sides."),
        ("Kind", "first", "", "What it is."),
        ("Off the line", "0.5, at most 1.0\u00a0mm", "good", "How far."),
        ("Bounding box", None, "", "Around all of it."),
        ("X", "1\u00a0mm", "", ""),
        ("More", None, "", ""),
        ("Kind", "b", "bad", "What it is."),
        ("Off the line", "3.5, at most 7.0\u00a0mm", "bad", "How far."),
    ]


plain = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=8), inner, max_size=3)
    ),
    max_leaves=8,
)


@given(st.dictionaries(st.text(min_size=1, max_size=12), plain, max_size=4))
def test_any_report_can_be_shown(report):
    json.dumps(report)
    for figure in rows_of(report, SILHOUETTE | SYMMETRY):
        assert figure.value is None or isinstance(figure.value, str)


def test_a_new_report_replaces_the_old(qtbot):
    figures = Figures()
    qtbot.addWidget(figures)
    figures.show_report({"a": 1, "b": 2}, {})
    figures.show_report({"c": 3}, {})
    shown = [w.text() for w in figures.findChildren(QLabel) if not w.isHidden()]
    assert shown == ["C", "3"]


def test_a_report_of_the_same_kind_keeps_its_rows(qtbot):
    """Reports come with every stroke: making rows anew would stop the window."""
    figures = Figures()
    qtbot.addWidget(figures)
    figures.show_report({"curves": [CURVE]}, SYMMETRY)
    before = [w for w in figures.findChildren(QLabel) if not w.isHidden()]
    figures.show_report({"curves": [CURVE | {"name": "Sill", "rms": 1.5}]}, SYMMETRY)
    after = [w for w in figures.findChildren(QLabel) if not w.isHidden()]
    assert [id(w) for w in after] == [id(w) for w in before]
    assert after[0].text() == "Sill"
    assert "1.50\u00a0px" in [w.text() for w in after]


def test_what_is_told_of_many_places_is_summed_up_or_left_out():
    many = {f"N{k}": float(k) for k in range(39)}
    report = {
        "nodes": {name: [0.0, 1.0, 2.0] for name in many},
        "residual_px": many,
        "leave_one_out_px": {"C1": 1.0, "C2": 7.25},
        "constraints": many,
        "camera": {"kind": "perspective", "eye": [0, 0, 0]},
        "dimensions": {"LN": 4500.2, "WB": 2700.0},
    }
    told = [(figure.key, figure.value) for figure in rows_of(report, CAR)]
    assert told == [
        ("Off the marks", "19.0, at most 38.0\u00a0px"),
        ("Without its say", "4.1, at most 7.2\u00a0px"),
        ("Dimensions", None),
        ("Length", "4\u202f500\u00a0mm"),
        ("Wheelbase", "2\u202f700\u00a0mm"),
    ]
