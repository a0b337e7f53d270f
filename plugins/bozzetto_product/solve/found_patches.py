"""Patches of a recipe: loops that were found become parts, and are switched on and off."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from bozzetto_product.fill.guide_chart import GuideChart
from bozzetto_product.fill.network_fills import guide_of
from bozzetto_product.loops.bent_holes import with_bent_holes
from bozzetto_product.loops.boundaries import boundary_of, loop_of, mirrored_boundary
from bozzetto_product.loops.finding import FoundLoops, find_loops
from bozzetto_product.loops.holes import EXACT, with_holes
from bozzetto_product.loops.orientation import orient_loops
from bozzetto_product.loops.sampling import SampledNet
from bozzetto_product.model.joints import Boundary
from bozzetto_product.model.patches import Patch
from bozzetto_product.model.state import ProductState
from bozzetto_product.network.half_edges import half_edge_images, half_edges
from bozzetto_product.network.net import Loop, Net
from bozzetto_product.network.outlines import joined_outlines, outlines_of, rim_edges, rim_of
from bozzetto_product.solve.solver import loops_of_patch, net_of_state

Edges = frozenset[int]


def with_patches_found(state: ProductState, flat: float = EXACT) -> ProductState:
    """Return the state with a patch for every loop that its network has.

    Patches that a person confirmed stay, those rejected stay away; all others are as the network
    is now. A loop that was there keeps its patch, and one that takes the place of another its
    name, colour and pressure.

    Parameters
    ----------
    state : ProductState
        A network.
    flat : float
        Distance from a plane, as share of its size, up to which a loop with holes lies in it.
    """
    net = net_of_state(state)
    patches = state.of_kind(Patch)
    known = [(patch, loops_of_patch(net, patch)) for patch in patches]
    fixed = [loop for patch, loops in known if patch.confirmed for loop in loops]
    found = find_loops(net, fixed=fixed, rejected=_rejected(net, state.rejected), flat=flat)
    return _with_loops(state, net, _with_bent_holes(net, found.loops, len(fixed), found.candidates))


def _with_bent_holes(
    net: Net, loops: Sequence[Loop], fixed: int, candidates: Sequence[Loop]
) -> list[Loop]:
    """Return loops, turned alike, with the holes that are in surfaces that bend."""
    made = _holes_added(net, orient_loops(net, loops).loops, fixed, candidates)
    return [loop for loop in made if loop is not None]


def _holes_added(
    net: Net, loops: Sequence[Loop], fixed: int, candidates: Sequence[Loop]
) -> list[Loop | None]:
    """Return loops with the holes that are in surfaces that bend; None for those that are some."""
    rims = {rim_edges(net, loop) for loop in loops}
    others = [loop for loop in candidates if rim_edges(net, loop) not in rims]

    def surface_of(number: int) -> GuideChart | None:
        guide = guide_of(net, loops, number)
        return None if guide is None else GuideChart(guide)

    return with_bent_holes(SampledNet.of(net), loops, fixed, others, surface_of)


def found_loops(state: ProductState, net: Net) -> FoundLoops:
    """Return all loops that may be meant, around those that are confirmed."""
    known = [(patch, loops_of_patch(net, patch)) for patch in state.of_kind(Patch)]
    fixed = [loop for patch, loops in known if patch.confirmed for loop in loops]
    return find_loops(net, fixed=fixed)


def _rejected(net: Net, boundaries: Sequence[Boundary]) -> list[Loop]:
    loops = (loop_of(net, boundary) for boundary in boundaries)
    return [loop for loop in loops if loop is not None]


def _with_loops(state: ProductState, net: Net, loops: Sequence[Loop]) -> ProductState:
    """Return the state with exactly these loops as patches; what was said of them stays."""
    old: dict[Edges, Patch] = {}
    for patch in state.of_kind(Patch):
        for loop in loops_of_patch(net, patch):
            old.setdefault(rim_edges(net, loop), patch)
    wanted = _with_images(net, orient_loops(net, loops).loops)
    kept: dict[str, Patch] = {}
    fresh: list[tuple[Loop, bool]] = []
    for loop, mirrored in wanted:
        own = old.get(rim_edges(net, loop))
        if own is not None and own.id not in kept:
            own = own if own.mirrored == mirrored else replace(own, mirrored=mirrored)
            kept[own.id] = _with_holes_of(net, own, loop)
        else:
            fresh.append((loop, mirrored))
    gone = [patch for patch in state.of_kind(Patch) if patch.id not in kept and not patch.confirmed]
    heirs = [(patch, _union(net, loops_of_patch(net, patch))) for patch in gone]
    lost = {patch.id for patch in gone}
    nodes = tuple(kept.get(node.id, node) for node in state.nodes if node.id not in lost)
    chosen = state.selected
    state = replace(state, nodes=nodes)
    new: list[tuple[Loop, bool]] = []
    for loop, mirrored in fresh:
        edges = rim_edges(net, loop)
        heir = max(heirs, key=lambda one: len(one[1] & edges), default=None)
        if heir is not None and 2 * len(heir[1] & edges) >= len(heir[1]) > 0:
            heirs.remove(heir)
            patch = replace(heir[0], boundary=boundary_of(net, loop), mirrored=mirrored)
            state = replace(state, nodes=(*state.nodes, patch))
        else:
            new.append((loop, mirrored))
    for loop, mirrored in new:  # last, for what is inherited keeps its id and name
        patch = _patch(state, boundary_of(net, loop), mirrored)
        state = replace(state, nodes=(*state.nodes, patch))
    ids = {node.id for node in state.nodes}
    return replace(state, selected=chosen if chosen in ids else "")


def _patch(state: ProductState, boundary: Boundary, mirrored: bool) -> Patch:
    name = state.unused_name("Surface")
    return Patch(state.unused_id(), name, boundary=boundary, mirrored=mirrored)


def _with_holes_of(net: Net, patch: Patch, loop: Loop) -> Patch:
    """Return a patch with the holes of a loop that has the same outline, or the same image."""
    own = loops_of_patch(net, patch)
    edges = {edge for edge, _ in loop}
    if any({edge for edge, _ in each} == edges for each in own):
        return patch
    boundary = boundary_of(net, loop)
    if rim_edges(net, own[0]) != rim_edges(net, loop):
        boundary = mirrored_boundary(boundary)
    return replace(patch, boundary=boundary)


def _union(net: Net, loops: Sequence[Loop]) -> Edges:
    return frozenset[int]().union(*(rim_edges(net, loop) for loop in loops))


def _with_images(net: Net, loops: Sequence[Loop]) -> list[tuple[Loop, bool]]:
    """Return loops, each with whether its mirror image is among them; the image itself is not."""
    images = half_edge_images(net)
    there = {rim_edges(net, loop) for loop in loops}
    taken: set[Edges] = set()
    kept = []
    for loop in loops:
        edges = rim_edges(net, loop)
        image = [int(images[half]) for half in half_edges(rim_of(net, loop))]
        image_edges = frozenset(half // 2 for half in image) if min(image) >= 0 else frozenset()
        if edges in taken:
            continue
        pair = bool(image_edges) and image_edges in there and image_edges != edges
        if pair:
            if sum(net.edges[e].mirrored for e in edges) > sum(
                net.edges[e].mirrored for e in image_edges
            ):
                continue
            taken.add(image_edges)
        kept.append((loop, pair))
    return kept


def switched(state: ProductState, net: Net, loop: Loop) -> ProductState:
    """Return the state with a loop switched: on where it has no patch, off where it has one.

    A hole of a surface that is switched on is a surface of its own, and none of its holes; one that
    is switched off is a hole of the surface round it, if other surfaces leave from it.
    """
    edges = rim_edges(net, loop)
    for patch in state.of_kind(Patch):
        if any(rim_edges(net, own) == edges for own in loops_of_patch(net, patch)):
            return without_patches(state, [patch])
    rejected = tuple(
        other
        for other in state.rejected
        if (own := loop_of(net, other)) is None or not _same_or_image(net, own, edges)
    )
    loop = _with_own_holes(state, net, loop)
    state = _without_holes(state, net, [loop, *_image(net, loop)])
    oriented = orient_loops(net, [*_loops(state, net), loop]).loops[-1]
    ((kept, mirrored),) = _with_images(net, [oriented, *_image(net, oriented)])[:1]
    patch = replace(_patch(state, boundary_of(net, kept), mirrored), confirmed=True)
    return replace(state, rejected=rejected).with_node(patch)


def _with_own_holes(state: ProductState, net: Net, loop: Loop) -> Loop:
    """Return a loop that becomes a surface with the holes that are in it."""
    known = _loops(state, net)
    rim, others = rim_of(net, loop), find_loops(net).candidates
    found = with_holes(SampledNet.of(net), [*known, rim], len(known), others)[-1] or rim
    return _holes_added(net, [*known, found], len(known), others)[-1] or found


def _without_holes(state: ProductState, net: Net, loops: Sequence[Loop]) -> ProductState:
    """Return the state in which some loops are no holes of any surface."""
    gone = {rim_edges(net, loop) for loop in loops}

    def left(loop: Loop) -> Loop:
        rim, *holes = outlines_of(net, loop)
        return joined_outlines((rim, *(h for h in holes if rim_edges(net, h) not in gone)))

    return _with_loops_changed(state, net, left)


def _with_holes_added(state: ProductState, net: Net, loops: Sequence[Loop]) -> ProductState:
    """Return the state in which some loops are holes of the surfaces round them, if they may be."""
    rims = [rim_of(net, loop) for loop in loops]
    wanted = {rim_edges(net, rim) for rim in rims}
    known = _loops(state, net)
    flat = with_holes(SampledNet.of(net), known, 0, rims)
    found = _holes_added(net, [two or one for one, two in zip(known, flat, strict=True)], 0, rims)
    more = {
        rim_edges(net, before): [
            hole for hole in outlines_of(net, after)[1:] if rim_edges(net, hole) in wanted
        ]
        for before, after in zip(known, found, strict=True)
        if after is not None
    }

    def grown(loop: Loop) -> Loop:
        return joined_outlines((loop, *more.get(rim_edges(net, loop), ())))

    return _with_loops_changed(state, net, grown)


def _with_loops_changed(
    state: ProductState, net: Net, change: Callable[[Loop], Loop]
) -> ProductState:
    """Return the state with other holes in its surfaces; a change of an image is one of both."""
    nodes: list[Any] = []
    for node in state.nodes:
        if isinstance(node, Patch):
            for loop in loops_of_patch(net, node):
                made = change(loop)
                if made != loop:
                    node = _with_holes_of(net, node, made)
                    break
        nodes.append(node)
    return replace(state, nodes=tuple(nodes))


def without_patches(state: ProductState, patches: Sequence[Patch]) -> ProductState:
    """Return the state with patches switched off: their loops are not found again.

    One from which other surfaces leave is a hole of the surface round it then.
    """
    net = net_of_state(state)
    loops = [loop for patch in patches for loop in loops_of_patch(net, patch)]
    state = state.without_nodes(*(patch.id for patch in patches))
    rejected = (*state.rejected, *(patch.boundary for patch in patches))
    return _with_holes_added(replace(state, rejected=rejected), net, loops)


def _loops(state: ProductState, net: Net) -> list[Loop]:
    return [loop for patch in state.of_kind(Patch) for loop in loops_of_patch(net, patch)]


def _image(net: Net, loop: Loop) -> list[Loop]:
    """Return the mirror image of a loop, where there is another one."""
    found = loop_of(net, mirrored_boundary(boundary_of(net, loop)))
    own = found is None or rim_edges(net, found) == rim_edges(net, loop)
    return [] if own or found is None else [found]


def _same_or_image(net: Net, own: Loop, edges: Edges) -> bool:
    return any(rim_edges(net, one) == edges for one in (own, *_image(net, own)))


def confirmed(state: ProductState) -> ProductState:
    """Return the state with all patches confirmed: finding loops takes none of them away."""
    nodes = tuple(
        replace(node, confirmed=True) if isinstance(node, Patch) else node for node in state.nodes
    )
    return replace(state, nodes=nodes)
