"""Which curves are pieces of one line, because the pen was lifted within it.

A stroke that begins where another one ended may go on with it, or begin a curve of its own: ends
of two pieces look like ends of two curves. So all that hangs together at its ends is read as one
line, by itself and beside each side that waits, and the readings decide: what fits whole as a pair
or across the plane was meant. Where nothing fits whole yet, a piece that goes on smoothly is taken
for one; of one that may go on round a corner the person is told.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice, product
from typing import Final

import numpy as np

from bozzetto.errors import UserError
from bozzetto.ink import Stroke, Strokes
from bozzetto_symmetry.interpretation.candidate import Read
from bozzetto_symmetry.model.state import Curve, SymmetryState
from bozzetto_symmetry.operations.second_sides import (
    SURE_PAIR,
    is_chance,
    shares_lines,
    waits,
)
from bozzetto_symmetry.solve.curve_solver import View, trace_if_any, views_of
from bozzetto_symmetry.solve.pieces import (
    Link,
    can_be_joined,
    links_between,
    open_links,
    others_in_view,
)
from bozzetto_symmetry.stereo.mirror_camera import MIRROR

WHOLE: Final = 0.9
"""Share of the ink that has its partner in a reading that takes it whole."""

LOOSELY: Final = 3.0
"""Price, px, up to which a line that may be one is a side of a pair: corners of a frame hang
together as well, and long lines of several tubes match something."""

WIDELY: Final = 2.0
"""Price, px, up to which pieces whose ends miss each other widely are one curve across the plane:
few different curves fold so well by chance."""

MORE: Final = 1.0
"""How much more, px, a reading may cost for each piece that it takes in and others do not."""

CORNER: Final = 45.0
"""Bend in space, degrees, from which on two curves that are known are two edges of a frame."""

END: Final = 8
"""Part of its curve over which the direction of an end is taken: one of so many."""

MOST: Final = 5
"""Most curves that are looked at as pieces of one line."""

MOST_READ: Final = 24
"""Most ways to put curves together that are read: each takes some hundredths of a second, and where
twenty lines meet in one point there are hundreds."""


@dataclass(frozen=True, eq=False)
class Joined:
    """Curves that are taken for one.

    Attributes
    ----------
    curve : Curve
        With the ink of all of them.
    members : tuple of str
        The ids of the curves that it was made of.
    links : tuple of Link
        Where the pen was lifted.
    view : View
    read : Read
        The best meaning of all this ink.
    """

    curve: Curve
    members: tuple[str, ...]
    links: tuple[Link, ...]
    view: View
    read: Read

    @property
    def sure(self) -> bool:
        """Whether the line goes on smoothly wherever the pen was lifted."""
        return all(link.how.sure for link in self.links)

    def is_whole(self, state: SymmetryState) -> bool:
        """Whether all of the ink is a pair, or one curve across the plane."""
        read = self.read
        if read.coverage < WHOLE or read.rest > 0.0:
            return False
        if read.reading == "self":
            # Two sides that meet at a corner fold there as well.
            smooth = all(link.how.smooth for link in self.links)
            return self.sure or (smooth and read.cost <= WIDELY)
        most = SURE_PAIR if self.sure else LOOSELY
        return read.reading == "pair" and read.cost <= most and not is_chance(self.view, state)


def joined_with_new(state: SymmetryState, new: Curve, cost: float, whole: bool) -> Joined | None:
    """Return what a new curve is a piece of, if it is one.

    A curve that is whole already is taken on only where all ink together is whole as well: what
    begins at its end is another curve, however smoothly it goes on.

    Parameters
    ----------
    state : SymmetryState
        The curves that were drawn before.
    new : Curve
        A curve of new ink, which is no node of the state yet.
    cost : float
        What it costs to take the new ink for the second side of a curve that waits, px; inf: it is
        none.
    whole : bool
        Whether that would take in all ink of both.
    """
    known = {curve.id: curve for curve in (*others_in_view(state, new), new) if _may_go_on(curve)}
    if new.id not in known:
        return None
    done = {name for name, node in known.items() if node is not new and _is_done(node, state)}
    if whole:
        # A bar and the lines that begin at its ends, left and right, are whole without each other.
        known = {name: node for name, node in known.items() if name not in done}
    waiting = {name for name, node in known.items() if node is new or _waits(node, state)} - done
    links = [
        link
        for link in links_between(list(known.values()), state)
        if link.how.sure or waiting.issuperset(link.curves)
    ]
    at_new = any(new.id in link.curves and done.intersection(link.curves) for link in links)
    ready = done | {new.id} if at_new and _is_done(new, state) else done
    links = [
        link
        for link in links
        if not (ready.issuperset(link.curves) and _is_corner(link, known, state))
    ]
    if not links or (whole and not any(new.id in link.curves for link in links)):
        return None
    ways = islice(_ways(known, links, new.id, state), MOST_READ)
    read = [(_chain(known, links, chain, other, state), other) for chain, other in ways]
    made = [each for each, _ in read if each is not None]
    pieces = [each for each, other in read if each is not None and not other]
    fits = [each for each in made if each.is_whole(state)]
    if fits:
        best = min(fits, key=lambda each: each.read.cost - MORE * len(each.members))
        if not whole or best.read.cost - MORE * (len(best.members) - 2) < cost:
            return best
    if np.isfinite(cost):
        return None
    sure = [
        each
        for each in pieces
        if each.sure and not done.intersection(each.members) and _is_better(each, known, state)
    ]
    return max(sure, key=lambda each: len(each.members), default=None)


def with_joined(state: SymmetryState, joined: Joined) -> SymmetryState:
    """Return the state with curves that are one as one, chosen."""
    state = state.without_nodes(*(name for name in joined.members if name != joined.curve.id))
    return state.with_node(joined.curve)


def joined_as_asked(curve: Curve, state: SymmetryState) -> Joined | None:
    """Return a curve with the one that it most likely goes on from, because a person says so."""
    for link in open_links(curve, state):
        other = next(node for node in state.curves if node.id in link.curves and node != curve)
        known = {node.id: replace(node, goes_on=True, reading="auto") for node in (other, curve)}
        made = _chain(known, (link,), link.curves, (), state)
        if made is not None:
            return made
    return None


def parted(state: SymmetryState) -> SymmetryState | None:
    """Return the state with the newest piece of the chosen curve as a curve of its own, chosen."""
    curve = state.chosen
    if curve is None or not curve.pieces:
        return None
    newest = max(number for piece in curve.pieces for number in piece)
    rest = curve.with_only([k for k in range(len(curve.strokes)) if k != newest])
    own = Curve(
        id=state.unused_id(), name=state.unused_name("Curve"),
        strokes=Strokes((curve.strokes[newest],)), goes_on=False, color=curve.color,
    )  # fmt: skip
    rest = replace(rest, reading="auto", other=False, end_snaps=())
    return state.with_node(rest).with_node(own)


def _may_go_on(curve: Curve) -> bool:
    return can_be_joined(curve) and curve.goes_on and curve.reading == "auto"


def _is_one_sided(curve: Curve, state: SymmetryState) -> bool:
    trace = trace_if_any(curve, state)
    return (
        trace is not None
        and waits(curve, trace)
        and len(trace.views) == 1
        and len(trace.views[0].sides) == 1
    )


def _waits(curve: Curve, state: SymmetryState) -> bool:
    trace = trace_if_any(curve, state)
    return trace is not None and waits(curve, trace)


def _is_done(curve: Curve, state: SymmetryState) -> bool:
    """Return whether all ink of a curve has its partner already."""
    trace = trace_if_any(curve, state)
    return (
        trace is not None
        and trace.reading in ("pair", "self")
        and trace.rest == 0.0
        and trace.coverage >= WHOLE
    )


def _ways(
    known: dict[str, Curve], links: Sequence[Link], new: str, state: SymmetryState
) -> Iterator[tuple[tuple[str, ...], tuple[str, ...]]]:
    """Yield what may be one curve with a new one: pieces of one side, and of the other if any.

    Those of one side come first, and of the others the newest: a hand draws both sides in turn.
    """
    own = tuple(_chains(new, links))
    yield from ((chain, ()) for chain in own)
    one_sided = [name for name in reversed(known) if _is_one_sided(known[name], state)]
    beside = (
        (chain, other)
        for chain in ((new,), *own)
        for name in one_sided
        if name not in chain
        for other in ((name,), *_chains(name, links))
        if (len(chain) > 1 or len(other) > 1) and not set(chain) & set(other)
    )
    for chain, other in dict.fromkeys(beside):
        if shares_lines(known[chain[0]], tuple(known[other[0]].strokes), state):
            yield chain, other


def _is_corner(link: Link, known: Mapping[str, Curve], state: SymmetryState) -> bool:
    """Return whether two curves that are known in space meet at a corner there.

    Two edges of a frame may look like one line.
    """
    ends = []
    for name in link.curves:
        trace = trace_if_any(known[name], state)
        if trace is None or len(trace.points) < 3:
            return False
        at = max(2, len(trace.points) // END)
        right = [trace.points[[0, at]], trace.points[[-1, -1 - at]]]
        ends.append(right + [end * MIRROR for end in right])
    one, other = min(product(*ends), key=lambda both: np.linalg.norm(both[0][0] - both[1][0]))
    way, on = one[0] - one[1], other[1] - other[0]
    size = float(np.linalg.norm(way) * np.linalg.norm(on))
    return size > 0.0 and float(way @ on) < np.cos(np.radians(CORNER)) * size


def _chains(name: str, links: Sequence[Link]) -> Iterator[tuple[str, ...]]:
    """Yield curves that may be pieces of one line with a curve: all, the sure ones, each alone."""
    sure = tuple(link for link in links if link.how.sure)
    near = [other for link in links if name in link.curves for other in link.curves]
    chains = [_hanging(name, links), _hanging(name, sure)]
    chains += [(name, other) for other in near if other != name]
    yield from dict.fromkeys(tuple(sorted(chain)) for chain in chains if 1 < len(chain) <= MOST)


def _hanging(name: str, links: Sequence[Link]) -> tuple[str, ...]:
    """Return all curves that hang together with a curve."""
    found = [name]
    for here in found:
        near = {other for link in links if here in link.curves for other in link.curves}
        found += sorted(near - set(found))
    return tuple(found)


def _chain(
    known: dict[str, Curve],
    links: Sequence[Link],
    chain: Sequence[str],
    other: Sequence[str],
    state: SymmetryState,
) -> Joined | None:
    """Return the curves of a chain, and of one on the other side, as one curve; None: they are not.

    A curve that has both sides already goes on at either of them, and takes in no third one.
    """
    members = [name for name in known if name in chain or name in other]
    used = tuple(
        link for link in links
        if set(link.curves) <= set(chain) or set(link.curves) <= set(other)
    )  # fmt: skip
    begins: dict[str, int] = {}
    strokes: list[Stroke] = []
    pieces: list[tuple[int, int]] = []
    for name in members:
        begins[name] = len(strokes)
        shift = len(strokes)
        strokes += list(known[name].strokes)
        pieces += [(i + shift, j + shift) for i, j in known[name].pieces]
    for link in used:
        one, two = (begins[c] + k for c, k in zip(link.curves, link.strokes, strict=True))
        pieces.append((one, two))
    curve = replace(
        known[members[0]], strokes=Strokes(strokes), pieces=tuple(pieces), end_snaps=(), axis=-1
    )
    try:
        (view,) = views_of(curve, state)
        # Sides that meet are pieces of one line as well, which is read as whatever it may be.
        read = view.reader.read("pair" if other else "auto", state.bounds)[0]
    except (UserError, ValueError):
        return None
    return Joined(curve, tuple(members), used, view, read)


def _is_better(joined: Joined, known: dict[str, Curve], state: SymmetryState) -> bool:
    """Return whether nothing that was read whole before comes apart by joining it."""
    whole = []
    for name in joined.members:
        trace = trace_if_any(known[name], state)
        if trace is not None and trace.reading in ("pair", "self"):
            whole.append(trace)
    if not whole:
        return True
    if joined.read.reading != whole[0].reading or joined.read.cost > SURE_PAIR:
        return False
    if joined.read.reading == "pair":
        return len(whole) == 1 and not is_chance(joined.view, state)
    return joined.read.coverage >= WHOLE
