"""A pen without a hand: strokes as a person would draw them, the same at every run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from bozzetto.arrays import Array
from bozzetto.ink.stroke import Stroke, StrokeTool
from bozzetto.view.camera import Camera


@dataclass(frozen=True)
class Pen:
    """Draws strokes through a camera.

    Parameters
    ----------
    camera : Camera
        Its viewport is the canvas, 1200 × 900 px by default.
    tremor : float
        How far the hand shakes, px (standard deviation); the shaking is smooth.
    pressure : float or sequence of float
        0 … 1; several values are spread evenly along the stroke.
    speed : float
        px/s.
    rate : float
        Samples per second.
    seed : int
        Pens of one seed shake alike.
    tool : {"pen", "eraser", "mouse", "imported"}
    """

    camera: Camera = field(default_factory=Camera)
    tremor: float = 0.0
    pressure: float | Sequence[float] = 0.6
    speed: float = 900.0
    rate: float = 240.0
    seed: int = 0
    tool: StrokeTool = "pen"

    def but(
        self,
        *,
        camera: Camera | None = None,
        tremor: float | None = None,
        pressure: float | Sequence[float] | None = None,
        seed: int | None = None,
        tool: StrokeTool | None = None,
    ) -> Pen:
        """Return the same pen with something changed."""
        return replace(
            self,
            camera=camera or self.camera,
            tremor=self.tremor if tremor is None else tremor,
            pressure=self.pressure if pressure is None else pressure,
            seed=self.seed if seed is None else seed,
            tool=tool or self.tool,
        )

    def along(self, points: ArrayLike) -> Stroke:
        """Draw a stroke along a polyline.

        Parameters
        ----------
        points : (n, 2) array_like
            Canvas pixels, y down.

        Returns
        -------
        Stroke
            Sampled in time, with the first and the last point.
        """
        path = np.reshape(np.asarray(points, np.float64), (-1, 2))
        run = np.concatenate(([0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))))
        count = max(2, int(np.ceil(run[-1] / self.speed * self.rate)) + 1) if run[-1] > 0 else 1
        at = np.linspace(0.0, run[-1], count)
        x, y = (np.interp(at, run, path[:, axis]) for axis in (0, 1))
        shake = self.tremor * _smooth_noise(count, self.seed)
        levels = np.atleast_1d(np.asarray(self.pressure, np.float64))
        along = np.linspace(0.0, 1.0, count)
        pressure = np.interp(along, np.linspace(0.0, 1.0, len(levels)), levels)
        return Stroke(
            x + shake[:, 0],
            y + shake[:, 1],
            self.camera,
            pressure=pressure,
            t=at / self.speed,
            tool=self.tool,
        )

    def polygon(self, *corners: tuple[float, float]) -> Stroke:
        """Draw a closed outline through corners, back to the first."""
        return self.along([*corners, corners[0]])

    def circle(self, x: float = 600.0, y: float = 450.0, radius: float = 200.0) -> Stroke:
        """Draw a closed circle, clockwise on the sheet from its right end."""
        turn = np.linspace(0.0, 2.0 * np.pi, 181)
        return self.along(np.column_stack((x + radius * np.cos(turn), y + radius * np.sin(turn))))

    def dot(self, x: float = 600.0, y: float = 450.0) -> Stroke:
        """Draw a touch: a stroke of one sample."""
        return self.along([(x, y)])


def _smooth_noise(count: int, seed: int) -> Array:
    """Return noise of unit deviation that is correlated over some samples, shape (count, 2)."""
    window = np.hanning(11)[1:-1]
    rough = np.random.default_rng(seed).normal(size=(count + len(window) - 1, 2))
    window /= np.sqrt(np.sum(window**2))
    columns = [np.convolve(rough[:, axis], window, "valid") for axis in (0, 1)]
    return np.column_stack(columns)
