"""Products in the window: corners by touch and by their number, creases by strength, pockets."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bozzetto.document.model import Document, Model
from bozzetto.document.storage.bozz_file import write_document
from bozzetto.plugin import Job
from bozzetto.testing import Pen
from bozzetto_app.testing import WindowShell
from bozzetto_product.model.arcs import Arc
from bozzetto_product.model.details import Detail
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.operations.corners import corners_of
from bozzetto_product.operations.meetings import splines_of
from bozzetto_product.solve.solver import net_of_state
from tests.plugins.product.test_details_on_floors import POCKET, drawn_state


@pytest.fixture
def shell(window: WindowShell, tmp_path: Path) -> WindowShell:
    """A box with a pocket in its top, seen from its corner."""
    state = drawn_state({**POCKET, "draft": 4.0, "depth": 2.5})
    version = ProductModeler.state_version
    model = Model("m", "Box", "bozzetto.product", state, state_version=version)
    write_document(Document((model,)), tmp_path / "box.bozz")
    window.session.files.open(tmp_path / "box.bozz")
    window.settle()
    window.choose("m")
    window.look("three-quarter")
    window.press("Home")
    return window


def seen(shell: WindowShell, *points: tuple[float, float, float]) -> np.ndarray:
    return np.asarray(shell.session.view.camera.project(np.array(points))[0])


def test_a_corner_is_rounded_by_touch_and_again_by_its_number(shell: WindowShell) -> None:
    shell.take("fillet")
    before = shell.state
    corner = next(
        one
        for one in corners_of(before.joints, splines_of(before), before.symmetry)
        if np.allclose(one.place, (100.0, 0.0, 40.0)) and one.handle[2] == pytest.approx(40.0)
    )
    start = seen(shell, corner.handle)[0]
    pen = Pen(camera=shell.session.view.camera)
    shell.drag(corner.name, pen.along([tuple(start), tuple(start + 0.4)]))
    arc = shell.state.chosen_of(Arc)
    assert arc is not None, shell.notices
    assert arc.radius == before.rounding
    shell.session.parts.set_parameter("radius", 12.0)
    shell.settle()
    wide = shell.state.chosen_of(Arc)
    ends = wide.spline.control_points[[0, -1]]
    assert np.linalg.norm(ends - corner.place, axis=1) == pytest.approx(12.0, rel=1e-6)
    shell.session.parts.set_parameter("radius", 500.0)
    shell.settle()
    assert "too large" in shell.notices[-1]
    assert shell.state.chosen_of(Arc).radius == 12.0
    shell.undo()
    assert shell.state.chosen_of(Arc).radius == before.rounding


def test_the_strength_of_creases_is_there_while_its_tool_is_in_the_hand(shell: WindowShell) -> None:
    shell.take("crease")
    shell.set(strength=0.4)
    place = seen(shell, (50.0, 0.0, 40.0))[0]
    shell.tap(*map(float, place))
    creases = [edge.crease for edge in net_of_state(shell.state).edges]
    assert creases.count(0.4) == 1, shell.notices
    shell.tap(*map(float, place))
    assert [edge.crease for edge in net_of_state(shell.state).edges].count(0.0) == 1


def test_a_round_in_a_pocket_lies_on_its_floor(shell: WindowShell) -> None:
    shell.take("detail")
    turn = np.linspace(0.0, 2.0 * np.pi, 60)
    floor = np.column_stack(
        (52.0 + 7.0 * np.cos(turn), 32.0 + 7.0 * np.sin(turn), np.full(len(turn), 37.5))
    )
    pixels = seen(shell, *map(tuple, floor))
    shell.draw(Pen(camera=shell.session.view.camera).along([tuple(row) for row in pixels]))
    assert len(shell.state.of_kind(Detail)) == 2, shell.notices
    solved = ProductModeler().solve(shell.state, Job())
    assert [one.problem for one in solved.detailed.details] == ["", ""]
    assert np.abs(solved.detailed.details[1].outlines[0][:, 2] - 37.5).max() < 1e-6
