"""Groups whose surfaces are faired together, one after another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from bozzetto.plugin import remembered
from bozzetto_product.model.curves import Curve
from bozzetto_product.model.patches import CurveGroup, Patch
from bozzetto_product.model.planes import Plane
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.net import Loop, Net
from bozzetto_product.network.reflection import Reflection
from bozzetto_product.shaping.group_fairing import FairedNet, faired
from bozzetto_product.shaping.outline_normals import rejoined


@dataclass(frozen=True, eq=False)
class FairedGroups:
    """A network after all groups were faired.

    Parameters
    ----------
    net : Net
    let_go : frozenset of str
        Ids of curves that are elsewhere now.
    kept : tuple of str
        Names of groups of which the curves could not, or not all, be let go.
    """

    net: Net
    let_go: frozenset[str] = frozenset()
    kept: tuple[str, ...] = ()

    def shown(self, curves: Sequence[Curve]) -> tuple[Curve, ...]:
        """Return the curves as the network has them."""
        return tuple(self._shown(curve) if curve.id in self.let_go else curve for curve in curves)

    def _shown(self, curve: Curve) -> Curve:
        own = [edge for edge in self.net.edges if edge.curve == curve.id and not edge.mirrored]
        own.sort(key=lambda edge: edge.piece)
        whole = own[0].spline if len(own) == 1 else rejoined([edge.spline for edge in own])
        return replace(curve, spline=whole)


def faired_groups(
    state: ProductState, net: Net, loops: Sequence[Loop], patches: Sequence[Patch]
) -> FairedGroups:
    """Fair the surfaces of all groups that let curves go.

    Parameters
    ----------
    state : ProductState
        The recipe.
    net : Net
        Of its curves.
    loops : sequence of Loop
        Of all surfaces, counter-clockwise seen from outside.
    patches : sequence of Patch
        Of which they are.
    """
    moved: set[int] = set()
    kept = []
    for group in state.of_kind(CurveGroup):
        held = parts_within(state, group)
        members = frozenset(k for k, patch in enumerate(patches) if patch.id in held)
        if group.let_go <= 0.0 or len(members) < 2:
            continue
        found = _faired(net, tuple(loops), members, group.let_go, state.symmetry)
        net = found.net
        moved |= found.moved
        if not found.whole:
            kept.append(group.name)
    return FairedGroups(net, frozenset(net.edges[k].curve for k in moved), tuple(kept))


@remembered(limit=16)
def _faired(
    net: Net, loops: tuple[Loop, ...], members: frozenset[int], share: float, symmetry: Plane
) -> FairedNet:
    return faired(net, loops, members, share, Reflection(symmetry))


def parts_within(state: ProductState, group: CurveGroup) -> set[str]:
    """Return the ids of all parts within a group, in groups within it too."""
    held = {group.id}
    while True:
        more = {node.id for node in state.nodes if node.within in held} - held
        if not more:
            return held
        held |= more
