"""Drawings in perspective, made parallel before they are read.

With the eye at the distance 1/k before the sheet, the corner seen at q lies at (q (1 + k Z), Z).
The axes of the solid tell k (see `axis_systems`), and then the depths Z follow: each line along an
axis has no part along the two others, which is linear in Z; and a planar face has reciprocal
depths 1 / (1 + k Z) that are linear on the sheet. The places q (1 + k Z) are a parallel drawing.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from bozzetto.arrays import Array
from bozzetto.view import Camera
from bozzetto_polyhedron.graph.planar_embedding import (
    Ring,
    components,
    embedded_faces,
    neighbors_of,
    shared_pairs,
)
from bozzetto_polyhedron.reconstruction.affine_depth import face_rows
from bozzetto_polyhedron.reconstruction.answer import Rings
from bozzetto_polyhedron.reconstruction.axis_systems import AxisSystem, axis_system
from bozzetto_polyhedron.reconstruction.drawing import Drawing
from bozzetto_polyhedron.reconstruction.planar_faces import inside

STARTS: Final = (0.15, 0.6)
"""Perspectives, 1/diagonal, from which the fit starts."""

LEAST_GAIN: Final = 1.5
"""Drop of the cost of the axes that a perspective has to bring to be believed."""

OF_CAMERA: Final = 0.2
"""Cost by which the perspective of the camera may be worse than none and is believed: people draw
without perspective on a sheet that has it."""

CERTAIN: Final = 3.0
"""Drop of the cost beyond which perspective also tells near from far."""

LEAST: Final = 0.04
"""Perspective, 1/diagonal, below which a drawing is as good as parallel."""

MOST: Final = 1.1
"""Perspective, 1/diagonal, above which none is believed: nobody draws from so near."""

MOST_OF_INK: Final = 0.62
"""Share of the length of all lines that runs along axes where a strong perspective of the camera is
taken out: axes of fewer are mostly wrong ones, and bend the drawing more than the eye does."""

STRONG: Final = 0.4
"""Perspective, 1/diagonal, from which on it is strong. A weaker one tells less of the depths, and
wrong axes bend the drawing less, in proportion."""

UNSURE: Final = 0.06
"""Root mean square difference, diagonals, from which on depths are other ones."""

OTHERWISE: Final = 2.0
"""Score that a reading loses whose depths are not those that a strong perspective tells."""

FEWEST: Final = 7
"""Lines along axes of which perspective is believed: a wedge has as many. Turning axes and moving
the eye explains five or six lines of a tetrahedron by chance."""

NEAREST: Final = 0.2
"""Least distance from the eye, in those of the sheet."""

SEATED: Final = (0.02, 2.0)
"""How far off a plane a ring may be to lie in it: diagonals, and more a diagonal of noise."""

MOST_SEATS: Final = 12
"""Faces and rings that are tried for each loose part, at most."""

MEAN: Final = 1e3
"""Weight of the condition that the mean depth is 0."""

ROUNDS: Final = 6
"""Steps of Gauss and Newton for the depths."""


@dataclass(frozen=True, eq=False)
class ParallelView:
    """A drawing as it would look from far away.

    Parameters
    ----------
    drawing : Drawing
        With straightened places, diagonals of the drawing as it was.
    flat : (n, 2) float64
        Places as drawn, seen from the point before which the eye is.
    about : (2,) float64
        That point, diagonals.
    perspective : float
        Reciprocal of the distance of the eye, 1/diagonal.
    depths : (n,) float64
        By which places were straightened.
    certain : bool
        Whether the perspective tells near from far.
    middle : (2,) float64
        Of straightened places, which is the zero of those of `drawing`.
    axes : (3, 3) float64, optional
        Axes by which places were straightened, rows right, up and away from the eye.
    """

    drawing: Drawing
    flat: Array
    about: Array
    perspective: float
    depths: Array
    certain: bool
    middle: Array = field(default_factory=lambda: np.zeros(2))
    axes: Array | None = None

    def as_drawn(self, places: Array, depths: Array) -> Array:
        """Return where straightened places are on the sheet as it was drawn, (n, 2), diagonals.

        Parameters
        ----------
        places : (n, 2) array
            In the units of `drawing`.
        depths : (n,) array
            Away from the eye, as those of this view.
        """
        away = np.maximum(1.0 + self.perspective * depths, NEAREST)
        return np.asarray((places + self.middle) / away[:, None] + self.about)

    def shape(self, depths: Array) -> Array:
        """Return corners in space that are seen where they were drawn, (n, 3), diagonals.

        Parameters
        ----------
        depths : (n,) array
            Away from the eye, of any mean.
        """
        level = depths - depths.mean() + self.depths.mean()
        away = np.maximum(1.0 + self.perspective * level, NEAREST)
        return np.column_stack((self.flat * away[:, None] + self.about, level))

    def doubt(self, depths: Array) -> float:
        """Return by how much a reading is less likely for having other depths than these.

        On whichever side of the sheet. Where the axes were not those of the solid, the depths of
        all readings are far off, and none is favoured.

        Parameters
        ----------
        depths : (n,) array
            Away from the eye, of any mean.
        """
        if self.perspective <= 0.0:
            return 0.0
        off, known = depths - depths.mean(), self.depths - self.depths.mean()
        apart = min(float(((side * off - known) ** 2).mean()) for side in (1.0, -1.0))
        strength = min(1.0, self.perspective / STRONG)
        return OTHERWISE * strength * (1.0 - float(np.exp(-apart / UNSURE**2)))

    def agrees(self, depths: Array) -> bool:
        """Whether depths are near where the perspective says so, or it says nothing."""
        off = depths - depths.mean()
        return not self.certain or float(off @ (self.depths - self.depths.mean())) >= 0.0


def parallel_view(
    drawing: Drawing, camera: Camera, faces: Sequence[Rings] | None = None
) -> ParallelView:
    """Return a drawing without its perspective: that of the camera, another one, or none.

    Parameters
    ----------
    drawing : Drawing
        In units of its own size.
    camera : Camera
        Through which it was drawn; a person may draw otherwise than it sees.
    faces : sequence of Rings, optional
        Rings of corners that lie in one plane each; those that follow from the lines of a whole
        solid without.
    """
    zero = np.zeros(2)
    plain = ParallelView(drawing, drawing.points, zero, 0.0, np.zeros(len(drawing.points)), False)
    every = np.ones(len(drawing.lines))
    parallel = axis_system(drawing, every, perspective=False)
    if parallel is None:
        parallel_cost = float(len(every))
    else:
        parallel_cost = parallel.cost
    found: list[tuple[float, float, Array, AxisSystem]] = []
    if camera.kind == "perspective":
        about = (
            (np.multiply(camera.viewport, 0.5) - drawing.center) * (1.0, -1.0) / drawing.diagonal
        )
        eye = drawing.diagonal / camera.pixels_per_mm / camera.distance
        seen = axis_system(
            replace(drawing, points=drawing.points - about), every, perspective=False, starts=(eye,)
        )
        if seen is not None and seen.share >= MOST_OF_INK * min(1.0, eye / STRONG):
            found.append((seen.cost - OF_CAMERA, eye, about, seen))
    fitted = axis_system(drawing, every, perspective=True, starts=STARTS)
    if (
        fitted is not None
        and LEAST < fitted.perspective < MOST
        and int((fitted.lines >= 0).sum()) >= FEWEST
    ):
        found.append((fitted.cost + LEAST_GAIN, fitted.perspective, zero, fitted))
    found = [each for each in found if each[0] < parallel_cost]
    if not found:
        return plain
    _, eye, about, system = min(found, key=lambda each: each[0])
    flat = drawing.points - about
    if faces is None:
        parts = _faces_of_parts(drawing)
        known: list[Rings] = [(ring,) for rings in parts for ring in rings]

        def solved(planar: Sequence[Rings]) -> Array:
            return _depths(drawing, flat, system, eye, planar)

        for seats in _seats_of_parts(drawing, parts):
            known += _level_seats(replace(drawing, points=flat), eye, known, seats, solved)
        depths = solved(known)
    else:
        depths = _depths(drawing, flat, system, eye, faces)
    straight = flat * (1.0 + eye * depths)[:, None]
    certain = parallel_cost - system.cost > CERTAIN
    middle = straight.mean(0)
    return ParallelView(
        replace(drawing, points=straight - middle),
        flat,
        about,
        eye,
        depths,
        certain,
        middle,
        system.axes,
    )


def _depths(
    drawing: Drawing, flat: Array, system: AxisSystem, eye: float, faces: Sequence[Rings]
) -> Array:
    """Return depths of mean 0 by lines along axes and by planar faces.

    Without the mean, all corners would fall together in the eye, where every equation holds.
    """
    count = len(flat)
    rows = [1e-3 * np.eye(count), np.full((1, count), MEAN / count)]
    values = [np.zeros(count), np.zeros(1)]
    for axis in range(3):
        lines = drawing.lines[system.lines == axis]
        for other in range(3):
            if other == axis or not len(lines):
                continue
            normal = system.axes[other]
            weight = eye * flat @ normal[:2] + normal[2]
            block = np.zeros((len(lines), count))
            number = np.arange(len(lines))
            block[number, lines[:, 1]] = weight[lines[:, 1]]
            block[number, lines[:, 0]] = -weight[lines[:, 0]]
            rows.append(block)
            values.append(-(flat[lines[:, 1]] - flat[lines[:, 0]]) @ normal[:2])
    matrix, right = np.vstack(rows), np.concatenate(values)
    depths = np.linalg.lstsq(matrix, right, rcond=None)[0]
    planar = face_rows(flat, range(len(flat)), faces)
    lowest = (NEAREST - 1.0) / max(eye, 1e-9)
    for _ in range(ROUNDS if len(planar) else 0):
        depths = np.clip(depths, lowest, 4.0)
        away = 1.0 + eye * depths
        slope = planar / away**2
        bent = planar @ (depths / away)
        step = np.linalg.lstsq(
            np.vstack((matrix, slope)), np.concatenate((right - matrix @ depths, -bent)), rcond=None
        )[0]
        depths = depths + step
    return np.asarray(np.clip(np.nan_to_num(depths), lowest, 4.0))


def _faces_of_parts(drawing: Drawing) -> list[tuple[Ring, ...]]:
    """Return the faces of each part that follow from its lines, the largest part first."""
    neighbors = neighbors_of(drawing.lines)
    found: list[tuple[float, tuple[Ring, ...]]] = []
    for part in components(neighbors):
        if len(part) < 4:
            continue
        rings = embedded_faces({corner: neighbors[corner] for corner in part})
        if rings is not None and not shared_pairs(rings):
            size = float(np.linalg.norm(np.ptp(drawing.points[list(part)], axis=0)))
            found.append((size, rings))
    return [rings for _, rings in sorted(found, key=lambda each: -each[0])]


def _seats_of_parts(
    drawing: Drawing, parts: Sequence[tuple[Ring, ...]]
) -> Iterator[list[tuple[Ring, Ring]]]:
    """Yield of each part but the first its rings that appear inside a face of a larger one."""
    for number, part in enumerate(parts[1:], start=1):
        faces = [face for other in parts[:number] for face in other]
        seats = [
            (face, ring)
            for face in faces
            for ring in part
            if bool(inside(drawing.points[list(ring)], drawing.points[list(face)]).all())
        ]
        if seats:
            yield sorted(seats, key=lambda seat: _lightness(drawing, (*seat[0], *seat[1])))


def _lightness(drawing: Drawing, corners: Sequence[int]) -> float:
    """Return how light the lines between some corners are."""
    between = np.isin(drawing.lines, corners).all(1)
    return float(drawing.light[between].mean()) if between.any() else 0.0


def _level_seats(
    drawing: Drawing,
    eye: float,
    known: Sequence[Rings],
    seats: Sequence[tuple[Ring, Ring]],
    solved: Callable[[Sequence[Rings]], Array],
) -> list[Rings]:
    """Return seats of a loose part that lie in one plane each.

    Lines and faces leave open how deep such a part lies. It is put where most of its rings lie in
    faces, both of a hole; of ways that are alike, where lines are drawn most firmly.

    Parameters
    ----------
    drawing : Drawing
        As seen from the point before which the eye is.
    eye : float
        Perspective, 1/diagonal.
    known : sequence of Rings
        Faces that are planar.
    seats : sequence of (Ring, Ring)
        A face and a ring of the part inside it, the firmest first.
    solved : callable
        Depths, (n,), for which given faces are planar.
    """
    near = SEATED[0] + SEATED[1] * drawing.noise
    corners = range(len(drawing.points))
    best: list[Rings] = []
    most = 0
    for seat in seats[:MOST_SEATS]:
        depths = solved([*known, seat])
        bent = depths / (1.0 + eye * depths)
        level: list[Rings] = [
            each
            for each in seats
            if float(np.abs(face_rows(drawing.points, corners, [each]) @ bent).max()) < near
        ]
        rings = {each[1] for each in level}
        if len(rings) > most:
            best, most = level, len(rings)
    return best
