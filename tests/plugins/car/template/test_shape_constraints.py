"""The inequalities: what they forbid, their derivatives, and what they let through."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import Template
from bozzetto_car.template.shape_constraints import (
    FOLD_MARGIN,
    Soundness,
    fold_name,
    soundness_names,
)

Array = NDArray[np.float64]


def moved(template: Template, *moves: tuple[str, tuple[float, float, float]]) -> Array:
    """Variables of the template with some right or middle nodes put elsewhere."""
    places = template.positions.copy()
    for name, place in moves:
        places[template.node[name]] = place
    return template.reduced(places)


def test_every_template_is_sound_with_room_to_spare(template: Template) -> None:
    least = Soundness.of(template).least(template.variables)
    assert min(least.values()) >= 40.0
    assert set(least) == set(soundness_names(template))


def test_slacks_are_lengths_as_one_would_measure_them(template: Template) -> None:
    places = {name: template.positions[number] for name, number in template.node.items()}
    least = Soundness.of(template).least(template.variables)
    lean = places["C3"][0] - places["C2"][0] - 50.0
    assert least["The windscreen leans back"] == pytest.approx(lean)
    crown = places["C4"][2] - places["R2.R"][2]
    assert least["The roof is crowned at the B-pillar"] == pytest.approx(crown)
    air = places["B3.R"][2] - 50.0
    assert least["There are 5 cm of air below the sill"] == pytest.approx(air)


@pytest.mark.parametrize(
    ("move", "name"),
    [
        (("C2", (2500.0, 0.0, 980.0)), "The windscreen leans back"),
        (("WF.R", (880.0, 900.0, 325.0)), "The front wheel stands inside the body"),
        (("WF.R", (1300.0, 770.0, 325.0)), "The front wheel stands before the sill"),
        (("B3.R", (2480.0, 872.0, 30.0)), "There are 5 cm of air below the sill"),
        (("R2.R", (2640.0, 612.0, 1500.0)), "The roof is crowned at the B-pillar"),
        (("R2.R", (2640.0, 900.0, 1400.0)), "The B-pillar leans inward"),
        (("S3.R", (1250.0, 876.0, 950.0)), "The waistline leads rearward at the front door"),
        (("S3.R", (1250.0, 876.0, 950.0)), fold_name("glass_front.R")),
        (
            ("R2.R", (2640.0, 150.0, 1400.0)),
            "Roof edge at the B-pillar: 20 cm from the middle at least",
        ),
        (("WR.R", (2300.0, 770.0, 325.0)), "The wheelbase is 1.5 m at least"),
        (("C4", (2580.0, 0.0, 2600.0)), "The car is 1.3 times as high as wide at most"),
    ],
)
def test_what_makes_no_car_is_named(
    move: tuple[str, tuple[float, float, float]], name: str
) -> None:
    sedan = bundled("sedan")
    assert Soundness.of(sedan).least(moved(sedan, move))[name] < 0.0


def test_the_jacobian_is_that_of_the_slacks(template: Template) -> None:
    """Central differences are exact for quadratics, up to rounding."""
    soundness = Soundness.of(template)
    rng = np.random.default_rng(3)
    for spread in (0.0, 300.0):
        at = template.variables + rng.normal(0.0, spread, len(template.variables))
        jacobian = soundness.jacobian(at)
        step = 10.0
        for column in range(len(at)):
            aside = np.zeros(len(at))
            aside[column] = step
            change = soundness.slacks(at + aside) - soundness.slacks(at - aside)
            np.testing.assert_allclose(jacobian[:, column], change / (2 * step), atol=1e-9)


def test_linear_rows_come_first_and_are_a_matrix(template: Template) -> None:
    soundness = Soundness.of(template)
    count = len(soundness.constants)
    assert count == len(template.rules)
    at = template.variables * 1.3 - 7.0
    rows = soundness.matrix @ at + soundness.constants
    assert (soundness.slacks(at)[:count] == rows).all()


def test_a_patch_does_not_fold_where_its_outline_is_convex() -> None:
    """Seen along the patch's normal: against shapely's convex hull, for distorted cars."""
    from shapely import Polygon

    sedan = bundled("sedan")
    soundness = Soundness.of(sedan)
    rng = np.random.default_rng(4)
    convex = folded = 0
    for _ in range(150):
        at = sedan.variables + rng.normal(0.0, 250.0, len(sedan.variables))
        places = sedan.whole(at)
        least = soundness.least(at)
        for patch in sedan.patches[:14]:
            own = sedan.positions[list(patch.nodes)]
            normal = np.cross(own[2] - own[0], own[3] - own[1])
            normal /= np.linalg.norm(normal)
            across = np.cross(normal, own[1] - own[0])
            across /= np.linalg.norm(across)
            flat = places[list(patch.nodes)] @ np.stack((np.cross(across, normal), across), axis=1)
            ring = Polygon(flat)
            shape = (
                ring.is_valid
                and ring.exterior.is_ccw
                and abs(ring.convex_hull.area - ring.area) <= 1e-9 * ring.area
            )
            open_ = least[fold_name(patch.name)] + FOLD_MARGIN > 0.0
            assert open_ == shape, patch.name
            convex += shape
            folded += not shape
    assert convex > 100
    assert folded > 100


def test_each_constraint_can_be_switched_off(template: Template) -> None:
    whole = Soundness.of(template)
    for name in soundness_names(template):
        rest = Soundness.of(template, without={name})
        assert name not in rest.names
        kept = [number for number, its in enumerate(whole.names) if its != name]
        for ask in ("slacks", "jacobian"):
            fewer = getattr(rest, ask)(template.variables)
            np.testing.assert_allclose(
                fewer, getattr(whole, ask)(template.variables)[kept], rtol=1e-12, atol=1e-9
            )


def test_none_at_all_is_no_obstacle(template: Template) -> None:
    none = Soundness.of(template, without=soundness_names(template))
    assert none.names == ()
    assert none.slacks(template.variables).shape == (0,)
    assert none.jacobian(template.variables).shape == (0, len(template.variables))
    assert none.least(template.variables) == {}


def test_names_that_nobody_knows_do_no_harm(template: Template) -> None:
    soundness = Soundness.of(template, without={"The moon is made of cheese"})
    assert soundness.names == Soundness.of(template).names


@pytest.mark.parametrize("factors", [(0.88, 0.94, 0.97), (1.12, 1.08, 1.06), (0.95, 1.08, 1.1)])
def test_other_cars_of_the_kind_are_sound(
    template: Template, factors: tuple[float, float, float]
) -> None:
    """Stretched over the range of published dimensions."""
    at = template.reduced(template.positions * factors)
    assert min(Soundness.of(template).least(at).values()) > 0.0


NARROW = (
    "The front wheel is no more than 4 cm lower than the rear one",
    "The front wheel is no more than 4 cm higher than the rear one",
    "The roof is crowned above the windscreen",
    "The roof is crowned at the B-pillar",
    "The roof is crowned above the rear window",
)
"""What holds of all cars and leaves less room than the rest."""


def test_the_constraints_leave_room_for_other_makes(template: Template) -> None:
    """Cars that differ by 4 cm at every node and axis, but for what holds of all cars."""
    assert set(NARROW) <= set(soundness_names(template))
    soundness = Soundness.of(template, without=NARROW)
    rng = np.random.default_rng(8)
    cars = template.variables + rng.normal(0.0, 40.0, (200, len(template.variables)))
    sound = [bool((soundness.slacks(car) >= 0.0).all()) for car in cars]
    assert np.mean(sound) > 0.85


def test_nonsense_gives_finite_numbers(template: Template) -> None:
    soundness = Soundness.of(template)
    rng = np.random.default_rng(9)
    for _ in range(100):
        at = rng.normal(0.0, 10.0 ** rng.uniform(-3, 8), len(template.variables))
        assert np.isfinite(soundness.slacks(at)).all()
        assert np.isfinite(soundness.jacobian(at)).all()
