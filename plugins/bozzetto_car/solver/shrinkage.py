"""Marks taken a little back toward the template, as far as the hand leaves open.

The likeliest car for given marks makes too much of them: what a hand gets wrong as another car
would look is taken for the car's, and on one sketch a turn of the camera, a stretch in depth and a
real difference look much alike. If a share of what looks like a difference from the template is the
hand's, the mean of all cars is that much nearer to the template, along every direction (shrinkage
toward the prior mean; James & Stein, *Estimation with quadratic loss*, 1961). To first order the
car of marks that are moved a share of the way to where the template is seen is the car moved by the
same share; camera, soundness and locked dimensions are those of a solve.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

import numpy as np

from bozzetto_car.camera.marked_view import MarkedView
from bozzetto_car.solver.prior import Cost
from bozzetto_car.template.model import Template

SHARE: Final = 0.5
"""How far marks are moved, rms, in standard deviations of the hand, less `UNMOVED`."""

UNMOVED: Final = 0.5
"""Standard deviations of a steady hand that do not count: among steady marks a miss is seen, among
unsteady ones it is not."""

MOST: Final = 0.5
"""Largest share of the way to the template that marks are moved."""


def moderated(template: Template, view: MarkedView, hand: float, say: float = 1.0) -> MarkedView:
    """Return a sketch with its marks moved toward where its camera sees the template.

    Parameters
    ----------
    template : Template
        The template of the car.
    view : MarkedView
        The sketch with the marks that count, and with the camera that the template has for it.
    hand : float
        How much less steady the hand is than usual, as a factor; 1 at least.
    say : float
        0 leaves marks where they are; 1 moves them as far as the hand leaves open.
    """
    seen = view.camera.project(template.positions[view.nodes])[0] + view.shift
    missed = view.marks - seen
    off = float(np.sqrt((missed**2).mean()))
    if not np.isfinite(off) or off == 0.0:
        return view
    usual = SHARE * (hand - UNMOVED) * Cost.balanced().hand
    open_ = usual * float(np.linalg.norm(np.ptp(view.marks, axis=0)))
    return replace(view, marks=view.marks - say * min(open_ / off, MOST) * missed)
