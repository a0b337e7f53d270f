"""Templates between two others: sound, smooth and symmetric, wherever between them."""

from __future__ import annotations

from itertools import permutations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry.patches import coons_nets, crease_angles
from bozzetto.plugin import Context
from bozzetto_car.body.build import body_of
from bozzetto_car.commands import all_commands
from bozzetto_car.modeler import Car
from bozzetto_car.solver.pipeline import blend_problem, template_of
from bozzetto_car.state import CarState
from bozzetto_car.template.blend import blended, can_blend
from bozzetto_car.template.loader import TEMPLATES, bundled, read_template
from bozzetto_car.template.model import MIRROR
from bozzetto_car.template.network import Network
from bozzetto_car.template.shape_constraints import Soundness
from tests.plugins.car.test_template_surface import VISIBLE_BREAK, smooth_across

PAIRS = [
    pair for pair in permutations(TEMPLATES, 2) if can_blend(bundled(pair[0]), bundled(pair[1]))
]


def test_those_of_one_network_can_be_blended() -> None:
    booted = {"sedan", "coupe", "limousine", "pickup"}
    assert {frozenset(pair) for pair in PAIRS} == {
        frozenset(pair)
        for group in (booted, set(TEMPLATES) - booted)
        for pair in permutations(group, 2)
    }


@pytest.mark.parametrize("pair", PAIRS, ids="-".join)
def test_what_is_between_is_sound_smooth_and_symmetric(pair: tuple[str, str]) -> None:
    first, second = map(bundled, pair)
    rng = np.random.default_rng(PAIRS.index(pair))
    for share in (*rng.uniform(0.0, 1.0, 3), 1.0):
        between = blended(first, second, share)
        assert min(Soundness.of(between).least(between.variables).values()) > 0.0
        creases = crease_angles(
            coons_nets(between.control_points, between.sides), between.sides, len(between.edges)
        )
        assert creases[smooth_across(between)].max() < VISIBLE_BREAK
        images = between.mirrored_edges
        forth = images >= 0
        own = between.tangents[forth] * MIRROR
        assert (between.tangents[images[forth]] == own).all()
        assert (between.positions[between.mirrored] * MIRROR == between.positions).all()


def test_the_ends_are_the_templates() -> None:
    sedan, coupe = bundled("sedan"), bundled("coupe")
    assert blended(sedan, coupe, 0.0) is sedan
    whole = blended(sedan, coupe, 1.0)
    assert (whole.positions == coupe.positions).all()
    np.testing.assert_allclose(whole.tangents, coupe.tangents, atol=1e-9)


def test_half_way_is_the_same_from_both_ends() -> None:
    one, other = (blended(bundled(a), bundled(b), 0.5) for a, b in (("suv", "van"), ("van", "suv")))
    np.testing.assert_allclose(one.positions, other.positions, atol=1e-9)
    np.testing.assert_allclose(one.tangents, other.tangents, atol=1e-9)


def test_other_networks_are_refused() -> None:
    with pytest.raises(ValueError, match="different networks"):
        blended(bundled("sedan"), bundled("suv"), 0.5)


# -- in a car --------------------------------------------------------------------------------------


def test_the_slider_leads_from_one_car_to_the_other() -> None:
    lengths = [
        body_of(CarState(template="city_car", blend="suv", share=share)).dimensions.length or 0.0
        for share in (0.0, 0.25, 0.5, 0.75, 1.0)
    ]
    assert lengths[0] == pytest.approx(
        body_of(CarState(template="city_car")).dimensions.length, abs=1e-9
    )
    assert lengths[-1] == pytest.approx(
        body_of(CarState(template="suv")).dimensions.length, abs=1e-6
    )
    assert lengths == sorted(lengths)
    assert len(set(lengths)) == 5


def test_the_same_blend_is_the_same_template() -> None:
    """Or nothing that depends on it would be remembered."""
    states = [CarState(blend="coupe", share=0.3, trace=trace) for trace in (0.2, 0.8)]
    assert template_of(states[0]) is template_of(states[1])


def test_what_cannot_be_blended_is_told_and_the_template_stays() -> None:
    state = CarState(template="sedan", blend="suv")
    assert template_of(state) is bundled("sedan")
    (told,) = [
        one.message for one in Car().cautions(state, body_of(state)) if "blend" in one.message
    ]
    assert "A sedan and an SUV" in told
    assert "Coupé, Limousine, Pickup" in told
    assert blend_problem(CarState(template="sedan", blend="coupe")) == ""
    assert blend_problem(CarState()) == ""


def test_a_blend_is_saved_as_a_template() -> None:
    state = CarState(template="hatchback", blend="van", share=0.4)
    command = next(one for one in all_commands() if one.id == "save-template")
    assert command.enabled(state)
    made = read_template(command.run(state, Context(file="Between")))
    own = body_of(CarState(template="own", own=command.run(state, Context()).decode())).network
    between = Network.of(template_of(state))
    np.testing.assert_allclose(made.positions, between.positions, atol=1e-9)
    np.testing.assert_allclose(own.tangents, between.tangents, atol=1e-6)


def test_a_template_of_ones_own_is_blended_too() -> None:
    source = all_commands()[-1].run(CarState(length=4300.0), Context(file="Wedge")).decode()
    state = CarState(template="own", own=source, blend="pickup", share=1.0)
    np.testing.assert_allclose(template_of(state).positions, bundled("pickup").positions, atol=1e-9)
    with pytest.raises(UserError):
        template_of(CarState(template="own", blend="pickup"))
