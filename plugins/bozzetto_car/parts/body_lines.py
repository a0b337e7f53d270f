"""Sill and bumper lines: lines of equal share of the height of panels, around the car.

A panel at the lower rim of the body has a line at a share of its way up from there, which is a
cubic on its surface. Neighbours share the edge between them, so their lines meet. The sill has one
between the wheels, the bumpers have one before and behind them; all end at the arches.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Final, Literal, get_args

import numpy as np
from numpy.typing import NDArray

from bozzetto.arrays import Array
from bozzetto.geometry.patches import bernstein
from bozzetto_car.parts.trimmed_face import cubic_piece
from bozzetto_car.parts.wheel_arches import RADII, CutPanel
from bozzetto_car.template.model import MIRROR
from bozzetto_car.template.network import Network

SILL: Final = 0.13
"""Height of the line over the sill, as share of the panel."""

BUMPER: Final = 0.54
"""Height of the line over a bumper, as share of the panel: between intake and grille."""

STEPS: Final = 200
"""Places along a line at which is asked whether it is beside a wheel."""

CLOSE: Final = 1e-12
"""How near to an arch a line is ended, as share of it."""

Zone = Literal["", "front", "sill", "rear"]
ZONES: Final[tuple[Zone, ...]] = get_args(Zone)
"""Between what a place of a line may lie; the first is in an arch."""


def body_lines(
    network: Network, nets: Array, cut: Mapping[int, CutPanel]
) -> Iterator[tuple[str, Array]]:
    """Yield the lines by name, as Bézier points (4, 3) on the surface, right ones and left ones.

    Parameters
    ----------
    network : Network
        The car; its wheels stand on the ground, so that their height is their radius.
    nets : (k, 4, 4, 3) array_like
        Its patches, mm.
    cut : mapping of int to CutPanel
        The panels that arches divide (`cut_panels`); a wheel without any is passed by closely.
    """
    template = network.template
    arches = _arches(network, cut)
    for number, patch in enumerate(template.patches):
        if not patch.name.endswith(".R") or patch.glass:
            continue
        for side in range(4):
            if template.edge_of(number, side) not in template.rim:
                continue
            for share, zones in ((SILL, ("sill",)), (BUMPER, ("front", "rear"))):
                line = _line(nets[number], side, share)
                for zone, piece in _pieces(line, arches):
                    if zone in zones:
                        name = "Sill line" if zone == "sill" else f"Bumper line {zone}"
                        yield f"{name} right", piece
                        yield f"{name} left", piece * MIRROR


def _line(net: Array, side: int, share: float) -> Array:
    """Return the line at a share of the way inward from a side of a patch, (4, 3)."""
    along = (net, net[::-1].swapaxes(0, 1), net[::-1, ::-1], net[:, ::-1].swapaxes(0, 1))[side]
    return np.asarray(np.tensordot(bernstein([share])[0], along, axes=(0, 1)))


def _arches(network: Network, cut: Mapping[int, CutPanel]) -> list[tuple[Array, float]]:
    """Return centre and radius of what lines leave out around the wheels on the right, mm."""
    radii = {panel.wheel: panel.radius for panel in cut.values()}
    centres = network.positions[network.template.wheels[:, 0]]
    return [
        (centre, radii.get(wheel, RADII[-1] * float(centre[2])))
        for wheel, centre in enumerate(centres)
    ]


def _pieces(line: Array, arches: list[tuple[Array, float]]) -> Iterator[tuple[Zone, Array]]:
    """Yield the pieces of a line that are beside no wheel, and where each lies."""
    at = np.linspace(0.0, 1.0, STEPS + 1)
    zones = _zones(line, at, arches)
    changes = np.flatnonzero(zones[1:] != zones[:-1])
    begin = 0.0
    for step in changes.tolist():
        low, high = float(at[step]), float(at[step + 1])
        while high - low > CLOSE:
            row = np.linspace(low, high, STEPS + 1)
            same = _zones(line, row, arches) == zones[step]
            last = int(np.argmin(same)) - 1
            low, high = float(row[last]), float(row[last + 1])
        if zones[step]:
            yield ZONES[zones[step]], cubic_piece(line, begin, low)
        begin = high
    if zones[-1]:
        yield ZONES[zones[-1]], cubic_piece(line, begin, 1.0)


def _zones(line: Array, at: Array, arches: list[tuple[Array, float]]) -> NDArray[np.intp]:
    """Return between what places of a line lie, numbers of `ZONES`."""
    places = bernstein(at) @ line
    found = np.full(len(at), ZONES.index("sill"))
    for (centre, _), zone in zip(arches, ("front", "rear"), strict=True):
        beyond = places[:, 0] < centre[0] if zone == "front" else places[:, 0] > centre[0]
        found[beyond] = ZONES.index(zone)
    for centre, radius in arches:
        found[np.hypot(*(places - centre)[:, [0, 2]].T) < radius] = 0
    return found
