"""Rough skins over the curves of other modelers: cars, and what was drawn for the gallery."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from bozzetto.cli.build import workbench
from bozzetto.exchange.import_file import read_drawing
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.geometry import Curve, Shapes
from bozzetto.plugin import Job
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.network import Network
from bozzetto_skin.modeler import RoughSkin, Skin, SkinState

GALLERY = Path(__file__).parents[3] / "docs" / "gallery" / "symmetry"

BEZIER = np.array([0.0, 0, 0, 0, 1, 1, 1, 1])


def _car(name: str) -> Shapes:
    points = Network.of(bundled(name)).control_points
    return Shapes(curves=tuple(Curve(3, BEZIER, each) for each in points))


def _wrapped(shapes: Shapes, detail: int = 5) -> tuple[SkinState, Skin]:
    modeler = RoughSkin()
    state = replace(modeler.read_shapes(shapes), detail=detail)
    return state, modeler.solve(state, Job())


def _shares(state: SkinState, skin: Skin) -> list[float]:
    """Median, 95th percentile and greatest of the distances, per diagonal of the curves."""
    size = np.linalg.norm(np.ptp(state.points, axis=0))
    return [float(each) for each in np.quantile(skin.distances / size, [0.5, 0.95, 1.0])]


@pytest.mark.parametrize("name", ["sedan", "hatchback", "minivan"])
def test_a_car_has_a_closed_symmetric_skin_through_its_lines(name: str) -> None:
    state, skin = _wrapped(_car(name))
    (solid,) = RoughSkin().shapes(state, skin).solids
    assert check_solid(solid).genus == 0
    median, most, greatest = _shares(state, skin)
    assert median <= 5e-5
    assert most <= 3e-4
    assert greatest <= 4e-3
    places = set(map(tuple, (solid.mesh.vertices + 0.0).tolist()))
    image = solid.mesh.vertices * np.float32([1, -1, 1]) + 0.0
    assert places == set(map(tuple, image.tolist()))


@pytest.mark.slow
@pytest.mark.parametrize("name", ["mouse", "vacuum-cleaner", "car-lines"])
def test_the_gallery_can_be_wrapped(name: str) -> None:
    bench = workbench()
    drawing = read_drawing(GALLERY / f"{name}.json")
    drawn = bench.sources.from_drawing("bozzetto.symmetry", drawing, {})
    state, skin = _wrapped(bench.shapes([drawn], Job()))
    (solid,) = RoughSkin().shapes(state, skin).solids
    assert check_solid(solid).genus == 0
    median, most, greatest = _shares(state, skin)
    assert median <= 1e-4
    assert most <= 5e-3
    assert greatest <= 0.04
