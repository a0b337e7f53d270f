"""Pieces of curves between joints that meet in their own way: in files, by touch, kept by edits."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from bozzetto.errors import UserError
from bozzetto.geometry import Spline
from bozzetto.plugin import Context, Job, Tap
from bozzetto.scene import Lines
from bozzetto.view import Camera
from bozzetto_product.hand_over.imported import product_of_network
from bozzetto_product.model.curve_stretch import crease_over, stretches_within, with_stretch
from bozzetto_product.model.curves import Curve, Stretch
from bozzetto_product.model.state import ProductState
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.operations.pieces import join_curves, split_curve, turn_curve
from bozzetto_product.report import report_of
from bozzetto_product.solve.solver import net_of_state, solve_product
from bozzetto_product.tools.crease import SwitchCrease
from tests.sizes import sized

VIEW = Camera(eye=(40.0, -160.0, 220.0), target=(0.0, 0.0, 5.0))


def dome(x: np.ndarray, y: np.ndarray) -> list[list[float]]:
    rows = np.column_stack(np.broadcast_arrays(x, y, 20.0 - (x * x + 0.6 * y * y) / 90.0))
    return rows.tolist()


def facts(**network: Any) -> dict[str, Any]:
    """A sheet of four surfaces: three curves each way; m and n cross in the middle."""
    way = np.linspace(-30.0, 30.0, 25)
    curves = [{"name": f"x{k}", "points": dome(way, np.full(25, y))}
              for k, y in enumerate((-30.0, 30.0))]  # fmt: skip
    curves += [{"name": f"y{k}", "points": dome(np.full(25, x), way)}
               for k, x in enumerate((-30.0, 30.0))]  # fmt: skip
    curves += [{"name": "m", "points": dome(way, np.zeros(25))}]
    curves += [{"name": "n", "points": dome(np.zeros(25), way)}]
    return {"network": {"curves": curves, **network}, "unit": "mm"}


def edges_of(state: ProductState) -> dict[str, tuple[float | None, bool]]:
    told = report_of(state, solve_product(state, Job()), Job())
    return {edge["curve"]: (edge["crease"], edge["smooth"]) for edge in told["edges"]}


def test_a_piece_in_a_file_is_a_crease_and_the_rest_is_not() -> None:
    assert edges_of(product_of_network(facts())) == dict.fromkeys(
        ("m/1", "m/2", "n/1", "n/2"), (None, True)
    )
    state = product_of_network(facts(creases={"m/1": 1, "n/2": 0.5}))
    assert edges_of(state) == {
        "m/1": (1.0, False), "m/2": (None, True), "n/1": (None, True), "n/2": (0.5, True),
    }  # fmt: skip


def test_a_piece_goes_before_its_curve() -> None:
    state = product_of_network(facts(creases={"m": 1, "m/2": 0}))
    edges = edges_of(state)
    assert edges["m/1"] == (1.0, False)
    assert edges["m/2"] == (0.0, True)


@pytest.mark.parametrize("name", ["m/3", "m/0", "x0/9", "m/x", "m/1/1"])
def test_a_piece_that_is_not_there_is_refused(name: str) -> None:
    with pytest.raises(UserError, match="names a piece"):
        product_of_network(facts(creases={name: 1}))


def _tap(state: ProductState, x: float, y: float, **more: Any) -> ProductState:
    scene = ProductModeler().scene(state, solve_product(state, Job()))
    place = dome(np.array([x]), np.array([y]))
    pixel = VIEW.project(np.array(place))[0][0]
    tap = Tap(*map(float, pixel), VIEW, **more)
    context = Context(camera=VIEW, scene=scene)
    assert SwitchCrease().preview(state, tap, context).layers
    return SwitchCrease().tap(state, tap, context)


def test_a_touch_switches_the_piece_under_the_pen_and_no_other() -> None:
    start = product_of_network(facts())
    once = _tap(start, -15.0, 0.0)
    assert {name for name, (crease, _) in edges_of(once).items() if crease == 1.0} == {"m/1"}
    scene = ProductModeler().scene(once, solve_product(once, Job()))
    shown = [layer for layer in scene.layers if layer.tool == "crease"]
    assert [item.color for layer in shown for item in layer.items if isinstance(item, Lines)] == [
        "accent"
    ]
    twice = _tap(once, -15.0, 0.0)
    assert edges_of(twice)["m/1"] == (0.0, True)
    back = _tap(twice, -15.0, 0.0, shift=True)
    assert all(curve.stretches == () for curve in back.of_kind(Curve))
    other = _tap(once, 0.0, 14.0)
    creased = {name for name, (crease, _) in edges_of(other).items() if crease == 1.0}
    assert creased == {"m/1", "n/2"}


@pytest.mark.parametrize("strength", [0.0, 0.3, 1.0])
def test_a_touch_gives_the_strength_that_is_set_and_the_next_one_takes_it(strength: float) -> None:
    state = replace(product_of_network(facts()), strength=strength)
    done = _tap(state, -15.0, 0.0)
    told = edges_of(done)
    assert told["m/1"] == (strength, strength < 1.0)
    assert {told[name] for name in ("m/2", "n/1", "n/2")} == {(None, True)}
    assert edges_of(_tap(done, -15.0, 0.0))["m/1"] == (0.0, True)


def test_nothing_under_the_pen_is_told() -> None:
    state = product_of_network(facts())
    with pytest.raises(UserError, match="no edge"):
        SwitchCrease().tap(state, Tap(2.0, 2.0, VIEW), Context(camera=VIEW))


def test_a_chosen_way_of_the_whole_curve_counts_for_all_pieces() -> None:
    state = _tap(product_of_network(facts()), -15.0, 0.0)
    commands = {command.id: command for command in ProductModeler().commands()}
    made = commands["edge-smooth"].run(state, Context())
    assert edges_of(made)["m/1"] == edges_of(made)["m/2"] == (0.0, True)


def _creases(state: ProductState, names: str = "mn") -> list[float]:
    """Creases of the edges of some curves and what became of them, by where they are."""
    net = net_of_state(state)
    known = {curve.id: curve.name for curve in state.of_kind(Curve)}
    rows = [
        (*np.round(np.sort(edge.spline.control_points[[0, -1]], axis=0).ravel(), 6), edge.crease)
        for edge in net.edges
        if known[edge.curve].partition(" ")[0] in names
    ]
    return [row[-1] for row in sorted(rows)]


def test_splitting_turning_and_joining_keep_what_was_chosen() -> None:
    state = product_of_network(facts(creases={"m/1": 1, "m/2": 0.25, "n/2": 0}))
    before = _creases(state)
    m = next(curve.id for curve in state.of_kind(Curve) if curve.name == "m")
    assert np.array_equal(_creases(turn_curve(state, m)), before, equal_nan=True)
    places = {meet.at for joint in state.joints for meet in joint.meetings if meet.curve == m}
    apart, names = split_curve(state, m, [at for at in places if 0.1 < at < 0.9])
    assert np.array_equal(_creases(apart), before, equal_nan=True)
    again = join_curves(apart, names[0], 1.0, names[1], 0.0)
    assert np.array_equal(_creases(again), before, equal_nan=True)
    early, _ = split_curve(state, m, [0.2])
    firsts = {edge.crease for edge in net_of_state(early).edges if edge.span[1] < 0.9}
    assert 1.0 in firsts


BARE = Curve("c", spline=Spline.uniform(np.linspace((0.0, 0.0, 0.0), (9.0, 0.0, 0.0), 7)))
CELLS = 24
PIECE = st.tuples(st.integers(0, CELLS - 1), st.integers(1, CELLS), st.sampled_from([None, 0, 1]))


def _painted(pieces: list[tuple[int, int, int | None]], closed: bool) -> tuple[Curve, list[float]]:
    """Return a curve of which pieces were chosen one after the other, and each cell's crease."""
    curve, cells = BARE, [np.nan] * CELLS
    for first, count, kind in pieces:
        last = first + count if closed else min(first + count, CELLS)
        chosen = None if kind is None else Stretch(0.0, 1.0, "crease" if kind else "smooth")
        curve = with_stretch(curve, first / CELLS, last / CELLS, chosen)
        for cell in range(first, last):
            cells[cell % CELLS] = np.nan if kind is None else float(kind)
    return curve, cells


def _cells(curve: Curve, count: int = CELLS) -> list[float]:
    return [crease_over(curve, k / count, (k + 1) / count) for k in range(count)]


@given(st.lists(PIECE, max_size=6), st.booleans())
@settings(max_examples=sized(100, 1000), deadline=None)
def test_the_last_choice_counts_everywhere(
    pieces: list[tuple[int, int, int | None]], closed: bool
) -> None:
    curve, cells = _painted(pieces, closed)
    assert np.array_equal(_cells(curve), cells, equal_nan=True)


@given(st.lists(PIECE, max_size=5), st.integers(0, CELLS - 1), st.integers(1, CELLS), st.booleans())
@settings(max_examples=sized(100, 1000), deadline=None)
def test_a_part_has_the_choices_of_its_whole(
    pieces: list[tuple[int, int, int | None]], first: int, count: int, backwards: bool
) -> None:
    curve, cells = _painted(pieces, closed=True)
    onto = (1.0, 0.0) if backwards else (0.0, 1.0)
    low, high = first / CELLS, (first + count) / CELLS
    part = Curve("p", stretches=stretches_within(curve.stretches, low, high, onto))
    wanted = [cells[k % CELLS] for k in range(first, first + count)]
    assert np.array_equal(
        _cells(part, count), wanted[::-1] if backwards else wanted, equal_nan=True
    )
