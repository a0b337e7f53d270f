"""Figures: reports in words."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st
from PySide6.QtWidgets import QLabel

from bozzetto_app.panels.figures import Figures, figures_of, readable_key


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
    rows = {f.key: f for f in figures_of({"watertight": False, "closed": True, "mirrored": False})}
    assert (rows["Watertight"].value, rows["Watertight"].mark) == ("no", "bad")
    assert (rows["Closed"].value, rows["Closed"].mark) == ("yes", "good")
    assert rows["Mirrored"].mark == "", "that is no verdict"


def test_an_expected_value_is_compared(qapp):
    good, bad = (list(figures_of({"genus": g, "expected_genus": 1})) for g in (1, 2))
    assert [(f.value, f.mark) for f in good] == [("1", "good")]
    assert [(f.value, f.mark) for f in bad] == [("2, expected 1", "bad")]


def test_parts_have_headings(qapp):
    rows = list(figures_of({"parts": [{"name": "Body", "genus": 0}, {"genus": 1}]}))
    assert [(f.key, f.value, f.depth) for f in rows] == [
        ("Body", None, 0),
        ("Genus", "0", 1),
        ("Part 2", None, 0),
        ("Genus", "1", 1),
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
    for figure in figures_of(report):
        assert figure.value is None or isinstance(figure.value, str)


def test_a_new_report_replaces_the_old(qtbot):
    figures = Figures()
    qtbot.addWidget(figures)
    figures.show_report({"a": 1, "b": 2})
    figures.show_report({"c": 3})
    shown = [w.text() for w in figures.findChildren(QLabel) if not w.isHidden()]
    assert shown == ["C", "3"]
