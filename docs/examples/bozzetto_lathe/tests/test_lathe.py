"""Laws of the lathe, and the contract suite."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import brep_mesh
from bozzetto.testing import ModelerContract, Pen, Shell
from bozzetto.view import Camera

LATHE = "example.lathe"
PIXELS = Camera().pixels_per_mm


class TestContract(ModelerContract):
    modeler = LATHE

    def sketch(self, shell: Shell, pen: Pen) -> None:
        shell.draw(pen.along([(700, 250), (760, 450), (680, 650)]))


def volume(shell: Shell) -> float:
    """Volume of what is handed over, by the divergence theorem, mm³."""
    (brep,) = shell.shapes().breps
    mesh = brep_mesh(brep, 1e-3)
    a, b, c = (mesh.vertices[mesh.faces[:, k]].astype(float) for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum()) / 6.0


def test_an_upright_line_turns_into_a_cylinder(shell: Shell, pen: Pen) -> None:
    shell.open(LATHE)
    shell.draw(pen.along([(700, 300), (700, 600)]))
    radius, height = 100 / PIXELS, 300 / PIXELS
    assert volume(shell) == pytest.approx(np.pi * radius**2 * height, rel=1e-3)


def test_a_slanted_line_to_the_axis_turns_into_a_cone(shell: Shell, pen: Pen) -> None:
    shell.open(LATHE)
    shell.draw(pen.along([(600, 300), (700, 600)]))
    radius, height = 100 / PIXELS, 300 / PIXELS
    assert volume(shell) == pytest.approx(np.pi * radius**2 * height / 3.0, rel=1e-3)


def test_both_sides_of_the_axis_turn_into_the_same(shell: Shell, pen: Pen) -> None:
    shell.open(LATHE)
    shell.draw(pen.along([(700, 300), (760, 450), (640, 600)]))
    right = volume(shell)
    shell.open(LATHE)
    shell.draw(pen.along([(500, 300), (440, 450), (560, 600)]))
    assert volume(shell) == pytest.approx(right, rel=1e-6)


def test_a_ring_beside_the_axis_is_a_torus(shell: Shell, pen: Pen) -> None:
    """Pappus: the area times the way of its middle."""
    shell.open(LATHE)
    shell.draw(pen.circle(800, 450, 60))
    shell.set(detail=80)
    small, large = 60 / PIXELS, 200 / PIXELS
    expected = np.pi * small**2 * 2.0 * np.pi * large
    assert volume(shell) == pytest.approx(expected, rel=0.02)


def test_a_drawn_axis_turns_the_solid_with_it(shell: Shell, pen: Pen) -> None:
    shell.open(LATHE)
    shell.draw(pen.along([(200, 450), (1000, 450)]), tool="axis")
    shell.draw(pen.along([(450, 350), (750, 350)]))
    radius, height = 100 / PIXELS, 300 / PIXELS
    assert volume(shell) == pytest.approx(np.pi * radius**2 * height, rel=1e-3)
    (brep,) = shell.shapes().breps
    size = np.ptp(brep_mesh(brep).bounds, axis=0)
    assert size == pytest.approx([height, 2 * radius, 2 * radius], rel=1e-2)


def test_a_stroke_over_the_profile_changes_only_what_it_covers(shell: Shell, pen: Pen) -> None:
    shell.open(LATHE)
    shell.draw(pen.along([(700, 200), (700, 700)]))
    before = volume(shell)
    shell.set(detail=80)
    shell.draw(pen.along([(700, 350), (800, 450), (700, 550)]))
    points = shell.shapes().breps[0].edges[0]
    assert volume(shell) > 1.1 * before
    assert points is not None
    with pytest.raises(UserError, match="begin and end the stroke on it"):
        shell.draw(pen.along([(900, 300), (900, 500)]))
    shell.undo()
    assert volume(shell) == pytest.approx(before, rel=1e-3)


@pytest.mark.parametrize(
    ("places", "words"),
    [
        ([(600, 450)], "dot"),
        ([(400, 300), (800, 600)], "crosses the axis"),
    ],
)
def test_what_cannot_be_turned_is_refused(
    shell: Shell, pen: Pen, places: list[tuple[float, float]], words: str
) -> None:
    shell.open(LATHE)
    with pytest.raises(UserError, match=words):
        shell.draw(pen.along(places))
