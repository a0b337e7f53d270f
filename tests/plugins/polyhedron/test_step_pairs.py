"""Steps that cost something at first, lines of solids, and pressure where most ink is light."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest

from bozzetto.ink import Stroke
from bozzetto_polyhedron.graph import search, steps
from bozzetto_polyhedron.graph.live import searched
from bozzetto_polyhedron.graph.planar_embedding import is_whole, neighbors_of
from bozzetto_polyhedron.graph.segments import Segments
from bozzetto_polyhedron.graph.step_pairs import with_detours
from tests.plugins.polyhedron.cad_parts import part
from tests.plugins.polyhedron.graph_truth import is_right
from tests.plugins.polyhedron.hand import SIZE, Hand, strokes_of
from tests.plugins.polyhedron.machine_parts import machine_part
from tests.plugins.polyhedron.objects import OBJECTS, TO_CANVAS, Polyhedron, made, view
from tests.plugins.polyhedron.untidy_parts import untidy
from tests.plugins.polyhedron.workshop_parts import workshop_part


@pytest.mark.slow
def test_two_steps_find_what_one_after_the_other_does_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two steps are as good as one that does both, which is taken away here."""
    monkeypatch.setattr(steps, "overlapping", lambda around, key: iter(()))
    monkeypatch.setattr(steps, "on_another_line", lambda around, corner: iter(()))
    strokes, places, edges = untidy(workshop_part("octagonal shaft with collar", 80_001), 80_001)
    assert is_right(searched(strokes).graph, places, edges)
    monkeypatch.setattr(search, "with_detours", lambda draft, checkpoint, most: (draft, 0))
    assert not is_right(searched(strokes).graph, places, edges)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["gusset", "house with porch", "drawer"])
def test_a_detour_never_leads_to_more_doubt_and_leaves_the_draft_as_it_is(name: str) -> None:
    strokes, _, _ = untidy(workshop_part(name, 80_001), 80_001)
    draft = searched(strokes).draft
    assert draft is not None
    before, cost = dict(draft.lines), draft.cost
    assert with_detours(draft, lambda: None, 20_000)[0].doubt <= draft.doubt
    assert draft.lines == before
    assert draft.cost == cost


@pytest.mark.slow
def test_detours_begin_at_other_drafts_than_the_likeliest(monkeypatch: pytest.MonkeyPatch) -> None:
    strokes, places, edges = clean(machine_part("boss with hole", 406), 406)
    assert is_right(searched(strokes).graph, places, edges)
    monkeypatch.setattr(search, "NOT_WHOLE", 1e-9)
    assert not is_right(searched(strokes).graph, places, edges)


@pytest.mark.slow
def test_starts_that_are_mended_join_other_ends_and_other_segments() -> None:
    """Four starts of the likeliest lines in other spreads were mended to the same before."""
    strokes, places, edges = clean(made(61_108), 61_108)
    assert is_right(searched(strokes).graph, places, edges)


@pytest.mark.slow
def test_lines_of_solids_stay_where_steps_would_lead_to_lines_of_none() -> None:
    strokes, places, edges = clean(part("channel with hole", 61_001), 61_001)
    draft = searched(strokes).draft
    assert draft is not None
    assert draft.is_whole
    assert is_right(searched(strokes).graph, places, edges)


def clean(
    solid: Polyhedron | None, seed: int
) -> tuple[tuple[Stroke, ...], np.ndarray, list[tuple[int, int]]]:
    """Draw a solid with 1 % of jitter, hidden lines lightly: its strokes, corners and edges."""
    seen = None if solid is None else view(solid, seed)
    assert seen is not None
    edges = [(int(a), int(b)) for a, b in seen.solid.edges]
    hidden = np.flatnonzero(seen.hidden > 0.5).tolist()
    strokes = strokes_of(seen.plane * TO_CANVAS, edges, Hand(jitter=0.01), seed, hidden)
    return strokes, seen.plane * TO_CANVAS * SIZE + 200.0, edges


@pytest.mark.slow
def test_a_drawing_most_of_whose_ink_is_light_has_hidden_lines() -> None:
    strokes, places, edges = untidy(workshop_part("cupboard", 80_000), 80_000)
    graph = searched(strokes).graph
    assert is_right(graph, places, edges)
    assert 0.5 < (graph.light > 0.5).mean() < 0.9


def of_pressure(pressure: np.ndarray, lengths: np.ndarray) -> Segments:
    ends = np.zeros((len(lengths), 2, 2))
    ends[:, 1, 0] = lengths
    return Segments(ends, pressure, np.arange(len(lengths)), np.zeros(len(lengths)))


@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_of_two_pressures_the_lower_one_is_light_however_much_of_it_there_is(share: float) -> None:
    rng = np.random.default_rng(5)
    light = np.arange(60) < 60 * share
    pressure = np.where(light, 0.35, 0.8) * rng.normal(1.0, 0.06, 60)
    assert (of_pressure(pressure, rng.uniform(0.1, 0.4, 60)).light == light).all()


def test_one_pressure_that_varies_has_no_light_ones() -> None:
    rng = np.random.default_rng(6)
    for seed in range(20):
        pressure = 0.7 + 0.1 * rng.uniform(-1.0, 1.0, 40)
        assert not of_pressure(pressure, rng.uniform(0.1, 0.4, 40)).light.any(), seed
    assert not of_pressure(np.full(7, 0.5), np.ones(7)).light.any()
    assert not of_pressure(np.array([0.5]), np.ones(1)).light.any()
    assert not len(of_pressure(np.zeros(0), np.zeros(0)).light)


def test_lines_of_solids_are_planar_and_hang_together_at_three_corners() -> None:
    for solid in OBJECTS.values():
        lines = [(int(a), int(b)) for a, b in solid.edges]
        whole = neighbors_of(lines)
        assert is_whole(whole) == all(
            not _parts_without(whole, pair) for pair in combinations(sorted(whole), 2)
        )
        assert not is_whole(neighbors_of(lines[1:]))
    bipartite = [(a, 3 + b) for a in range(3) for b in range(3)]
    assert not is_whole(neighbors_of(bipartite))


def _parts_without(neighbors: dict[int, set[int]], pair: tuple[int, ...]) -> bool:
    """Whether a part of a graph falls apart without two corners of it: tried one by one."""
    left = set(neighbors) - set(pair)
    seen: set[int] = set()
    groups = []
    for start in sorted(left):
        if start in seen:
            continue
        group, waiting = {start}, [start]
        while waiting:
            for other in neighbors[waiting.pop()] & left - group:
                group.add(other)
                waiting.append(other)
        seen |= group
        groups.append(group)
    beside = [sum(bool(neighbors[corner] & group) for group in groups) for corner in pair]
    return min(beside) > 1
