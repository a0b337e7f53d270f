"""What the pen did is recorded, shown again, and leaves as a film and with the export."""

from __future__ import annotations

import json
import os
import shutil
import struct
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from scipy.spatial.transform import Rotation

from bozzetto.cli.main import main
from bozzetto.document.model import Document, Model
from bozzetto.document.storage.bozz_file import write_document
from bozzetto.errors import UserError
from bozzetto.ink import Stroke
from bozzetto.plugin import Context, Drag
from bozzetto_polyhedron.commands.motion import at_rest, forget, is_recorded
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.modeler import PolyhedronModeler
from bozzetto_polyhedron.solve.moving import moving
from bozzetto_polyhedron.solve.recording import at_time, recorded_times, screw_between
from bozzetto_polyhedron.tools.move import Move
from bozzetto_polyhedron.tools.replay import Replay
from tests.blender import asked
from tests.core.exchange.test_blender import FRAMES
from tests.plugins.polyhedron.drawn_bodies import VIEW
from tests.plugins.polyhedron.figures_open_boxes import lidded_box
from tests.plugins.polyhedron.test_folds import corners, folds, hinged, read, seen, shape_of
from tests.plugins.polyhedron.test_simulate import VALIDATE

MODELER = PolyhedronModeler()
NEAR = 1e-4
"""Distance, in the extent of a box, by which a lid may miss where the pen had it."""


@cache
def opened(seed: int = 80_100) -> tuple[PolyhedronState, tuple[float, ...], np.ndarray]:
    """Return a box whose lid the pen has swung in uneven steps, with where its corners were when.

    The lid is pulled, let swing on for a while, and pulled back.
    """
    state = read(lidded_box(seed))
    (fold,) = folds(state)
    state = hinged(state, fold)
    shape = shape_of(state)
    plates = moving(state).machine.plates[0]
    alone = int(np.flatnonzero(np.bincount(plates)[plates] == 1)[0])
    lid = sorted(set(shape.faces[alone][0]) - set(fold))
    rng = np.random.default_rng(seed)
    times, places = [0.0], [corners(state)]
    for way in ((30.0, 40.0), None, (-20.0, -45.0)):
        begin = seen(corners(state)[lid[0]])[0]
        for frame in range(14):
            path = None
            if way is not None:
                path = Drag(
                    "", Stroke(*(begin + np.linspace(0, 1, frame + 2)[:, None] * way).T, VIEW)
                )
            state = Move().step(state, path, float(rng.uniform(0.005, 0.05)), Context())
            times.append(state.moved.seconds)
            places.append(corners(state))
    return state, tuple(times), np.array(places)


def stored(state: PolyhedronState, path: Path) -> Path:
    model = Model("m1", "Box", MODELER.id, state, state_version=MODELER.state_version)
    write_document(Document((model,)), path)
    return path


def test_every_pose_is_recorded_from_the_one_before_the_first_step():
    state, times, places = opened()
    assert recorded_times(state) == times
    for time, place in zip(times, places, strict=True):
        then = MODELER.replayed(state, time)
        assert corners(then) == pytest.approx(place, abs=1e-9)
        assert then.moved.seconds == time
        assert recorded_times(then) == times[: times.index(time) + 1]


def test_between_two_poses_a_hinge_stays_closed_and_nothing_leaps():
    state, times, places = opened()
    extent = float(np.ptp(places[0], axis=0).max())
    made = moving(state)
    for share in np.linspace(0.03, 0.97, 40):
        then = at_time(state, times[0] + share * (times[-1] - times[0]))
        assert made.stepper.largest_gap(made.motion(then.moved)) < NEAR * extent * 1e-3
    assert corners(at_time(state, -9.0)) == pytest.approx(places[0], abs=1e-9)
    assert corners(at_time(state, 1e9)) == pytest.approx(places[-1], abs=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_a_piece_between_two_poses_is_on_the_screw_from_one_to_the_other(seed):
    """Oracle: a turn about an axis in space with a shift along it, at a share of both."""
    rng = np.random.default_rng(seed)
    axis, middle, place = rng.normal(size=(3, 3))
    axis /= np.linalg.norm(axis)
    angle, shift, share = rng.uniform(0.0, 3.0), rng.normal(), rng.uniform()
    turn = Rotation.random(random_state=seed).as_matrix()

    def screwed(part: float) -> tuple[np.ndarray, np.ndarray]:
        swing = Rotation.from_rotvec(part * angle * axis).as_matrix()
        return middle + swing @ (place - middle) + part * shift * axis, swing @ turn

    other, turned = screwed(1.0)
    rows = (place[None], turn[None]), (other[None], turned[None])
    found = screw_between(*rows[0], *rows[1], share)
    back = screw_between(*rows[1], *rows[0], 1.0 - share)
    for each in (found, back):
        assert each[0][0] == pytest.approx(screwed(share)[0], abs=1e-9)
        assert each[1][0] == pytest.approx(screwed(share)[1], abs=1e-9)
    shifted = screw_between(place[None], turn[None], place[None] + 1.0, turn[None], share)
    assert shifted[0][0] == pytest.approx(place + share, abs=1e-12)


def test_moving_on_after_a_replay_overwrites_what_came_later():
    state, times, _ = opened()
    middle = at_time(state, times[10])
    assert recorded_times(middle) == times
    on = Move().step(middle, None, 0.02, Context())
    assert recorded_times(on) == (*times[:11], on.moved.seconds)
    between = at_time(state, 0.5 * (times[10] + times[11]))
    on = Move().step(between, None, 0.02, Context())
    assert recorded_times(on) == (*times[:11], between.moved.seconds, on.moved.seconds)


def test_replay_plays_the_recording_and_begins_again_after_its_end():
    state, times, places = opened()
    now = Replay().step(state, None, 0.02, Context())
    assert corners(now) == pytest.approx(places[0], abs=1e-9)
    now = Replay().step(now, None, times[3] - times[0], Context())
    assert corners(now) == pytest.approx(places[3], abs=1e-9)
    now = Replay().step(now, None, 1e3, Context())
    assert corners(now) == pytest.approx(places[-1], abs=1e-9)
    assert now.recorded is state.recorded


def test_replay_follows_the_pen_across_the_sheet():
    state, times, _ = opened()
    width = VIEW.viewport[0]
    reached = []
    for share in (0.0, 0.2, 0.5, 0.9, 1.0):
        path = Stroke([0.3 * width, share * width], [50.0, 60.0], VIEW)
        reached.append(Replay().step(state, Drag("", path), 0.02, Context()).moved.seconds)
    assert reached == sorted(reached)
    assert (reached[0], reached[-1]) == (times[0], times[-1])
    assert reached[2] == pytest.approx(0.5 * (times[0] + times[-1]))


def test_a_recording_is_thrown_away_and_then_there_is_nothing_to_replay():
    state, _, places = opened()
    assert is_recorded(state)
    for without, place in ((forget(state, Context()), -1), (at_rest(state, Context()), 0)):
        assert not is_recorded(without)
        assert MODELER.recorded(without) == ()
        assert corners(without) == pytest.approx(places[place], abs=1e-9)
        with pytest.raises(UserError, match="Nothing was recorded"):
            Replay().step(without, None, 0.02, Context())
        assert Replay().next_step(without).tool == "move"
    assert "are recorded" in Move().next_step(state).sentence
    assert "Film of what moves" in Replay().next_step(state).sentence


def test_a_recording_of_other_pieces_is_none():
    state, _, _ = opened()
    assert recorded_times(replace(state, nodes=state.nodes[:1])) == ()


def read_film(path: Path) -> tuple[np.ndarray, list[np.ndarray], np.ndarray]:
    """Return the times of the animation of a GLB, all places at each, and those without it, mm."""
    data = path.read_bytes()
    length = struct.unpack("<I", data[12:16])[0]
    said, blob = json.loads(data[20 : 20 + length]), data[28 + length :]

    def values(number: int) -> np.ndarray:
        entry = said["accessors"][number]
        view = said["bufferViews"][entry["bufferView"]]
        begin = view.get("byteOffset", 0) + entry.get("byteOffset", 0)
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[entry["type"]]
        return np.frombuffer(blob, "<f4", entry["count"] * width, begin).reshape(-1, width)

    (animation,) = said["animations"]
    times = values(animation["samplers"][0]["input"])[:, 0]
    still = [
        values(said["meshes"][node["mesh"]]["primitives"][0]["attributes"]["POSITION"])
        for node in said["nodes"]
    ]
    shifts = [np.zeros((len(times), 3)) for _ in still]
    turns = [Rotation.identity(len(times)) for _ in still]
    for channel in animation["channels"]:
        output = values(animation["samplers"][channel["sampler"]]["output"])
        if channel["target"]["path"] == "translation":
            shifts[channel["target"]["node"]] = output
        else:
            turns[channel["target"]["node"]] = Rotation.from_quat(output)
    at_times = [
        np.concatenate([turns[k][row].apply(rest) + shifts[k][row] for k, rest in enumerate(still)])
        for row in range(len(times))
    ]
    return times, [own_frame(places) for places in at_times], own_frame(np.concatenate(still))


def own_frame(places: np.ndarray) -> np.ndarray:
    """Return places of a GLB in millimetres with Z up."""
    return 1e3 * np.asarray(places, float) @ np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])


def apart(places: np.ndarray, meant: np.ndarray) -> float:
    """Return how far two sets of places are from one another at most."""
    away = np.linalg.norm(places[:, None] - meant, axis=2)
    return float(max(away.min(axis=1).max(), away.min(axis=0).max()))


@pytest.mark.parametrize("seed", [80_100, 80_102])
def test_a_film_has_the_lid_where_the_pen_had_it_at_each_time(seed, tmp_path):
    state, times, places = opened(seed)
    source, target = stored(state, tmp_path / "box.bozz"), tmp_path / "film.glb"
    assert main(["simulate", str(source), "--recorded", "-o", str(target)]) == 0
    told, shown, _ = read_film(target)
    assert told == pytest.approx(times, abs=1e-6)
    extent = float(np.ptp(places[0], axis=0).max())
    assert float(np.abs(places - places[0]).max()) > 0.05 * extent
    for found, meant in zip(shown, places, strict=True):
        assert apart(found, meant) < NEAR * extent


@pytest.mark.parametrize("scale", [1.0, 2.5])
def test_an_exported_glb_stands_as_it_is_now_and_holds_how_it_came_there(scale, tmp_path):
    state, times, places = opened()
    source, target = stored(state, tmp_path / "box.bozz"), tmp_path / "box.glb"
    assert main(["export", str(source), "-o", str(target), "--scale", str(scale)]) == 0
    told, shown, still = read_film(target)
    near = NEAR * scale * float(np.ptp(places[0], axis=0).max())
    assert told == pytest.approx(times, abs=1e-6)
    assert apart(still, scale * places[-1]) < near
    for found, meant in zip(shown, scale * places, strict=True):
        assert apart(found, meant) < near


def test_frames_may_be_even_and_are_between_what_was_recorded(tmp_path):
    state, times, _ = opened()
    source, target = stored(state, tmp_path / "box.bozz"), tmp_path / "film.glb"
    words = ["simulate", str(source), "--recorded", "-o", str(target), "--rate", "30"]
    assert main(words) == 0
    told, shown, _ = read_film(target)
    assert np.diff(told)[:-1] == pytest.approx(1 / 30, abs=1e-6)
    assert told[-1] == pytest.approx(times[-1], abs=1e-6)
    for time, found in zip(told.tolist(), shown, strict=True):
        assert apart(found, corners(at_time(state, time))) < 2e-3


def test_a_gif_shows_the_recording(tmp_path):
    state, times, _ = opened()
    source, target = stored(state, tmp_path / "box.bozz"), tmp_path / "film.gif"
    words = ["simulate", str(source), "--recorded", "-o", str(target), "--rate", "10"]
    assert main([*words, "--size", "160x120"]) == 0
    with Image.open(target) as film:
        assert (film.n_frames, film.size) == (int(np.ceil(times[-1] * 10)) + 1, (160, 120))


def test_what_cannot_be_is_refused_in_plain_words(tmp_path, capsys):
    state, _, _ = opened()
    full = stored(state, tmp_path / "full.bozz")
    empty = stored(forget(state, Context()), tmp_path / "empty.bozz")
    words = ["simulate", "--recorded", "-o"]
    assert main([*words, str(tmp_path / "a.glb"), str(empty)]) == 2
    assert "Nothing was recorded" in capsys.readouterr().err
    assert main([*words, str(tmp_path / "a.step"), str(full)]) == 2
    assert "leaves as a film" in capsys.readouterr().err
    assert main([*words, str(tmp_path / "a.gif"), str(full), "--rate", "-1"]) == 2
    assert "above 0" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main([*words, str(tmp_path / "a.glb"), str(full), "--seconds", "2"])
    assert not list(tmp_path.glob("a.*"))


@pytest.mark.interop
@pytest.mark.parametrize("command", [["simulate", "--recorded"], ["export"]])
def test_the_khronos_validator_finds_nothing_in_a_recording(command, tmp_path):
    folder = os.environ.get("BOZZETTO_GLTF_VALIDATOR")
    if not folder or not shutil.which("node"):
        pytest.skip("BOZZETTO_GLTF_VALIDATOR names no folder with the npm package, or no node")
    source, target = stored(opened()[0], tmp_path / "box.bozz"), tmp_path / "film.glb"
    assert main([*command, str(source), "-o", str(target)]) == 0
    words = ["node", "-e", VALIDATE, folder, str(target)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    report = json.loads(done.stdout)
    assert report["issues"]["messages"] == []
    assert report["info"]["animationCount"] == 1


@pytest.mark.interop
@pytest.mark.parametrize("command", [["simulate", "--recorded"], ["export"]])
def test_blender_plays_a_recording(command, tmp_path):
    state, times, places = opened()
    source, target = stored(state, tmp_path / "box.bozz"), tmp_path / "film.glb"
    assert main([*command, str(source), "-o", str(target)]) == 0
    extent = float(np.ptp(places[0], axis=0).max())
    rows = asked(FRAMES, target, json.dumps(times))
    for row, meant in zip(rows, places, strict=True):
        found = 1e3 * np.concatenate([np.array(each) for each in row.values()])
        assert apart(found, meant) < NEAR * extent
