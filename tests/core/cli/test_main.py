"""The command line, as a person would use it."""

from __future__ import annotations

import json
import math
import re
import struct
import subprocess
import sys
import zipfile
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

import bozzetto_car
from bozzetto.cli.main import main
from bozzetto.errors import UserError
from bozzetto.workbench.workbench import Workbench

SQUARE = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="-10 -10 60 60">'
    '<path d="M0,0 L40,0 L40,30 L0,30 Z"/></svg>'
)
RING = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">'
    '<circle cx="50" cy="50" r="40"/><circle cx="50" cy="50" r="20"/></svg>'
)
EIGHT = (
    '<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 100 100">'
    '<path fill="none" stroke="black" d="M10,10 L90,90 L90,10 L10,90 Z"/></svg>'
)


class Finished(NamedTuple):
    """What a finished command leaves."""

    returncode: int
    stdout: str
    stderr: str


@pytest.fixture
def bozzetto(tmp_path, monkeypatch, capfd):
    """Run a command in an empty folder, in this process: most of a second is saved each time."""
    monkeypatch.chdir(tmp_path)

    def run(*words):
        capfd.readouterr()
        try:
            code = main([str(word) for word in words])
        except SystemExit as end:
            code = end.code
        return Finished(code, *capfd.readouterr())

    return run


def test_why_a_file_is_refused_is_told_where_the_modeler_has_nothing_to_say(
    bozzetto, tmp_path, monkeypatch
):
    asked = []

    def fails_later(self, model, job):
        asked.append(model)
        if len(asked) > 1:
            raise UserError("The modeler is at a loss.")
        return ()

    (tmp_path / "square.svg").write_text(SQUARE)
    plain = bozzetto("build", "silhouette", "square.svg", "-o", "square.igs")
    assert plain.returncode == 2
    assert "exact surfaces" in plain.stderr
    monkeypatch.setattr(Workbench, "cautions", fails_later)
    assert bozzetto("build", "silhouette", "square.svg", "-o", "square.igs") == plain
    assert len(asked) == 2


def test_what_is_not_read_of_a_drawing_is_said(bozzetto, tmp_path):
    text = SQUARE.replace("</svg>", "<text>Front view</text></svg>")
    (tmp_path / "named.svg").write_text(text)
    built = bozzetto("build", "silhouette", "named.svg", "-o", "named.bozz")
    assert built.returncode == 0
    assert "1 text of this drawing is left out" in built.stderr
    facts = json.loads(bozzetto("info", "named.svg", "--json").stdout)
    assert "1 text" in facts["left_out"][0]


@pytest.fixture
def square(tmp_path):
    path = tmp_path / "square.svg"
    path.write_text(SQUARE)
    return path


def read_stl(path: Path) -> np.ndarray:
    """Triangle corners of a binary STL, read by hand; shape (n, 3, 3)."""
    data = path.read_bytes()
    (count,) = struct.unpack_from("<I", data, 80)
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("extra", "<u2")])
    return np.frombuffer(data, record, count, 84)["corners"]


def refused(process) -> str:
    """The one line of an error; fails where there is more, or a traceback."""
    assert process.returncode == 2, process
    lines = process.stderr.strip().splitlines()
    assert len(lines) == 1, process.stderr
    assert lines[0].startswith("error: ")
    return lines[0]


def test_an_svg_point_lies_at_x_0_minus_y(bozzetto, square, tmp_path):
    process = bozzetto("build", "silhouette", square, "-o", "out.stl")
    assert process.returncode == 0, process.stderr
    corners = read_stl(tmp_path / "out.stl").reshape(-1, 3)
    assert corners[:, 0].min() == pytest.approx(0, abs=0.05)
    assert corners[:, 0].max() == pytest.approx(40, abs=0.05)
    assert corners[:, 2].min() == pytest.approx(-30, abs=0.05)
    assert corners[:, 2].max() == pytest.approx(0, abs=0.05)
    assert corners[:, 1].max() == pytest.approx(-corners[:, 1].min(), rel=1e-3)


def test_every_format_is_written_and_described(bozzetto, square, tmp_path):
    for ending in ("stl", "3mf", "glb", "obj", "ply", "bozz"):
        process = bozzetto("build", "silhouette", square, "-o", f"out.{ending}")
        assert process.returncode == 0, process.stderr
        assert (tmp_path / f"out.{ending}").stat().st_size > 500
    facts = json.loads(bozzetto("info", "out.ply", "--json").stdout)
    assert facts["kind"] == "mesh"
    assert facts["parts"] == 1
    assert facts["size_mm"][0] == pytest.approx(40, abs=0.1)
    facts = json.loads(bozzetto("info", "out.bozz", "--json").stdout)
    assert facts["plugins"] == ["bozzetto.silhouette"]
    assert json.loads(bozzetto("info", square, "--json").stdout)["strokes"] == 1


def test_inflation_deepens_and_keeps_the_silhouette(bozzetto, square, tmp_path):
    sizes = {}
    for inflation in ("0.5", "1", "2"):
        process = bozzetto(
            "build", "silhouette", square, "-o", "out.stl", "--set", f"inflation={inflation}"
        )
        assert process.returncode == 0, process.stderr
        sizes[inflation] = np.ptp(read_stl(tmp_path / "out.stl").reshape(-1, 3), axis=0)
    assert sizes["2"][1] == pytest.approx(4 * sizes["0.5"][1], rel=0.03)
    for inflation in sizes:
        assert sizes[inflation][[0, 2]] == pytest.approx(sizes["1"][[0, 2]], rel=2e-3)


def test_a_report_says_how_true_the_shape_is(bozzetto, tmp_path):
    (tmp_path / "ring.svg").write_text(RING)
    process = bozzetto("build", "silhouette", "ring.svg", "-o", "r.stl", "--report", "r.json")
    assert process.returncode == 0, process.stderr
    (part,) = json.loads((tmp_path / "r.json").read_text())["parts"]
    assert part["genus"] == part["expected_genus"] == 1
    assert part["iou"] > 0.99
    assert part["watertight"] is True


def test_several_formats_come_of_one_solve(bozzetto, tmp_path):
    (tmp_path / "ring.svg").write_text(RING)
    words = ("build", "silhouette", "ring.svg", "-o", "r.stl", "-o", "out/r.glb")
    process = bozzetto(*words, "--report", "r.json")
    assert process.returncode == 0, process.stderr
    written = json.loads((tmp_path / "r.json").read_text())["written"]
    assert [one["format"] for one in written] == ["stl", "glb"]
    assert (tmp_path / "r.stl").stat().st_size > 0
    assert (tmp_path / "out" / "r.glb").stat().st_size > 0
    for more in (("--format", "stl"), ("-o", "r.stl"), ("-o", "out/")):
        process = bozzetto(*words, *more)
        assert process.returncode == 2
        assert "error:" in process.stderr


def test_several_inputs_go_to_a_folder_with_progress(bozzetto, square, tmp_path):
    (tmp_path / "ring.svg").write_text(RING)
    (tmp_path / "eight.svg").write_text(EIGHT)
    process = bozzetto(
        "build", "silhouette", "square.svg", "eight.svg", "ring.svg",
        "-o", "out/", "--format", "stl", "--report", "all.json",
    )  # fmt: skip
    assert process.returncode == 2
    assert "[3/3]" in process.stderr
    assert "error: eight.svg:" in process.stderr
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["ring.stl", "square.stl"]
    files = json.loads((tmp_path / "all.json").read_text())["files"]
    assert [Path(entry["input"]).name for entry in files] == ["square.svg", "ring.svg"]


def test_a_document_is_exported_and_rendered(bozzetto, square, tmp_path):
    bozzetto("build", "silhouette", square, "-o", "a.stl")
    bozzetto("build", "silhouette", square, "-o", "doc.bozz")
    process = bozzetto("export", "doc.bozz", "-o", "b.stl", "--object", "square")
    assert process.returncode == 0, process.stderr
    assert np.array_equal(read_stl(tmp_path / "a.stl"), read_stl(tmp_path / "b.stl"))
    process = bozzetto("render", "doc.bozz", "-o", "p.png", "--size", "320x200", "--theme", "dark")
    assert process.returncode == 0, process.stderr
    from PIL import Image

    with Image.open(tmp_path / "p.png") as picture:
        assert picture.size == (320, 200)
        colors = np.asarray(picture.convert("RGB")).reshape(-1, 3)
    assert len(np.unique(colors, axis=0)) > 50
    assert "no object nothing" in refused(
        bozzetto("export", "doc.bozz", "-o", "c.stl", "--object", "nothing")
    )
    with zipfile.ZipFile(tmp_path / "doc.bozz") as archive:
        assert archive.testzip() is None


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("build", "silhouette", "missing.svg", "-o", "x.stl"), "missing.svg"),
        (("build", "nonsense", "square.svg", "-o", "x.stl"), "bozzetto.silhouette"),
        (("build", "silhouette", "square.svg", "-o", "x.xyz"), ".stl"),
        (("build", "silhouette", "square.svg", "-o", "x"), ".stl"),
        (("build", "silhouette", "square.svg", "-o", "x.stl", "--set", "inflation=9"), "0.2"),
        (("build", "silhouette", "square.svg", "-o", "x.stl", "--set", "inflation"), "NAME=VALUE"),
        (("build", "silhouette", "square.svg", "-o", "x.stl", "--set", "colour=2"), "inflation"),
        (("build", "silhouette", "square.svg", "-o", "x.stl", "--set", "inflation=nan"), "finite"),
        (("build", "silhouette", "square.svg", "square.svg", "-o", "x.stl"), "--format"),
        (("build", "silhouette", "eight.svg", "-o", "x.stl"), "crosses itself"),
        (("build", "silhouette", "eight.svg", "-o", "x.stl"), "(50, 50)"),
        (("build", "silhouette", "square.svg", "-o", f"{'n' * 300}.stl"), "shorter"),
        (("build", "silhouette", "square.svg", "-o", ""), "no name"),
        (
            ("build", "silhouette", "square.svg", "-o", "x.stl", "--report", "a", "--report", "b"),
            "given twice",
        ),
        (("build", "silhouette", ".", "-o", "x.stl"), "folder"),
        (("build", "silhouette", "square.svg", "-o", "new/", "--format", "svg"), "curves"),
        (("build", "silhouette", "square.svg", "-o", "./", "--format", "svg"), "replace an input"),
        (("build", "silhouette", "square.svg", "-o", "x.stl", "--report", "x.stl"), "report"),
        (("build", "silhouette", "square.svg", "-o", "x.stl", "--report", "square.svg"), "input"),
        (("build", "silhouette", "square.svg", "-o", "x.stl", "--report", "."), "file name"),
        (("export", "bad.bozz", "-o", "bad.bozz"), "replace an input"),
        (("render", "bad.bozz", "-o", "x.jpg"), "PNG"),
        (("render", "bad.bozz", "-o", "x.png", "--size", "big"), "1200x900"),
        (("info", "."), "folder"),
        (("build", "silhouette", "empty.svg", "-o", "x.stl"), "empty"),
        (("build", "silhouette", "bad.json", "-o", "x.stl"), "bad.json"),
        (("export", "square.svg", "-o", "x.stl"), "build MODELER square.svg"),
        (("export", "square.stl", "-o", "x.glb"), "build mesh square.stl"),
        (("export", "bad.bozz", "-o", "x.stl"), ""),
        (("export", "bad.bozz", "-o", "x.xyz"), ".bozz, .stl"),
        (("simulate", "bad.bozz", "-o", "x.xyz"), ".gif, .mp4, .stl"),
        (("build", "silhouette", "missing.svg", "-o", "x.xyz"), ".bozz, .stl"),
        (("render", "bad.bozz", "-o", "x.png"), ""),
        (("render", "square.svg", "-o", "x.png"), ""),
        (("info", "bad.bozz"), ""),
        (("plugins", "check"), "NAME"),
        (("nonsense",), "invalid choice"),
        ((), "required"),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(bozzetto, square, tmp_path, words, said):
    (tmp_path / "eight.svg").write_text(EIGHT)
    (tmp_path / "empty.svg").write_text('<svg xmlns="http://www.w3.org/2000/svg"/>')
    (tmp_path / "bad.json").write_text('{"format": "bozzetto-ink/1"}')
    (tmp_path / "bad.bozz").write_bytes(b"PK\x03\x04 not a zip at all")
    before = sorted(tmp_path.iterdir())
    assert said.lower() in refused(bozzetto(*words)).lower()
    assert sorted(tmp_path.iterdir()) == before


def test_names_may_be_anything_that_the_disk_takes(bozzetto, tmp_path):
    (tmp_path / "ünï cödé 形.svg").write_text(SQUARE)
    process = bozzetto("build", "silhouette", "ünï cödé 形.svg", "-o", "new folder/öut 形.glb")
    assert process.returncode == 0, process.stderr
    assert bozzetto("info", "new folder/öut 形.glb").returncode == 0


def test_a_switch_may_stand_before_the_command(tmp_path, monkeypatch, capfd):
    from bozzetto_app.__main__ import main as entry

    monkeypatch.chdir(tmp_path)
    assert entry(["-v", "info", "missing.stl"]) == 2
    assert "missing.stl" in capfd.readouterr().err


def test_a_picture_is_described_by_its_size(bozzetto, square):
    bozzetto("build", "silhouette", square, "-o", "doc.bozz")
    bozzetto("render", "doc.bozz", "-o", "p.png", "--size", "64x48")
    assert "size_px: 64 48" in bozzetto("info", "p.png").stdout


def test_an_older_file_survives_a_refusal(bozzetto, square, tmp_path):
    (tmp_path / "eight.svg").write_text(EIGHT)
    (tmp_path / "x.stl").write_bytes(b"precious")
    refused(bozzetto("build", "silhouette", "eight.svg", "-o", "x.stl"))
    assert (tmp_path / "x.stl").read_bytes() == b"precious"


def test_the_module_is_a_program(tmp_path):
    process = subprocess.run(
        [sys.executable, "-m", "bozzetto.cli.main", "build", "silhouette", "no.svg", "-o", "x.stl"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert "no.svg" in refused(Finished(process.returncode, process.stdout, process.stderr))
    assert list(tmp_path.iterdir()) == []


# -- what leaves is honest ---------------------------------------------------------------------

FEW = 5
"""Marks of a sketch: one fewer than a camera needs."""


def marks_file(folder, count):
    """The bundled car sample with so many marks, and nothing drawn on it."""
    samples = Path(bozzetto_car.__file__).parent / "samples"
    told = json.loads((samples / "hatchback.json").read_text())
    (folder / "hatchback.png").write_bytes((samples / "hatchback.png").read_bytes())
    for view in told["views"]:
        view["marks"] = dict(list(view["marks"].items())[:count])
        view.pop("strokes", None)
    told.pop("styling")
    path = folder / "few.json"
    path.write_text(json.dumps(told))
    return path


def test_a_car_without_a_camera_is_an_error_unless_the_template_is_asked_for(bozzetto, tmp_path):
    few = marks_file(tmp_path, FEW)
    said = refused(bozzetto("build", "car", few, "-o", "car.step"))
    assert "bare template" in said
    assert "--allow-template" in said
    assert not (tmp_path / "car.step").exists()
    process = bozzetto("build", "car", few, "-o", "car.step", "--allow-template")
    assert process.returncode == 0
    assert "warning: No sketch has a camera yet" in process.stderr
    assert (tmp_path / "car.step").exists()
    # A document is there to be gone on with.
    process = bozzetto("build", "car", few, "-o", "car.bozz")
    assert process.returncode == 0
    assert "bare template" in process.stderr
    # … and what is made of it later says so as well.
    process = bozzetto("export", "car.bozz", "-o", "car.glb")
    assert process.returncode == 0
    assert "bare template" in process.stderr


@pytest.mark.slow
def test_what_is_left_out_is_said_and_stands_in_the_report(bozzetto, tmp_path):
    sample = Path(bozzetto_car.__file__).parent / "samples/hatchback.json"
    process = bozzetto("build", "car", sample, "-o", "car.3mf", "--report", "built.json")
    assert process.returncode == 0
    assert "warning: Left out of the 3MF file: 22 curves" in process.stderr
    built = json.loads((tmp_path / "built.json").read_text())
    assert built["written"]["format"] == "3mf"
    assert built["written"]["left_out"][0]["what"] == "22 curves"
    assert len(built["written"]["left_out"][0]["names"]) == 22
    bozzetto("build", "car", sample, "-o", "car.bozz")
    process = bozzetto("export", "car.bozz", "-o", "again.3mf", "--report", "exported.json")
    assert process.returncode == 0
    exported = json.loads((tmp_path / "exported.json").read_text())
    assert exported["written"] == built["written"]
    (one,) = exported["objects"]
    assert (one["name"], one["modeler"]) == ("hatchback", "bozzetto.car")
    assert one["report"] == {key: value for key, value in built.items() if key != "written"}
    assert exported["written"]["bytes"] == (tmp_path / "again.3mf").stat().st_size


@pytest.mark.slow
def test_an_svg_of_a_car_shows_it(bozzetto, tmp_path):
    """It was a blank page, with coordinates up to 13,001,643."""
    sample = Path(bozzetto_car.__file__).parent / "samples/hatchback.json"
    bozzetto("build", "car", sample, "-o", "car.bozz")
    for words in ((), ("--view", "right"), ("--view", "top")):
        process = bozzetto("export", "car.bozz", "-o", "car.svg", *words)
        assert process.returncode == 0, process.stderr
        text = (tmp_path / "car.svg").read_text()
        x, y, width, height = map(float, re.search('viewBox="([^"]*)"', text)[1].split())
        starts = np.array(re.findall(r'd="M([-\d.e+]+),([-\d.e+]+)', text), float)
        assert len(starts) == 22
        assert (starts > (x, y)).all()
        assert (starts < (x + width, y + height)).all()
        assert (np.ptp(starts, axis=0) > (0.3 * width, 0.1 * height)).all()
    assert "no view called 'aside'" in refused(
        bozzetto("export", "car.bozz", "-o", "car.svg", "--view", "aside")
    )


def test_the_ink_of_a_document_is_read_by_another_modeler(bozzetto, tmp_path):
    (tmp_path / "ring.svg").write_text(RING)
    assert bozzetto("build", "silhouette", "ring.svg", "-o", "ring.bozz").returncode == 0
    assert bozzetto("build", "symmetry", "ring.bozz", "-o", "again.bozz").returncode == 0
    (read,) = json.loads(bozzetto("info", "--json", "again.bozz").stdout)["objects"]
    assert read["modeler"] == "bozzetto.symmetry"
    refused = bozzetto("build", "car", "ring.bozz", "-o", "car.stl")
    assert refused.returncode == 2
    assert "holds no marks of a car" in refused.stderr
    assert not (tmp_path / "car.stl").exists()


def test_hidden_and_closed_objects_are_named(bozzetto, square, tmp_path):
    bozzetto("build", "silhouette", square, "-o", "doc.bozz")
    bozzetto("plugins", "disable", "silhouette")
    process = bozzetto("export", "doc.bozz", "-o", "out.stl")
    assert process.returncode == 2
    assert "“square” (its plugin bozzetto.silhouette is switched off)" in process.stderr
    process = bozzetto("render", "doc.bozz", "-o", "out.png", "--size", "80x60")
    assert process.returncode == 0
    assert "warning: Left out of the picture: “square”" in process.stderr
    bozzetto("plugins", "enable", "silhouette")
    process = bozzetto("export", "doc.bozz", "-o", "out.stl")
    assert process.returncode == 0
    assert process.stderr == ""


def test_strokes_that_are_too_small_are_named(bozzetto, tmp_path):
    (tmp_path / "dot.svg").write_text(SQUARE.replace("</svg>", '<path d="M60,60 l.05,.05"/></svg>'))
    process = bozzetto("build", "silhouette", "dot.svg", "-o", "dot.stl")
    assert process.returncode == 0
    assert "warning: 1 stroke of “Part 1” is too small and is not used." in process.stderr


@pytest.mark.skipif(sys.platform == "win32", reason="a closed pipe is another error there")
def test_who_reads_no_further_gets_no_traceback():
    words = [sys.executable, "-m", "bozzetto.cli.main", "plugins"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    assert process.stdout is not None
    assert process.stderr is not None
    process.stdout.close()
    with process.stderr as errors:
        assert errors.read() == b""
    assert process.wait(60) == 141


def test_a_setting_that_changes_nothing_is_named(bozzetto, square):
    build = ("build", "silhouette", "square.svg", "-o", "square.stl", "--set", "depth=9")
    process = bozzetto(*build)
    assert process.returncode == 0
    said = "warning: “Depth” changes nothing while “Surface” is “Round”."
    assert said in process.stderr
    process = bozzetto(*build, "--set", "surface=straight")
    assert "changes nothing" not in process.stderr
    process = bozzetto(*build[:-1], "Part 1.depth=9")
    assert said in process.stderr


def test_a_picture_takes_the_documents_own_view_where_all_lies_in_it(bozzetto, square, tmp_path):
    bozzetto("build", "silhouette", square, "-o", "doc.bozz")
    for name, words in (("own", ()), ("oblique", ("--view", "three-quarter"))):
        process = bozzetto("render", "doc.bozz", "-o", f"{name}.png", "--size", "60x45", *words)
        assert process.returncode == 0
    assert (tmp_path / "own.png").read_bytes() != (tmp_path / "oblique.png").read_bytes()


def test_plugins_are_listed(bozzetto):
    process = bozzetto("plugins")
    assert process.returncode == 0
    assert "bozzetto.silhouette" in process.stdout
    assert "bozzetto.mesh" in process.stdout


def test_a_bundled_plugin_passes_its_check(bozzetto):
    process = bozzetto("plugins", "check", "bozzetto_mesh")
    assert process.returncode == 0, process.stdout + process.stderr


@pytest.mark.slow
def test_samples_of_every_modeler_are_built_in_the_formats_that_hold_them(bozzetto):
    done = bozzetto("samples", "-o", "out")
    assert done.returncode == 0, done.stderr
    made = {path.name for path in Path("out").iterdir()}
    assert {"silhouette-horse.stl", "symmetry-boat.step", "car-hatchback.step"} <= made
    assert {f"car-hatchback.{ending}" for ending in ("stl", "glb", "bozz", "png")} <= made
    assert "symmetry-boat.stl" not in made, "a mesh has no place for curves"
    assert "silhouette-horse.step" not in made, "STEP has none for meshes"


def test_waiting_ink_is_told_by_info_and_left_out_of_shapes_with_a_note(bozzetto, square):
    from bozzetto.document.storage.bozz_file import read_document, write_document
    from bozzetto.document.waiting_ink import WaitingStroke
    from bozzetto.ink.stroke import Stroke
    from bozzetto.plugin.host.registry import Registry
    from bozzetto.view.camera import Camera

    assert bozzetto("build", "silhouette", square, "-o", "a.bozz").returncode == 0
    document, _ = read_document("a.bozz", Registry())
    ink = WaitingStroke(Stroke([1, 2], [3, 4], Camera()), "absent.modeler", "draw", "refused")
    write_document(document.with_waiting((ink,)), "b.bozz")
    assert "waiting_strokes: 1" in bozzetto("info", "b.bozz").stdout
    dry, wet = (bozzetto("export", f"{name}.bozz", "-o", f"{name}.stl") for name in "ab")
    assert (dry.returncode, dry.stderr) == (0, "")
    assert wet.returncode == 0
    assert "no part of the shapes" in wet.stderr
    assert Path("a.stl").read_bytes() == Path("b.stl").read_bytes()
    copied = bozzetto("export", "b.bozz", "-o", "c.bozz")
    assert (copied.returncode, copied.stderr) == (0, "")
    assert len(read_document("c.bozz", Registry())[0].waiting) == 1


def test_a_turntable_is_a_gif_or_a_row_of_pictures(bozzetto, square, tmp_path):
    bozzetto("build", "silhouette", "square.svg", "-o", "doc.bozz")
    words = ("render", "doc.bozz", "--turntable", "3", "--size", "64x48", "-o")
    assert bozzetto(*words, "turn.gif").returncode == 0
    assert bozzetto(*words, "row.png").returncode == 0
    assert (tmp_path / "turn.gif").read_bytes()[:4] == b"GIF8"
    assert sorted(path.name for path in tmp_path.glob("row*")) == [
        f"row-{number}.png" for number in (1, 2, 3)
    ]
    refused = bozzetto(*words, "turn.avi")
    assert refused.returncode != 0
    assert ".gif" in refused.stderr


def test_a_file_that_cannot_be_written_leaves_the_report_and_the_reason(bozzetto, tmp_path):
    at = [2 * math.pi * k / 200 for k in range(201)]
    knot = [
        [math.sin(t) + 2 * math.sin(2 * t), math.cos(t) - 2 * math.cos(2 * t), -math.sin(3 * t)]
        for t in at
    ]
    network = {"network": {"curves": [{"name": "knot", "points": knot}]}, "unit": "mm"}
    (tmp_path / "knot.json").write_text(json.dumps(network))
    built = bozzetto("build", "product", "knot.json", "-o", "knot.obj", "--report", "knot.r.json")
    assert built.returncode == 2
    assert not (tmp_path / "knot.obj").exists()
    told = json.loads((tmp_path / "knot.r.json").read_text())
    assert told["loops"] == [["knot"]]
    assert told["patches"] == []
    (reason,) = told["warnings"]
    assert "folds over itself" in reason
    assert reason in built.stderr
