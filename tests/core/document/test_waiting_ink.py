"""Ink that waits, as a value."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.document.waiting_ink import WaitingStroke, marked, strokes_of, touched, without
from bozzetto.ink.checked_points import seen_through
from bozzetto.ink.stroke import Stroke
from bozzetto.view.camera import Camera
from bozzetto.view.navigation import zoom
from tests.document_kit import stroke, waiting_ink

CAMERA = Camera()


def line(*points, camera=CAMERA):
    x, y = zip(*points, strict=True)
    return Stroke(x, y, camera)


def test_what_is_taken_is_told_by_identity_and_order_is_kept():
    twins = tuple(WaitingStroke(stroke(7)) for _ in range(3))
    assert twins[0].stroke == twins[1].stroke
    assert without(twins, [twins[1].stroke]) == (twins[0], twins[2])
    assert without(twins, [stroke(7)]) is twins
    assert without(twins, strokes_of(twins)) == ()


def test_a_mark_is_made_on_some_strokes_and_its_places_belong_to_the_last():
    ink = waiting_ink()
    meant = strokes_of(ink[:2])
    after = marked(
        ink, meant, "refused", modeler="m", tool="t", reason="No.", places=[(1, 2), (np.inf, 0)]
    )
    assert after[2:] == ink[2:]
    assert [one.status for one in after[:2]] == ["refused", "refused"]
    assert [one.places for one in after[:2]] == [(), ((1, 2),)]
    assert all(one.is_for("m", "t") and one.is_for("m", "") for one in after[:2])
    assert not after[0].is_for("m", "other")
    assert not after[0].is_for("other", "t")


def test_a_stroke_of_an_unknown_tool_is_for_any():
    assert WaitingStroke(stroke(1), "m").is_for("m", "whichever")


@pytest.mark.parametrize("wrong", [{"status": "lost"}, {"places": ((0.0, np.nan),)}])
def test_nonsense_is_refused(wrong):
    with pytest.raises(ValueError, match="waiting ink"):
        WaitingStroke(stroke(1), **wrong)


@pytest.mark.parametrize(("gap", "meets"), [(17.0, True), (19.0, False)])
def test_an_eraser_meets_lines_within_its_reach_however_few_samples_they_have(gap, meets):
    ink = (WaitingStroke(line((0, 400), (1000, 400))),)
    beside = line((500, 100), (500, 400 - gap))
    across = line((500, 100), (500, 700))
    along = line((100, 400 - gap), (900, 400 - gap))
    assert bool(touched(ink, beside, 18.0)) == meets
    assert bool(touched(ink, along, 18.0)) == meets
    assert touched(ink, across, 18.0) == strokes_of(ink)


def test_an_eraser_meets_ink_where_it_is_seen_now():
    drawn = WaitingStroke(line((600, 400), (640, 400)))
    closer = zoom(CAMERA, 3.0)
    seen = seen_through(drawn.stroke.points, CAMERA, closer)
    assert np.ptp(seen[:, 0]) > 100
    (x, y), _ = seen
    assert touched((drawn,), line((x, y - 30), (x, y + 30), camera=closer), 18.0)
    assert not touched((drawn,), line((600, 370), (600, 430), camera=closer), 18.0)
