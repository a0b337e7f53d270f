"""The whole modeler without a window: ink files in; report, curves and documents out."""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bozzetto.cli.main import main
from bozzetto.exchange.ink import ink_json
from bozzetto.ink import Drawing, Stroke, Strokes
from bozzetto.plugin import Job
from bozzetto.plugin.host.registry import Registry
from bozzetto.workbench.workbench import Workbench
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry import scenes as s

ROOT = Path(__file__).parents[3]
BOX = {"box": {"center": [0, 0, 0], "size": [200, 100, 100]}}


def stroke(curve: np.ndarray, view, group: str, **hand) -> Stroke:
    pixels = s.drawn(curve, view, **hand)
    return Stroke(pixels[:, 0], pixels[:, 1], view, group=group)


@pytest.fixture(scope="module")
def drawing() -> Drawing:
    """A pair, a curve across, one in the plane and a side alone; the last from elsewhere."""
    view, aside = s.camera(35, 20), s.camera(25, 25)
    side = s.PAIRS["S-wave"]
    strokes = [
        stroke(side, view, "wave"),
        stroke(s.ACROSS["windscreen base"], view, "screen"),
        stroke(side * MIRROR, view, "wave", sense=-1),
        stroke(s.FLAT["roof line"], view, "roof"),
        stroke(s.PAIRS["roof rail"], aside, "rail"),
    ]
    facts = BOX | {"readings": {"roof": "plane"}}
    return Drawing(Strokes(strokes), view, "all", facts)


@pytest.fixture(scope="module")
def bench() -> Workbench:
    return Workbench(Registry())


@pytest.fixture(scope="module")
def report(bench: Workbench, drawing: Drawing) -> dict[str, Any]:
    model = bench.sources.from_drawing("bozzetto.symmetry", drawing, {})
    return json.loads(json.dumps(bench.report(model, Job()), allow_nan=False))


def told(report: dict[str, Any], name: str) -> dict[str, Any]:
    (found,) = (curve for curve in report["curves"] if curve["id"] == name)
    return found


def test_every_reading_is_found(report: dict[str, Any]) -> None:
    readings = {curve["id"]: curve["reading"] for curve in report["curves"]}
    assert readings == {"wave": "pair", "screen": "self", "roof": "plane", "rail": "half"}


@pytest.mark.parametrize(
    ("name", "truth", "worst"),
    [
        ("wave", s.PAIRS["S-wave"], 0.003),
        ("screen", s.ACROSS["windscreen base"], 0.01),  # known least where it crosses the plane
        ("roof", s.FLAT["roof line"], 0.003),
    ],
)
def test_points_lie_on_what_was_drawn(report, name: str, truth: np.ndarray, worst: float) -> None:
    curve = told(report, name)
    points, sigma = np.array(curve["points"]), np.array(curve["sigma"])
    assert points.shape == (len(sigma), 3)
    assert (sigma > 0).all()
    errors = s.distances(points, truth)
    assert np.median(errors) < 5e-4 * s.DIAGONAL
    assert np.quantile(errors, 0.95) < worst * s.DIAGONAL


def test_points_lie_on_the_spline_that_is_told(report) -> None:
    from scipy.interpolate import BSpline

    for name in ("wave", "screen", "roof"):
        curve = told(report, name)
        knots, controls = np.array(curve["knots"]), np.array(curve["control_points"])
        spline = BSpline(knots, controls, curve["degree"])
        at = np.linspace(knots[3], knots[-4], 20_000)
        gap = np.linalg.norm(np.diff(spline(at), axis=0), axis=1).max()
        assert s.distances(np.array(curve["points"]), spline(at)).max() < gap


def test_the_mirror_is_exact(report) -> None:
    pair, screen, roof = (told(report, name) for name in ("wave", "screen", "roof"))
    mirrored = np.array(pair["mirrored_control_points"])
    assert (mirrored == np.array(pair["control_points"]) * MIRROR).all()
    whole, knots = np.array(screen["control_points"]), np.array(screen["knots"])
    assert (whole[::-1] * MIRROR == whole).all()
    assert (knots + knots[::-1] == knots[0] + knots[-1]).all()
    assert (np.array(roof["control_points"])[:, 1] == 0.0).all()


def test_a_side_alone_hands_over_nothing_and_says_so(report) -> None:
    rail = told(report, "rail")
    assert rail["points"] == rail["knots"] == rail["control_points"] == []


def test_shapes_are_the_curves_of_the_report(bench, drawing, report) -> None:
    model = bench.sources.from_drawing("bozzetto.symmetry", drawing, {})
    shapes = bench.shapes([model], Job())
    assert [curve.name for curve in shapes.curves] == ["wave", "wave mirrored", "screen", "roof"]
    first, image = shapes.curves[:2]
    assert first.control_points.tolist() == told(report, "wave")["control_points"]
    assert (image.control_points == first.control_points * MIRROR).all()


@pytest.mark.parametrize("ending", ["step", "iges", "svg", "bozz"])
def test_the_command_line_writes_every_format(drawing, tmp_path, ending: str) -> None:
    (tmp_path / "ink.json").write_bytes(ink_json.write_drawing(drawing))
    target = tmp_path / f"curves.{ending}"
    words = ["build", "symmetry", tmp_path / "ink.json", "-o", target, "--report", tmp_path / "r"]
    assert main([str(word) for word in words]) == 0
    assert target.stat().st_size > 500
    assert len(json.loads((tmp_path / "r").read_text())["curves"]) == 4


def test_any_plane_gives_the_same_curves_turned(bench, report) -> None:
    """What is drawn of a world on its side is the same curve, on its side."""
    turn = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]).T
    side = s.PAIRS["S-wave"]
    view = s.camera(35, 20)
    eye, up = turn @ np.asarray(view.eye), turn @ (0.0, 0.0, 1.0)
    turned = replace(view, eye=tuple(eye), up=tuple(up))
    strokes = [stroke(curve @ turn.T, turned, "wave") for curve in (side, side * MIRROR)]
    normal = (turn @ (0.0, 1.0, 0.0)).tolist()
    facts = {"box": [200, 200, 200], "plane": {"point": [0, 0, 0], "normal": normal}}
    model = bench.sources.from_drawing(
        "bozzetto.symmetry", Drawing(Strokes(strokes), turned, "t", facts), {}
    )
    (curve,) = bench.report(model, Job())["curves"]
    errors = s.distances(np.array(curve["points"]) @ turn, side)
    assert np.median(errors) < 5e-4 * s.DIAGONAL
    points, image = (np.array(curve[k]) for k in ("control_points", "mirrored_control_points"))
    assert np.abs(image - (points - 2.0 * (points @ normal)[:, None] * normal)).max() < 1e-12


def test_the_first_curve_imports_nothing_that_was_not_there_before_the_pen() -> None:
    """An import holds up the whole window; in a process of its own, where nothing is imported."""
    code = """
import sys
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Ink, Job
from bozzetto_symmetry.modeler import Symmetry
from tests.plugins.symmetry import scenes as s

known = [name for name in sys.modules if name.startswith("scipy")]
for name in known:
    del sys.modules[name]
modeler, view = Symmetry(), s.camera(35, 20)
state = modeler.create(Context(camera=view))
modeler.view_advice(state, view, Job())
before = set(sys.modules)
tool, rail = modeler.tools()[0], s.PAIRS["roof rail"]
for curve in (rail, rail * (1.0, -1.0, 1.0), s.ACROSS["hood U"]):
    x, y = view.project(curve)[0].T
    state = tool.apply(state, Ink((Stroke(x, y, view),)), Context(camera=view))
    modeler.scene(state, modeler.solve(state, Job()))
late = sorted({name.split(".", 2)[1] for name in set(sys.modules) - before if "scipy." in name})
assert not late, late
"""
    made = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT)
    assert made.returncode == 0, made.stderr
