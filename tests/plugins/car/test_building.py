"""From a file of marks to STEP and a report, by the command line, and what the report says."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.cli.main import main
from bozzetto_car.template.loader import bundled
from bozzetto_car.template.model import twin
from tests.core.exchange.test_curve_interop import ask, messages
from tests.core.exchange.test_surfaces import OPENCASCADE, Shells
from tests.plugins.car.drawn_cars import Drawn, drawn
from tests.plugins.car.sketched import FRONT_QUARTER, REAR_QUARTER, rms

Array = NDArray[np.float64]

FACES = {"sedan": 28, "hatchback": 30, "minivan": 30}

SURFACES = ("--set", "wheels=false")
"""What is looked at here are the surfaces; wheels are seen, and so would be in the file."""


def built(
    folder: Path, file: dict[str, Any], ending: str = "step", more: Sequence[str] = ()
) -> dict[str, Any]:
    """What is told of a car; the car lies beside as ``car.<ending>``."""
    (folder / "marks.json").write_text(json.dumps(file), "utf-8")
    code = main(
        ["build", "car", str(folder / "marks.json"), "-o", str(folder / f"car.{ending}"),
         "--report", str(folder / "r.json"), *more]
    )  # fmt: skip
    assert code == 0
    told: dict[str, Any] = json.loads((folder / "r.json").read_text("utf-8"))
    return told


def car(name: str, seed: int) -> Drawn:
    return drawn(bundled(name), seed, (FRONT_QUARTER, REAR_QUARTER))


def seen(view: dict[str, Any], place: list[float]) -> Array:
    """Where the reported matrix has a point, px."""
    x, y, w = np.array(view["camera"]["matrix"]) @ [*place, 1.0]
    return np.array([x / w, y / w])


@pytest.mark.parametrize("name", FACES)
def test_a_report_agrees_with_itself_and_with_the_marks(tmp_path: Path, name: str) -> None:
    file = car(name, 5).marks_file()
    for view in file["views"]:
        del view["strokes"]  # they take nodes along
    told = built(tmp_path, file)
    nodes, template = told["nodes"], bundled(name)
    assert set(nodes) == set(template.names)
    for view, given in zip(told["views"], file["views"], strict=True):
        assert set(view["residual_px"]) == set(given["marks"])
        assert set(view["leave_one_out_px"]) == set(given["marks"])
        for node, mark in given["marks"].items():
            off = float(np.linalg.norm(seen(view, nodes[node]) - mark))
            assert view["residual_px"][node] == pytest.approx(off, abs=1e-6)
        assert rms(np.array(list(view["residual_px"].values()))) < 4.0
        assert all(
            view["leave_one_out_px"][node] >= px - 1e-6 for node, px in view["residual_px"].items()
        )
    assert all(slack >= -1e-9 for slack in told["constraints"].values())
    for node, (x, y, z) in nodes.items():
        other = nodes[twin(node)]
        assert [x, -y, z] == other if node != twin(node) else y == 0.0
    front, rear = nodes["WF.R"][0], nodes["WR.R"][0]
    assert told["dimensions"]["WB"] == pytest.approx(rear - front, abs=1e-9)
    assert told["warnings"] == []


@pytest.mark.parametrize("name", FACES)
def test_a_step_file_holds_the_patches_of_the_report(tmp_path: Path, name: str) -> None:
    told = built(tmp_path, car(name, 2).marks_file(), more=SURFACES)
    ((title, ((kind, faces),)),) = Shells((tmp_path / "car.step").read_bytes()).models
    assert (kind, len(faces), title) == ("OPEN_SHELL", FACES[name], bundled(name).title)
    assert len(told["crease_deg"]) == len(bundled(name).edges) - 12


def test_typed_dimensions_are_those_of_the_handed_over_surface(tmp_path: Path) -> None:
    wanted = {"LN": 4520.0, "WD": 1810.5, "HG": 1390.0, "FO": 861.25, "WB": 2655.0}
    told = built(tmp_path, car("sedan", 3).marks_file() | {"dimensions": wanted}, more=SURFACES)
    for name, value in wanted.items():
        assert told["dimensions"][name] == pytest.approx(value, abs=1e-6)
    places = np.array([place for face in step_points(tmp_path / "car.step") for place in face])
    low, high = places.min(axis=0), places.max(axis=0)
    # Fine samples of the very surface: its box is no smaller than theirs, and hardly larger.
    assert high[0] - low[0] == pytest.approx(4520.0, abs=0.01)
    assert high[1] - low[1] == pytest.approx(1810.5, abs=0.01)
    assert high[2] == pytest.approx(1390.0, abs=0.01)
    assert told["nodes"]["WF.L"][0] - low[0] == pytest.approx(861.25, abs=0.01)


def step_points(path: Path) -> list[Array]:
    """Places on the surfaces of a STEP file, from its own control points, 200 × 200 each."""
    at = np.linspace(0.0, 1.0, 200)
    powers = np.array([[1, -3, 3, -1], [0, 3, -6, 3], [0, 0, 3, -3], [0, 0, 0, 1]])
    weights = np.vander(at, 4, increasing=True) @ powers.T
    ((_, ((_, faces),)),) = Shells(path.read_bytes()).models
    return [
        np.einsum("ui,vj,ijx->uvx", weights, weights, np.array(face.net)).reshape(-1, 3)
        for face in faces
    ]


def test_styling_curves_stand_in_the_step_file(tmp_path: Path) -> None:
    file = car("hatchback", 1)
    points = file.places()[[file.template.node[n] for n in ("S2.R", "S3.R")]] + [0.0, 25.0]
    way = np.linspace(points[0], points[1], 30).tolist()
    built(tmp_path, file.marks_file() | {"styling": [{"view": 0, "points": way, "name": "Swage"}]})
    assert b"Swage" in (tmp_path / "car.step").read_bytes()


def test_what_is_set_and_changes_nothing_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    view = {"image": {"width": 1200, "height": 800}, "marks": {"C1": [100.0, 500.0]}}
    bare = ["--allow-template", "--set", "share=0.3"]
    built(tmp_path, {"views": [view]}, more=bare)
    assert "“Share” changes nothing while “Blend with” is “Nothing”." in capsys.readouterr().err
    built(tmp_path, {"views": [view]}, more=[*bare, "--set", "blend=coupe"])
    assert "changes nothing" not in capsys.readouterr().err


def test_a_car_without_marks_enough_says_what_is_missing(tmp_path: Path) -> None:
    file = car("sedan", 4).marks_file()
    for view in file["views"]:
        view["marks"] = dict(list(view["marks"].items())[:5])
        view["strokes"] = {}
    (tmp_path / "few.json").write_text(json.dumps(file), "utf-8")
    assert main(["build", "car", str(tmp_path / "few.json"), "-o", str(tmp_path / "x.step")]) == 2
    assert not (tmp_path / "x.step").exists()
    told = built(tmp_path, file, more=["--allow-template"])
    assert any("6" in warning or "six" in warning for warning in told["warnings"])
    assert told["nodes"]["C4"] == pytest.approx(bundled("sedan").positions[4])


def test_a_file_without_marks_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "m.json").write_text('{"template": "sedan"}')
    assert main(["build", "car", str(tmp_path / "m.json"), "-o", str(tmp_path / "x.step")]) != 0
    assert "views" in capsys.readouterr().err
    assert not (tmp_path / "x.step").exists()


@pytest.mark.interop
@pytest.mark.parametrize("name", FACES)
@pytest.mark.parametrize("ending", ["step", "iges"])
def test_opencascade_reads_a_built_car_without_a_message(
    tmp_path: Path, name: str, ending: str
) -> None:
    one = car(name, 7)
    places = one.places()[[one.template.node[n] for n in ("B3.R", "S3.R", "R2.R")]] + (40.0, 0.0)
    seam = {"view": 0, "name": "Seam, over a crease", "points": places.tolist()}
    told = built(tmp_path, one.marks_file() | {"styling": [seam]}, ending, SURFACES)
    said, answer = ask(OPENCASCADE, tmp_path / f"car.{ending}")
    assert messages(said) == []
    assert answer["valid"]
    assert (len(answer["faces"]), answer["free"]) == (FACES[name], 12)
    corners = np.array(answer["faces"])[:, [0, 6, 42, 48]].reshape(-1, 3)
    body = [place for node, place in told["nodes"].items() if node[0] != "W"]
    for place in body:
        assert np.abs(corners - place).max(axis=1).min() <= 1e-9
