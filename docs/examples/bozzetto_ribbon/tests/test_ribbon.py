"""Laws of the ribbon, and the contract suite."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.testing import ModelerContract
from bozzetto.view import Camera

RIBBON = "example.ribbon"


class TestContract(ModelerContract):
    modeler = RIBBON


def test_even_ribbon_has_the_width_asked_for(shell, pen):
    shell.open(RIBBON)
    shell.draw(pen.along([(300, 450), (900, 450)]))
    shell.set(width=10.0, influence=0.0)
    (ribbon,) = shell.shapes().surfaces
    pixels_per_mm = Camera().pixels_per_mm
    size = np.ptp(ribbon.mesh.bounds, axis=0)
    assert size == pytest.approx([600 / pixels_per_mm, 0.0, 10.0], abs=1e-3)


def test_pressure_widens(shell, pen):
    shell.open(RIBBON)
    shell.draw(pen.but(pressure=(0.0, 1.0)).along([(300, 450), (900, 450)]))
    shell.set(width=10.0, influence=1.0)
    edges = shell.shapes().surfaces[0].mesh.vertices.reshape(2, -1, 3)
    widths = np.linalg.norm(edges[1] - edges[0], axis=1)
    assert widths[0] == pytest.approx(0.0, abs=1e-6)
    assert widths[-1] == pytest.approx(10.0)
    assert (np.diff(widths) >= -1e-5).all()


def test_half_a_turn_exchanges_the_edges(shell, pen):
    shell.open(RIBBON)
    shell.draw(pen.along([(300, 450), (900, 450)]))
    shell.set(influence=0.0)
    left, right = shell.shapes().surfaces[0].mesh.vertices.reshape(2, -1, 3)
    shell.set(twist=0.5)
    turned_left, _ = shell.shapes().surfaces[0].mesh.vertices.reshape(2, -1, 3)
    assert turned_left[0] == pytest.approx(left[0], abs=1e-4)
    assert turned_left[-1] == pytest.approx(right[-1], abs=1e-4)


def test_handle_moves_the_ribbon(shell, pen):
    shell.open(RIBBON)
    shell.draw(pen.along([(300, 450), (900, 450)]))
    before = shell.shapes().surfaces[0].mesh.vertices
    (handle,) = shell.handles()
    shell.drag(handle.id, pen.along([(300, 450), (300, 350)]))
    after = shell.shapes().surfaces[0].mesh.vertices
    rise = 100 / Camera().pixels_per_mm
    assert after - before == pytest.approx(np.broadcast_to([0, 0, rise], after.shape), abs=1e-3)
    shell.undo()
    assert np.array_equal(shell.shapes().surfaces[0].mesh.vertices, before)


def test_tap_takes_away_what_is_under_it(shell, pen):
    shell.open(RIBBON)
    shell.draw(pen.along([(300, 300), (900, 300)]), pen.along([(300, 600), (900, 600)]))
    with pytest.raises(UserError, match="no ribbon here"):
        shell.tap(600, 450)
    shell.tap(600, 602)
    assert len(shell.shapes().surfaces) == 1
    assert shell.shapes().surfaces[0].mesh.bounds[0, 2] > 0


def test_dot_is_refused_in_plain_words(shell, pen):
    shell.open(RIBBON)
    with pytest.raises(UserError, match="Draw a stroke"):
        shell.draw(pen.dot())


def test_first_version_is_upgraded():
    from bozzetto_ribbon.modeler import Ribbon

    old = {"bands": [], "width": 8.0, "pressure": 0.4}
    assert Ribbon().upgrade(old, 1) == {
        "bands": [],
        "width": 8.0,
        "influence": 0.4,
        "twist": 0.0,
    }
    assert old["pressure"] == 0.4
