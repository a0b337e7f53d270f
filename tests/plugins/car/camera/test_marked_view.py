"""Sketches as the joint solve sees them: places, derivatives, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.view import Camera
from bozzetto_car.camera.marked_view import MarkedView, Reprojection
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import Template
from tests.plugins.car.sketched import FRONT_QUARTER, PICTURE, looking

KINDS = ["perspective", "orthographic"]


@pytest.fixture
def template() -> Template:
    return bundled("hatchback")


def view(template: Template, kind: str, cropped: bool = False, seed: int = 0) -> MarkedView:
    rng = np.random.default_rng(seed)
    camera = looking(template.positions, FRONT_QUARTER, rng, kind)
    nodes = rng.choice(len(template.names), 20, replace=False)
    marks = rng.uniform(0.0, 1.0, (20, 2)) * PICTURE
    shift = (31.0, -17.0) if cropped else (0.0, 0.0)
    return MarkedView(camera, nodes, marks, shift, cropped)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("cropped", [False, True])
def test_it_sees_what_the_camera_sees(template: Template, kind: str, cropped: bool) -> None:
    given = view(template, kind, cropped)
    sight, pose = Reprojection.of(template, given, held=False)
    missed = sight.residuals(pose, template.positions)
    assert missed is not None
    size = np.linalg.norm(np.ptp(given.marks, axis=0))
    seen = given.camera.project(template.positions[given.nodes])[0] + given.shift
    assert missed.missed * size == pytest.approx(seen - given.marks, abs=1e-8)
    assert sight.extent * sight.framing.diagonal == pytest.approx(size)
    camera, shift = sight.framing.camera(pose)
    there_and_back = camera.project(template.positions)[0] + shift
    assert there_and_back[given.nodes] == pytest.approx(seen, abs=1e-7)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("cropped", [False, True])
@pytest.mark.parametrize("seed", range(3))
def test_derivatives_are_those_of_small_steps(
    template: Template, kind: str, cropped: bool, seed: int
) -> None:
    sight, pose = Reprojection.of(template, view(template, kind, cropped, seed), held=False)
    rng = np.random.default_rng(seed)
    follow = rng.normal(size=(len(template.names), 3, 5))
    seen = sight.residuals(pose, template.positions)
    assert seen is not None
    rows = sight.rows(seen, follow)
    numbers = len(sight.free)
    assert numbers == (6 if kind == "orthographic" else 9 if cropped else 7)
    assert rows.shape == (40, 5 + numbers)
    for column in range(5 + numbers):
        sides = []
        for sign in (1.0, -1.0):
            positions, turned = template.positions, pose
            if column < 5:
                positions = positions + sign * 1e-3 * follow[:, :, column]
            else:
                step = np.zeros(numbers)
                step[column - 5] = sign * 1e-6
                turned = sight.stepped(pose, step)
            found = sight.residuals(turned, positions)
            assert found is not None
            sides.append(found.missed.ravel())
        slope = (sides[0] - sides[1]) / (2e-3 if column < 5 else 2e-6)
        assert rows[:, column] == pytest.approx(slope, abs=1e-5 * np.abs(slope).max() + 1e-9)


def test_a_held_camera_has_no_numbers(template: Template) -> None:
    sight, pose = Reprojection.of(template, view(template, "perspective"), held=True)
    seen = sight.residuals(pose, template.positions)
    assert seen is not None
    assert seen.by_camera.shape == (20, 2, 0)
    assert np.array_equal(sight.stepped(pose, np.empty(0)).offset, pose.offset)


def test_nodes_behind_the_eye_are_told(template: Template) -> None:
    given = view(template, "perspective")
    sight, pose = Reprojection.of(template, given, held=False)
    toward = np.asarray(given.camera.eye) - template.positions.mean(axis=0)
    assert sight.residuals(pose, template.positions + 1.5 * toward) is None


def test_the_principal_point_of_a_cropped_picture_is_held_softly(template: Template) -> None:
    sight, pose = Reprojection.of(template, view(template, "perspective", cropped=True), held=False)
    form, slope, cost = sight.middle(pose)
    assert np.array_equal(np.flatnonzero(np.diag(form)), [7, 8])
    share = np.array([31.0, -17.0]) / np.hypot(*PICTURE)
    assert cost == pytest.approx(np.sum((share / 0.2) ** 2))
    assert slope[7:] == pytest.approx(share / 0.04)
    fixed, start = Reprojection.of(template, view(template, "perspective"), held=False)
    assert fixed.middle(start)[2] == 0.0


def test_what_is_no_sketch_is_refused(template: Template) -> None:
    good = view(template, "perspective")
    camera, nodes, marks = good.camera, good.nodes, good.marks
    with pytest.raises(UserError, match="more marks"):
        MarkedView(camera, nodes[:3], marks[:3])
    far = marks.copy()
    far[2] = 1e6
    with pytest.raises(UserError, match="far beyond the picture"):
        MarkedView(camera, nodes, far)
    with pytest.raises(ValueError, match="one mark"):
        MarkedView(camera, np.repeat(nodes[:5], 2), marks[:10])
    with pytest.raises(ValueError, match="one mark"):
        MarkedView(camera, nodes[:5], marks[:6])
    broken = marks.copy()
    broken[0, 0] = np.nan
    with pytest.raises(ValueError, match="finite"):
        MarkedView(camera, nodes, broken)
    middle = template.positions.mean(axis=0)
    eye = np.asarray(camera.eye)
    away = Camera("perspective", tuple(eye), tuple(2.0 * eye - middle), viewport=PICTURE)
    with pytest.raises(UserError, match="behind it"):
        Reprojection.of(template, MarkedView(away, nodes, marks), held=False)


def test_marks_in_one_place_have_an_extent(template: Template) -> None:
    good = view(template, "perspective")
    heap = MarkedView(good.camera, good.nodes, np.full((20, 2), 400.0))
    sight, pose = Reprojection.of(template, heap, held=False)
    missed = sight.residuals(pose, template.positions)
    assert missed is not None
    assert np.isfinite(missed.missed).all()
