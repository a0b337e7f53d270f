"""What is said to change nothing changes nothing, and all else something."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import get_args

import numpy as np
import pytest

from bozzetto.ink import Strokes
from bozzetto.parameters import parameter_fields
from bozzetto.plugin import Job
from bozzetto.testing import Pen
from bozzetto_silhouette.model.state import Part, SilhouetteState, Surface
from bozzetto_silhouette.modeler import Silhouette

MODELER = Silhouette()
CONDITIONED = {
    field.name: values
    for field in parameter_fields(Part)
    for other, values in field.parameter.idle_while
    if other == "surface"
}
OTHER = {"depth": 20.0, "softness": 1.8, "kernel": "cauchy", "skeleton": "paper"}


def clover() -> np.ndarray:
    turn = np.linspace(0.0, 2.0 * np.pi, 60, endpoint=False)
    reach = 150.0 * (1.0 + 0.35 * np.cos(3.0 * turn))
    return np.column_stack((600.0 + reach * np.cos(turn), 450.0 + reach * np.sin(turn)))


@cache
def vertices(surface: str, name: str = "", carved: bool = False) -> bytes:
    """The solid of a clover, or of a ball with a clover carved out, with a parameter changed."""
    pen = Pen()
    ball = Part(id="n0", name="Ball", strokes=Strokes((pen.circle(600.0, 450.0, 320.0),)))
    drawn = Part(id="n1", name="Clover", strokes=Strokes((pen.polygon(*clover()),)))
    drawn = replace(drawn, surface=surface, **({name: OTHER[name]} if name else {}))
    nodes = (ball, replace(drawn, operation="carve")) if carved else (drawn,)
    state = SilhouetteState(nodes, resolution=32)
    (solid,) = MODELER.shapes(state, MODELER.solve(state, Job())).solids
    return solid.mesh.vertices.tobytes()


def test_all_that_depend_on_the_surface_are_known() -> None:
    assert set(CONDITIONED) == set(OTHER)


@pytest.mark.parametrize("name", sorted(OTHER))
@pytest.mark.parametrize("surface", get_args(Surface))
def test_a_parameter_is_idle_exactly_where_it_says_so(surface: str, name: str) -> None:
    carved = name == "depth"  # it counts for what takes away
    same = vertices(surface, "", carved) == vertices(surface, name, carved)
    assert same == (surface in CONDITIONED[name])
