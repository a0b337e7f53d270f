"""How far the mirror image of a curve on a surface is from its ink, and what would bring it nearer.

Of a curve that is its own mirror image the ink shows both halves: from one half and the surface in
which the curve lies follows where the other half is seen.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.ink import resample
from bozzetto.plugin import cached_property
from bozzetto_symmetry.stereo.bowed_plane import FIGURES, BowedPlane
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo
from bozzetto_symmetry.stereo.uncertainty import image_slopes

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

FINE: Final = 480
"""Places of the ink among which the nearest one is looked for."""

REACH: Final = 6
"""Of these, to either side over which the direction of the ink is taken."""

SHOWN: Final = 0.8
"""Least share of a half whose mirror image is not beyond the ends of the ink."""

MEASURES: Final = 3.5
"""Independent measurements along half a stroke: a tremor stays alike over a 25th of it."""

USUAL: Final = 6.0
"""How many measurements it is worth to know that a hand errs by about 1 px."""

CONTRADICTED: Final = 9.0
"""Gain in squared errors of the hand by which a bend is more than tremor: one in a hundred flat
curves gains as much."""

ENDS: Final = 2.0
"""How much worse a hand ends in the right place than it keeps on the curve: the ends of a line are
each other's mirror images, and say so along the ink where all else speaks across it."""

CARELESS: Final = 3.0
"""Errors of such a hand beyond which an end was not meant there, and says little more."""

ASIDE: Final = 0.1
"""Error of the hand, px, by which it is worked out how far it is carried."""

FARTHEST: Final = 1e3
"""Distance, px, that counts where an end cannot be seen at all."""


@dataclass(frozen=True, eq=False)
class InkLine:
    """A line as places close to one another, with its normals.

    Attributes
    ----------
    pixels, normals : (n, 2) float
    ring : bool
    backwards : bool
        The half whose places are known was drawn first, towards the crossing.
    """

    pixels: Array
    normals: Array
    ring: bool
    backwards: bool

    @classmethod
    def of(cls, pixels: Array, ring: bool, backwards: bool = False) -> InkLine:
        """Return a line (n, 2) px at even steps."""
        fine = resample(pixels, count=FINE, closed=ring)
        way = np.roll(fine, -REACH, axis=0) - np.roll(fine, REACH, axis=0)
        if not ring:
            index = np.arange(FINE)
            way = fine[np.minimum(index + REACH, FINE - 1)] - fine[np.maximum(index - REACH, 0)]
        length = np.linalg.norm(way, axis=1, keepdims=True)
        normals = np.column_stack((-way[:, 1], way[:, 0])) / np.maximum(length, 1e-12)
        return cls(fine, normals, ring, backwards)

    @property
    def ends(self) -> tuple[Array, Array, Array]:
        """The end of the known half and that of the other one, px; the direction of the latter."""
        line, normals = self.pixels, self.normals
        if not self.backwards:
            line, normals = line[::-1], normals[::-1]
        way = np.array((normals[-1, 1], -normals[-1, 0]))
        return line[:1], line[-1], way

    def nearest(self, places: Array) -> Index:
        """Return the numbers of the nearest places of the line."""
        finite = np.isfinite(places).all(axis=1)
        found = np.zeros(len(places), np.intp)
        found[finite] = self._tree.query(places[finite])[1]
        return found

    @cached_property
    def _tree(self) -> cKDTree:
        from scipy.spatial import cKDTree

        return cKDTree(self.pixels)

    def shown(self, feet: Index) -> Flags:
        """Return which feet are not beyond an end of the line."""
        if self.ring:
            return np.ones(len(feet), bool)
        return np.asarray((feet > 0) & (feet < len(self.pixels) - 1))


@dataclass(frozen=True, eq=False)
class MirrorImage:
    """Where the mirror image of a line on a surface is seen, and what moves it.

    Attributes
    ----------
    points, depths : (n, 3) float
        Places of the line, mm, and how they move along their rays as the surface rises by 1 mm.
    pixels, moved : (n, 2) float
        Their mirror images, and how these move where the line is 1 px aside.
    """

    points: Array
    depths: Array
    pixels: Array
    moved: Array

    @classmethod
    def of(cls, stereo: Stereo, line: Array, surface: BowedPlane) -> MirrorImage:
        """Return the mirror image of a line (n, 2) px, its places in order."""
        way = np.gradient(line, axis=0)
        length = np.sqrt((way**2).sum(axis=1, keepdims=True))
        across = np.column_stack((-way[:, 1], way[:, 0])) / np.maximum(length, 1e-12)
        points, rays, slopes = surface.met(stereo, np.vstack((line, line + ASIDE * across)))
        images = stereo.project(points * MIRROR)
        count = len(line)
        return cls(
            points[:count], (rays / slopes[:, None])[:count], images[:count],
            (images[count:] - images[:count]) / ASIDE,
        )  # fmt: skip

    def shares(self, normals: Array) -> Array:
        """Return what a distance from the ink counts for, (n,): 1 where both halves look alike.

        The hand errs in either half. Its error in the known one moves the mirror image by another
        amount where a plane seen at a small angle shows one half much longer than the other: so
        what is counted is a distance over what both errors make of it (Sampson, 1982).

        Parameters
        ----------
        normals : (n, 2) float
            Of the ink at the images.
        """
        carried = np.nan_to_num((self.moved * normals).sum(axis=1))
        return np.asarray(np.sqrt(2.0 / (1.0 + carried**2)))


def equations(
    stereo: Stereo, near: Array, ink: InkLine, feet: Index | None, surface: BowedPlane
) -> tuple[Array, Array, Array] | None:
    """Return how far the mirror image is from the ink, and the derivatives of that.

    Without feet the nearest places of the ink are taken.

    Returns
    -------
    rest : (m,) float
        Across the ink, px, of the places whose image is not beyond its ends; then along it at its
        end.
    columns : (m, 5) float
        By the figures of the surface.
    images : (n, 2) float
        Of all places mirrored, px.
    """
    seen = MirrorImage.of(stereo, near, surface)
    images = seen.pixels
    if not np.isfinite(images).all():
        return None
    feet = ink.nearest(images) if feet is None else feet
    shown = ink.shown(feet)
    if shown.mean() < SHOWN:
        return None
    normals = ink.normals[feet]
    share = seen.shares(normals)
    rest = share * ((images - ink.pixels[feet]) * normals).sum(axis=1)
    columns = _columns(stereo, surface, seen.points, seen.depths, share[:, None] * normals)
    rest, columns = rest[shown], columns[shown]
    if not ink.ring:
        off, row = _at_end(stereo, ink, surface)
        end = float(np.sqrt(len(rest) / MEASURES)) / ENDS
        end /= float(np.hypot(1.0, off / (CARELESS * ENDS * np.sqrt(2.0))))
        rest, columns = np.append(rest, end * off), np.vstack((columns, end * row))
    return rest, columns, images


def _columns(stereo: Stereo, surface: BowedPlane, points: Array, rays: Array, ways: Array) -> Array:
    """Return how far mirror images move along ways on the sheet for each figure, (n, 5) px."""
    slopes = image_slopes(stereo, points * MIRROR) * MIRROR
    moved = np.einsum("ni,nij,nj->n", ways, slopes, rays)
    return np.asarray(surface.moves(points) * moved[:, None])


def _at_end(stereo: Stereo, ink: InkLine, surface: BowedPlane) -> tuple[float, Array]:
    """Return how far beyond its end the mirror image of the other end is, px, and its row."""
    end, other, way = ink.ends
    # What the hand errs by at the known end, along the line and across it, is carried as well.
    aside = ASIDE * np.vstack((np.zeros((1, 2)), np.eye(2)))
    points, rays, slopes = surface.met(stereo, end + aside)
    images = stereo.project(points * MIRROR)
    if not np.isfinite(images).all():
        return FARTHEST, np.zeros((1, FIGURES))
    row = _columns(stereo, surface, points[:1], rays[:1] / slopes[:1, None], way[None])
    carried = (images[1:] - images[0]) @ way / ASIDE
    kept = float(np.sqrt(2.0 / (1.0 + carried @ carried)))
    return kept * float((images[0] - other) @ way), kept * row
