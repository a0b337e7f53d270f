"""The surfaces of a product as in the paper: relaxed, pressed, and evened across curves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from bozzetto.plugin import Job, remembered
from bozzetto_product.fill.normals import smooth_half_edges
from bozzetto_product.model.patches import CurveGroup, Patch
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.net import Loop, Net
from bozzetto_product.network.outlines import outlines_of
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.paper.group_spring import EvenedGroup, evened_group
from bozzetto_product.paper.membrane import pressed
from bozzetto_product.paper.network_surfaces import paper_surfaces
from bozzetto_product.paper.paper_surface import PaperSurface
from bozzetto_product.shaping.pressure import volume_of_pressure
from bozzetto_product.solve.groups import FairedGroups, parts_within
from bozzetto_product.solve.result import SolvedPatch

FOLDED: Final = "its triangles fold. Draw a curve across, or set “Surfaces” to “Fair”."

HOLED: Final = "surfaces as in the paper have no holes. Set “Surfaces” to “Fair”."

UNPULLED: Final = (
    "Surfaces as in the paper follow no stroke. Set “Surfaces” of the product to “Fair” to pull."
)

UNCARVED: Final = (
    "Surfaces as in the paper hold no details. Set “Surfaces” of the product to “Fair” first."
)


@dataclass(frozen=True, eq=False)
class PaperSurfacing:
    """The surfaces of a product as in the paper.

    Parameters
    ----------
    patches : tuple of SolvedPatch
    groups : FairedGroups
        The network, with curves that gave way to the V-spring.
    """

    patches: tuple[SolvedPatch, ...]
    groups: FairedGroups


def surfaced_as_in_paper(
    state: ProductState,
    net: Net,
    wanted: Sequence[tuple[Patch, bool]],
    loops: Sequence[Loop],
    job: Job,
) -> PaperSurfacing:
    """Surface loops by the paper's means, in its order: created, pressed, then evened as groups.

    Parameters
    ----------
    state : ProductState
        The recipe.
    net : Net
        Of its curves.
    wanted : sequence of (Patch, bool)
        Of each loop the patch, and whether it is its mirror image.
    loops : sequence of Loop
        Counter-clockwise seen from outside.
    job : Job
        Asked between the surfaces whether to go on.
    """
    plain = [k for k, loop in enumerate(loops) if len(outlines_of(net, loop)) == 1]
    made = dict(zip(plain, _created(net, tuple(loops[k] for k in plain), job), strict=True))
    problems = [
        HOLED if k not in made else FOLDED if made[k].folded else "" for k in range(len(loops))
    ]
    rows = [
        _pressed(made[k], patch.pressure) if not problems[k] else (None, False)
        for k, (patch, _) in enumerate(wanted)
    ]
    surfaces = [surface for surface, _ in rows]
    moved: set[int] = set()
    kept = []
    for group in state.of_kind(CurveGroup):
        held = parts_within(state, group)
        members = frozenset(
            k for k, (patch, _) in enumerate(wanted) if patch.id in held and surfaces[k] is not None
        )
        if group.v_spring <= 0.0 or not members:
            continue
        job.checkpoint(0.9, f"V-spring of {group.name}")
        found = _evened(
            net,
            tuple(surfaces),
            members,
            group.v_spring,
            group.let_go,
            state.symmetry,
        )
        if any(one is not None and one.folded for one in found.surfaces):
            kept.append(group.name)
            continue
        surfaces, net = list(found.surfaces), found.net
        moved |= found.moved
    smooth = smooth_half_edges(net, tuple(loops))
    return PaperSurfacing(
        tuple(
            SolvedPatch(patch, mirrored, loop, surface, problem, limited, _pull_problem(patch), own)
            for (patch, mirrored), loop, surface, problem, (_, limited), own in zip(
                wanted, loops, surfaces, problems, rows, smooth, strict=True
            )
        ),
        FairedGroups(net, frozenset(net.edges[k].curve for k in moved), tuple(kept)),
    )


def _pull_problem(patch: Patch) -> str:
    return UNPULLED if len(patch.pulls) or len(patch.pulls_mirrored) else ""


@remembered(limit=8, key=lambda net, loops, job: (net, loops))
def _created(net: Net, loops: tuple[Loop, ...], job: Job) -> tuple[PaperSurface, ...]:
    numbers = iter(range(len(loops)))

    def checkpoint() -> None:
        number = next(numbers)
        job.checkpoint(0.2 + 0.6 * number / len(loops), f"Surface {number + 1}")

    return paper_surfaces(net, loops, checkpoint=checkpoint)


@remembered(limit=256)
def _pressed(surface: PaperSurface, pressure: float) -> tuple[PaperSurface, bool]:
    """Return a surface under its pressure, and whether it holds less than asked for."""
    if pressure == 0.0:
        return surface, False
    found = pressed(surface.triangles, volume_of_pressure(surface.area, pressure))
    mesh = replace(surface.triangles, points=found.points)
    made = replace(surface, triangles=mesh)
    return (surface, True) if made.folded else (made, found.limited)


@remembered(limit=16)
def _evened(
    net: Net,
    surfaces: tuple[PaperSurface | None, ...],
    members: frozenset[int],
    weight: float,
    freedom: float,
    symmetry: Plane,
) -> EvenedGroup:
    return evened_group(net, surfaces, members, weight, freedom, Reflection(symmetry))
