"""The gallery: ink of both sides is read as it was meant, opens as a document, goes to CAD."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from bozzetto.cli.main import main
from bozzetto.document.storage.bozz_file import read_document
from bozzetto.exchange.import_file import read_drawing
from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.job import Job
from bozzetto.testing import same
from bozzetto.workbench.workbench import Workbench
from bozzetto_symmetry.solve.curve_solver import Trace
from bozzetto_symmetry.view import view_advice

FOLDER = Path(__file__).parents[3] / "docs" / "gallery" / "symmetry"
INKS = sorted(FOLDER.glob("*.json"))

IN_PLANE = {
    "mouse": {"Spine", "Cable"},
    "vacuum-cleaner": {"Spine", "Hose front", "Hose back"},
    "car-lines": {"Bonnet", "Roof", "Tail"},
}
ACROSS = {
    "mouse": {
        "Base", "Seam", "Button line", "Palm arch", "Front lip", "Wheel slot", "Cable sleeve",
    },
    "vacuum-cleaner": {
        "Bumper", "Base", "Front arch", "Back arch", "Lid", "Socket",
        *(f"Hose ring {number}" for number in range(1, 6)),
    },
    "car-lines": {
        "Windscreen base", "Windscreen top", "Rear window top", "Rear window base", "Bonnet lip",
        "Bumper", "Front lip", "Grille", "Spoiler", "Rear bumper", "Diffuser",
    },
}  # fmt: skip
"""All others were drawn left and right."""

WHEELS = {
    "mouse": {"Wheel": (31.0, 3.4, 24.4, 9.6)},
    "vacuum-cleaner": {"Wheel": (-98.0, 134.0, 94.0, 92.0), "Rim": (-98.0, 140.0, 94.0, 62.0)},
    "car-lines": {
        "Front wheel": (1330.0, 870.0, 338.0, 338.0),
        "Rear wheel": (-1320.0, 870.0, 338.0, 338.0),
    },
}
"""Middle and radius, mm, of what is round."""


def meant(name: str, curve: str) -> str:
    if curve in IN_PLANE[name]:
        return "plane"
    return "self" if curve in ACROSS[name] else "pair"


def test_there_are_three() -> None:
    assert {path.stem for path in INKS} == {"mouse", "vacuum-cleaner", "car-lines"}


def test_advice_on_a_drawing_that_was_just_opened_solves_only_its_newest_curves(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    bench, drawing = Workbench(Registry()), read_drawing(FOLDER / "car-lines.json")
    model = bench.sources.from_drawing("bozzetto.symmetry", drawing, {})
    asked = []

    def counted(curve, state):
        asked.append(curve.name)
        return Trace("half")

    monkeypatch.setattr(view_advice, "trace_of", counted)
    assert bench.view_advice(model, drawing.camera) is not None
    assert asked == [curve.name for curve in model.state.curves][-view_advice.NEWEST :]


@pytest.fixture(scope="module", params=INKS, ids=lambda path: path.stem)
def built(request: pytest.FixtureRequest) -> tuple[Path, Workbench, dict]:
    """An ink file of the gallery, and what the report tells of every curve in it."""
    bench = Workbench(Registry())
    model = bench.sources.from_drawing("bozzetto.symmetry", read_drawing(request.param), {})
    told = bench.report(model, Job())["curves"]
    return request.param, bench, {curve["name"]: curve for curve in told}


@pytest.mark.slow
def test_every_curve_is_read_as_it_was_meant(built) -> None:
    path, _, curves = built
    readings = {name: told["reading"] for name, told in curves.items()}
    assert readings == {name: meant(path.stem, name) for name in curves}
    assert ACROSS[path.stem] | IN_PLANE[path.stem] < set(curves)
    assert min(told["margin"] for told in curves.values()) > 1.2


@pytest.mark.slow
def test_every_curve_is_known_well(built) -> None:
    path, _, curves = built
    box = read_drawing(path).facts["box"]["size"]
    for told in curves.values():
        assert np.median(told["sigma"]) < 0.01 * np.linalg.norm(box)
        assert told["rms"] < 1.0


@pytest.mark.slow
def test_what_is_round_is_round_and_stands_upright(built) -> None:
    path, _, curves = built
    diagonal = np.linalg.norm(read_drawing(path).facts["box"]["size"])
    for name, (x, y, z, radius) in WHEELS[path.stem].items():
        points = np.array(curves[name]["points"]) - (x, y, z)
        off = np.hypot(np.hypot(points[:, 0], points[:, 2]) - radius, points[:, 1])
        assert np.median(off) < 0.003 * diagonal
        assert off.max() < 0.01 * diagonal


@pytest.mark.slow
def test_the_command_of_the_readme_does_what_it_says(tmp_path: Path, monkeypatch) -> None:
    root = FOLDER.parents[2]
    line = next(
        line for line in (root / "README.md").read_text().splitlines() if "build symmetry" in line
    )
    words = line.split(" run ")[1].split()
    monkeypatch.chdir(tmp_path)
    assert main([str(root / word) if word.endswith(".json") else word for word in words]) == 0
    assert (tmp_path / words[-1]).stat().st_size > 10_000


@pytest.mark.slow
def test_ink_becomes_a_document_and_curves_for_cad(built, tmp_path: Path) -> None:
    path, bench, curves = built
    for ending in ("bozz", "step"):
        target = str(tmp_path / f"x.{ending}")
        assert main(["build", "symmetry", str(path), "-o", target]) == 0
    opened, report = read_document(tmp_path / "x.bozz", bench.registry)
    assert not report.warnings
    model = bench.sources.from_drawing("bozzetto.symmetry", read_drawing(path), {})
    assert same(opened.models[0].state, model.state)
    pairs = sum(told["reading"] == "pair" for told in curves.values())
    text = (tmp_path / "x.step").read_text()
    assert text.count("B_SPLINE_CURVE_WITH_KNOTS") == len(curves) + pairs
