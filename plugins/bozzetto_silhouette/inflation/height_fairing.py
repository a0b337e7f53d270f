"""Fairing: the heights freed from ripples, as the shape of a membrane under calm pressure.

Where the field's heights have ripples (skeleton segments of different weight meet, a
correction follows every bend of the outline), the squared height u = z^2 shows them most
clearly in its Laplacian: that is constant on a ball (-4) and on a tube (-2), and -laplace(u)
is the pressure that would blow a membrane held at the outline up to u. So the pressure is
read off the heights, averaged over a share of the local radius, and the membrane is solved
again. What comes out is two orders smoother than the averaged pressure, still exact on the
outline and upright there, and balls and tubes pass unchanged.

Averaging is implicit diffusion (Desbrun, Meyer, Schroder and Barr, "Implicit fairing of
irregular meshes using diffusion and curvature flow", 1999, here of a scalar on the plan).
It takes a little off what varies slowly, too; feeding what is missing through the same
filter again (Tukey's twicing) gives the heights back and leaves the ripples out.
"""

from __future__ import annotations

import numpy as np

from bozzetto.arrays import Array
from bozzetto_silhouette.outline.domain_mesh import Plan
from bozzetto_silhouette.outline.fem import Elements, factorised

REACH = 0.2
"""Length over which the pressure is averaged, in local radii."""

ROUNDS = 4
"""Rounds in which what the filter took off is fed through it: more keeps the heights better,
fewer the surface calmer."""

LEAST = 0.3
"""No squared height falls below this share of what it was."""


def _local_radii(plan: Plan, square: Array, distance: Array) -> Array:
    """Return for every triangle the radius of the circle that its section fits, (t,).

    At depth d below the rim a circle of radius r stands ``u = d (2 r - d)`` high.
    """
    rim = len(plan.after)
    inner = 0.5 * (square[rim:] / distance + distance)
    radius = np.concatenate([np.zeros(rim), inner])[plan.triangles]
    # Rim samples have no section of their own: the other corners speak for them.
    known: Array = radius.sum(axis=1) / np.maximum((plan.triangles >= rim).sum(axis=1), 1)
    return known


def faired(plan: Plan, square: Array, distance: Array) -> Array:
    """Remove the ripples from squared heights.

    Parameters
    ----------
    plan : Plan
        Triangles of the inside of the outline.
    square : (n,) float array
        Squared half thickness at the plan's points, 0 on the rim.
    distance : (k,) float array
        Of the inner points from the outline.

    Returns
    -------
    (n,) float array
        Positive, 0 on the rim.
    """
    from scipy.sparse import diags_array

    rim = len(plan.after)
    elements = Elements.of(plan)
    reach = REACH * _local_radii(plan, square, np.maximum(distance, 1e-9))
    # On the rim the pressure is not known (the membrane is held there): it does not count.
    mass = elements.mass.copy()
    mass[:rim] = 0.0
    stiffness = elements.stiffness()
    diffusion = factorised((diags_array(mass) + elements.stiffness(reach**2)).tocsc())
    load = stiffness @ square
    load[:rim] = 0.0
    pressure = np.zeros(len(square))
    for _ in range(ROUNDS):
        missing = diffusion.solve(load - mass * pressure)
        pressure += diffusion.solve(mass * missing)
    result = np.zeros(len(square))
    result[rim:] = factorised(stiffness[rim:, rim:]).solve((mass * pressure)[rim:])
    return np.maximum(result, LEAST * square)
