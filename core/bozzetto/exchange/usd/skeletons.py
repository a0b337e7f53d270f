"""Skeletons of a USD scene (UsdSkel): joints at rest, what follows them, and their motions.

Joints are named by their paths. A skeleton's *bind* transforms say where joints are while the mesh
is as it is written, its *rest* transforms how it stands where no motion plays: as it is posed.
"""

from __future__ import annotations

from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.exchange.mesh.gltf_motion import nearest
from bozzetto.exchange.mesh.gltf_skin import follows, local_places, local_turns
from bozzetto.exchange.usd.prims import (
    DIRECTIONS,
    PLACES,
    Names,
    Prim,
    matrices,
    numbers,
    samples,
    tokens,
    tuples,
)
from bozzetto.geometry.rig import Clip, Rig, Skin

RATE: Final = 24.0
"""Frames in a second; times between them are kept."""

BINDING: Final = "SkelBindingAPI"


def skeleton_prims(name: str, title: str, path: str, skin: Skin) -> list[Prim]:
    """Return the skeleton of a rig and its motions, of which the first one plays.

    Parameters
    ----------
    name, title : str
        Identifier and name of the skeleton.
    path : str
        Of the prim that will hold them.
    skin : Skin
        In the unit and the axes of the file.
    """
    rig = skin.rig
    joints = joint_paths(rig)
    made = Prim("Skeleton", name, title, (BINDING,))
    made.put("uniform token[] joints", tokens(joints))
    made.put("uniform token[] jointNames", tokens(rig.names))
    bind = np.tile(np.eye(4), (len(joints), 1, 1))
    bind[:, :3, :3] = np.eye(3) if rig.axes is None else rig.axes
    bind[:, :3, 3] = rig.joints
    made.put("uniform matrix4d[] bindTransforms", matrices(bind))
    made.put("uniform matrix4d[] restTransforms", matrices(_stance(rig)))
    names = Names()
    names.new(name)
    motions = [_motion(names.new(clip.name, "motion"), clip, rig, joints) for clip in skin.clips]
    if motions:
        made.lines.append(f"rel skel:animationSource = <{path}/{motions[0].name}>")
    return [made, *motions]


def joint_paths(rig: Rig) -> list[str]:
    """Return the path of every joint, its parents first."""
    names = Names()
    paths: list[str] = []
    for name, parent in zip(rig.names, rig.parents.tolist(), strict=True):
        own = names.new(name, "joint")
        paths.append(own if parent < 0 else f"{paths[parent]}/{own}")
    return paths


def put_skin(mesh: Prim, skin: Skin, skeleton: str) -> None:
    """Let the vertices of a mesh follow the joints of a skeleton, which is named by its path."""
    joints, weights = follows(skin, np.arange(len(skin.joints)))
    each = '(\n        elementSize = 4\n        interpolation = "vertex"\n    )'
    mesh.schemas = (*mesh.schemas, BINDING)
    mesh.put("int[] primvars:skel:jointIndices", f"{numbers(joints.ravel())} {each}")
    mesh.put("float[] primvars:skel:jointWeights", f"{numbers(weights.ravel(), PLACES)} {each}")
    mesh.put("matrix4d primvars:skel:geomBindTransform", matrices(np.eye(4)[None])[1:-1])
    mesh.lines.append(f"rel skel:skeleton = <{skeleton}>")


def _stance(rig: Rig) -> Array:
    """Return where joints are in the axes of their parents as they are posed, (n, 4, 4)."""
    from scipy.spatial.transform import Rotation

    found = np.tile(np.eye(4), (len(rig.joints), 1, 1))
    turns = local_turns(rig, rig.turns)
    if turns is not None:
        found[:, :3, :3] = Rotation.from_quat(turns).as_matrix()
    found[:, :3, 3] = local_places(rig, rig.shifts)
    return found


def _motion(name: str, clip: Clip, rig: Rig, joints: list[str]) -> Prim:
    """Return a clip as an animation of all joints."""
    made = Prim("SkelAnimation", name, clip.name)
    made.put("uniform token[] joints", tokens(joints))
    times = clip.seconds * RATE
    if clip.shifts is None:
        made.put("float3[] translations", tuples(local_places(rig, None), PLACES))
    else:
        places = [tuples(rows, PLACES) for rows in local_places(rig, clip.shifts)]
        made.put("float3[] translations.timeSamples", samples(times, places))
    turns = nearest(np.array(local_turns(rig, clip.turns)))
    rows = [tuples(one[:, [3, 0, 1, 2]], PLACES) for one in turns]
    made.put("quatf[] rotations.timeSamples", samples(times, rows))
    made.put("half3[] scales", tuples(np.ones((len(joints), 3)), DIRECTIONS))
    return made
