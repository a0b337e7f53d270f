"""What is said of a shape: figures against closed forms, warnings, printing, coloured lines."""

from __future__ import annotations

import json
from dataclasses import replace

import manifold3d
import numpy as np
import pytest
import shapely

from bozzetto.geometry import Placement
from bozzetto.ink import Strokes
from bozzetto.plugin import Job
from bozzetto.scene import walls_of
from bozzetto.testing import Pen
from bozzetto_silhouette.analysis.report import report_of
from bozzetto_silhouette.inflation.manifold_check import topology_of
from bozzetto_silhouette.model.state import Oversketch, Part, SilhouetteState
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.solids.part_solid import solid_of
from bozzetto_silhouette.solids.placements import drawn_rings
from bozzetto_silhouette.view.ink_layers import deviation_layer, ink_layers

MODELER, PEN = Silhouette(), Pen()
Manifold = manifold3d.Manifold


def arrays(solid: Manifold):
    mesh = solid.to_mesh64()
    return np.asarray(mesh.vert_properties)[:, :3], np.asarray(mesh.tri_verts).astype(np.int32)


def walls(solid: Manifold):
    return walls_of(*arrays(solid))


BALL = Manifold.sphere(10.0, 100)
ROD = Manifold.cylinder(40.0, 1.0, 1.0, 48).rotate((0, 90, 0)).refine(4)
SOLIDS = {
    "ball": (BALL, 20.0),
    "slab": (Manifold.cube((30.0, 20.0, 4.0)).refine(6), 4.0),
    "tube bent to a ring": (
        manifold3d.CrossSection.circle(3.0, 48).translate((10.0, 0.0)).revolve(96),
        6.0,
    ),
    "two balls on a rod": (BALL + BALL.translate((40.0, 0.0, 0.0)) + ROD, 2.0),
    "hollow ball": (BALL - Manifold.sphere(9.5, 100), 0.5),
    "plate under a block": (
        Manifold.cube((40.0, 40.0, 1.0)).refine(8)
        + Manifold.cube((10.0, 10.0, 20.0)).translate((15.0, 15.0, 0.5)).refine(3),
        1.0,
    ),
}


@pytest.mark.parametrize(("solid", "expected"), SOLIDS.values(), ids=SOLIDS)
def test_the_thinnest_wall_is_that_of_the_solid(solid, expected) -> None:
    found = walls(solid)
    assert found.thinnest == pytest.approx(expected, rel=0.02)
    assert found.detail <= 1.3 * max(expected, 20.0)


@pytest.mark.parametrize("solid", [SOLIDS["two balls on a rod"][0]])
def test_its_place_is_there_and_turns_and_scales_with_it(solid) -> None:
    found = walls(solid)
    x, y, z = found.place
    assert 8.0 < x < 32.0
    assert np.hypot(y, z) < 0.3
    other = walls(solid.rotate((20, 50, 70)).scale((1e3, 1e3, 1e3)).translate((1e4, 0, 0)))
    assert other.thinnest == pytest.approx(1e3 * found.thinnest, rel=0.02)


def test_tips_are_no_walls_but_details() -> None:
    spike = Manifold.cylinder(8.0, 3.0, 0.0, 64).refine(8)
    found = walls(BALL + spike.translate((0.0, 0.0, 9.0)))
    assert found.thinnest > 3.0
    assert found.detail < found.thinnest


def test_topology_is_that_of_manifold3d() -> None:
    ring = manifold3d.CrossSection.circle(3.0, 32).translate((10.0, 0.0)).revolve(64)
    for solid in (BALL, ring, ring + BALL.translate((50.0, 0.0, 0.0)), SOLIDS["hollow ball"][0]):
        found = topology_of(*arrays(solid))
        assert found.watertight
        assert found.volume == pytest.approx(solid.volume(), rel=1e-9)
        assert found.components == len(solid.decompose())
        assert found.genus == sum(part.genus() for part in solid.decompose())
    assert found.bodies == 1


# -- the report --


def part_of(*strokes, number=1, **more) -> Part:
    more = {"blend": 0.0, **more}
    return Part(id=f"n{number}", name=f"Part {number}", strokes=Strokes(strokes), **more)


def report(*parts: Part, selected: str = "n1", resolution: int = 64):
    state = SilhouetteState(nodes=parts, selected=selected, resolution=resolution)
    result = MODELER.solve(state, Job())
    made = MODELER.report(state, result, Job())
    json.dumps(made, allow_nan=False)
    return made, result, state


def test_a_ball_is_reported_in_millimetres_where_it_stands() -> None:
    """Volume and area of a ball in closed form, also of one that was made larger."""
    for scale in (1.0, 2.5):
        part = part_of(PEN.circle(600, 450, 200), pose=Placement(scale=scale))
        made, _, state = report(part)
        radius = np.ptp(drawn_rings(state, part)[0][:, 0]) / 2.0
        for figures in (made["whole"], made["parts"][0]):
            assert figures["volume"] == pytest.approx(4 / 3 * np.pi * radius**3, rel=0.03)
            assert figures["area"] == pytest.approx(4 * np.pi * radius**2, rel=0.03)
            assert figures["thinnest_wall"] == pytest.approx(2 * radius, rel=0.06)
        assert made["parts"][0]["hausdorff"] < 5e-3 * radius
        assert made["print"]["ready"]
        assert made["print"]["size_mm"] == pytest.approx([2 * radius] * 3, rel=0.04)
        assert "warnings" not in made


def test_the_whole_is_what_manifold3d_says() -> None:
    made, result, _ = report(
        part_of(PEN.circle(500, 450, 150), PEN.circle(500, 450, 60)),
        part_of(PEN.circle(650, 450, 60), number=2),
        part_of(PEN.circle(380, 450, 25), number=3, operation="carve"),
    )
    solid = result.body.manifold
    assert made["whole"]["volume"] == pytest.approx(solid.volume(), rel=1e-6)
    assert made["whole"]["area"] == pytest.approx(solid.surface_area(), rel=1e-6)
    assert made["whole"]["genus"] == sum(p.genus() for p in solid.decompose())
    assert [p["name"] for p in made["parts"]] == ["Part 1", "Part 2", "Part 3"]
    assert ["thinnest_wall" in p for p in made["parts"]] == [True, False, False]


def test_what_does_not_print_is_said() -> None:
    apart, _, _ = report(
        part_of(PEN.circle(300, 450, 90)), part_of(PEN.circle(800, 450, 90), number=2)
    )
    assert not apart["print"]["ready"]
    assert "2 pieces" in apart["print"]["problems"][0]
    thin, _, _ = report(part_of(PEN.circle(600, 450, 100), inflation=0.2,
                                pose=Placement(scale=0.02)))  # fmt: skip
    assert "thinnest wall" in thin["print"]["problems"][0]
    assert all(problem.endswith(".") for problem in thin["print"]["problems"])


def test_nothing_is_left_and_nothing_is_there() -> None:
    made, result, _ = report(
        part_of(PEN.circle(600, 450, 90)), part_of(PEN.circle(600, 450, 150), number=2,
                                                   operation="carve"),
    )  # fmt: skip
    assert result.body is None
    assert "whole" not in made
    assert report()[0] == {"parts": []}


def test_another_topology_than_the_drawings_is_warned_of() -> None:
    """A ring's solid in the place of a disc's."""
    disc, ring = part_of(PEN.circle()), part_of(PEN.circle(), PEN.circle(600, 450, 80))
    state = SilhouetteState(nodes=(disc,))
    made = report_of(state, None, {"n1": solid_of(ring, 48)}, Job(), list)
    (genus, *rest) = made["warnings"]
    assert "“Part 1” has 1 hole in 1 piece; its drawing has no holes in 1 piece" in genus
    assert all(words.endswith(".") for words in (genus, *rest))
    assert "leaves its outline by" in rest[0]


# -- the lines --


def test_a_true_part_shows_no_deviation() -> None:
    part = part_of(PEN.circle(), PEN.circle(600, 450, 80))
    state = SilhouetteState(nodes=(part,), selected="n1")
    assert deviation_layer(state, part, solid_of(part, 48)) is None
    names = [layer.name for layer in MODELER.scene(state, MODELER.solve(state, Job())).layers]
    assert "fidelity" not in names


def test_deviation_is_shown_where_it_is_and_in_steps() -> None:
    """The solid of a circle in the place of that of an ellipse that meets it above and below."""
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    wide = PEN.along(np.column_stack([600 + 212 * np.cos(turn), 450 + 200 * np.sin(turn)]))
    part, round_ = part_of(wide, pose=Placement(offset=(0.0, 0.0, 30.0))), part_of(PEN.circle())
    state = SilhouetteState(nodes=(part,), selected="n1")
    layer = deviation_layer(state, part, solid_of(round_, 64))
    assert layer is not None
    (ring,) = drawn_rings(state, part)
    middle = ring.mean(axis=0)
    angles = []
    for item in layer.items:
        seen = shapely.points(np.asarray(item.points)[:, [0, 2]])
        assert shapely.distance(shapely.LinearRing(ring[:, [0, 2]]), seen).max() < 1e-3
        away = np.abs(np.asarray(item.points) - middle)
        angles.append(np.degrees(np.arctan2(away[:, 2], away[:, 0])).mean())
    # The sides are 12 px off, which is 2 % of the diagonal: red; further up less.
    assert len(angles) == 3
    assert angles[0] > angles[1] > angles[2]


def test_the_ghost_of_a_changed_outline_is_the_outline() -> None:
    part = part_of(PEN.circle())
    state = SilhouetteState(nodes=(part,), selected="n1")
    plain = ink_layers(state)[0].items[0]
    assert len(plain.points) == len(part.strokes[0])
    bump = PEN.along([(560, 250), (600, 180), (640, 250)])
    changed = state.with_node(replace(part, edits=(Oversketch(bump),)))
    (line,) = ink_layers(changed)[0].items
    (ring,) = drawn_rings(changed, changed.parts[0])
    assert np.asarray(line.points)[:-1] == pytest.approx(ring, abs=1e-3)
