"""A USD scene: the tree of parts, their skeletons and their materials."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.exchange.handover import MM_PER, FileFrame
from bozzetto.exchange.mesh.gltf_motion import drawn_parts, is_still, quaternions
from bozzetto.exchange.mesh.picture_places import Checkpoint, no_checkpoint, picture_places
from bozzetto.exchange.usd.looks import Looks
from bozzetto.exchange.usd.mesh_prims import mesh_prim
from bozzetto.exchange.usd.prims import FULL, PLACES, Names, Prim, samples, tokens
from bozzetto.exchange.usd.skeletons import BINDING, RATE, put_skin, skeleton_prims
from bozzetto.geometry.placement import Placement
from bozzetto.geometry.rig import Rig, same_rig
from bozzetto.geometry.shapes import Shapes, Solid, Surface

ROOT: Final = "Model"
MATERIALS: Final = "Materials"


@dataclass
class _Holder:
    """A prim that holds others, with its path, and those in it by their names for people."""

    prim: Prim
    path: str
    names: Names = field(default_factory=Names)
    inner: dict[str, _Holder] = field(default_factory=dict)

    def held(self, name: str, type: str = "Xform") -> _Holder:
        """Return the holder of a name in it; a new one where there is none."""
        if name not in self.inner:
            own = self.names.new(name)
            self.inner[name] = _Holder(Prim(type, own, name), f"{self.path}/{own}")
            self.prim.children.append(self.inner[name].prim)
        return self.inner[name]


def stage_text(
    shapes: Shapes,
    frame: FileFrame,
    picture_name: Callable[[int], str],
    *,
    uvs: bool = False,
    checkpoint: Checkpoint = no_checkpoint,
    motions: Sequence[Sequence[Placement]] = (),
    seconds: Sequence[float] = (),
) -> tuple[str, dict[str, bytes]]:
    """Return a scene as text, and the pictures that it names.

    Parts are meshes, in prims of the names that they are in (`Solid.path`). Parts on equal rigs
    stand with their skeleton in one prim.

    Parameters
    ----------
    shapes : Shapes
        In the unit and the axes of the frame.
    frame : FileFrame
        Its unit and axis are said at the top.
    picture_name : callable
        Gives the file of a picture by its number, from 1.
    uvs : bool
        Whether parts without a picture get places in one that somebody may paint: one for all.
    checkpoint : callable
        Called with the fraction done and the step's name meanwhile; may raise to stop it.
    motions, seconds
        Where each part is at each of these times, as seen from where it is written.

    Returns
    -------
    text : str
    pictures : dict of str to bytes
    """
    parts = list(drawn_parts(shapes).meshes())
    root = _Holder(Prim("Xform", ROOT), f"/{ROOT}")
    looks = Looks(f"/{ROOT}/{root.names.new(MATERIALS)}", picture_name)
    rigs: list[tuple[Rig, _Holder, str]] = []
    holding = {(*part.path[:k],) for part in parts for k in range(1, len(part.path) + 1)}
    laid = picture_places(parts, checkpoint) if uvs else [None] * len(parts)
    for number, part in enumerate(parts):
        holder, skeleton = root, ""
        if part.skin is not None:
            rig = part.skin.rig
            known = next((row for row in rigs if same_rig(row[0], rig)), None)
            if known is None:
                known = (rig, *_figure(root, part))
                rigs.append(known)
            _, holder, skeleton = known
        for name in part.path:
            holder = holder.held(name)
        if (*part.path, part.name) in holding:
            holder = holder.held(part.name)  # a mesh may hold no meshes
        made = mesh_prim(holder.names.new(part.name), part, looks, laid[number])
        if part.skin is not None:
            put_skin(made, part.skin, skeleton)
        elif motions:
            _put_motion(made, motions[number], np.asarray(seconds, float) * RATE)
        holder.prim.children.append(made)
    root.prim.children.append(Prim("Scope", MATERIALS, children=looks.prims))
    clips = [part.skin.clips[0] for part in parts if part.skin is not None and part.skin.clips]
    ends = [float(clip.seconds[-1]) for clip in clips] + list(seconds)[-1:]
    return _head(frame, max(ends, default=None)) + root.prim.text(), looks.pictures


def _head(frame: FileFrame, end: float | None) -> str:
    lines = [
        f'defaultPrim = "{ROOT}"',
        'doc = "Bozzetto"',
        f"metersPerUnit = {MM_PER[frame.unit] / 1000.0:g}",
        f'upAxis = "{frame.up.upper()}"',
    ]
    if end is not None:
        lines += [
            "startTimeCode = 0",
            f"endTimeCode = {FULL % (end * RATE)}",
            f"timeCodesPerSecond = {RATE:g}",
            f"framesPerSecond = {RATE:g}",
        ]
    return "#usda 1.0\n(\n" + "".join(f"    {line}\n" for line in lines) + ")\n\n"


def _figure(root: _Holder, part: Solid | Surface) -> tuple[_Holder, str]:
    """Return a new prim for what follows the rig of a part, and the path of its skeleton."""
    assert part.skin is not None
    own = root.names.new(f"{part.name}_rig")
    holder = _Holder(Prim("SkelRoot", own, f"{part.name} rig", (BINDING,)), f"{root.path}/{own}")
    root.prim.children.append(holder.prim)
    name = holder.names.new(f"{part.name}_skeleton")
    prims = skeleton_prims(name, f"{part.name} skeleton", holder.path, part.skin)
    for prim in prims[1:]:
        holder.names.new(prim.name)
    holder.prim.children += prims
    return holder, f"{holder.path}/{name}"


def _put_motion(made: Prim, motion: Sequence[Placement], times: Array) -> None:
    """Let a mesh move rigidly; not where it stands still."""
    if all(map(is_still, motion)):
        return
    places = [f"({x:.9g}, {y:.9g}, {z:.9g})" for x, y, z in (pose.offset for pose in motion)]
    turns = quaternions(np.array([pose.rotation for pose in motion]).reshape(-1, 3, 3))
    form = "(" + ", ".join([PLACES] * 4) + ")"
    made.put("double3 xformOp:translate.timeSamples", samples(times, places))
    rows = [form % tuple(turn) for turn in turns[:, [3, 0, 1, 2]].tolist()]
    made.put("quatf xformOp:orient.timeSamples", samples(times, rows))
    order = tokens(("xformOp:translate", "xformOp:orient"))
    made.put("uniform token[] xformOpOrder", order)
