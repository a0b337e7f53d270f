"""Styling curves: lines drawn on the body from any side, which follow its changes.

A stroke is smoothed in the image, and every place of it goes along its ray to the body. A curve
keeps the patch, u and v of these places (Kara & Shimada, CAD 2008).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.arrays import Array
from bozzetto.geometry.patches import Places, points_at
from bozzetto.ink import arc_length
from bozzetto.view import Camera
from bozzetto_car.body.body import Body
from bozzetto_car.state import StylingCurve
from bozzetto_car.styling.project_on_body import project_line
from bozzetto_car.styling.stroke_line import smooth_line
from bozzetto_car.styling.surface_path import join_paths, split_at_gaps
from bozzetto_car.template.model import Template, twin


class CurvePlaces(NamedTuple):
    """The places of a line on the body as a styling curve keeps them; see `StylingCurve`."""

    patches: tuple[str, ...]
    on: NDArray[np.int32]
    places: Array


def project_stroke(body: Body, strokes_px: ArrayLike, camera: Camera) -> CurvePlaces:
    """Project a stroke onto the visible side of the body.

    Parameters
    ----------
    body : Body
        The body to draw on.
    strokes_px : (n, 2) array_like
        A stroke as drawn, px; it is smoothed first.
    camera : Camera
        The view that the stroke was drawn in.

    Returns
    -------
    CurvePlaces
        The longest stretch, where the stroke misses the body or leads to parts behind others.

    Raises
    ------
    UserError
        If the stroke is a dot or misses the body.
    """
    paths = project_line(body.template, body.nets, smooth_line(strokes_px), camera)
    lengths = [arc_length(camera.project(points_at(body.nets, path))[0])[-1] for path in paths]
    return _kept(body.template, paths[int(np.argmax(lengths))])


def _kept(template: Template, path: Places) -> CurvePlaces:
    """Return a path in the form that a styling curve keeps."""
    numbers, on = np.unique(path.patches, return_inverse=True)
    names = tuple(template.patches[number].name for number in numbers.tolist())
    return CurvePlaces(names, on.astype(np.int32), path.parameters)


def curve_paths(curve: StylingCurve, nets: Array, template: Template) -> list[Places]:
    """Return the paths of a styling curve on a body: one, if the body has all of its patches.

    Parameters
    ----------
    curve : StylingCurve
        The styling curve.
    nets : (k, 4, 4, 3) float
        Control nets of the body, mm.
    template : Template
        The template of the body.
    """
    known = {patch.name: number for number, patch in enumerate(template.patches)}
    numbers = np.array([known.get(name, -1) for name in curve.patches], np.intp)
    patches = numbers[curve.on]
    paths: list[Places] = []
    for run in np.split(np.arange(len(patches)), np.flatnonzero(np.diff(patches >= 0)) + 1):
        if len(run) and patches[run[0]] >= 0:
            paths += split_at_gaps(nets, Places(patches[run], curve.places[run]))
    return paths


def with_paths(curve: StylingCurve, body: Body, paths: Sequence[Places]) -> StylingCurve:
    """Return a curve that runs on other paths of a body."""
    new = _kept(body.template, join_paths(paths))
    return replace(curve, patches=new.patches, on=new.on, places=new.places)


def mirror_curve(curve: StylingCurve) -> StylingCurve:
    """Return the mirror image of a curve: on the other side's patches u and v are exchanged."""
    return replace(
        curve, patches=tuple(map(twin, curve.patches)), places=curve.places[:, ::-1].copy()
    )


def stem_of(name: str) -> str:
    """Return a name without its number, as a stem for the name of a derived curve."""
    return name.rstrip(" 0123456789") or name
