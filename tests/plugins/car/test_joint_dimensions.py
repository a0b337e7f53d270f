"""Cameras and shape together where dimensions are known."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto_car.dimensions import Dimensions, Overlap, measure_dimensions
from bozzetto_car.solver.bundle_adjustment import solve
from bozzetto_car.solver.prior import Cost
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import Template
from bozzetto_car.template.shape_constraints import Soundness
from tests.plugins.car.sketched import (
    FRONT_QUARTER,
    REAR_QUARTER,
    rms,
    sketched,
    styled,
)
from tests.plugins.car.solved import assert_allowed, of_nodes


@pytest.mark.parametrize("seed", range(2))
def test_known_dimensions_are_met_and_help(template: Template, seed: int) -> None:
    car = styled(template, seed)
    body = np.delete(car, template.wheels.ravel(), axis=0)
    front, rear = car[template.wheels[:, 0], 0]
    true = measure_dimensions(np.array([body.min(axis=0), body.max(axis=0)]), front, rear)
    sketch = sketched(template, car, (FRONT_QUARTER,), seed)
    sound = Soundness.of(template)
    joint = solve(template, sketch.views, Cost.balanced(), sound, locked=true)
    assert_allowed(template, joint, sound)
    found = of_nodes(template, joint)
    for name, value in true.given().items():
        assert found[name] == pytest.approx(value, abs=1e-6)
    assert rms(joint.residuals[0]) <= 2.0
    assert joint.information.shape == (joint.span.shape[1],) * 2


def test_known_dimensions_count_the_bulge_of_the_surface() -> None:
    template = bundled("minivan")
    sketch = sketched(template, styled(template, 0), (FRONT_QUARTER,), 0)
    wanted = Dimensions(length=4900.0, width=1950.0, height=1700.0, front_overhang=940.0)
    joint = solve(
        template,
        sketch.views,
        Cost.balanced(),
        Soundness.of(template),
        locked=wanted,
        overlap=Overlap(30.0, 20.0, 10.0, 5.0),
    )
    found = of_nodes(template, joint)
    assert found["length"] == pytest.approx(4850.0, abs=1e-6)
    assert found["width"] == pytest.approx(1930.0, abs=1e-6)
    assert found["height"] == pytest.approx(1695.0, abs=1e-6)
    assert found["front_overhang"] == pytest.approx(910.0, abs=1e-6)


def test_another_node_may_become_the_foremost_one() -> None:
    """The car's nose is higher than the template's: its foremost node is another."""
    template = bundled("sedan")
    car = template.positions.copy()
    names = template.names
    foremost = names[int(np.argmin(car[:, 0]))]
    other = "C1" if foremost == "C0" else "C0"
    car[template.node[other], 0] = car[:, 0].min() - 60.0
    true = Dimensions(length=float(np.ptp(car[:, 0])))
    sketch = sketched(template, car, (FRONT_QUARTER, REAR_QUARTER), 0, hand=0.5)
    joint = solve(template, sketch.views, Cost.balanced(), Soundness.of(template), locked=true)
    found = template.whole(joint.variables)
    assert names[int(np.argmin(found[:, 0]))] == other
    assert of_nodes(template, joint)["length"] == pytest.approx(true.length, abs=1e-6)
