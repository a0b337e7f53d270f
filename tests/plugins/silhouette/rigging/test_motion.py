"""Motions of rigs: walks, sways and key poses, in the window's steps and in files."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from bozzetto.document.model import Document
from bozzetto.errors import UserError
from bozzetto.exchange.export import encode_shapes
from bozzetto.geometry import Shapes
from bozzetto.ink import Drawing
from bozzetto.plugin import Context
from bozzetto.plugin.host.registry import Registry
from bozzetto.workbench.films import animation_of, frames
from bozzetto.workbench.links import with_state
from bozzetto.workbench.workbench import Workbench
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.rigging.posing import rig_of
from tests.core.exchange.test_skins import opened, shown
from tests.plugins.silhouette.outlines import COMMITTED, circle, svg_rings
from tests.plugins.silhouette.rigging.characters import (
    FRONT,
    fitted,
    man,
    person_of_parts,
    solid_of,
    state_of_rings,
)
from tests.plugins.silhouette.rigging.test_armature import turned

MODELER = Silhouette()
COMMANDS = {command.id: command for command in MODELER.commands()}
PERSON = state_of_rings([man()], 48)
DRAWING = Drawing(PERSON.nodes[0].strokes, FRONT)
HORSE = state_of_rings(fitted(svg_rings(COMMITTED / "horse_skimage.svg")), 48)
ANIMATE = next(tool for tool in MODELER.tools() if tool.id == "animate")


def ran(state, command):
    return COMMANDS[command].run(state, Context())


def later(state, seconds):
    return ANIMATE.step(state, None, seconds, Context())


def at_time(data, seconds):
    """A file's nodes as a viewer turns them at a time: glTF 2.0, appendix C, linear samplers."""
    gltf, values = opened(data)
    for animation in gltf["animations"]:
        for channel in animation["channels"]:
            sampler = animation["samplers"][channel["sampler"]]
            assert channel["target"]["path"] == "rotation"
            times, turns = values(sampler["input"])[:, 0], values(sampler["output"])
            k = min(int(np.searchsorted(times, seconds, side="right")) - 1, len(times) - 2)
            part = (seconds - times[k]) / (times[k + 1] - times[k])
            one, other = Rotation.from_quat(turns[k]), Rotation.from_quat(turns[k + 1])
            turn = one * Rotation.from_rotvec(part * (one.inv() * other).as_rotvec())
            gltf["nodes"][channel["target"]["node"]]["rotation"] = turn.as_quat().tolist()
    return gltf, values


@pytest.mark.parametrize("motion", ["walk", "sway"])
@pytest.mark.parametrize("state", [PERSON, HORSE], ids=["person", "horse"])
def test_a_viewer_of_the_file_sees_what_the_window_plays(state, motion, monkeypatch):
    state = ran(state, motion)
    data = encode_shapes(Shapes(solids=(solid_of(state),)), "a.glb")
    gltf, _ = opened(data)
    (animation,) = gltf["animations"]
    assert animation["name"] == motion
    now = state
    for seconds in (0.04, 0.17, 0.05, 0.31):
        now = later(now, seconds)
        monkeypatch.setattr(
            "tests.core.exchange.test_skins.opened", lambda data, t=now.time: at_time(data, t)
        )
        np.testing.assert_allclose(shown(data, 0), solid_of(now).mesh.vertices, atol=2e-3)
        monkeypatch.undo()


def test_a_motion_comes_back_to_where_it_began_and_keeps_its_bones():
    state = ran(PERSON, "walk")
    rest = rig_of(PERSON).joints
    now, apart = state, 0.0
    for _ in range(24):
        now = later(now, 0.05)
        places = rig_of(now).posed()[1]
        apart = max(apart, np.abs(places - rest).max())
        for joint, parent in enumerate(rig_of(now).parents):
            if parent >= 0:
                length = np.linalg.norm(places[joint] - places[parent])
                assert length == pytest.approx(np.linalg.norm(rest[joint] - rest[parent]))
    assert now.time == pytest.approx(0.0, abs=1e-9) or now.time == pytest.approx(1.2)
    assert apart > 15.0, "it does move"
    np.testing.assert_allclose(rig_of(now).posed()[1], rig_of(state).posed()[1], atol=1e-6)


def test_left_and_right_walk_alike_half_a_cycle_apart():
    state = ran(PERSON, "walk")
    rig = rig_of(state)
    half = rig_of(later(replace(state, time=0.6 - 1e-9), 1e-9))
    for name in ("Leg", "Leg-2", "Arm"):
        left, right = rig.names.index(f"{name}.L"), rig.names.index(f"{name}.R")
        np.testing.assert_allclose(np.abs(rig.turns[left]), np.abs(half.turns[right]), atol=1e-6)


@pytest.mark.parametrize("ears", [False, True])
@pytest.mark.parametrize("seed", [200, 201, 202, 203])
def test_a_person_drawn_limb_by_limb_walks_towards_us(seed, ears):
    state = person_of_parts(seed, ears)
    rig = rig_of(state)
    stems = {name.split(".")[0].split("-")[0] for name in rig.names}
    assert stems - {"Limb 1"} == {"Spine", "Head", "Arm", "Leg"}
    assert ("Limb 1" in stems) == ears
    walk = ran(state, "walk")
    places = np.array([rig_of(later(walk, t)).posed()[1] for t in np.linspace(0.0, 1.1, 12)])
    aside, ahead, _ = np.abs(places - rig.joints).max(axis=0).max(axis=0)
    assert ahead > 3.0 * aside, "legs swing to and from us, not from side to side"
    moved = np.linalg.norm(places - rig.joints, axis=2).max(axis=0)
    for side in (".L", ".R"):
        limbs = {word: [k for k, n in enumerate(rig.names) if n.startswith(word) and side in n]
                 for word in ("Arm", "Leg", "Limb")}  # fmt: skip
        leg = limbs["Leg"]
        lowest = min(leg, key=lambda k: rig.joints[k, 2])
        assert moved[lowest] > 10.0
        assert moved[limbs["Arm"]].max() > 5.0
        assert moved[limbs["Limb"]].max(initial=0.0) < 3.0, "ears go with the head"
    # Where limbs begin inside the body they have one joint there, and no bones into its corners.
    body = rig.joints[[n.startswith("Spine") for n in rig.names]]
    for name, place in zip(rig.names, rig.joints, strict=True):
        if "." in name and "-" in name:
            assert np.linalg.norm(body - place, axis=1).min() > 10.0


def test_a_motion_says_how_it_is_played():
    draw = next(tool for tool in MODELER.tools() if tool.id == "draw")
    step = MODELER.next_step(ran(PERSON, "walk"), draw)
    assert (step.tool, step.panel) == (ANIMATE.id, True)
    assert "P to play" in step.sentence
    assert not MODELER.next_step(PERSON, draw).panel


MIRRORED = state_of_rings(
    [ring * (-1.0, 1.0) for ring in fitted(svg_rings(COMMITTED / "horse_skimage.svg"))], 48
)


@pytest.mark.parametrize("horse", [HORSE, MIRRORED], ids=["to the right", "to the left"])
def test_what_walks_seen_from_its_side_keeps_its_trunk_still_and_moves_its_four_feet(horse):
    state = ran(horse, "walk")
    rig = rig_of(horse)
    places = np.array([rig_of(later(state, t)).posed()[1] for t in np.linspace(0.0, 1.1, 12)])
    moved = np.linalg.norm(places - places[0], axis=2).max(axis=0)
    size = np.ptp(rig.joints[:, 2])
    trunk = [k for k, name in enumerate(rig.names) if name.startswith("Body")]
    assert len(trunk) >= 4
    assert moved[trunk].max() < 1e-9
    ends = np.setdiff1d(np.arange(len(rig.names)), rig.parents)
    feet = [k for k in ends if rig.joints[k, 2] < rig.joints[:, 2].min() + 0.1 * size]
    assert len(feet) == 4
    assert (moved[feet] > 0.1 * size).all()
    others = [k for k in ends if k not in feet]
    assert moved[others].max() < 1e-9, "head, ears and tail hang on a trunk that is still"


def test_kept_poses_become_a_motion_in_their_order():
    one = turned(PERSON, 1, (0, 1, 0), 30)
    other = turned(PERSON, 1, (0, 1, 0), -30)
    state = ran(one, "keep-pose")
    state = ran(replace(state, turns=other.turns), "keep-pose")
    assert [key.turns for key in state.keys] == [one.turns, other.turns]
    middle = rig_of(later(state, 0.5 * state.beat))
    np.testing.assert_allclose(middle.posed()[1], rig_of(PERSON).joints, atol=1e-6)
    assert ran(state, "next-pose").turns == one.turns, "the pose kept last is shown; then the first"
    assert ran(ran(state, "next-pose"), "next-pose").turns == other.turns
    assert [key.turns for key in ran(state, "forget-pose").keys] == [one.turns]
    assert ran(state, "rest").turns == ran(state, "rest").keys == ()


def test_a_key_pose_is_changed_moved_and_taken_out_where_the_motion_is():
    walk = ran(PERSON, "walk")
    number = 3
    state = replace(walk, time=number * walk.beat, turns=walk.keys[5].turns)
    changed = ran(state, "change-pose")
    assert changed.keys[number] == walk.keys[5]
    assert [k for k in range(8) if changed.keys[k] != walk.keys[k]] == [number]
    moved = ran(state, "later-pose")
    order = [0, 1, 2, 4, 3, 5, 6, 7]
    assert moved.keys == tuple(walk.keys[k] for k in order)
    assert moved.time == pytest.approx(4 * walk.beat)
    assert moved.turns == walk.keys[3].turns
    last = ran(replace(walk, time=7 * walk.beat), "later-pose")
    assert last.keys == (walk.keys[7], *walk.keys[:7])
    gone = ran(state, "forget-pose")
    assert gone.keys == walk.keys[:3] + walk.keys[4:]
    assert gone.turns == walk.keys[2].turns
    kept = ran(state, "keep-pose")
    assert kept.keys == (*walk.keys[:4], walk.keys[5], *walk.keys[4:])


def test_a_motion_that_is_emptied_leaves_the_pose():
    state = ran(PERSON, "walk")
    for left in range(7, -1, -1):
        state = ran(state, "forget-pose")
        assert len(state.keys) == left
    assert state.turns == ran(PERSON, "walk").keys[7].turns, "the one that stood there last"


def test_a_film_from_the_command_line_has_the_motion():
    bench = Workbench(Registry())
    model = bench.sources.from_drawing("bozzetto.silhouette", DRAWING, {"resolution": 32})
    model = with_state(bench.registry, model, ran(model.state, "sway"))
    film = list(frames(bench, Document((model,)), 0.4, 10))
    gltf, values = opened(animation_of(bench, film, np.arange(len(film)) / 10))
    (animation,) = gltf["animations"]
    assert animation["channels"]
    times = values(animation["samplers"][0]["input"])
    np.testing.assert_allclose(times[:, 0], [0.0, 0.1, 0.2, 0.3, 0.4], atol=1e-6)


@pytest.mark.parametrize("command", sorted(COMMANDS))
@pytest.mark.parametrize(
    "state",
    [SilhouetteState(), state_of_rings([circle(0, 0, 20)], 32)],
    ids=["nothing", "a ball"],
)
def test_where_there_is_nothing_to_move_commands_say_so_or_change_no_shape(state, command):
    """Commands end with a state or with a sentence, never with another exception."""
    after = state
    with suppress(UserError):
        after = ran(state, command)
    assert after.nodes == state.nodes
    assert after.turns == ()


def test_a_motion_survives_a_change_of_the_ink():
    state = ran(PERSON, "walk")
    other = replace(state, nodes=(replace(state.nodes[0], strokes=HORSE.nodes[0].strokes),))
    assert solid_of(later(other, 0.1)).skin is not None
    assert later(replace(other, nodes=state.nodes), 0.1).keys == state.keys
    with pytest.raises(UserError):
        later(replace(state, nodes=()), 0.1)
