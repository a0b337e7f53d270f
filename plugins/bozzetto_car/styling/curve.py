"""Styling curves: lines drawn on the body from any side, which stay on it whatever it becomes.

A stroke is smoothed in the image, every place of it goes along its ray to the body, and what is
kept is the patch, u and v (Kara & Shimada, CAD 2008).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from bozzetto.geometry.patches.patch import Places, points_at
from bozzetto.ink.curves.resample import arc_length
from bozzetto.view import Camera
from bozzetto_car.array_types import Array
from bozzetto_car.body.build import Body
from bozzetto_car.state import StylingCurve
from bozzetto_car.styling.project_on_body import laid_paths
from bozzetto_car.styling.stroke_line import smoothed_line
from bozzetto_car.styling.surface_path import joined, unbroken
from bozzetto_car.template.model import Template, twin


class Laid(NamedTuple):
    """What a styling curve keeps of a line on the body; see `StylingCurve`."""

    patches: tuple[str, ...]
    on: NDArray[np.int32]
    places: Array


def laid(body: Body, strokes_px: ArrayLike, camera: Camera) -> Laid:
    """Lay a stroke on the visible side of the body.

    Parameters
    ----------
    body : Body
    strokes_px : (n, 2) array_like
        A stroke as drawn, px; it is smoothed first.
    camera : Camera

    Returns
    -------
    Laid
        Of the longest stretch, where the stroke misses the body or leads to parts behind others.

    Raises
    ------
    UserError
        If the stroke is a dot or misses the body.
    """
    paths = laid_paths(body.template, body.nets, smoothed_line(strokes_px), camera)
    lengths = [arc_length(camera.project(points_at(body.nets, path))[0])[-1] for path in paths]
    return _kept(body.template, paths[int(np.argmax(lengths))])


def _kept(template: Template, path: Places) -> Laid:
    """The form in which a styling curve keeps a path."""
    numbers, on = np.unique(path.patches, return_inverse=True)
    names = tuple(template.patches[number].name for number in numbers.tolist())
    return Laid(names, on.astype(np.int32), path.parameters)


def curve_paths(curve: StylingCurve, nets: Array, template: Template) -> list[Places]:
    """Where a styling curve runs on a body: one path, if the body has all of its patches.

    Parameters
    ----------
    curve : StylingCurve
    nets : (k, 4, 4, 3) float
        Of the body, mm.
    template : Template
    """
    known = {patch.name: number for number, patch in enumerate(template.patches)}
    numbers = np.array([known.get(name, -1) for name in curve.patches], np.intp)
    patches = numbers[curve.on]
    paths: list[Places] = []
    for run in np.split(np.arange(len(patches)), np.flatnonzero(np.diff(patches >= 0)) + 1):
        if len(run) and patches[run[0]] >= 0:
            paths += unbroken(nets, Places(patches[run], curve.places[run]))
    return paths


def with_paths(curve: StylingCurve, body: Body, paths: Sequence[Places]) -> StylingCurve:
    """A curve that runs on other paths of a body."""
    new = _kept(body.template, joined(paths))
    return replace(curve, patches=new.patches, on=new.on, places=new.places)


def mirrored(curve: StylingCurve) -> StylingCurve:
    """The mirror image of a curve: on patches of the other side u and v are exchanged."""
    return replace(
        curve, patches=tuple(map(twin, curve.patches)), places=curve.places[:, ::-1].copy()
    )


def stem_of(name: str) -> str:
    """A name without its number: what a curve that comes of another one is called."""
    return name.rstrip(" 0123456789") or name
