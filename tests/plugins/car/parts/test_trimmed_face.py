"""Edges of faces that are cut out of a panel: on it, however unevenly they are run."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from bozzetto.geometry import ParameterCurve
from bozzetto_car.parts.trimmed_face import CLOSE, bezier, edge_along, face_within

BONNET = np.array([
    [[69, 0, 642], [69, 214, 642], [287, 429, 657], [505, 643, 672]],
    [[589, 0, 835], [589, 214, 835], [671, 500, 821], [889, 714, 836]],
    [[1110, 0, 943], [1110, 274, 943], [1219, 511, 995], [1273, 785, 999]],
    [[1632, 0, 1050], [1632, 274, 1050], [1685, 548, 1054], [1739, 823, 1058]],
], float)  # fmt: skip
"""A panel that meets its mirror image smoothly: seen from the side it turns back there."""


def arc(samples: int, power: float) -> ParameterCurve:
    """A way from one side of a panel to the other, faster and faster towards its end."""
    t = np.linspace(0.0, 1.0, samples)
    fit = make_interp_spline(t, np.column_stack((0.32 + 0.1 * t, (1.0 - t) ** power)), k=3)
    return ParameterCurve(3, fit.t, fit.c)


@pytest.mark.parametrize("samples", [7, 25, 40])
@pytest.mark.parametrize("power", [0.5, 0.7, 1.0, 2.0])
def test_an_edge_is_on_its_surface(samples: int, power: float) -> None:
    surface, path = bezier(BONNET), arc(samples, power)
    edge = edge_along(surface, path)
    at = np.linspace(0.0, 1.0, 5003)
    away = np.linalg.norm(edge.value(at) - surface.value(*path.value(at).T), axis=1)
    assert away.max() < 3.0 * CLOSE
    np.testing.assert_allclose(edge.value([0.0, 1.0]), surface.value(*path.value([0, 1]).T))


def test_a_face_beside_an_arc_that_runs_into_the_middle_of_the_car_is_one() -> None:
    sides = [arc(25, 0.5)]
    (u0, v0), (u1, v1) = sides[0].value([0.0, 1.0])
    for a, b in (((u1, v1), (0.0, v1)), ((0.0, v1), (0.0, v0)), ((0.0, v0), (u0, v0))):
        sides.append(ParameterCurve.line(a, b, (0.0, 1.0)))
    turned = [ParameterCurve(s.degree, 1.0 - s.knots[::-1], s.control_points[::-1]) for s in sides]
    brep = face_within(bezier(BONNET), [turned[::-1]])
    assert brep.largest_gap() <= brep.tolerance
