"""Guessed hidden edges: how likely they are said to be, and that parts in faces are completed."""

from __future__ import annotations

import ast
from dataclasses import replace

import numpy as np
import pytest

import bozzetto_polyhedron.reconstruction.guess_numbers as written
from bozzetto.ink import Strokes
from bozzetto.plugin import Context
from bozzetto_polyhedron.commands.hidden_edges import draw_hidden_edges
from bozzetto_polyhedron.graph.planar_embedding import components, neighbors_of
from bozzetto_polyhedron.model.assign_stroke import new_body
from bozzetto_polyhedron.model.state import Body, Choice, PolyhedronState
from bozzetto_polyhedron.reconstruction.guess_certainty import certainty_of_guess
from bozzetto_polyhedron.reconstruction.hidden_lines import hidden_lines
from bozzetto_polyhedron.reconstruction.ranking import SURE
from bozzetto_polyhedron.report import cautions_of
from bozzetto_polyhedron.solve.pipeline import answers_of_ink, never, solved
from tests.plugins.polyhedron.figures_hidden_lines import visible_lines
from tests.plugins.polyhedron.fit_guesses import Fit, Guess, fitted, text_of, told
from tests.plugins.polyhedron.hand import Hand, strokes_of
from tests.plugins.polyhedron.objects import CAMERA, OBJECTS, Polyhedron, box, polyhedron_of, view
from tests.plugins.polyhedron.test_hidden_edges import guessed_pairs, seen_graph

STEADY = Hand(jitter=0.002, wobble=0.0, tremble=0.0)


def completed_state(certainty: float | None = None) -> PolyhedronState:
    """A box of which visible edges are drawn, its hidden ones guessed, turned into a solid."""
    seen = view(OBJECTS["box"], 3)
    assert seen is not None
    strokes = strokes_of(*visible_lines(seen), STEADY, 3)
    state = draw_hidden_edges(new_body(PolyhedronState(), strokes), Context())
    (body,) = state.of_kind(Body)
    if certainty is not None:
        body = replace(body, guess_certainty=certainty)
    return state.with_node(replace(body, choice=Choice()))


def confidence_of(state: PolyhedronState) -> float:
    (body,) = state.of_kind(Body)
    answer = solved(body, state).answer
    assert answer is not None
    return answer.confidence


def test_answers_are_as_much_less_likely_as_the_guess() -> None:
    (body,) = completed_state().of_kind(Body)
    alone = answers_of_ink(body.strokes, body.evidence, body.hidden, never)[0].confidence
    assert 0.0 < body.guess_certainty < 1.0
    assert confidence_of(completed_state()) == pytest.approx(body.guess_certainty * alone)
    assert confidence_of(completed_state(0.25)) == pytest.approx(0.25 * alone)


@pytest.mark.parametrize(("certainty", "words"), [(0.9, "did not mean"), (0.2, "next guess")])
def test_what_was_guessed_is_told_and_in_doubt_it_is_asked(certainty: float, words: str) -> None:
    state = completed_state(certainty)
    (body,) = state.of_kind(Body)
    told_here = [each.message for each in cautions_of(state, {body.id: solved(body, state)})]
    assert any("3 edges are guessed" in each and words in each for each in told_here)


def test_edges_that_a_person_changed_are_no_guess_any_more() -> None:
    state = completed_state(0.25)
    (body,) = state.of_kind(Body)
    changed = state.with_node(replace(body, strokes=Strokes(tuple(body.strokes)[::-1])))
    assert confidence_of(changed) > 2.0 * confidence_of(state)


def test_limits_of_traits_hold_and_odds_add_up() -> None:
    low, high, weights = np.array(list(written.TRAITS.values())).T
    assert (low <= high).all()
    middle = 0.5 * (low + high)
    for k in range(len(low)):
        beyond, at_limit = middle.copy(), middle.copy()
        beyond[k], at_limit[k] = high[k] + 10.0, high[k]
        assert certainty_of_guess(beyond) == certainty_of_guess(at_limit)
        rises = certainty_of_guess(at_limit) - certainty_of_guess(middle)
        assert np.sign(rises) == np.sign(weights[k] * (high[k] - middle[k]))


def made_up(count: int, seed: int) -> list[Guess]:
    """Guesses of which the second trait tells how often they are right, and answers the rest."""
    rng = np.random.default_rng(seed)
    traits = rng.normal(size=(count, len(written.TRAITS)))
    said = rng.uniform(0.5, 1.0, count)
    right = rng.random(count) < said / (1.0 + np.exp(-2.0 * traits[:, 1]))
    return [
        Guess(k, 0, *each) for k, each in enumerate(zip(traits, said, right.tolist(), strict=True))
    ]


def test_what_is_written_says_what_the_fit_says() -> None:
    every = made_up(200, 4)
    fit = fitted(every)
    odds, traits = (
        ast.literal_eval(each.value)
        for each in ast.parse(text_of(fit)).body
        if isinstance(each, ast.AnnAssign) and each.value is not None
    )
    kept = Fit(odds, np.array(list(traits.values())))
    assert np.allclose(
        [told(kept, each) for each in every], [told(fit, each) for each in every], atol=2e-3
    )


def test_a_fit_finds_the_trait_that_tells_and_how_often_guesses_are_right() -> None:
    fit = fitted(made_up(1500, 5))
    weights = np.abs(fit.traits[:, 2])
    assert weights.argmax() == 1
    others = made_up(1500, 6)
    said = np.array([told(fit, each) for each in others])
    right = np.array([each.right for each in others])
    for low, high in ((0.0, 0.3), (0.3, 0.6), (0.6, 1.0)):
        here = (said >= low) & (said < high)
        assert abs(said[here].mean() - right[here].mean()) < 0.06


def plate_with(kind: str) -> Polyhedron:
    """An angle with a hole through its wall, and blocks with a pocket and a boss on top."""
    angle = box((3.0, 0.6, 2.4)) + box((0.6, 2.6, 2.4))
    block = box((3.0, 2.6, 1.4))
    solids = {
        "hole in a side": angle - box((0.9, 2.0, 0.9), (1.3, -0.7, 0.8)),
        "pocket": block - box((1.6, 1.4, 2.0), (0.7, 0.6, 0.9)),
        "boss": block + box((1.0, 0.9, 0.9), (1.0, 0.8, 1.4)),
    }
    found = polyhedron_of(solids[kind], kind, 0.03)
    assert found is not None
    return found


@pytest.mark.parametrize(
    ("kind", "least"), [("hole in a side", 0.9), ("pocket", 0.9), ("boss", 0.7)]
)
def test_parts_in_faces_that_are_no_ends_of_a_prism_are_completed(kind: str, least: float) -> None:
    """Seen from sides that show six lines of them; of pockets one in five was completed before."""
    solid = plate_with(kind)
    parts = components(neighbors_of(solid.edges))
    part = min(parts, key=lambda each: float(np.ptp(solid.vertices[list(each)], axis=0).sum()))
    own = np.isin(solid.edges[:, 0], part)
    outcomes = []
    for seed in range(200, 222):
        shown = view(solid, seed)
        if shown is None or (shown.hidden[own] < 1.0).sum() < 6:
            continue
        seen, graph = seen_graph(solid, seed)
        hidden = {
            tuple(sorted(pair))
            for pair, share in zip(solid.edges.tolist(), seen.hidden, strict=True)
            if share == 1.0
        }
        edges = {tuple(sorted(pair)) for pair in solid.edges.tolist()}
        found = guessed_pairs(seen, graph)
        outcomes.append(any(each is not None and hidden <= each <= edges for each in found))
    assert len(outcomes) >= 8
    assert np.mean(outcomes) >= least


def test_certainty_of_a_guess_does_not_hang_on_the_order_of_lines() -> None:
    _, graph = seen_graph(OBJECTS["stairs"], 2)
    order = np.random.default_rng(1).permutation(len(graph.lines))
    other = replace(graph, lines=graph.lines[order], light=graph.light[order])
    first, again = (hidden_lines(each, CAMERA)[0] for each in (graph, other))
    assert first.certainty == pytest.approx(again.certainty, abs=1e-9)
    assert first.certainty > SURE
