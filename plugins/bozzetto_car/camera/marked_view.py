"""A sketch with its marks, in the units in which cameras and shape are solved together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Final, NamedTuple

import numpy as np

from bozzetto.arrays import Array, Flags, Index
from bozzetto.errors import UserError
from bozzetto.geometry import frozen
from bozzetto.view import Camera
from bozzetto.view.calibration import CROPPED, NEAREST, PARAMETERS, Framing, Poses, freedom
from bozzetto_car.template.model import Template

FEWEST_MARKS: Final = 4
"""Fewest marks of a sketch that determine a camera: it has seven numbers, a mark tells two."""

PRINCIPAL: Final = 7
"""Index of the first of the two numbers of a pose that are its principal point."""

MOST_VIEWS: Final = 8
"""Most sketches of one car that are solved together."""

FARTHEST_MARK: Final = 20.0
"""Farthest mark from the middle of the picture, in its diagonals. Marks may lie off the
picture, but not so far that nobody could have set them."""

LEAST_EXTENT: Final = 0.01
"""Least diagonal of the marks' box that counts, in diagonals of the picture: of marks that
all lie in one place, none is exact to 0 px."""


@dataclass(frozen=True, eq=False)
class MarkedView:
    """One sketch of the car with its marks and a camera.

    Attributes
    ----------
    camera : Camera
        Its viewport is the picture; the solve starts here.
    nodes : (k,) int
        Marked nodes of the template, each once.
    marks : (k, 2) float
        Their places in the picture, px.
    shift : (float, float)
        Shift of the principal point from the middle of the picture, px.
    cropped : bool
        Whether the principal point is free.

    Raises
    ------
    UserError
        If there are fewer than four marks, or a mark is not finite or far beyond the picture.
    ValueError
        If nodes and marks do not belong together.
    """

    camera: Camera
    nodes: Index
    marks: Array
    shift: tuple[float, float] = (0.0, 0.0)
    cropped: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "nodes", frozen(self.nodes, np.intp))
        object.__setattr__(self, "marks", frozen(self.marks, np.float64, 2))
        if len(self.nodes) != len(self.marks) or len(np.unique(self.nodes)) < len(self.nodes):
            raise ValueError("every marked node needs one mark")
        if len(self.nodes) < FEWEST_MARKS:
            raise UserError(
                f"A sketch needs {FEWEST_MARKS} marks at least, and six to find its camera. "
                "Set more marks."
            )
        off = np.abs(self.marks - 0.5 * np.array(self.camera.viewport))
        if off.max() > FARTHEST_MARK * np.hypot(*self.camera.viewport):
            raise UserError("A mark lies far beyond the picture. Set it again.")

    def turned(self, camera: Camera, shift: tuple[float, float]) -> MarkedView:
        """Return the same marks with another camera."""
        return replace(self, camera=camera, shift=shift)

    def only(self, counted: Flags) -> MarkedView:
        """Return the view with some of its marks, (k,)."""
        return replace(self, nodes=self.nodes[counted], marks=self.marks[counted])


class Residuals(NamedTuple):
    """The residuals of a sketch and their derivatives.

    Attributes
    ----------
    missed : (k, 2) float
        Place minus mark, in diagonals of the marks.
    by_nodes : (k, 2, 3) float
        Derivative by the marked nodes, per mm.
    by_camera : (k, 2, c) float
        Derivative by the free numbers of the camera.
    """

    missed: Array
    by_nodes: Array
    by_camera: Array


def framing_of(template: Template, view: MarkedView) -> Framing:
    """Return the units of a sketch, which do not depend on the car in it."""
    centroid = template.positions.mean(axis=0)
    radius = np.sqrt(((template.positions - centroid) ** 2).sum(axis=1).mean())
    return Framing(centroid, float(radius), view.camera.viewport)


@dataclass(frozen=True, eq=False)
class Reprojection:
    """A sketch as the solve sees it: everything but the pose of its camera.

    Attributes
    ----------
    framing : Framing
    nodes : (k,) int
    marks : (k, 2) float
        Places of the marks from the middle of the picture, in its diagonals.
    extent : float
        Diagonal of the marks' box, in diagonals of the picture.
    free : (c,) int
        Indices of the numbers of a pose, of nine, that are unknown.
    """

    framing: Framing
    nodes: Index
    marks: Array
    extent: float
    free: Index

    @classmethod
    def of(cls, template: Template, view: MarkedView, held: bool) -> tuple[Reprojection, Poses]:
        """Return a sketch in these units, and the pose to start from.

        Parameters
        ----------
        template : Template
            The template of the car.
        view : MarkedView
            The sketch with its marks and camera.
        held : bool
            Whether the camera stays as it is.

        Raises
        ------
        UserError
            If the camera has the car behind it.
        """
        framing = framing_of(template, view)
        pose = _posed(view, framing)
        marks = framing.marks(view.marks)
        size = float(np.linalg.norm(np.ptp(marks, axis=0)))
        sought = np.flatnonzero(freedom(pose, view.cropped)[0])
        free = np.empty(0, np.intp) if held else sought
        return cls(framing, view.nodes, marks, max(size, LEAST_EXTENT), free), pose

    def residuals(self, pose: Poses, positions: Array) -> Residuals | None:
        """Return the residuals of a pose and a car (n, 3); None if a marked node is behind it."""
        points = self.framing.points(positions[self.nodes])
        seen = pose.see(points)
        if seen.depth.min() <= NEAREST:
            return None
        unit = 1.0 / self.extent
        by_camera = pose.slopes(seen)[0, self.free].transpose(2, 1, 0) * unit
        turn, strength = pose.turn[0], pose.perspectivity[0]
        toward = (seen.places[0] - pose.principal[0])[:, :, None] * (strength * turn[2])
        scale = np.exp(pose.log_scale[0]) / self.framing.radius / seen.depth[0] * unit
        by_nodes = scale[:, None, None] * (turn[:2] - toward)
        return Residuals((seen.places[0] - self.marks) * unit, by_nodes, by_camera)

    def rows(self, seen: Residuals, follow: Array) -> Array:
        """Return the derivative of the residuals by the car and the free numbers of the camera.

        Parameters
        ----------
        seen : Residuals
            The residuals.
        follow : (n, 3, f) float
            How the nodes follow the free directions of the car.

        Returns
        -------
        (2 k, f + c) float
        """
        by_car = seen.by_nodes @ follow[self.nodes]
        rows = np.concatenate((by_car, seen.by_camera), axis=2)
        return rows.reshape(-1, rows.shape[2])

    def stepped(self, pose: Poses, step: Array) -> Poses:
        """Return the pose after a step of its free numbers (c,), within the bounds of a pose."""
        whole = np.zeros((1, PARAMETERS))
        whole[0, self.free] = step
        return pose.moved(whole)

    def middle(self, pose: Poses) -> tuple[Array, Array, float]:
        """Return the prior of the principal point: its form (c, c), slope (c,) and cost."""
        wide = np.where(self.free >= PRINCIPAL, 1.0 / CROPPED**2, 0.0)
        at = np.concatenate((np.zeros(PRINCIPAL), pose.principal[0]))[self.free]
        return np.diag(wide), wide * at, float(wide @ at**2)


def _posed(view: MarkedView, framing: Framing) -> Poses:
    camera = view.camera
    axes = camera.axes * np.array([[1.0], [-1.0], [1.0]])
    across, below, depth = axes @ (framing.centroid - np.asarray(camera.eye))
    height = camera.viewport[1]
    if camera.kind == "orthographic":
        strength, scale = 0.0, height / camera.height
    else:
        if depth <= 0.0:
            raise UserError("The camera of a sketch has the car behind it. Set the marks again.")
        focus = 0.5 * height / np.tan(np.radians(camera.fov_y) / 2.0)
        strength, scale = framing.diagonal / focus, focus / depth
    return Poses(
        axes[None],
        np.log([scale * framing.radius / framing.diagonal]),
        scale * np.array([[across, below]]) / framing.diagonal,
        np.array([strength]),
        np.array([view.shift]) / framing.diagonal,
    )
