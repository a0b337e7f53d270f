"""Products drawn on other objects by a file or a command: linked, as in the window."""

from __future__ import annotations

import itertools
import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bozzetto.cli.main import main
from bozzetto.document import Document, Model, edit
from bozzetto.document.links import resolved
from bozzetto.document.storage.bozz_file import read_document, write_document
from bozzetto.errors import UserError
from bozzetto.exchange.import_file import read_drawing
from bozzetto.geometry import closest_on_mesh
from bozzetto.ink import Stroke
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.job import Job
from bozzetto.testing import Shell
from bozzetto.workbench.workbench import Workbench
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.rough_shapes import FollowedShape
from tests.plugins.product.pen_strokes import FRONT
from tests.plugins.product.test_followed_by_pen import BOWS, CORNERS, PEN

TURN = np.linspace(0.0, 2.0 * np.pi, 120)
LENS = [(float(600 + 220 * np.cos(a)), float(455 + 120 * np.sin(a))) for a in TURN]
SIDES = [
    PEN.along([a, bow, b])
    for (a, b), bow in zip(itertools.pairwise((*CORNERS, CORNERS[0])), BOWS, strict=True)
]
STEPS = [{"tool": "draw", "strokes": [number]} for number in range(4)]
LINK = {"drawing": {"file": "lens.json"}}


def ink(path: Path, strokes: list[Stroke], **facts: Any) -> Path:
    width, height = FRONT.viewport
    record = {
        "format": "bozzetto-ink/1",
        "canvas": {"width": width, "height": height},
        "camera": {
            "kind": FRONT.kind, "eye": FRONT.eye, "target": FRONT.target, "up": FRONT.up,
            "fov_y": FRONT.fov_y,
        },
        "strokes": [{"x": one.x.tolist(), "y": one.y.tolist()} for one in strokes],
        **facts,
    }  # fmt: skip
    path.write_text(json.dumps(record), "utf-8")
    return path


def lens(folder: Path, **facts: Any) -> Path:
    return ink(folder / "lens.json", [PEN.along(LENS)], **facts)


@pytest.fixture
def on_file(tmp_path: Path) -> Path:
    """An ink file of four sides on a lens, which it names."""
    lens(tmp_path, modeler="silhouette")
    return ink(tmp_path / "cap.json", SIDES, steps=STEPS, on=LINK)


@pytest.fixture
def document(tmp_path: Path) -> Path:
    """A document with the lens and an object beside it."""
    bench = Workbench(Registry())
    drawing = read_drawing(ink(tmp_path / "lens 1.json", [PEN.along(LENS)]))
    drawing = replace(drawing, name="lens")
    model = bench.sources.from_drawing("bozzetto.silhouette", drawing, {})
    beside = bench.sources.from_drawing("bozzetto.silhouette", drawing, {"inflation": 0.2})
    made = edit.add_model(edit.add_model(Document(), model).document, beside).document
    write_document(made, tmp_path / "lens.bozz")
    return tmp_path / "lens.bozz"


def build(source: Path, *words: str) -> int:
    return main(["build", "product", str(source), *words])


def opened(path: Path) -> Document:
    return read_document(path, Registry())[0]


def curves_of(model: Model) -> list[np.ndarray]:
    return [curve.spline.control_points for curve in model.state.of_kind(Curve)]


def inflated(bench: Workbench, document: Document, amount: float) -> tuple[Document, Any]:
    """Return the document with its first object inflated, and the mesh of that."""
    thick = bench.set_parameters(document.models[0], {"inflation": amount})
    (solid,) = bench.own_shapes(thick, Job()).solids
    return document.with_model(thick), solid.mesh


def test_a_file_makes_what_the_window_makes(on_file: Path, tmp_path: Path) -> None:
    shell = Shell(Registry(), tmp_path)
    shell.open("bozzetto.silhouette")
    shell.camera = FRONT
    shell.draw(PEN.along(LENS))
    shell.use("bozzetto.product")
    for side in SIDES:
        shell.draw(side, tool="draw")
    drawing = read_drawing(on_file)
    model = Workbench(Registry()).sources.from_drawing("bozzetto.product", drawing, {})
    for ours, theirs in zip(curves_of(model), curves_of(shell.model), strict=True):
        assert np.allclose(ours, theirs, atol=1e-3)
    assert [len(p.boundary) for p in model.state.of_kind(Patch)] == [4]
    laid = [curve.laid is not None for curve in model.state.of_kind(Curve)]
    assert laid == [curve.laid is not None for curve in shell.state.of_kind(Curve)] == [True] * 4


def test_it_follows_when_the_object_is_inflated(on_file: Path) -> None:
    assert build(on_file, "-o", str(on_file.with_name("cap.bozz"))) == 0
    made = opened(on_file.with_name("cap.bozz"))
    assert [model.name for model in made] == ["lens", "cap"]
    assert made.models[1].sources == (made.models[0].id,)
    bench = Workbench(Registry())
    for amount in (0.6, 1.3):
        thick, mesh = inflated(bench, made, amount)
        result = bench.solve(resolved(thick)[made.models[1].id], Job())
        size = float(np.linalg.norm(np.ptp(mesh.bounds, axis=0)))
        for curve in result.curves:
            gaps = closest_on_mesh(mesh, curve.spline.sampled(60)).distances
            assert np.median(gaps) < 0.01 * size
        assert len(result.filled) == 1


def test_on_names_an_object_of_a_document(on_file: Path, document: Path) -> None:
    out = on_file.with_name("both.bozz")
    bare = ink(on_file.with_name("bare.json"), SIDES, steps=STEPS)
    report = on_file.with_name("report.json")
    words = ("--on", f"{document}:lens", "-o", str(out), "--report", str(report))
    assert build(bare, *words) == 0
    before, made = opened(document), opened(out)
    assert [model.name for model in made] == ["lens", "lens 2", "bare"]
    assert made.models[2].sources == (before.models[0].id,)
    assert json.loads(report.read_text())["follows"] == ["lens"]
    (part,) = made.models[2].state.of_kind(FollowedShape)
    assert part.source == before.models[0].id
    drawing = read_drawing(on_file)
    by_file = Workbench(Registry()).sources.from_drawing("bozzetto.product", drawing, {})
    for ours, theirs in zip(curves_of(made.models[2]), curves_of(by_file), strict=True):
        assert np.allclose(ours, theirs, atol=1e-3)


def test_on_takes_the_place_of_what_the_file_names(on_file: Path, document: Path) -> None:
    out = on_file.with_name("both.bozz")
    assert build(on_file, "--on", f"{document}:lens 2", "-o", str(out)) == 0
    made = opened(out)
    assert [model.name for model in made] == ["lens", "lens 2", "cap"]
    assert made.models[2].sources == (made.models[1].id,)


def test_shapes_are_those_of_the_product_alone(on_file: Path, document: Path) -> None:
    whole = on_file.with_name("cap.obj")
    assert build(on_file, "-o", str(whole)) == 0
    onto = on_file.with_name("onto.obj")
    assert build(on_file, "--on", f"{document}:lens", "-o", str(onto)) == 0
    counts = [path.read_text().count("\nf ") for path in (whole, onto)]
    assert counts[0] == counts[1] > 100


def test_strokes_without_steps_are_curves_one_by_one(on_file: Path) -> None:
    bench = Workbench(Registry())
    plain = read_drawing(ink(on_file, SIDES, on=LINK))
    model = bench.sources.from_drawing("bozzetto.product", plain, {})
    assert len(model.state.of_kind(Curve)) == 4
    assert all(curve.laid is not None for curve in model.state.of_kind(Curve))


REFUSED = (
    ({"on": 3}, "no object"),
    ({"on": {"drawing": {"file": "other.json"}}}, "not there"),
    ({"on": {"drawing": {"file": "../lens.json"}}}, "not in the folder"),
    ({"on": {"drawing": "lens.json"}}, "no object"),
    ({"on": {**LINK, "unit": "mm"}}, "has a key “unit”"),
    ({"on": LINK, "template": "box"}, "“template”"),
    ({"on": [LINK] * 17}, "17"),
)


@pytest.mark.parametrize(("facts", "words"), REFUSED)
def test_what_makes_no_sense_is_refused(
    on_file: Path, facts: dict[str, Any], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    out = on_file.with_name("cap.bozz")
    assert build(ink(on_file, SIDES, steps=STEPS, **facts), "-o", str(out)) == 2
    assert words in capsys.readouterr().err
    assert not out.exists()


@pytest.mark.parametrize(
    ("facts", "words"),
    [({}, "does not say"), ({"modeler": "nobody"}, "nobody"), ({"on": LINK}, "does not say")],
)
def test_a_drawing_of_no_modeler_cannot_be_drawn_on(
    on_file: Path, facts: dict[str, Any], words: str
) -> None:
    lens(on_file.parent, **facts)
    with pytest.raises(UserError, match=words):
        Workbench(Registry()).sources.from_drawing("bozzetto.product", read_drawing(on_file), {})


@pytest.mark.parametrize(
    ("name", "words"),
    [(":nobody", "no object nobody"), (".gone", "gone"), ("", "cannot follow")],
)
def test_an_object_that_cannot_be_drawn_on_is_told(
    on_file: Path, document: Path, name: str, words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    modeler = "product" if name else "silhouette"
    out = on_file.with_name("cap.bozz")
    code = main(["build", modeler, str(on_file), "--on", f"{document}{name}", "-o", str(out)])
    assert code == 2
    assert words in capsys.readouterr().err
    assert not out.exists()


def test_the_gallery_helmet_follows_its_head() -> None:
    path = Path(__file__).parents[3] / "docs" / "gallery" / "product" / "helmet.json"
    bench = Workbench(Registry())
    model = bench.sources.from_drawing("bozzetto.product", read_drawing(path), {})
    document = edit.add_model(Document(), model).document
    widths = []
    for amount in (0.84, 1.0):
        wide, _ = inflated(bench, document, amount)
        shapes = bench.own_shapes(resolved(wide)[model.id], Job())
        (solid,) = shapes.solids
        assert solid.exact is not None
        assert solid.exact.is_closed
        widths.append(float(np.ptp(solid.mesh.bounds, axis=0)[1]))
    assert widths[1] > 1.1 * widths[0]
