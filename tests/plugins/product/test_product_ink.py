"""Products from ink files: a template, strokes, and the steps in which they were used."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bozzetto.arrays import Array
from bozzetto.document import Model
from bozzetto.errors import UserError
from bozzetto.exchange.import_file import read_drawing
from bozzetto.ink import Drawing, Strokes, distances_to_polyline
from bozzetto.ink.steps import CommandStep, SelectStep
from bozzetto.plugin import Context
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.job import Job
from bozzetto.scene import Scene
from bozzetto.testing import Pen, Shell, same
from bozzetto.workbench.play_steps import run_steps
from bozzetto.workbench.workbench import Workbench
from bozzetto_product.commands.all_commands import all_commands
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.rough_shapes import RoughShape
from bozzetto_product.model.state import ProductState
from bozzetto_product.modeler import ProductModeler
from bozzetto_product.report import report_of
from bozzetto_product.rough_shapes.shapes import SIZES
from bozzetto_product.solve.result import ProductResult
from tests.plugins.product.pen_strokes import FRONT, TOP_EDGES, draw_rectangle, straight

PEN = Pen(tremor=0.4, seed=2024, camera=FRONT)
GALLERY = Path(__file__).parents[3] / "docs" / "gallery" / "product"

BOX = {"kind": "box", "length": 120, "width": 80, "height": 60}
RECTANGLE = [{"tool": "draw", "strokes": [n]} for n in range(4)]
"""The four edges of a rectangle on the top of the box."""

EDGE = RECTANGLE[:1]

CAMERA = {
    "kind": FRONT.kind, "eye": FRONT.eye, "target": FRONT.target, "up": FRONT.up,
    "fov_y": FRONT.fov_y,
}  # fmt: skip


def stroke(points: Array, **facts: Any) -> dict[str, Any]:
    made = PEN.along(FRONT.project(points)[0])
    return {"x": made.x.tolist(), "y": made.y.tolist(), **facts}


def seen_at(x: float, y: float, z: float) -> list[float]:
    return FRONT.project(np.array([(x, y, z)]))[0][0].tolist()


def file_of(folder: Path, strokes: Sequence[dict], steps: Sequence[dict], template: Any) -> Path:
    width, height = FRONT.viewport
    record = {
        "format": "bozzetto-ink/1",
        "canvas": {"width": width, "height": height},
        "camera": CAMERA,
        "template": template,
        "strokes": strokes,
        "steps": steps,
    }
    path = folder / "ink.json"
    path.write_text(json.dumps(record), "utf-8")
    return path


def built(
    folder: Path, steps: Sequence[dict], more: Sequence[dict] = (), template: Any = BOX
) -> tuple[Workbench, Model]:
    edges = [stroke(straight(start, end)) for start, end in TOP_EDGES]
    bench = Workbench(Registry())
    drawing = read_drawing(file_of(folder, [*edges, *more], steps, template))
    return bench, bench.sources.from_drawing("bozzetto.product", drawing, {})


def test_a_file_makes_what_the_pen_makes(tmp_path: Path) -> None:
    bench, model = built(tmp_path, RECTANGLE)
    shell = Shell(Registry(), tmp_path)
    shell.open("bozzetto.product")
    draw_rectangle(shell, PEN)
    theirs, ours = (state.of_kind(Curve) for state in (shell.state, model.state))
    assert [len(p.boundary) for p in model.state.of_kind(Patch)] == [4]
    assert len(model.state.joints) == len(shell.state.joints) == 4
    for one, other in zip(theirs, ours, strict=True):
        assert np.allclose(one.spline.control_points, other.spline.control_points, atol=1e-4)
    assert bench.shapes((model,), Job()).surfaces


def test_templates_are_as_large_as_such_things_are(tmp_path: Path) -> None:
    _, model = built(tmp_path, [{"set": {"controls": 9}}], template=list(SIZES))
    for part, (kind, size) in zip(model.state.of_kind(RoughShape), SIZES.items(), strict=True):
        assert (part.kind, (part.length, part.width, part.height)) == (kind, size)
        assert part.centre[2] == 0.5 * size[2]


def test_tools_and_facts_of_parts_are_steps(tmp_path: Path) -> None:
    bow = straight(*TOP_EDGES[0])
    bow[:, 1] -= 6.0 * np.sin(np.linspace(0.0, np.pi, len(bow)))
    across = straight((10.0, -28.0, 60.0), (10.0, 29.0, 60.0))
    more = [stroke(bow), stroke(across), stroke(straight((0, 0, 60), (-8, 0, 60)))]
    steps = [
        {"set": {"controls": 9}},
        *RECTANGLE,
        {"rename": "Back"},
        {"set": {"color": [200, 40, 20], "edge": "crease"}},
        {"tool": "modify", "strokes": [4]},
        {"tool": "draw", "strokes": [5]},
        {"rename": "Across"},
        {"tool": "loop", "tap": seen_at(30.0, 3.0, 60.0)},
        {"command": "hide-rough"},
        {"tool": "move", "tap": seen_at(-30.0, 3.0, 60.0)},
        {"set": {"color": [10, 20, 30], "finish": "glass", "pressure": 0.1}},
        {"select": "Across"},
        {"tool": "move", "drag": "", "stroke": 6},
    ]
    _, plain = built(tmp_path, steps[:-1], more)
    ids = {j.id for j in plain.state.joints for m in j.meetings if 0.0 < m.at < 1.0}
    steps[-1]["drag"] = f"joint {sorted(ids)[0]}"
    _, model = built(tmp_path, steps, more)
    curves = {curve.name: curve for curve in model.state.of_kind(Curve)}
    assert curves["Back"].color == (200, 40, 20)
    assert curves["Back"].edge == "crease"
    image = FRONT.project(plain.state.of_kind(Curve)[0].spline.sampled(200))[0]
    assert distances_to_polyline(FRONT.project(bow)[0], image).max() < 4.0
    (patch,) = model.state.of_kind(Patch)  # the right one of the two was switched off
    assert (patch.color, patch.finish, patch.pressure) == ((10, 20, 30), "glass", 0.1)
    assert len(model.state.rejected) == 1
    before = next(c for c in plain.state.of_kind(Curve) if c.name == "Across")
    moved = curves["Across"].spline.control_points - before.spline.control_points
    assert np.abs(moved).max() > 2.0


REFUSED = {"join-wider", "trim", "add", "forget-pulls", "split-creases"}
"""Commands that have nothing to do on a rectangle that is joined, and say so."""

UNCHANGED = {"edge-auto", "find-surfaces", "straighten"}


@pytest.fixture(scope="module")
def rectangle(tmp_path_factory: pytest.TempPathFactory) -> tuple[Workbench, Model]:
    """Four edges that were drawn, and their surface."""
    return built(tmp_path_factory.mktemp("rectangle"), RECTANGLE)


@pytest.mark.parametrize("command", [command.id for command in all_commands()])
def test_every_command_is_a_step(rectangle: tuple[Workbench, Model], command: str) -> None:
    """It does something, or says why it cannot, with the number of the step."""
    bench, before = rectangle
    chosen = {"delete-surface": "Surface 1"}.get(command, "Curve 1")
    steps = (SelectStep(chosen), CommandStep(command))
    drawing = Drawing(Strokes(), FRONT, steps=steps)
    if command in REFUSED:
        with pytest.raises(UserError, match=r"^Step 2: .{30}"):
            run_steps(bench, before, drawing, Context())
        return
    after = run_steps(bench, before, drawing, Context())
    unchosen = [replace(model.state, selected="") for model in (before, after)]
    assert not same(*unchosen) or command in UNCHANGED


@pytest.mark.parametrize(
    ("template", "steps", "words"),
    [
        ("teapot", (), "template[0].kind"),
        ([BOX, {"kind": "box", "size": 3}], (), "template[1]"),
        ({"kind": "box", "length": -3}, (), "template[0].length"),
        ({"kind": "box", "centre": [0, 0]}, (), "template[0].centre"),
        (7, (), "template[0]"),
        (BOX, [{"tool": "pencil", "strokes": [0]}], "Step 1"),
        (BOX, [*EDGE, {"tool": "draw", "strokes": [9]}], "step 2"),
        (BOX, [*EDGE, {"set": {"edge": "velvet"}, "part": "Curve 1"}], "Step 2"),
        (BOX, [*EDGE, {"set": {"colour": [1, 2, 3]}, "part": "Curve 1"}], "Step 2"),
        (BOX, [*EDGE, {"select": "Curve 17"}], "Step 2"),
        (BOX, [*EDGE, {"command": "polish"}], "Step 2"),
        (BOX, [{"tool": "modify", "strokes": [0]}], "Step 1"),
        (BOX, [*EDGE, {"tool": "loop", "tap": [3.0, 3.0]}], "Step 2"),
        (BOX, [*EDGE, {"tool": "move", "tap": [3.0, 3.0]}], "Step 2"),
        (BOX, [*EDGE, {"tool": "move", "drag": "joint 99", "stroke": 0}], "Step 2"),
        (BOX, [*EDGE, {"tool": "draw", "strokes": [0], "curve": "a"}], "step 2"),
    ],
)
def test_what_makes_no_sense_is_refused_by_name(
    tmp_path: Path, template: Any, steps: Sequence[dict], words: str
) -> None:
    with pytest.raises(UserError) as refused:
        built(tmp_path, steps, template=template)
    assert words in refused.value.message


def test_what_is_drawn_over_an_early_surface_lies_on_the_rough_shape(tmp_path: Path) -> None:
    """A surface that came too soon bulges before the rough shape; the next curve is beneath it."""
    steps = [
        *RECTANGLE,
        {"set": {"pressure": 0.5}, "part": "Surface 1"},
        {"tool": "draw", "strokes": [4]},
    ]
    across = [stroke(straight((-48.0, 3.0, 60.0), (48.0, 3.0, 60.0)))]
    _, model = built(tmp_path, steps, across)
    heights = model.state.of_kind(Curve)[-1].spline.sampled(50)[:, 2]
    assert np.abs(heights - 60.0).max() < 0.5
    steps.insert(-1, {"command": "hide-rough"})
    _, model = built(tmp_path, steps, across)
    assert model.state.of_kind(Curve)[-1].spline.sampled(50)[:, 2].max() > 65.0


def test_a_file_makes_the_same_whether_shapes_are_solved_at_once_or_put_off(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What a gesture never looks at cannot matter to it: on the box, over its rim, on surfaces."""
    lines = (
        straight((10.0, -28.0, 60.0), (10.0, 29.0, 60.0)),
        straight((-20.0, 5.0, 60.0), (-20.0, 90.0, 60.0)),
        straight((-30.0, -10.0, 60.0), (0.0, 10.0, 60.0)),
        straight((90.0, 0.0, 0.0), (90.0, 0.0, 60.0)),
    )
    more = [stroke(line) for line in lines]
    draws = [{"tool": "draw", "strokes": [n]} for n in range(4, 8)]
    pressed = [{"select": "Surface 1"}, {"set": {"pressure": 0.4}}]
    steps = [*RECTANGLE, *pressed, *draws[:2], {"command": "hide-rough"}, *draws[2:]]
    solves: list[ProductState] = []
    solve = ProductModeler.solve

    def counting(self: ProductModeler, state: ProductState, job: Job) -> ProductResult:
        solves.append(state)
        return solve(self, state, job)

    monkeypatch.setattr(ProductModeler, "solve", counting)
    _, put_off = built(tmp_path, steps, more)
    late = len(solves)
    monkeypatch.setattr(Scene, "put_off", lambda make: make())
    _, at_once = built(tmp_path, steps, more)
    assert same(put_off.state, at_once.state)
    assert late == 3, "where most of the ink is beside the box, and with the box hidden"
    assert len(solves) - late > 8


def test_a_stroke_along_the_plane_lies_in_it(tmp_path: Path) -> None:
    steps = [{"set": {"mirror": True}}, {"tool": "draw", "strokes": [4]}]
    along = straight((-50.0, 0.0, 60.0), (50.0, 0.0, 60.0))
    along[:, 1] += 0.5 * np.sin(np.linspace(0.0, 6.0, len(along)))
    _, model = built(tmp_path, steps, [stroke(along)])
    (curve,) = model.state.of_kind(Curve)
    assert not curve.mirrored
    assert (curve.spline.control_points[:, 1] == 0.0).all()


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(GALLERY.glob("*.json")), ids=lambda path: path.stem)
def test_products_of_the_gallery_close(path: Path) -> None:
    bench = Workbench(Registry())
    model = bench.sources.from_drawing("bozzetto.product", read_drawing(path), {})
    told = report_of(model.state, bench.solve(model, Job()), Job())
    assert told["closed"], told["open_edges"]
    assert told["warnings"] == []
    shapes = bench.shapes((model,), Job())
    assert shapes.solids
    assert not shapes.surfaces
