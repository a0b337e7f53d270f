"""Where faces lie over lines on the sheet: the same for all depths, so each is asked once."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto_polyhedron.graph.planar_embedding import Ring
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.planar_faces import inside

SAMPLES: Final = 7
"""Places on each line that are looked at."""

SHARES: Final = np.linspace(0.08, 0.92, SAMPLES)
"""Where on the line they are, from its smaller corner on."""


@dataclass(frozen=True, eq=False)
class CoveredLines:
    """Which places on the lines of a drawing are inside faces, as far as it was asked.

    Parameters
    ----------
    points : (n, 2) float64
        Corners, diagonals.
    lines : (m, 2) intp
        Numbers of corners.
    """

    points: Array
    lines: Index
    _samples: dict[Rings, Flags] = field(default_factory=dict)
    _middles: dict[Ring, Flags] = field(default_factory=dict)

    def samples(self, face: Rings) -> Flags:
        """Return which samples of lines are inside a face and not on lines of it, (m * SAMPLES,).

        Parameters
        ----------
        face : Rings
            Its outer ring, then its holes.
        """
        found = self._samples.get(face)
        if found is None:
            start, stop = self.points[self.lines[:, 0], None], self.points[self.lines[:, 1], None]
            places = (start + SHARES[:, None] * (stop - start)).reshape(-1, 2)
            members = [corner for ring in face for corner in ring]
            found = np.repeat(~np.isin(self.lines, members).all(1), SAMPLES)
            covered = np.zeros(len(places), bool)
            for ring in face:
                covered ^= inside(places, self.points[list(ring)])
            found = self._samples[face] = found & covered
        return found

    def middles(self, ring: Ring) -> Flags:
        """Return which middles of lines are inside a ring, (m,).

        Parameters
        ----------
        ring : Ring
            Corners, once round.
        """
        found = self._middles.get(ring)
        if found is None:
            places = self.points[self.lines].mean(1)
            found = self._middles[ring] = inside(places, self.points[list(ring)])
        return found
