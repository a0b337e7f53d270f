"""Skeletons of a USD scene (UsdSkel), read: joints, what follows them, and their motions."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from scipy.spatial.transform import Rotation

from bozzetto.arrays import Array, Index
from bozzetto.errors import FormatError, UserError
from bozzetto.exchange.limits import MAX_COORDINATE, at_most
from bozzetto.exchange.reading import Reading
from bozzetto.exchange.usd.read_looks import absolute
from bozzetto.exchange.usd.usda_text import ReadPrim, rows_of
from bozzetto.geometry.placement import Placement
from bozzetto.geometry.rig import Clip, Rig, Skin

MAX_JOINTS: Final = 10_000

MAX_KEYS: Final = 2_000_000
"""Turns of all joints at all times of one motion."""

RIGID: Final = 1e-4
"""How far the axes of a joint may be off a rotation: what was rounded is one all the same."""

STILL: Final = 1e-7
"""Difference from no turn, and share of a size, that comes from rounding to seven digits."""

RATE: Final = 24.0
"""Frames in a second, where a file does not say it."""


@dataclass(frozen=True, eq=False)
class ReadSkeleton:
    """A skeleton in millimetres with Z up.

    Attributes
    ----------
    rig : Rig
    clips : tuple of Clip
    number : dict of str to int
        Of the joints, by their paths.
    joints : list of str
        As the file has them.
    matrix : (4, 4) float array
        From its axes to our world, for columns.
    """

    rig: Rig
    clips: tuple[Clip, ...]
    number: dict[str, int]
    joints: list[str]
    matrix: Array

    def skin(self, mesh: ReadPrim, count: int, reading: Reading) -> Skin:
        """Return how so many vertices of a mesh follow it.

        Raises
        ------
        FormatError
            If it does not say it, or says nonsense.
        """
        indices = mesh.numbers("primvars:skel:jointIndices", 1)
        shares = mesh.numbers("primvars:skel:jointWeights", 1)
        if indices is None or shares is None or len(indices) != len(shares) or not len(indices):
            raise FormatError("No vertex says which of them it follows.")
        size = mesh.remarks.get("primvars:skel:jointIndices", {}).get("elementSize", 1.0)
        width = int(size) if isinstance(size, float) and 1.0 <= size <= 64.0 else 1
        if len(indices) == width:  # one for the whole
            indices, shares = np.tile(indices, (count, 1)), np.tile(shares, (count, 1))
        if len(indices) != width * count:
            raise FormatError("There are not as many weights as vertices.")
        own = mesh.values.get("skel:joints")
        names = own if isinstance(own, list) else self.joints
        number = np.array([self.number.get(str(name), -1) for name in names], np.intp)
        rows, parts = indices.reshape(count, width), shares.reshape(count, width)
        known = np.isfinite(parts).all() and np.isfinite(rows).all()
        if not known or (rows < 0).any() or (rows >= len(number)).any():
            raise FormatError("A vertex follows one that is not there.")
        joints = number[rows.astype(np.intp)]
        if (joints < 0).any():
            raise FormatError("A vertex follows one that is not there.")
        return self._skin(joints, np.maximum(parts, 0.0), reading)

    def _skin(self, joints: Index, parts: Array, reading: Reading) -> Skin:
        rank = np.tile(np.arange(parts.shape[1]), (len(parts), 1))
        if parts.shape[1] > 4:
            rank = np.argsort(-parts, axis=1, kind="stable")[:, :4]
        kept = np.take_along_axis(parts, rank, axis=1)
        if float(kept.sum()) < float(parts.sum()) * (1.0 - 1e-6):
            reading.tell(
                "Left out of the USD file: the weakest of more than four bones that vertices "
                "follow. The four strongest are kept."
            )
        joints = np.take_along_axis(joints, rank, axis=1)
        short = ((0, 0), (0, 4 - joints.shape[1]))
        joints, kept = np.pad(joints, short), np.pad(kept, short)
        for later in range(1, 4):  # a joint that is named again
            for first in range(later):
                again = (joints[:, later] == joints[:, first]) & (kept[:, later] > 0.0)
                kept[again, first] += kept[again, later]
                kept[again, later] = 0.0
        sums = kept.sum(axis=1, keepdims=True)
        kept[sums[:, 0] <= 0.0, 0] = 1.0  # what follows nothing follows the first
        sums = kept.sum(axis=1, keepdims=True)
        kept = np.where(np.abs(sums - 1.0) <= 2.0**-23, kept, kept / sums)
        joints = np.where(kept > 0.0, joints, 0)
        return Skin(self.rig, joints.astype(np.int32), kept.astype(np.float32), clips=self.clips)


@dataclass
class ReadSkeletons:
    """The skeletons of a scene, each read once.

    Parameters
    ----------
    prims : dict of str to ReadPrim
        All of the scene, by their paths.
    worlds : dict of str to (4, 4) float array
        From the axes of prims to our world.
    rate : float
        Times in a second.
    reading : Reading
        What is told.
    """

    prims: dict[str, ReadPrim]
    worlds: dict[str, Array]
    rate: float
    reading: Reading
    _known: dict[str, ReadSkeleton | None] = field(default_factory=dict)
    _beside: dict[str, list[ReadPrim]] = field(default_factory=dict)

    def followed(self, holders: list[ReadPrim]) -> ReadSkeleton | None:
        """Return the skeleton that a mesh follows; None where it follows none that can be read.

        Parameters
        ----------
        holders : list of ReadPrim
            The mesh, and what it is in, the innermost first.
        """
        for holder in holders:
            for target in holder.targets("skel:skeleton"):
                path = absolute(target, holder.path)
                if path not in self._known:
                    self._known[path] = self._read(path)
                return self._known[path]
        return None

    def _read(self, path: str) -> ReadSkeleton | None:
        prim = self.prims.get(path)
        try:
            if prim is None or path not in self.worlds:
                raise FormatError("They are not in it.")
            return self._skeleton(prim, self.worlds[path])
        except (UserError, ValueError, np.linalg.LinAlgError) as error:
            said = error.message if isinstance(error, UserError) else "They are damaged."
            self.reading.tell(f"Left out of the USD file: the bones of a part. {said}")
            return None

    def _skeleton(self, prim: ReadPrim, world: Array) -> ReadSkeleton:
        joints = _words(prim, "joints")
        at_most(len(joints), MAX_JOINTS, "joints")
        bind = prim.numbers("bindTransforms", 16)
        if not joints or bind is None or len(bind) != len(joints):
            raise FormatError("They do not say where they are.")
        number = {path: k for k, path in enumerate(joints)}
        if len(number) < len(joints):
            raise FormatError("Two of them have one name.")
        parents = np.array([_parent(path, number) for path in joints], np.int32)
        if (parents >= np.arange(len(joints))).any():
            raise FormatError("One of them stands before the one that it hangs on.")
        frames = bind.reshape(-1, 4, 4).transpose(0, 2, 1)
        axes = _rotations(frames[:, :3, :3])
        places = frames[:, :3, 3]
        if not (np.abs(places) <= MAX_COORDINATE).all():
            raise FormatError("One of them is too far away.")
        plain = bool((axes == np.eye(3)).all())
        rest = prim.numbers("restTransforms", 16)
        turns = shifts = None
        held = _Held(places, parents, axes)
        if rest is not None and len(rest) == len(joints):
            local = rest.reshape(-1, 4, 4).transpose(0, 2, 1)
            if not (np.abs(local[:, :3, 3]) <= MAX_COORDINATE).all():
                raise FormatError("One of them stands too far away.")
            turned = Rotation.from_matrix(_rotations(local[:, :3, :3]))
            turns, shifts = held.pose(turned.as_quat()[None], local[None, :, :3, 3])
            turns, shifts = _unless_still(turns[0], shifts[0], places)
        names = _words(prim, "jointNames")
        if len(names) != len(joints) or len(set(names)) < len(names):
            names = [path.rpartition("/")[2] for path in joints]
        if len(set(names)) < len(names):
            names = joints
        rig = Rig(places, parents, tuple(names), turns, axes=None if plain else axes, shifts=shifts)
        placement = _placement(world)
        clips = []
        for one in self._motions(prim):
            clip = self._clip(one, joints, held)
            if clip is not None:
                clips.append(clip.placed(placement))
        return ReadSkeleton(rig.placed(placement), tuple(clips), number, joints, world)

    def _motions(self, skeleton: ReadPrim) -> list[ReadPrim]:
        """Return the motions of a skeleton: the one that plays first, and those beside it."""
        found = []
        for target in skeleton.targets("skel:animationSource"):
            played = self.prims.get(absolute(target, skeleton.path))
            if played is not None:
                found.append(played)
        for path in (skeleton.path, skeleton.path.rpartition("/")[0]):
            found += self._motions_in(path)
        return list(dict.fromkeys(found))

    def _motions_in(self, path: str) -> list[ReadPrim]:
        """Return the motions that a prim holds, unless they may be those of several skeletons."""
        if path not in self._beside:
            inner = self.prims[path].children if path in self.prims else []
            alone = sum(one.type == "Skeleton" for one in inner) < 2
            self._beside[path] = [one for one in inner if alone and one.type == "SkelAnimation"]
        return self._beside[path]

    def _clip(self, prim: ReadPrim, joints: list[str], held: _Held) -> Clip | None:
        """Return a motion; None where nothing moves, or it is told."""
        try:
            times = sorted(
                {time for name in ("rotations", "translations")
                 for time, _ in prim.values.get(f"{name}.timeSamples") or ()}
            )  # fmt: skip
            if len(times) < 2:
                return None
            at_most(len(times) * len(joints), MAX_KEYS, "turns of joints")
            order = _words(prim, "joints")
            if sorted(order) != sorted(joints):
                raise FormatError("It moves some joints only, or others.")
            there = {path: k for k, path in enumerate(order)}
            back = np.array([there[path] for path in joints])
            spins = _sampled(prim, "rotations", 4, times, len(order))[:, back][..., [1, 2, 3, 0]]
            moved = _sampled(prim, "translations", 3, times, len(order))[:, back]
            length = np.linalg.norm(spins, axis=2, keepdims=True)
            if not ((length > 0.0) & np.isfinite(length)).all():
                raise FormatError("It turns a joint by nothing.")
            scales = prim.numbers("scales", 3)
            if scales is not None and np.abs(scales - 1.0).max(initial=0.0) > RIGID:
                self.reading.tell("Left out of the USD file: that a motion scales bones.")
            turns, shifts = held.pose(spins / length, moved)
            still = float(np.abs(shifts).max(initial=0.0)) <= STILL * held.size
            seconds = np.array(times) / self.rate
            return Clip(
                prim.title, seconds - min(seconds[0], 0.0), turns, None if still else shifts
            )
        except (FormatError, ValueError) as error:
            said = error.message if isinstance(error, FormatError) else "It is damaged."
            self.reading.tell(f"Left out of the USD file: the motion “{prim.title[:80]}”. {said}")
            return None


@dataclass(frozen=True, eq=False)
class _Held:
    """Joints at rest, (n, 3), what each hangs on, (n,), and its axes, (n, 3, 3)."""

    places: Array
    parents: Any
    axes: Array

    @property
    def size(self) -> float:
        return float(np.abs(self.places).max(initial=1e-300))

    def pose(self, spins: Array, moved: Array) -> tuple[Array, Array]:
        """Return turns (k, n, 4) and shifts (k, n, 3) in the model's axes.

        Parameters
        ----------
        spins : (k, n, 4) float array
            Quaternions (x, y, z, w) in the axes of what each joint hangs on.
        moved : (k, n, 3) float array
            Places in these axes.
        """
        root = self.parents < 0
        around = np.where(root[:, None, None], np.eye(3), self.axes[self.parents])
        arms = self.places - np.where(root[:, None], 0.0, self.places[self.parents])
        turned = (
            Rotation.from_quat(spins.reshape(-1, 4)).as_matrix().reshape(*spins.shape[:2], 3, 3)
        )
        whole = around @ turned @ self.axes.transpose(0, 2, 1)
        turns = Rotation.from_matrix(whole.reshape(-1, 3, 3)).as_quat().reshape(spins.shape)
        return turns, np.einsum("nij,knj->kni", around, moved) - arms


def _unless_still(turns: Array, shifts: Array, places: Array) -> tuple[Array | None, Array | None]:
    """Return turns and shifts where there are any but for rounding."""
    size = float(np.abs(places).max(initial=1e-300))
    moved = float(np.abs(shifts).max(initial=0.0)) > STILL * size
    turned = float(np.abs(turns[:, :3]).max(initial=0.0)) > STILL
    return (turns if turned else None), (shifts if moved else None)


def _parent(path: str, number: dict[str, int]) -> int:
    """Return the number of the joint that one hangs on: the nearest above that there is."""
    while "/" in path:
        path = path.rpartition("/")[0]
        if path in number:
            return number[path]
    return -1


def _rotations(matrices: Array) -> Array:
    """Return rotations (n, 3, 3) without the rounding of a file.

    Raises
    ------
    FormatError
        If they stretch or mirror.
    """
    if not np.isfinite(matrices).all() or np.abs(matrices).max(initial=0.0) > 1e6:
        raise FormatError("One of them is not finite.")
    off = np.abs(matrices @ matrices.transpose(0, 2, 1) - np.eye(3)).max(initial=0.0)
    if off > RIGID or (np.linalg.det(matrices) < 0.0).any():
        raise FormatError("They are scaled or mirrored. Apply their scale first.")
    if off <= 1e-12:
        return matrices
    return np.asarray(Rotation.from_matrix(matrices).as_matrix())


def _placement(world: Array) -> Placement:
    """Return a transform (4, 4) as a placement.

    Raises
    ------
    FormatError
        If it does more than turn and scale evenly.
    """
    scale = float(np.cbrt(abs(np.linalg.det(world[:3, :3]))))
    if not 0.0 < scale < np.inf:
        raise FormatError("They are scaled to nothing.")
    turn = world[:3, :3] / scale
    if np.abs(turn @ turn.T - np.eye(3)).max() > 1e-6:
        raise FormatError("They are scaled unevenly. Apply their scale first.")
    x, y, z = world[:3, 3].tolist()
    return Placement(tuple(turn.ravel().tolist()), scale, (x, y, z))


def _words(prim: ReadPrim, name: str) -> list[str]:
    value = prim.values.get(name)
    return [str(one) for one in value] if isinstance(value, list) else []


def _sampled(prim: ReadPrim, name: str, width: int, times: list[float], count: int) -> Array:
    """Return values (k, n, width) at times; in between they go straight, beyond they stay."""
    samples = prim.values.get(f"{name}.timeSamples") or [(0.0, prim.values.get(name))]
    keys: list[float] = []
    tables: list[Array] = []
    for time, value in samples:
        if value is None:
            raise FormatError(f"It does not say its {name}.")
        rows = rows_of(value, width, name)
        if len(rows) != count or not (np.abs(rows) <= MAX_COORDINATE).all():
            raise FormatError("It has not as many values as joints.")
        if keys and time <= keys[-1]:
            raise FormatError("Its times do not grow.")
        keys.append(time)
        tables.append(rows)
    table = np.array(tables)
    after = np.clip(np.searchsorted(keys, times), 0, len(keys) - 1)
    before = np.maximum(after - 1, 0)
    span = np.array(keys)[after] - np.array(keys)[before]
    gone = np.array(times) - np.array(keys)[before]
    share = np.clip(np.divide(gone, span, out=np.ones(len(times)), where=span > 0.0), 0.0, 1.0)
    first, second = table[before], table[after]
    if width == 4:  # the shorter way round
        against = (first * second).sum(axis=2, keepdims=True) < 0.0
        second = np.where(against, -second, second)
        second = np.where(share[:, None, None] == 1.0, table[after], second)
    return np.asarray((1.0 - share[:, None, None]) * first + share[:, None, None] * second)
