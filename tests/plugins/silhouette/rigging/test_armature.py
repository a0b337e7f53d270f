"""Rigs, skins and poses of silhouettes: laws of what moves, and hostile trees."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import shapely
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial.transform import Rotation

import bozzetto_silhouette
from bozzetto.errors import UserError
from bozzetto.exchange.import_file import read_drawing
from bozzetto.exchange.mesh.manifold_check import check_solid
from bozzetto.geometry import Placement
from bozzetto.ink import Stroke, Strokes
from bozzetto.plugin import Context, Drag, Job
from bozzetto.scene import Shaded
from bozzetto.view import Camera
from bozzetto_silhouette.model.state import Group, Part, SilhouetteState, Turn
from bozzetto_silhouette.modeler import Silhouette
from bozzetto_silhouette.outline.from_ink import outline_of
from bozzetto_silhouette.rigging.armature import armature_of
from bozzetto_silhouette.rigging.posing import joints_layer, posed, posed_scene, rig_of
from tests.plugins.silhouette.outlines import COMMITTED, circle, svg_rings
from tests.plugins.silhouette.rigging.characters import FRONT, dense, drawn, stretches

SAMPLES = Path(bozzetto_silhouette.__file__).parent / "samples"
MODELER = Silhouette()


def part(*rings, number=1, **more):
    closed = [np.vstack([ring, ring[:1]]) for ring in rings]
    more = {"name": f"Part {number}", **more}
    return Part(id=f"n{number}", strokes=Strokes(drawn(ring) for ring in closed), **more)


def state_of(*nodes, resolution=48):
    return SilhouetteState(nodes=nodes, resolution=resolution)


def capsule(x, y, length, radius, degrees=0.0):
    """An outline around a segment from (x, y)."""
    turn = np.linspace(np.pi / 2, 3 * np.pi / 2, 24)
    end = np.column_stack([np.cos(turn), np.sin(turn)]) * radius
    ring = np.vstack([end, end[::-1] * [-1, 1] * np.array([1, 1]) + [length, 0]])
    ring = ring[np.argsort(np.arctan2(ring[:, 1], ring[:, 0] - length / 2), kind="stable")]
    angle = np.radians(degrees)
    rows = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    return ring @ rows + [x, y]


def solved(state, quality="final"):
    return MODELER.solve(replace(state, posing=True), Job(quality))


def turned(state, joint, axis, degrees):
    """The state with one joint turned, besides what is turned."""
    rig = rig_of(state)
    vector = np.radians(degrees) * np.array(axis, float) / np.linalg.norm(axis)
    x, y, z, w = Rotation.from_rotvec(vector).as_quat().tolist()
    turn = Turn(tuple(rig.joints[joint].tolist()), (w, x, y, z))
    return replace(state, turns=(*state.turns, turn))


def horse(resolution=64):
    drawing = read_drawing(SAMPLES / "horse.json")
    return replace(MODELER.read_drawing(drawing, Context(), Job()), resolution=resolution)


WORM = part(capsule(-60, 0, 120, 8))
RING = part(circle(0, 0, 40), circle(0, 0, 22))


def test_a_horse_has_a_rig_for_animators():
    rig = rig_of(horse())
    assert 15 <= len(rig.joints) <= 32
    assert (rig.parents < 0).sum() == 1
    assert rig.names[0] == "Body"
    children = np.bincount(rig.parents[rig.parents >= 0], minlength=len(rig.joints))
    assert 6 <= (children == 0).sum() <= 9  # four hooves, tail, muzzle, perhaps ears
    armature = armature_of(horse())
    assert armature.radii[0] == armature.radii.max()


def test_feet_that_nearly_touch_follow_their_own_leg():
    """Cut off above the hooves, each piece of the skin hangs on joints of its own."""
    state = horse(128)
    result = solved(state)
    faces = result.mesh.faces
    low = result.mesh.vertices[:, 2] < -70.0
    kept = faces[low[faces].all(axis=1)]
    links = coo_matrix((np.ones(len(kept)), (kept[:, 0], kept[:, 1])), shape=(len(low), len(low)))
    links += coo_matrix((np.ones(len(kept)), (kept[:, 1], kept[:, 2])), shape=links.shape)
    piece = connected_components(links, directed=False)[1]
    table = dense(result.skin)
    closest = [piece == k for k in np.unique(piece[kept]) if (piece == k).sum() > 20]
    assert len(closest) == 4
    followed = [set(np.flatnonzero((table[foot] > 0.02).any(axis=0)).tolist()) for foot in closest]
    assert not any(followed[a] & followed[b] for a in range(4) for b in range(a))


def test_bones_stay_inside_the_skin():
    """A limb that bends has a joint in the bend, where its length alone would ask for none."""
    rig = rig_of(horse())
    inside = outline_of(horse().parts[0]).polygon()
    ends = np.flatnonzero(rig.parents >= 0)
    bones = np.stack([rig.joints[ends], rig.joints[rig.parents[ends]]], axis=1)[:, :, [0, 2]]
    assert all(inside.contains(shapely.LineString(bone)) for bone in bones)


def test_joints_stay_when_the_drawing_is_moved_scaled_and_started_elsewhere():
    ring = svg_rings(COMMITTED / "hand-paper.svg")[0] * [1, -1]
    ring -= ring.mean(axis=0)
    ring *= 100 / np.ptp(ring, axis=0).max()
    first = rig_of(state_of(part(ring)))
    again = rig_of(state_of(part(np.roll(ring, 37, axis=0))))
    large = rig_of(state_of(part(ring * 1.7 + [10, 5])))
    assert first.names == again.names == large.names
    np.testing.assert_allclose(again.joints, first.joints, atol=1.5)
    moved = (large.joints - [10, 0, 5]) / 1.7
    np.testing.assert_allclose(moved, first.joints, atol=1.5)
    np.testing.assert_array_equal(large.parents, first.parents)


@pytest.mark.parametrize("state", [horse(), state_of(WORM), state_of(RING)])
def test_weights_are_shares(state):
    skin = solved(state).skin
    assert (skin.weights >= 0).all()
    np.testing.assert_allclose(skin.weights.sum(axis=1), 1.0, atol=1e-5)
    assert (skin.joints[skin.weights == 0] == 0).all()


def test_at_rest_the_mesh_is_the_one_without_a_rig():
    state = horse()
    result = solved(state)
    identity = turned(state, 3, (0, 0, 1), 0.0)
    np.testing.assert_allclose(solved(identity).mesh.vertices, result.mesh.vertices, atol=2e-5)


def test_turning_the_root_turns_everything_rigidly():
    state = horse()
    rest, rig = solved(state).mesh, rig_of(state)
    after = solved(turned(state, 0, (1, 2, 3), 75)).mesh
    turn = Rotation.from_rotvec(np.radians(75) * np.array([1, 2, 3]) / np.sqrt(14))
    expected = turn.apply(rest.vertices - rig.joints[0]) + rig.joints[0]
    np.testing.assert_allclose(after.vertices, expected, atol=1e-3)
    check_solid(MODELER.shapes(state, solved(turned(state, 0, (1, 2, 3), 75))).solids[0])


def test_a_bone_in_the_middle_of_a_limb_and_a_tip_move_rigidly():
    state = state_of(WORM)
    rig = rig_of(state)
    ends = sorted(set(range(len(rig.joints))) - set(rig.parents.tolist()))
    tip = max(ends, key=lambda k: rig.joints[k, 0])
    bend = int(rig.parents[tip])
    rest = solved(state).mesh.vertices
    after = solved(turned(state, bend, (0, 1, 0), 50)).mesh.vertices
    turn = Rotation.from_rotvec([0, np.radians(50), 0])
    expected = turn.apply(rest - rig.joints[bend]) + rig.joints[bend]
    beyond = rest[:, 0] > rig.joints[bend, 0] + 8.5
    assert beyond.sum() > 20
    np.testing.assert_allclose(after[beyond], expected[beyond], atol=1e-3)
    before = rest[:, 0] < rig.joints[bend, 0] - 8.5
    np.testing.assert_allclose(after[before], rest[before], atol=1e-4)
    # In between it bends evenly: no section is squeezed to nothing.
    middle = np.abs(rest[:, 0] - rig.joints[bend, 0]) < 8.0
    gap = np.linalg.norm(after[middle] - rig.joints[bend], axis=1)
    assert gap.min() > 0.6 * 8.0


def steepest(result, radius):
    """The largest change of weights between neighbours, per radius of way."""
    table = dense(result.skin)
    faces, rest = result.mesh.faces, result.mesh.vertices.astype(float)
    edges = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    change = 0.5 * np.abs(table[edges[:, 0]] - table[edges[:, 1]]).sum(axis=1)
    way = np.linalg.norm(rest[edges[:, 0]] - rest[edges[:, 1]], axis=1)
    return float((change / np.maximum(way, 0.05 * radius)).max() * radius)


@pytest.mark.parametrize(
    ("ring", "radius", "most"),
    # At a joint the change takes a radius to either side, with ease: 3/4 per radius at most.
    # Bones of one radius and a half have room for three quarters of that, and the inner side
    # of the ring is shorter by 22 / 31; where it was cut a second change lies over the first.
    [(WORM, 8.0, 1.1), (RING, 9.0, 2.0)],
    ids=["worm", "ring"],
)
def test_weights_change_gently(ring, radius, most):
    assert steepest(solved(state_of(ring, resolution=96)), radius) < most


def test_weights_change_gently_across_a_seam():
    body = part(circle(0, 0, 30), number=1)
    arm = part(capsule(20, 0, 60, 8), number=2, blend=0.0)
    state = state_of(body, arm, resolution=96)
    assert steepest(solved(state), 8.0) < 3.0


def test_a_ring_is_cut_once_and_its_skin_still_closes():
    state = state_of(RING)
    rig = rig_of(state)
    assert len(rig.cuts) == 1
    assert len(rig.joints) >= 4
    result = solved(turned(state, 1, (0, 1, 0), 25))
    solid = MODELER.shapes(state, result).solids[0]
    assert check_solid(solid).genus == 1
    told = MODELER.report(state, result, Job())["rig"]
    assert told["joints"] == len(rig.joints)
    assert told["cuts"] == [[rig.names[k] for k in rig.cuts[0]]]


def test_a_limb_hangs_on_the_body_that_it_touches():
    body = part(circle(0, 0, 30), number=1, name="Body")
    arm = part(capsule(25, 0, 60, 6), number=2, name="Arm")
    apart = part(circle(120, 0, 12), number=3, name="Ball")
    rig = rig_of(state_of(arm, apart, body))  # in any order
    by_name = dict(zip(rig.names, range(len(rig.names)), strict=True))
    assert rig.parents[by_name["Body"]] == -1
    shoulder = by_name["Arm"]
    assert rig.names[rig.parents[shoulder]].startswith("Body")
    arms = [k for name, k in by_name.items() if name.startswith("Arm")]
    assert rig.joints[shoulder, 0] == min(rig.joints[k, 0] for k in arms)
    assert rig.parents[by_name["Ball"]] == -1


def test_turning_a_limb_leaves_the_body_alone():
    body = part(circle(0, 0, 30), number=1)
    arm = part(capsule(25, 0, 80, 6), number=2, name="Arm", blend=0.0)
    state = state_of(body, arm, resolution=64)
    rig = rig_of(state)
    rest = solved(state).mesh.vertices
    after = solved(turned(state, rig.names.index("Arm"), (0, 1, 0), 40)).mesh.vertices
    moved = np.linalg.norm(after - rest, axis=1)
    assert moved[rest[:, 0] < 15].max() < 1e-4
    assert moved[rest[:, 0] > 95].min() > 20


@pytest.mark.parametrize("operation", ["carve", "intersect"])
def test_what_takes_away_has_no_joints(operation):
    body = part(circle(0, 0, 30), number=1)
    hole = part(circle(10, 0, 12), number=2, operation=operation)
    alone, both = rig_of(state_of(body)), rig_of(state_of(body, hole))
    np.testing.assert_array_equal(alone.joints, both.joints)
    skin = solved(state_of(body, hole)).skin
    np.testing.assert_allclose(skin.weights.sum(axis=1), 1.0, atol=1e-5)


def test_hidden_parts_and_parts_of_hidden_groups_have_no_joints():
    body = part(circle(0, 0, 30), number=1)
    arm = part(capsule(25, 0, 60, 6), number=2)
    alone = rig_of(state_of(body))
    hidden = rig_of(state_of(body, replace(arm, visible=False)))
    group = Group(id="g", name="Group", visible=False)
    inside = rig_of(state_of(body, group, replace(arm, within="g")))
    np.testing.assert_array_equal(alone.joints, hidden.joints)
    np.testing.assert_array_equal(alone.joints, inside.joints)


def test_a_straight_part_follows_as_a_whole():
    arm = part(capsule(-60, 0, 120, 8), number=1)
    blade = part(capsule(50, 0, 60, 3, 90), number=2, surface="straight", blend=0.0)
    state = state_of(arm, blade, resolution=64)
    result = solved(state)
    table = dense(result.skin)
    tip = np.abs(result.mesh.vertices[:, 2]) > 25
    assert tip.sum() > 3
    assert (table[tip].max(axis=1) > 1 - 1e-6).all()
    assert len(set(table[tip].argmax(axis=1))) == 1


def plate_on_legs():
    """A plate that goes straight through, on three legs that touch nothing else."""
    legs = [
        part(capsule(x, -20, 50, 4, 90), number=k, name=f"Leg {k}")
        for k, x in enumerate((-30, 0, 30), 2)
    ]
    plate = part(
        capsule(-40, 10, 80, 12), number=1, name="Plate", surface="straight", inflation=0.4
    )
    return state_of(plate, *legs, resolution=64)


def test_a_plate_that_holds_legs_has_a_joint_and_they_hang_on_it():
    state = plate_on_legs()
    rig = rig_of(state)
    (plate,) = np.flatnonzero(rig.parents < 0)
    assert rig.names[plate] == "Plate"
    assert (rig.parents == plate).sum() == 3
    result = solved(state)
    assert stretches(result.mesh, result.skin).max() <= 1.8
    whole = solved(turned(state, plate, (0, 1, 0), 40)).mesh.vertices
    back = Rotation.from_rotvec([0.0, -np.radians(40.0), 0.0]).apply(whole - rig.joints[plate])
    np.testing.assert_allclose(back + rig.joints[plate], result.mesh.vertices, atol=1e-3)
    one = state_of(*state.nodes[:2])  # a single leg needs nothing to hold it
    assert all(name.startswith("Leg") for name in rig_of(one).names)


def test_parts_touch_where_one_is_thicker_than_round():
    body = part(circle(0, 0, 30), number=1, name="Body", inflation=1.5)
    nose = replace(
        part(circle(0, 0, 3), number=2, name="Nose"), pose=Placement(offset=(0.0, -45.0, 0.0))
    )
    assert (rig_of(state_of(body, nose)).parents < 0).sum() == 1
    assert (rig_of(state_of(replace(body, inflation=1.0), nose)).parents < 0).sum() == 2


MIRROR = Placement((-1.0, 0, 0, 0, 1.0, 0, 0, 0, 1.0), 1.0, (7.0, 0.0, 3.0))


def test_a_mirrored_part_has_the_mirrored_rig_and_skin():
    plain = state_of(WORM)
    mirrored = state_of(replace(WORM, pose=MIRROR))
    one, other = rig_of(plain), rig_of(mirrored)
    np.testing.assert_allclose(other.joints, MIRROR.points(one.joints), atol=1e-9)
    first, second = solved(plain), solved(mirrored)
    np.testing.assert_allclose(dense(first.skin), dense(second.skin), atol=1e-3)


def test_names_are_unique_whatever_parts_are_called():
    same = [part(circle(x, 0, 10), number=k, name="Leg") for k, x in enumerate((0, 60), 1)]
    odd = [
        part(capsule(0, 60, 90, 5), number=3, name=""),
        part(circle(0, -60, 9), number=4, name="Leg.2"),
    ]
    names = rig_of(state_of(*same, *odd)).names
    assert len(set(names)) == len(names)


@pytest.mark.parametrize(
    "nodes",
    [
        (),
        (Group(id="g", name="G"),),
        (replace(part(circle(0, 0, 20)), visible=False),),
        (part(capsule(0, 0, 50, 5), surface="straight"),),
        (Group(id="a", within="b"), Group(id="b", within="a"), part(circle(0, 0, 9), within="a")),
    ],
)
def test_where_nothing_has_joints_there_is_no_rig(nodes):
    state = replace(state_of(*nodes), posing=True)
    assert rig_of(state) is None
    assert joints_layer(state) is None
    result = solved(state)
    assert result.skin is None
    MODELER.scene(state, result)
    with pytest.raises(UserError):
        posed(state, drag_of(state, 0, (0, 0)))


def test_a_ball_has_one_joint_and_nothing_to_drag():
    state = replace(state_of(part(circle(0, 0, 0.5))), posing=True)
    assert len(rig_of(state).joints) == 1
    assert (solved(state).skin.weights[:, 0] == 1).all()
    with pytest.raises(UserError, match="follow this one"):
        posed(state, drag_of(state, 0, (30, 0)))


COLOURING, OTHERS = (
    [tool for tool in MODELER.tools() if (tool.group == "Colours") is colours]
    for colours in (True, False)
)


@pytest.mark.parametrize("tool", COLOURING, ids=lambda tool: tool.id)
def test_what_colours_says_how_while_posing_too(tool):
    limb = replace(state_of(part(capsule(0, 0, 80, 8))), posing=True)
    assert tool.next_step(limb).sentence == tool.hint


@pytest.mark.parametrize("tool", OTHERS, ids=lambda tool: tool.id)
def test_while_posing_every_other_tool_speaks_of_joints_and_of_nothing_else(tool):
    limb = state_of(part(capsule(0, 0, 80, 8)))
    assert tool.next_step(limb).sentence == tool.next_step(state_of()).sentence == tool.hint
    assert tool.next_step(replace(state_of(), posing=True)).sentence == tool.hint, "nothing to pose"
    said = tool.next_step(replace(limb, posing=True)).sentence
    assert said.startswith("Drag a joint")
    assert "outline" not in said
    ball = replace(state_of(part(circle(0, 0, 0.5))), posing=True)
    assert "no joint" in tool.next_step(ball).sentence


# -- dragging ------------------------------------------------------------------------------------


def drag_of(state, joint, by, camera=FRONT):
    """A drag of a joint by pixels on the sheet."""
    rig = rig_of(state)
    start = np.zeros((1, 3)) if rig is None else rig.posed()[1][[joint]]
    ((x, y),) = camera.project(start)[0]
    path = Stroke(np.linspace(x, x + by[0], 9), np.linspace(y, y + by[1], 9), camera)
    return Drag(f"joint:{joint}", path)


def ends_of(rig):
    return sorted(set(range(len(rig.joints))) - set(rig.parents.tolist()))


VIEWS = (FRONT, Camera("perspective", eye=(300, -400, 150), viewport=(900, 900)))


@pytest.mark.parametrize("camera", VIEWS, ids=["front", "askew"])
def test_a_dragged_end_arrives_under_the_pen_and_bones_keep_their_lengths(camera):
    state = state_of(WORM)
    rig = rig_of(state)
    for end in ends_of(rig):
        inwards = -np.sign(rig.joints[end, 0])
        drag = drag_of(state, end, (40 * inwards, -45), camera)
        after = rig_of(posed(state, drag))
        _, places = after.posed()
        seen = camera.project(places[[end]])[0][0]
        np.testing.assert_allclose(seen, drag.path.points[-1], atol=3.0)
        for joint, parent in enumerate(after.parents):
            if parent >= 0:
                length = np.linalg.norm(places[joint] - places[parent])
                rest = np.linalg.norm(rig.joints[joint] - rig.joints[parent])
                assert length == pytest.approx(rest, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("aside", [(5.0, -4.0), (-6.0, 3.0)])
def test_a_joint_goes_as_far_as_the_pen_wherever_it_was_held(aside):
    state = state_of(WORM)
    tip = ends_of(rig_of(state))[-1]
    held = drag_of(state, tip, (0.0, -20.0))
    x, y = (held.path.points + aside).T
    beside = replace(held, path=Stroke(x, y, FRONT))
    np.testing.assert_allclose(
        rig_of(posed(state, beside)).posed()[1], rig_of(posed(state, held)).posed()[1], atol=1e-6
    )


def test_a_touched_joint_stays_as_it_was():
    state = state_of(WORM)
    trembling = drag_of(state, ends_of(rig_of(state))[-1], (2.0, -1.0))
    assert posed(state, trembling) is state


def test_an_end_dragged_out_of_reach_points_at_the_pen():
    state = state_of(WORM)
    rig = rig_of(state)
    for end in ends_of(rig):
        _, places = rig_of(posed(state, drag_of(state, end, (0, -9000)))).posed()
        joint, length = end, 0.0
        while rig.parents[rig.parents[joint]] >= 0:
            length += np.linalg.norm(rig.joints[joint] - rig.joints[rig.parents[joint]])
            joint = rig.parents[joint]
        assert length > 20
        assert places[end, 2] - places[joint, 2] == pytest.approx(length, rel=0.01)


def test_a_straight_limb_pushed_along_itself_folds():
    state = state_of(WORM)
    rig = rig_of(state)
    end = ends_of(rig)[-1]
    towards = -np.sign(rig.joints[end, 0]) * 60
    _, places = rig_of(posed(state, drag_of(state, end, (towards, 0)))).posed()
    pixel = 300.0 / 900.0
    assert places[end, 0] == pytest.approx(rig.joints[end, 0] + towards * pixel, abs=1.0)


def test_dragging_twice_turns_one_joint_not_two():
    state = state_of(WORM)
    middle = int(rig_of(state).parents[ends_of(rig_of(state))[0]])
    once = posed(state, drag_of(state, middle, (0, -30)))
    here, there = (FRONT.project(rig_of(one).posed()[1][[middle]])[0][0] for one in (once, state))
    twice = posed(once, drag_of(once, middle, there - here))
    assert len(once.turns) == len(twice.turns) == 1
    # Ink has single precision: 900 px are exact to 6e-5 px, which are 2e-5 mm here.
    np.testing.assert_allclose(rig_of(twice).posed()[1], rig_of(state).joints, atol=2e-5)


def test_turns_wait_while_their_joint_is_away():
    arm = part(capsule(25, 0, 60, 6), number=2)
    state = state_of(part(circle(0, 0, 30), number=1), arm)
    bent = posed(state, drag_of(state, len(rig_of(state).joints) - 1, (0, -40)))
    gone = replace(bent, nodes=bent.nodes[:1])
    assert rig_of(gone).turns is None
    back = replace(gone, nodes=bent.nodes)
    np.testing.assert_array_equal(rig_of(back).turns, rig_of(bent).turns)


@pytest.mark.parametrize("within", ["", "g"], ids=["part", "group"])
@pytest.mark.parametrize("mirrored", [False, True])
def test_a_pose_goes_where_its_part_goes(within, mirrored):
    """Moved after it was posed or before, a limb stands the same."""
    bent = posed(
        state_of(WORM), drag_of(state_of(WORM), len(rig_of(state_of(WORM)).joints) - 1, (-30, -60))
    )
    rest = rig_of(bent).posed()[1]
    turn = Rotation.from_rotvec([0.4, -0.2, 0.7]).as_matrix()
    turn = turn @ np.diag([-1.0, 1.0, 1.0]) if mirrored else turn
    motion = Placement(tuple(turn.ravel()), 1.7, (200.0, 3.0, -8.0))
    group = Group(id="g", name="Group", pose=motion)
    one = replace(WORM, within="g") if within else replace(WORM, pose=motion)
    moved = replace(bent, nodes=(group, one) if within else (one,))
    np.testing.assert_allclose(rig_of(moved).posed()[1], motion.points(rest), atol=1e-9)
    assert len(rig_of(moved).turns) == len(rig_of(bent).turns)


def test_dragging_on_after_a_move_changes_the_same_turns():
    bent = posed(state_of(WORM), drag_of(state_of(WORM), 1, (0, -40)))
    moved = replace(bent, nodes=(replace(WORM, pose=MIRROR),))
    again = posed(moved, drag_of(moved, 1, (0, 10)))
    assert len(again.turns) == len(bent.turns)


def test_the_preview_is_what_comes_after():
    state = replace(horse(), posing=True)
    solved(state)
    drag = drag_of(state, ends_of(rig_of(state))[0], (25, -25))
    layers = {layer.name: layer for layer in posed_scene(state, drag).layers}
    (shaded,) = [item for item in layers["shape"].items if isinstance(item, Shaded)]
    after = solved(posed(state, drag))
    np.testing.assert_allclose(shaded.mesh.vertices, after.mesh.vertices, atol=1e-4)
    assert after.mesh.normals is not None
    np.testing.assert_allclose(np.linalg.norm(after.mesh.normals, axis=1), 1.0, atol=1e-4)
    check_solid(MODELER.shapes(state, after).solids[0])


@pytest.mark.parametrize("handle", ["joint:", "joint:999", "joint:-1", "joint:x", "joint:٣"])
def test_handles_that_are_no_joints_are_refused(handle):
    state = state_of(WORM)
    drag = replace(drag_of(state, 1, (5, 5)), handle=handle)
    with pytest.raises(UserError):
        posed(state, drag)
    assert posed_scene(state, drag).layers == ()


@pytest.mark.parametrize(
    "rotation", [(0.0, 0.0, 0.0, 0.0), (1e200, 0.0, 1e200, 0.0), (5.0, 0.0, 0.0, 0.0)]
)
def test_turns_of_a_damaged_file_break_nothing(rotation):
    state = state_of(WORM)
    joint = tuple(rig_of(state).joints[1].tolist())
    result = solved(replace(state, turns=(Turn(joint, rotation), Turn((1e9, 0, 0), rotation))))
    assert np.isfinite(result.mesh.vertices).all()
