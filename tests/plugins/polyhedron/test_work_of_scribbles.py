"""How much of a search a scribble gets: counted, so that no answer hangs on time."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_polyhedron.graph import search
from bozzetto_polyhedron.graph.draft import Change, Draft
from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.reconstruction.drawing import drawing_of
from bozzetto_polyhedron.reconstruction.readings import MOST_LIFTED_LOOSE, readings
from tests.plugins.polyhedron.cad_parts import part
from tests.plugins.polyhedron.figures_graph import scribble
from tests.plugins.polyhedron.hand import CONDITIONS, strokes_of
from tests.plugins.polyhedron.objects import view

LONGEST_REPAIR = 10_000
"""Steps that one repair may price: it is not broken off, or it would leave a draft half mended."""


@pytest.fixture
def priced(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Counts the steps that are priced."""
    count = [0]
    price = Draft.price

    def counted(draft: Draft, change: Change) -> float:
        count[0] += 1
        return price(draft, change)

    monkeypatch.setattr(Draft, "price", counted)
    return count


@pytest.mark.slow
@pytest.mark.parametrize("seed", [18, 100, 104])
def test_a_scribble_gets_no_more_work_than_it_may(seed: int, priced: list[int]) -> None:
    """Without the bound these took 55,000, 58,000 and 43,000."""
    graph = searched(scribble(seed)).graph
    assert np.isfinite(graph.places).all()
    assert priced[0] < search.MOST_PRICED + LONGEST_REPAIR


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1045, 1195])
def test_of_a_scribble_no_more_is_lifted_than_may_be(seed: int) -> None:
    """Without the bound these took eight and ten."""
    drawing = drawing_of(searched(scribble(seed)).graph)
    asked: list[float] = []
    found = readings(drawing, lambda share, step: asked.append(share))
    assert len(asked) <= MOST_LIFTED_LOOSE
    assert found
    assert all(np.isfinite(each.depths).all() for each in found)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "condition"),
    [
        ("clevis", "and every corner overshot"),
        ("t slot", "and a third dashed"),
        ("v block with slot", "and two ticks"),
    ],
)
def test_an_untidy_drawing_of_a_solid_is_found_as_without_the_bound(
    name: str, condition: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    solid = part(name, 310)
    assert solid is not None
    seen = view(solid, 310)
    assert seen is not None
    edges = [(int(a), int(b)) for a, b in solid.edges]
    strokes = strokes_of(seen.plane, edges, CONDITIONS[condition], 310)
    bounded = searched(strokes).graph
    monkeypatch.setattr(search, "MOST_PRICED", 10**9)
    free = searched(strokes).graph
    assert np.array_equal(bounded.places, free.places)
    assert np.array_equal(bounded.lines, free.lines)
    assert bounded.health == free.health
