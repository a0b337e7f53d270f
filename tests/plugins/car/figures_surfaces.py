"""Figures of surfaces: creases, saddles and breaks of zebra stripes, of templates and solved cars.

Run ``python -m tests.plugins.car.figures_surfaces``; it prints tables. Solved cars and sketches are
of seeds from 700 on, which neither a test uses nor a constant of the program was chosen with.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from bozzetto.geometry.patches import (
    SMOOTH,
    crease_angles,
    grid,
    grid_curvatures,
)
from bozzetto.geometry.patches.patch import grid_normals
from bozzetto.scene.renderer.zebra import TUBES
from bozzetto_car.body.build import body_of
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.loader import PAPER_TEMPLATES, TEMPLATES, bundled
from bozzetto_car.template.model import Template, ViewHint
from bozzetto_car.template.network import Network
from tests.plugins.car.held_out import held_out
from tests.plugins.car.marked_points import marked
from tests.plugins.car.sketched import FRONT_QUARTER, rubbery, styled

Array = NDArray[np.float64]

SEED = 700
OTHERS = range(SEED, SEED + 2)
"""Seeds of the solved cars of templates of which no dimensions are held out."""

VISIBLE = 1.0 / 50_000.0
"""Curvature, 1/mm, from which a bend counts as seen: over half a metre it is 0.6 mm deep."""

STEEP = 30.0
"""Degrees from which a crease counts as sharp."""

PLACES = (np.arange(24) + 0.5) / 24.0
"""Parameters of the places in which a patch is judged, in both directions."""

LEAST_PLACES = (np.arange(8) + 0.5) / 8.0
LEAST_TRIES = 400
FARTHEST = 60.0
"""Places of a patch, surfaces that are tried, and how far control points move, mm, where the least
share is looked for."""

SIGHTS = tuple(ViewHint(turn, rise).toward_eye for turn in range(0, 360, 30) for rise in (5, 25))
"""From where zebra stripes are looked at."""


@dataclass(frozen=True)
class Car:
    """The patches of a car.

    Attributes
    ----------
    template : Template
    nets : (k, 4, 4, 3) float
        Control points, mm.
    """

    template: Template
    nets: Array

    @classmethod
    def of(cls, network: Network) -> Car:
        """Return the car of a network."""
        return cls(network.template, fair_nets(network))


def solved(name: str) -> Iterator[Car]:
    """Yield cars solved from one three-quarter sketch each."""
    template = bundled(name)
    if name in PAPER_TEMPLATES:
        cars = [
            car.positions
            for seed in (SEED, SEED + 1)
            for car in held_out(seed)
            if car.template is template
        ]
    else:
        cars = [make(template, seed) for seed in OTHERS for make in (styled, rubbery)]
    for number, car in enumerate(cars):
        state = marked(template, car, (FRONT_QUARTER,), SEED + number).state
        yield Car.of(body_of(state).network)


def areas(nets: Array, at: Array = PLACES) -> Array:
    """Return the area that each place of each patch stands for, (k, a, a)."""
    ways = grid(nets, at, at, du=1), grid(nets, at, at, dv=1)
    return np.asarray(np.linalg.norm(np.cross(*ways), axis=-1))


def saddles(nets: Array, bend: float) -> NDArray[np.bool_]:
    """Return where a surface bends to both sides, each more than so much, (k, a, a)."""
    found = grid_curvatures(nets, PLACES, PLACES)
    return np.asarray((found.most > bend) & (found.least < -bend))


def share(nets: Array, bend: float) -> float:
    """Return the share of the area that is a saddle, %."""
    own = areas(nets)
    return float(100.0 * (own * saddles(nets, bend)).sum() / own.sum())


def least_share(car: Car) -> float:
    """Return about the least share of visible saddles that the edges of a car allow, %.

    The inner control points of each patch move along its normal, without regard to its neighbours.
    """
    nets = car.nets
    right = [n for n, patch in enumerate(car.template.patches) if patch.name.endswith(".R")]
    found, whole = 0.0, 0.0
    for number in right:
        net = nets[number]
        normal = np.cross(net[3, 3] - net[0, 0], net[0, 3] - net[3, 0])
        normal /= np.linalg.norm(normal)

        def moved(heights: Array, net: Array = net, normal: Array = normal) -> Array:
            made = net.copy()
            made[1:3, 1:3] += heights.reshape(2, 2, 1) * normal
            return made[None]

        def cost(heights: Array, moved=moved) -> float:  # type: ignore[no-untyped-def]
            made = moved(heights)
            bent = grid_curvatures(made, LEAST_PLACES, LEAST_PLACES)
            depth = np.minimum(bent.most, -bent.least) / VISIBLE
            own = areas(made, LEAST_PLACES)
            return float((own * np.clip(depth, 0.0, 2.0)).sum() / own.sum())

        best = minimize(
            cost,
            np.zeros(4),
            method="Powell",
            bounds=[(-FARTHEST, FARTHEST)] * 4,
            options={"maxfev": LEAST_TRIES},
        ).x
        options = [moved(heights) for heights in (best, np.zeros(4))]
        parts = [(areas(one) * saddles(one, VISIBLE)).sum() for one in options]
        found += min(parts)
        whole += areas(options[int(np.argmin(parts))]).sum()
    return float(100.0 * found / whole)


def break_of(car: Car, nets: Array) -> float:
    """Return by how much stripes break over the edges that are no creases, in stripes with gaps."""
    along = np.linspace(0.0, 1.0, 33)
    normals: dict[int, list[Array]] = {}
    for sides, rows in zip(car.template.sides.tolist(), _round(nets, along), strict=True):
        for side, row in zip(sides, rows, strict=True):
            normals.setdefault(max(side, ~side), []).append(row if side >= 0 else row[::-1])
    worst = 0.0
    for edge in np.flatnonzero(car.template.smooth_edges).tolist():
        for toward in SIGHTS:
            seen = [row @ toward for row in normals[edge]]
            both = (seen[0] > 0.1) & (seen[1] > 0.1)
            climbs = [
                np.degrees(np.arcsin(np.clip(2.0 * up * row[:, 2] - toward[2], -1.0, 1.0)))
                for up, row in zip(seen, normals[edge], strict=True)
            ]
            if both.any():
                worst = max(worst, float(np.abs(climbs[0] - climbs[1])[both].max()))
    return worst / (180.0 / TUBES)


def _round(nets: Array, along: Array) -> Array:
    """Return unit normals along the four sides of patches, in their sense, (k, 4, n, 3)."""
    return np.stack(
        (
            grid_normals(nets, along, [0.0])[:, :, 0],
            grid_normals(nets, [1.0], along)[:, 0],
            grid_normals(nets, along, [1.0])[:, ::-1, 0],
            grid_normals(nets, [0.0], along)[:, 0, ::-1],
        ),
        axis=1,
    )


def judged(car: Car) -> Array:
    """Edges below 0.1°; sharp creases that are not declared; the largest one not declared, degrees;
    shares of saddles that are seen, and of all, %; the share of those seen that lies in windows, %;
    breaks of stripes."""
    template, nets = car.template, car.nets
    angles = crease_angles(nets, template.sides, len(template.edges))
    glass = np.array([patch.glass for patch in template.patches])
    own = areas(nets) * saddles(nets, VISIBLE)
    undeclared = angles[template.smooth_edges]
    return np.array(
        [
            (angles < SMOOTH).sum(),
            (undeclared > STEEP).sum(),
            undeclared.max(),
            share(nets, VISIBLE),
            share(nets, 0.0),
            100.0 * own[glass].sum() / max(own.sum(), 1e-300),
            break_of(car, nets),
        ]
    )


HEAD = (
    "edges below 0.1°",
    "not declared, above 30°",
    "largest not declared",
    "saddle, seen",
    "of it in windows",
    "saddle, any",
    "stripes break by",
)


def up_to(value: float, least: float) -> str:
    """A figure that should be nought: its size, or that it is smaller than what matters."""
    return f"< {least:g}" if value < least else f"{value:.2g}"


def cells(rows: Array) -> list[str]:
    """Means of rows of `judged`, largest of what should be nought."""
    mean, most = rows.mean(axis=0), rows.max(axis=0)
    return [
        f"{rows[:, 0].min():.0f}",
        f"{most[1]:.0f}",
        f"{up_to(most[2], 1e-4)}°",
        f"{mean[3]:.1f} %",
        f"{mean[5]:.0f} %",
        f"{mean[4]:.1f} %",
        up_to(most[6], 1e-4),
    ]


def main() -> None:
    print(
        "A saddle bends to both sides; it is *seen* where both curvatures exceed 1/50 m⁻¹ (0.6 mm "
        "over half a metre). Stripes break in pairs of a stripe and its gap, seen from 24 sides. "
        "*Least*: about what the lines allow if "
        "every patch bends as it likes, by up to 60 mm."
    )
    print()
    print("| template | inner edges | creases | " + " | ".join(HEAD) + " | least |")
    print("| --- " * (len(HEAD) + 4) + "|")
    for name in TEMPLATES:
        template = bundled(name)
        car = Car.of(Network.of(template))
        inner = len(template.edges) - len(template.rim)
        row = [template.title, f"{inner}", f"{len(template.creases)}"]
        row += cells(judged(car)[None])
        print("| " + " | ".join([*row, f"{least_share(car):.1f} %"]) + " |")
    print()
    print("Cars solved from one sketch (means; the largest of creases and breaks):")
    print()
    print("| template | cars | " + " | ".join(HEAD) + " |")
    print("| --- " * (len(HEAD) + 2) + "|")
    for name in TEMPLATES:
        rows = np.array([judged(car) for car in solved(name)])
        print("| " + " | ".join([bundled(name).title, f"{len(rows)}", *cells(rows)]) + " |")


if __name__ == "__main__":
    main()
