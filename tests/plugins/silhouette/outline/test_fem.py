"""Factors of the matrices of plans: against dense solutions, in bands and without."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csc_array, diags_array

from bozzetto_silhouette.outline import fem
from bozzetto_silhouette.outline.boundary_sampling import sample_rim
from bozzetto_silhouette.outline.domain_mesh import Plan, plan_of
from bozzetto_silhouette.outline.fem import Elements, factorised
from tests.plugins.silhouette import outlines as o


def _plan(seed: int) -> Plan:
    """A wavy disc, with a hole in every other one."""
    random = np.random.default_rng(seed)
    angle = np.linspace(0.0, 2.0 * np.pi, 160, endpoint=False)
    radius = 0.4 + sum(
        random.normal(0.0, 0.03) * np.cos(k * angle + random.uniform(0.0, 6.0)) for k in (2, 3, 5)
    )
    rings = [np.column_stack([radius * np.cos(angle), radius * np.sin(angle)])]
    if seed % 2:
        rings.append(o.circle(0.02, 0.0, 0.1, 40)[::-1])
    return plan_of(sample_rim(tuple(rings), 0.05, 0.01), np.zeros((0, 2)), 0.05)


@pytest.mark.parametrize("banded", [0.0, np.inf])
@pytest.mark.parametrize("seed", range(71300, 71304))
def test_factors_solve_what_they_are_factors_of(
    seed: int, banded: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fem, "BANDED", banded)
    plan, random = _plan(seed), np.random.default_rng(seed)
    elements, rim = Elements.of(plan), len(plan.after)
    weight = random.uniform(0.01, 1.0, len(plan.triangles))
    for matrix in (
        elements.stiffness()[rim:, rim:],
        (elements.stiffness(weight) + diags_array(elements.mass)).tocsc(),
    ):
        dense, right = matrix.toarray(), random.normal(size=matrix.shape[0])
        found = factorised(matrix).solve(right)
        assert found == pytest.approx(np.linalg.solve(dense, right), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize("banded", [0.0, np.inf])
def test_rows_of_points_without_triangles_are_left_alone(
    banded: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(fem, "BANDED", banded)
    matrix = np.zeros((5, 5))
    matrix[:3, :3] = [[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 2.0]]
    found = factorised(csc_array(matrix)).solve(np.array([1.0, 0.0, 1.0, 0.0, 0.0]))
    assert found == pytest.approx([1.0, 1.0, 1.0, 0.0, 0.0])


def test_a_matrix_that_rounding_made_indefinite_still_has_factors() -> None:
    """Pivots below zero end Cholesky's factors; the sparse ones go on."""
    matrix = np.array([[1.0, 1.0 + 1e-15, 0.0], [1.0 + 1e-15, 1.0, 0.0], [0.0, 0.0, 1.0]])
    found = factorised(csc_array(matrix)).solve(np.array([1.0, 1.0, 2.0]))
    assert np.isfinite(found).all()
    assert found[2] == pytest.approx(2.0)
