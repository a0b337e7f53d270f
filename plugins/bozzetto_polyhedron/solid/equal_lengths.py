"""Lengths of a body that are probably meant to be the same."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import suppress
from itertools import pairwise
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto_polyhedron.solid.exact import EqualLengths
from bozzetto_polyhedron.solid.face_rings import edges_of
from bozzetto_polyhedron.solid.planar_body import PlanarBody

ALIKE: Final = 2.0
"""Standard deviations of a corner within which two lengths may be the same."""

LARGEST_SHARE: Final = 0.1
"""Share of the shorter length that this may be: short lengths are all alike within the noise."""

SAME: Final = 1e-9
"""Share of the size, and of 1 for cosines, below which planes are one or parallel."""


def equal_lengths(body: PlanarBody, noise: float) -> tuple[EqualLengths, ...]:
    """Propose lengths that are probably equal, the most alike first.

    Only distances between parallel faces count that an edge shows: one that runs from one face to
    the other. Each distance is compared with the nearest one alone, so that the proposals do not
    contradict one another.

    Parameters
    ----------
    body : PlanarBody
        As it was drawn.
    noise : float
        Standard deviation of a corner, mm.
    """
    spans = _spans(body)
    spans.sort(key=lambda span: (span[0], span[1]))
    found = []
    for (one, first), (two, second) in pairwise(spans):
        apart = two - one
        if apart <= min(ALIKE * noise, LARGEST_SHARE * one):
            found.append((apart, EqualLengths(first, second)))
    found.sort(key=lambda item: (item[0], item[1].first))
    return tuple(each for _, each in found)


def with_equal_lengths(fit: Callable[..., PlanarBody], noise: float) -> PlanarBody:
    """Return a body of which lengths that are probably equal are so to the last digits.

    All are taken where they go together, else one after the other, the most alike first, as far as
    they agree with what was typed and turn no face over.

    Parameters
    ----------
    fit : callable
        `exact_body` of a drawing; gets lengths that are to be equal as ``equal``.
    noise : float
        Standard deviation of a corner, mm.
    """
    body = fit()
    offered = equal_lengths(body, noise)
    if not offered:
        return body
    with suppress(UserError):
        return fit(equal=offered)
    taken: tuple[EqualLengths, ...] = ()
    for each in offered:
        with suppress(UserError):
            body = fit(equal=(*taken, each))
            taken = (*taken, each)
    return body


def _spans(body: PlanarBody) -> list[tuple[float, tuple[int, int]]]:
    """Return distances between parallel faces that an edge joins, each pair of planes once."""
    faces_at: dict[int, set[int]] = {}
    for number, face in enumerate(body.faces):
        for vertex in (v for ring in face for v in ring):
            faces_at.setdefault(vertex, set()).add(number)
    plane = _planes(body)
    found: dict[tuple[int, int], tuple[float, tuple[int, int]]] = {}
    for start, end in edges_of(body.faces).tolist():
        own = faces_at[start] & faces_at[end]
        for one in sorted(faces_at[start] - own):
            for two in sorted(faces_at[end] - own):
                cosine = float(body.normals[one] @ body.normals[two])
                if abs(cosine) > 1.0 - SAME:
                    length = abs(float(body.offsets[one] - np.sign(cosine) * body.offsets[two]))
                    pair = (min(plane[one], plane[two]), max(plane[one], plane[two]))
                    found.setdefault(pair, (length, (one, two)))
    return list(found.values())


def _planes(body: PlanarBody) -> list[int]:
    """Return for each face the first one in the same plane."""
    size = float(np.ptp(body.vertices, axis=0).max())
    same = []
    for number, (normal, offset) in enumerate(zip(body.normals, body.offsets, strict=True)):
        cosines = body.normals[:number] @ normal
        level = np.abs(body.offsets[:number] - np.sign(cosines) * offset) < SAME * size
        known = np.flatnonzero((np.abs(cosines) > 1.0 - SAME) & level)
        same.append(int(known[0]) if len(known) else number)
    return same
