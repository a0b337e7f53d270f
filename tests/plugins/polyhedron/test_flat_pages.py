"""Faces and nets as files: true size, one row a body, from the command line and the shell."""

from __future__ import annotations

import re

import numpy as np
import pytest

from bozzetto.cli.main import main
from bozzetto.plugin import Job
from bozzetto.testing import Shell
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solid.face_rings import edges_of
from tests.plugins.polyhedron.drawn_bodies import VIEW, fitted, strokes_of
from tests.plugins.polyhedron.objects import OBJECTS
from tests.plugins.polyhedron.true_bodies import face_areas, polygon_area
from tests.plugins.polyhedron.write_samples import FOLDER

MODELER = PolyhedronModeler()


def drawn(shell: Shell, name: str = "box") -> None:
    solid = OBJECTS[name]
    shell.open("bozzetto.polyhedron")
    shell.camera = VIEW
    shell.draw(*strokes_of(fitted(solid), solid.edges, jitter=1.0, seed=9600))
    shell.run("next-answer")


def test_every_face_lies_flat_at_true_size(shell):
    drawn(shell)
    body = MODELER.solve(shell.state, Job()).bodies["n1"].body
    shell.put(type(shell.state)(**{**vars(shell.state), "files": "faces"}))
    curves = shell.shapes().curves
    assert not shell.shapes().breps
    flat = sorted(abs(polygon_area(curve.control_points[:-1, :2])) for curve in curves)
    assert flat == pytest.approx(sorted(face_areas(body)), rel=1e-12)
    assert all(np.abs(curve.control_points[:, 2]).max() == 0.0 for curve in curves)
    assert min(curve.control_points[:, 0].min() for curve in curves) > body.vertices[:, 0].max()


def test_a_net_has_every_edge_once_as_a_fold_or_twice_as_cuts(shell):
    drawn(shell)
    body = MODELER.solve(shell.state, Job()).bodies["n1"].body
    shell.run("unfold")
    assert "page" in {layer.name for layer in shell.scene().layers}
    curves = shell.shapes().curves
    folds = [curve for curve in curves if curve.name.endswith("folds")]
    cuts = [curve for curve in curves if curve.name.endswith("cuts")]
    count = len(edges_of(body.faces))
    assert len(folds) == len(body.faces) - 1
    assert 2 * len(folds) + len(cuts) == 2 * count
    shell.run("unfold")
    assert shell.shapes().breps
    assert not shell.shapes().curves


def test_two_bodies_have_rows_of_their_own(shell):
    drawn(shell)
    shell.run("new-body")
    solid = OBJECTS["house"]
    far = fitted(solid, 60.0, (400.0, 0.0, 40.0))
    shell.draw(*strokes_of(far, solid.edges, seed=9601))
    shell.run("next-answer")
    shell.run("unfold")
    rows = {}
    for curve in shell.shapes().curves:
        rows.setdefault(curve.name.split(",")[0], []).append(curve.control_points[:, 1])
    (low, high), (low_other, high_other) = (
        (np.concatenate(y).min(), np.concatenate(y).max()) for y in rows.values()
    )
    assert high < low_other or high_other < low


@pytest.mark.parametrize("ending", ["svg", "dxf"])
def test_the_command_line_writes_a_net_in_millimetres(tmp_path, ending):
    if ending == "dxf":
        pytest.importorskip("ezdxf")
    target = tmp_path / f"net.{ending}"
    asked = ["--set", "files=nets", "--set", "tab=5", "-o", str(target)]
    assert main(["build", "polyhedron", str(FOLDER / "house.json"), *asked]) == 0
    text = target.read_text()
    if ending == "svg":
        width = float(re.search(r'width="([0-9.]+)mm"', text)[1])
        box = [float(value) for value in re.search(r'viewBox="([^"]+)"', text)[1].split()]
        assert width == pytest.approx(box[2], rel=1e-6)
        assert text.count("tabs") >= 4
    else:
        assert "LINE" in text
