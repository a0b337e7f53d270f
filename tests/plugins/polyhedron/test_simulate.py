"""``bozzetto simulate``: films and ends of motions, from the command line."""

from __future__ import annotations

import json
import os
import re
import shutil
import struct
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from bozzetto.cli.main import main
from bozzetto.document.model import Document, Model
from bozzetto.document.storage.bozz_file import read_document, write_document
from bozzetto.plugin.host.registry import Registry
from bozzetto.workbench.films import frames
from bozzetto.workbench.workbench import Workbench
from bozzetto_polyhedron.model.state import Body, PolyhedronState
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solve.moving import moving
from tests.plugins.polyhedron.linkages import FOUR_BAR, FOUR_BAR_LINES, linkage, traced, with_motor
from tests.plugins.polyhedron.write_samples import FOLDER

VALIDATE = (
    "const v=require(process.argv[1]);const fs=require('fs');"
    "v.validateBytes(new Uint8Array(fs.readFileSync(process.argv[2])))"
    ".then(r=>console.log(JSON.stringify(r)));"
)


@pytest.fixture
def four_bar(tmp_path) -> Path:
    state = linkage(FOUR_BAR, FOUR_BAR_LINES, held="ad")
    state = with_motor(state, FOUR_BAR["a"], FOUR_BAR["b"], speed=180.0)
    return stored(traced(state, FOUR_BAR["c"]), tmp_path / "four.bozz")


def stored(state: PolyhedronState, path: Path) -> Path:
    modeler = PolyhedronModeler
    model = Model("m1", "Linkage", modeler.id, state, state_version=modeler.state_version)
    write_document(Document((model,)), path)
    return path


def test_a_film_has_a_node_for_every_bar_and_moves_them(four_bar, tmp_path):
    target = tmp_path / "film.glb"
    words = ["simulate", str(four_bar), "-o", str(target), "--seconds", "0.4", "--rate", "10"]
    assert main(words) == 0
    data = target.read_bytes()
    said = json.loads(data[20 : 20 + struct.unpack("<I", data[12:16])[0]])
    assert [node["name"] for node in said["nodes"]] == [f"Bars bar {k}" for k in (1, 2, 3)]
    assert {each["target"]["node"] for each in said["animations"][0]["channels"]} == {0, 1, 2}


def test_a_film_as_usdz_moves_every_bar(four_bar, tmp_path):
    target = tmp_path / "film.usdz"
    words = ["simulate", str(four_bar), "-o", str(target), "--seconds", "0.4", "--rate", "10"]
    assert main(words) == 0
    with zipfile.ZipFile(target) as package:
        text = package.read("model.usda").decode()
    assert re.findall(r'displayName = "(.*)"', text)[:3] == [f"Bars bar {k}" for k in (1, 2, 3)]
    turned = re.findall(r"xformOp:orient.timeSamples = \{(.*)\}", text)
    assert [len(re.findall(r"[\d.]+: \(", one)) for one in turned] == [5, 5, 5]
    assert "endTimeCode = 9.6" in text


def test_a_gif_has_all_frames(four_bar, tmp_path):
    target = tmp_path / "film.gif"
    words = ["simulate", str(four_bar), "-o", str(target), "--seconds", "0.3", "--rate", "10"]
    assert main([*words, "--size", "160x120"]) == 0
    with Image.open(target) as film:
        assert (film.n_frames, film.size) == (4, (160, 120))


def test_the_end_is_a_document_with_its_recording(four_bar, tmp_path):
    target = tmp_path / "end.bozz"
    assert main(["simulate", str(four_bar), "-o", str(target), "--seconds", "0.5"]) == 0
    document, _ = read_document(target, Registry())
    (model,) = document
    assert model.state.moved.seconds == pytest.approx(0.5, abs=0.02)
    assert len(model.state.recorded.seconds) >= 12


def test_what_does_not_move_is_refused(tmp_path, capsys):
    empty = stored(PolyhedronState(), tmp_path / "empty.bozz")
    assert main(["simulate", str(empty), "-o", str(tmp_path / "a.glb")]) == 2
    assert "nothing to move" in capsys.readouterr().err
    assert main(["simulate", str(empty), "-o", str(tmp_path / "a.glb"), "--rate", "1e9"]) == 2
    assert "frames" in capsys.readouterr().err


def test_the_walker_among_the_samples_walks_upright_on_the_ground(tmp_path):
    """A shaft that turned half round has taken a step; nothing holds it but its feet."""
    target = tmp_path / "walker.bozz"
    words = ["build", "polyhedron", str(FOLDER / "walker.json"), "-o", str(target)]
    assert main(words) == 0
    (model,) = read_document(target, Registry())[0]
    assert not any(body.anchors for body in model.state.of_kind(Body))
    made = moving(model.state)
    masses = made.machine.assembly.masses
    *_, end = frames(Workbench(Registry()), Document((model,)), 1.0, 30.0)
    (walked,) = end
    motion = made.motion(walked.state.moved)
    way = 1e3 * masses @ (motion.places - made.machine.rest.places) / masses.sum()
    assert 20.0 < way[0] < 80.0
    assert abs(way[1]) < 1e-6
    assert abs(way[2]) < 5.0
    beam = motion.turns[made.machine.bar_between(0, *axle(made))]
    assert np.degrees(np.arccos(beam[0, 0])) < 10.0
    assert made.stepper.largest_gap(motion) < 1e-6


def axle(made) -> np.ndarray:
    """Return both ends of the longest level bar of the first body: one of its frame, mm."""
    shape = made.machine.shapes[0]
    ends = shape.vertices[shape.edges]
    span = ends[:, 1] - ends[:, 0]
    level = np.where(np.abs(span[:, 2]) < 0.1 * np.abs(span[:, 0]), np.abs(span[:, 0]), 0.0)
    return ends[int(np.argmax(level))]


@pytest.mark.interop
def test_the_khronos_validator_finds_nothing_in_a_film(four_bar, tmp_path):
    folder = os.environ.get("BOZZETTO_GLTF_VALIDATOR")
    if not folder or not shutil.which("node"):
        pytest.skip("BOZZETTO_GLTF_VALIDATOR names no folder with the npm package, or no node")
    target = tmp_path / "film.glb"
    assert main(["simulate", str(four_bar), "-o", str(target), "--seconds", "1"]) == 0
    words = ["node", "-e", VALIDATE, folder, str(target)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    report = json.loads(done.stdout)
    assert report["issues"]["messages"] == []
    assert report["info"]["animationCount"] == 1


@pytest.mark.parametrize("length", [("-1", "-25"), ("0", "25"), ("1", "nan"), ("1e9", "25")])
def test_a_film_of_no_length_or_too_many_frames_is_refused(four_bar, tmp_path, capsys, length):
    seconds, rate = length
    words = ["simulate", str(four_bar), "-o", str(tmp_path / "a.gif")]
    assert main([*words, f"--seconds={seconds}", f"--rate={rate}"]) == 2
    assert "1 to 3600 frames" in capsys.readouterr().err
    assert not list(tmp_path.glob("*.gif"))
