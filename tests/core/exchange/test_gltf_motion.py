"""Films of rigid parts in GLB: where each part is at each time, read back from the file."""

from __future__ import annotations

import json
import struct

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from bozzetto.errors import UserError
from bozzetto.exchange.mesh.glb import write_motion
from bozzetto.exchange.mesh.gltf_motion import quaternions, rigid_motions
from bozzetto.geometry import Mesh, Placement, Shapes, Solid

CORNERS = np.array([[0, 0, 0], [30, 0, 0], [0, 20, 0], [0, 0, 10]], float)
FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


def wedge(name: str, turn: Rotation, offset: tuple[float, float, float]) -> Solid:
    return Solid(Mesh((turn.apply(CORNERS) + offset).astype(np.float32), FACES), name)


def frame(share: float) -> Shapes:
    turn = Rotation.from_euler("xyz", [1.0 * share, 5.0 * share, -2.0 * share])
    moved = wedge("moved", turn, (100.0 * share, -40.0, 7.0))
    return Shapes(solids=(wedge("still", Rotation.identity(), (0.0, 0.0, 0.0)), moved))


def parsed(data: bytes) -> tuple[dict, bytes]:
    (length,) = struct.unpack("<I", data[12:16])
    return json.loads(data[20 : 20 + length]), data[28 + length :]


def values(said: dict, blob: bytes, number: int) -> np.ndarray:
    accessor = said["accessors"][number]
    view = said["bufferViews"][accessor["bufferView"]]
    piece = blob[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    return np.frombuffer(piece, "<f4").reshape(accessor["count"], -1)


def test_a_part_is_where_it_was_in_every_frame_and_what_stands_has_no_keys():
    shares = np.linspace(0.0, 1.0, 12)
    frames = [frame(share) for share in shares]
    said, blob = parsed(write_motion(frames, list(shares)))
    (film,) = said["animations"]
    paths = {(each["target"]["node"], each["target"]["path"]): each for each in film["channels"]}
    assert set(paths) == {(1, "translation"), (1, "rotation")}
    keys = {
        path: values(said, blob, film["samplers"][each["sampler"]]["output"])
        for (_, path), each in paths.items()
    }
    primitive = said["meshes"][said["nodes"][1]["mesh"]]["primitives"][0]
    rest = values(said, blob, primitive["attributes"]["POSITION"])
    for k, now in enumerate(frames):
        there = Rotation.from_quat(keys["rotation"][k]).apply(rest) + keys["translation"][k]
        x, y, z = (now.solids[1].mesh.vertices.astype(float) / 1000.0).T
        expected = np.column_stack((x, z, -y))
        away = np.linalg.norm(there[:, None] - expected[None], axis=2).min(axis=1)
        assert away.max() < 1e-6


def test_turns_take_the_short_way_between_frames():
    turns = Rotation.from_euler("z", np.linspace(0.0, 4.0 * np.pi, 40)[:, None])
    found = quaternions(turns.as_matrix())
    assert (np.einsum("ti,ti->t", found[1:], found[:-1]) > 0.9).all()
    half = Slerp([0, 1], Rotation.from_quat(found[:2]))(0.5)
    assert half.magnitude() == pytest.approx(2.0 * np.pi / 39, rel=1e-6)


def test_what_bends_comes_or_goes_is_refused():
    bent = Solid(Mesh((CORNERS * [1.0, 1.0, 1.3]).astype(np.float32), FACES), "moved")
    still = frame(0.0).solids[0]
    with pytest.raises(UserError, match="changes its shape"):
        rigid_motions([frame(0.0), Shapes(solids=(still, bent))])
    with pytest.raises(UserError, match="come or go"):
        rigid_motions([frame(0.0), Shapes(solids=(still,))])


def test_mirrored_parts_are_no_rigid_motion():
    flipped = Solid(Mesh((CORNERS * [-1.0, 1.0, 1.0]).astype(np.float32), FACES), "moved")
    first = Shapes(solids=(wedge("moved", Rotation.identity(), (0.0, 0.0, 0.0)),))
    with pytest.raises(UserError, match="changes its shape"):
        rigid_motions([first, Shapes(solids=(flipped,))])


def test_nothing_that_moves_is_no_film():
    said, _ = parsed(write_motion([frame(0.0), frame(0.0)], [0.0, 1.0]))
    assert "animations" not in said
    assert rigid_motions([frame(0.5), frame(0.5)])[0] == [Placement(), Placement()]
