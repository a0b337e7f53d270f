"""The box of a new drawing beside objects of any size."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.geometry import Mesh
from bozzetto.plugin import Context
from bozzetto.scene import Image, Layer, Scene, Shaded
from bozzetto.view import Camera
from bozzetto_symmetry.model.state import SymmetryState
from bozzetto_symmetry.modeler import Symmetry

USUAL = (200.0, 100.0, 100.0)


def edges(state: SymmetryState) -> tuple[float, float, float]:
    return state.length, state.width, state.height


def ends(state: SymmetryState) -> tuple[np.ndarray, np.ndarray]:
    centre, half = np.array(state.centre), 0.5 * np.array(edges(state))
    return centre - half, centre + half


def beside(*corners: tuple[float, float, float]) -> SymmetryState:
    """Return a new drawing beside a triangle."""
    mesh = Mesh(np.array(corners, np.float32), np.array([[0, 1, 2]], np.int32))
    scene = Scene((Layer("other", (Shaded(mesh),)),))
    return Symmetry().create(Context(scene=scene))


@pytest.mark.parametrize("size", [4000.0, 1.2e5, 20.0, 1.0])
def test_a_box_has_room_for_objects_of_any_size(size: float) -> None:
    corners = np.array(((-0.1, 0.02, 0.01), (0.9, 0.3, 0.01), (0.5, -0.12, 0.41))) * size
    made = beside(*(tuple(row) for row in corners.tolist()))
    low, high = ends(made)
    assert (low <= corners.min(axis=0) + 0.01 * size).all()
    assert (high >= corners.max(axis=0) - 0.01 * size).all()
    assert max(edges(made)) < 1.4 * size
    assert made.centre[1] == 0.0


def test_an_object_beside_the_plane_has_its_own_centre_plane() -> None:
    made = beside((0.0, 500.0, 0.0), (3000.0, 1500.0, 0.0), (0.0, 1000.0, 800.0))
    assert made.centre[1] == pytest.approx(1000.0)


def test_what_is_of_the_usual_size_changes_nothing() -> None:
    made = beside((0.0, 10.0, 0.0), (150.0, 40.0, 0.0), (0.0, 10.0, 90.0))
    assert edges(made) == USUAL
    assert made == Symmetry().create(Context())


def test_a_flat_object_gets_a_box_that_can_be_drawn_in() -> None:
    made = beside((0.0, 0.0, 0.0), (4000.0, 0.0, 0.0), (0.0, 0.0, 0.0))
    assert min(edges(made)) >= 0.2 * max(edges(made))


def test_a_picture_is_no_object() -> None:
    picture = Image(
        np.zeros((2, 2, 4), np.uint8), (0.0, 0.0, 9e3), (9e3, 0.0, 0.0), (0.0, 0.0, -9e3)
    )
    made = Symmetry().create(Context(scene=Scene((Layer("sketch", (picture,)),))))
    assert edges(made) == USUAL


def test_a_file_that_gives_a_box_is_taken_at_its_word() -> None:
    scene = Scene((Layer("other", (Shaded(Mesh(9e3 * np.eye(3), np.array([[0, 1, 2]]))),)),))
    given = Context(camera=Camera(), scene=scene, facts={"box": [30.0, 20.0, 10.0]})
    assert edges(Symmetry().create(given)) == (30.0, 20.0, 10.0)
