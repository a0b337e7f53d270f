"""Details on a surface that gets another number of sides stay where they were drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.testing import same
from bozzetto_product.model.details import Detail
from bozzetto_product.model.state import ProductState
from bozzetto_product.operations.fillet import fillet
from bozzetto_product.operations.meetings import meeting_place, splines_of
from tests.plugins.product.detail_kit import RADIUS, ball, grounds, loop_around, solved, with_detail

MIDDLE = RADIUS / np.sqrt(3.0)


def rounded(state: ProductState) -> ProductState:
    """The ball, its first octant rounded at the corner on the x axis: that has four sides then."""
    splines = splines_of(state)
    corner = next(
        joint
        for joint in state.joints
        if meeting_place(splines, joint.meetings[0], state.symmetry)[0] > 0.99 * RADIUS
    )
    beside = [
        meet.curve
        for meet in corner.meetings
        if (splines[meet.curve].sampled(9) > -1e-6 * RADIUS).all()
    ]
    assert len(beside) == 2
    return fillet(state, corner.id, *beside, 6.0)[0]


@pytest.mark.parametrize("kind", ["in", "cut"])
def test_a_detail_stays_where_it_is_when_a_corner_of_its_surface_is_rounded(kind: str) -> None:
    row = loop_around(ball(), (MIDDLE, MIDDLE, MIDDLE), 6.0)
    state = with_detail(ball(), [row], kind=kind, depth=1.0)
    after = rounded(state)
    sides = [len(one.fill.patches) for one in (grounds(ball())[0], *grounds(rounded(ball())))]
    assert len(set(sides)) > 1, "the corner changed no surface"
    (one,) = solved(after).detailed.details
    assert one.problem == ""
    (outline,) = one.outlines
    away = np.linalg.norm(outline[:, None] - row[None], axis=2).min(axis=1)
    assert away.max() < 0.5


def test_places_of_documents_before_are_read_as_they_were() -> None:
    """They do not tell the number of pieces; on an unchanged surface that makes no difference."""
    row = loop_around(ball(), (MIDDLE, MIDDLE, MIDDLE), 6.0)
    state = with_detail(ball(), [row], kind="in", depth=1.0)
    (detail,) = state.of_kind(Detail)
    assert detail.places is not None
    assert len(detail.places.pieces) == len(detail.places.patches)
    old = replace(detail, places=replace(detail.places, pieces=()))
    one, other = (
        solved(state.with_node(each)).detailed.details[0].outlines for each in (detail, old)
    )
    assert same(one, other)
