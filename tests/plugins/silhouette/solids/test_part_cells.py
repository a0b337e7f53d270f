"""How fine the parts of a tree are: as asked for, but for small ones beside large ones."""

from __future__ import annotations

from dataclasses import replace

import pytest

from bozzetto.geometry import Placement
from bozzetto.ink import Strokes
from bozzetto.testing import Pen
from bozzetto_silhouette.inflation.manifold_check import topology_of
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.solids.evaluate import evaluated
from bozzetto_silhouette.solids.part_cells import FEWEST, FINER, cells_of


def part(name: str, x: float, radius: float) -> Part:
    return Part(id=name, name=name, strokes=Strokes((Pen().circle(x, 450.0, radius),)))


BODY, EYE = part("body", 500.0, 300.0), part("eye", 790.0, 20.0)


@pytest.mark.parametrize("resolution", [32, 48, 64, 128, 256])
def test_cells_are_as_asked_for_where_nothing_is_larger(resolution: int) -> None:
    for state in (SilhouetteState((EYE,)), SilhouetteState((BODY, part("twin", 900.0, 290.0)))):
        assert set(cells_of(state, resolution).values()) == {resolution}
    hidden = SilhouetteState((replace(BODY, visible=False), EYE))
    assert cells_of(hidden, resolution) == {"eye": resolution}


@pytest.mark.parametrize("resolution", [64, 128, 256])
def test_parts_far_apart_have_fewer_though_all_are_alike(resolution: int) -> None:
    """Twenty-four beads at the full resolution are half a million triangles, remade at a stroke."""
    few = SilhouetteState(tuple(part(f"n{k}", 100.0 + 45.0 * k, 20.0) for k in range(4)))
    many = SilhouetteState(tuple(part(f"n{k}", 100.0 + 45.0 * k, 20.0) for k in range(24)))
    assert set(cells_of(few, resolution).values()) == {resolution}
    (cells,) = set(cells_of(many, resolution).values())
    assert min(resolution, FEWEST) <= cells <= max(resolution // 2, FEWEST)
    span, size = 45.0 * 23 + 40.0, 40.0
    assert cells * span / size > 2.0 * resolution  # and each is finer than the whole asks for


@pytest.mark.parametrize("resolution", [32, 48, 64, 128, 256])
def test_small_parts_have_fewer_and_never_too_few(resolution: int) -> None:
    radii = (300.0, 200.0, 150.0, 100.0, 60.0, 20.0, 5.0)
    state = SilhouetteState(tuple(part(f"n{k}", 500.0, r) for k, r in enumerate(radii)))
    found = list(cells_of(state, resolution).values())
    assert found == sorted(found, reverse=True)
    assert found[0] == resolution
    assert found[-1] == min(resolution, FEWEST)
    for cells, radius in zip(found, radii, strict=True):
        # At least as fine as the largest part, and as `FINER` asks.
        assert cells >= min(resolution, resolution * FINER * radius / radii[0]) - 1


def test_a_part_that_was_made_larger_counts_as_large() -> None:
    grown = replace(EYE, pose=Placement(scale=10.0))
    assert cells_of(SilhouetteState((BODY, grown)), 128)["eye"] == 128


def test_a_small_part_is_sound_and_round() -> None:
    body, solids = evaluated(SilhouetteState((BODY, EYE)), 128)
    assert body is not None
    assert topology_of(body.vertices, body.faces).watertight
    eye = solids["eye"]
    assert eye.soundness.ok
    assert len(eye.faces) < 0.25 * len(solids["body"].faces)
    size = 0.5 * float(eye.vertices[:, 0].max() - eye.vertices[:, 0].min())
    assert eye.vertices[:, 2].max() == pytest.approx(size, rel=0.02)
