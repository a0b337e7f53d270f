"""From the recipe of one curve to the curve in space; remembered.

The ink of each view is put in sides and read; what the views say is fused; one symmetric
spline is fitted to the ink of all views; then the edits of the curve are replayed in order.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, Literal

import numpy as np

from bozzetto.arrays import Array
from bozzetto.errors import UserError
from bozzetto.ink import Stroke, distances_to_polyline
from bozzetto.plugin import cached_property, remembered
from bozzetto_symmetry.editing.edit_sequence import apply_edits
from bozzetto_symmetry.editing.end_snaps import with_end_snaps
from bozzetto_symmetry.fitting.bundle_adjustment import Controls, Sight, adjust_bundle
from bozzetto_symmetry.fitting.multi_view_fusion import Estimate, fuse
from bozzetto_symmetry.fitting.normal_equations import NO_PLANES
from bozzetto_symmetry.fitting.space_curve import SpaceCurve
from bozzetto_symmetry.ink.sides import Side, sides_of
from bozzetto_symmetry.ink.stroke_views import by_view
from bozzetto_symmetry.interpretation.candidate import Read
from bozzetto_symmetry.interpretation.side_reading import Reader
from bozzetto_symmetry.interpretation.view_pairing import is_whole_pair, pair_across
from bozzetto_symmetry.model.canvas import Canvas, LaidInk
from bozzetto_symmetry.model.state import AskedReading, Curve, SymmetryState
from bozzetto_symmetry.model.symmetry_plane import CentrePlane
from bozzetto_symmetry.solve.canvas_fit import fitted_in_plane, fitted_on_surface
from bozzetto_symmetry.solve.curve_fit import Fit, sampled
from bozzetto_symmetry.solve.notices import is_undecided, lies_in_either, notices, off_the_ink
from bozzetto_symmetry.solve.view_agreement import agree, facing, main_view, tree_of
from bozzetto_symmetry.stereo.mirror_camera import MIRROR, Stereo

WAITING: Final = "One side waits for the other. Draw its mirror image, here or in another view."

IMAGE_OFF: Final = 0.005
"""Distance of a mirror image from the surface, in diagonals of the box, that a person is told."""

BESIDE_SURFACE: Final = (
    "The surface is not symmetric there: the mirror image is up to {:.3g} mm off it. Move the "
    "object over the centre plane to have both on it."
)

MOST_MARGIN: Final = 1000.0
"""Greatest margin that is given, also where there is no other reading."""


@dataclass(frozen=True, eq=False)
class View:
    """The ink of one curve in one view; `numbers` are those of its strokes in the curve."""

    stereo: Stereo
    strokes: tuple[Stroke, ...]
    sides: tuple[Side, ...]
    numbers: tuple[int, ...]

    @cached_property
    def reader(self) -> Reader:
        """All that the sides may mean."""
        return Reader(self.stereo, self.sides)


@dataclass(frozen=True, eq=False)
class Trace:
    """The curve that a recipe gives, in the frame of the centre plane.

    Attributes
    ----------
    reading : {"pair", "self", "plane", "half"}
        "half": there is one side, and no curve yet.
    curve : SpaceCurve or None
    points : (k, 3) float
        Along the side that was drawn, mm; of a curve across the plane along all of it.
    sigma : (k,) float
        How far each of them may be off across the curve if the hand is off by 1 px, mm.
    margin : float
        Cost of the next best reading over the cost of this one; 1 is undecided.
    cost : float
        How far the ink contradicts this reading, px.
    rms : float
        Distance of the ink from the images of the curve, px.
    ghost : SpaceCurve or None
        What the next best reading gives, where it is close.
    choices : int
        How many readings the ink allows that give a curve.
    views : tuple of View
    warnings : tuple of str
    rest : float
        Share of a side that waits, because only a part of the other side was drawn.
    coverage : float
        Share of the ink of the main view that has a partner, as `Read.coverage`.
    planes : int
        How many planes hold a curve across the centre plane: one if it was taken to be flat, two
        if straight.
    """

    reading: Literal["pair", "self", "plane", "half"]
    curve: SpaceCurve | None = None
    points: Array = field(default_factory=lambda: np.zeros((0, 3)))
    sigma: Array = field(default_factory=lambda: np.zeros(0))
    margin: float = MOST_MARGIN
    cost: float = 0.0
    rms: float = 0.0
    ghost: SpaceCurve | None = None
    choices: int = 0
    views: tuple[View, ...] = ()
    warnings: tuple[str, ...] = ()
    rest: float = 0.0
    coverage: float = 0.0
    planes: int = 0


ALONGSIDE: Final = 20.0
"""Mean distance, px, within which a stroke shows one half of a curve across the plane; what
runs over both halves is farther from each."""


AMBIGUOUS: Final = 1.5
"""Margin below which the other reading is shown as well; above it 1.2 % of senses are wrong."""


def _recipe(curve: Curve, state: SymmetryState) -> Hashable:
    return (
        replace(curve, id="", name="", visible=True, within="", color=None),
        state.plane, state.centre, state.size,
        # Only what was drawn over is moulded.
        state.forces if curve.edits else (),
    )  # fmt: skip


@remembered(limit=256, key=_recipe)
def trace_of(curve: Curve, state: SymmetryState) -> Trace:
    """Return the curve in space of a recipe, with how sure it is.

    Raises
    ------
    UserError
        If the strokes cannot be read as the curve is asked to be.
    """
    return _traced(curve, state)


def trace_if_any(curve: Curve, state: SymmetryState) -> Trace | None:
    """Return the curve in space of a recipe; None where its strokes cannot be read."""
    try:
        return trace_of(curve, state)
    except UserError:
        return None


def views_of(curve: Curve, state: SymmetryState, asked: AskedReading = "auto") -> tuple[View, ...]:
    """Return the strokes of a curve by their views, in the order of the first of each.

    Parameters
    ----------
    curve : Curve
        For its strokes, and which of them are pieces of one line.
    state : SymmetryState
        For its plane.
    asked : str
        The reading that the curve is asked to have; a pair has two sides, all others one.
    """
    return _views(tuple(curve.strokes), curve.pieces, state.plane, asked == "pair")


@remembered(limit=256)
def _views(
    drawn: tuple[Stroke, ...], pieces: tuple[tuple[int, int], ...], plane: CentrePlane, apart: bool
) -> tuple[View, ...]:
    return tuple(_view(seen, pieces, plane, apart) for seen in by_view(drawn))


def _view(
    seen: Mapping[int, Stroke],
    pieces: tuple[tuple[int, int], ...],
    plane: CentrePlane,
    apart: bool,
) -> View:
    numbers, strokes = tuple(seen), tuple(seen.values())
    place = {number: k for k, number in enumerate(numbers)}
    here = [(place[i], place[j]) for i, j in pieces if i in place and j in place]
    sides = sides_of(strokes, apart=apart, pieces=here)
    return View(Stereo.of(strokes[0].camera, plane), strokes, sides, numbers)


def _traced(curve: Curve, state: SymmetryState) -> Trace:
    if not len(curve.strokes):
        raise UserError(f"“{curve.name}” has no ink. Draw it, or delete it.")
    if not curve.edits:
        return _as_drawn(curve, state)
    base = trace_of(replace(curve, edits=()), state)
    if base.curve is None:
        return base
    changed, warnings = apply_edits(base.curve, curve.edits, state, solve_curve)
    points, sigma = _carried(base, changed)
    return replace(
        base, curve=changed, points=points, sigma=sigma, warnings=(*base.warnings, *warnings)
    )


def _as_drawn(curve: Curve, state: SymmetryState) -> Trace:
    """Return a curve without its edits, its ends at the places that they were drawn to."""
    if curve.canvas is not None:
        base = _on_canvas(curve, curve.canvas, state)
    elif (curve.end_snaps and curve.settles) or curve.axis >= 0:
        base = trace_of(replace(curve, end_snaps=(), axis=-1, settles=True), state)
    else:
        return _read(curve, state)
    if base.curve is None:
        return base
    drawn_to = curve if curve.settles else replace(curve, end_snaps=())
    caught = with_end_snaps(base.curve, drawn_to, base.sigma, state)
    if caught is base.curve:
        return base
    points, sigma = _carried(base, caught)
    return replace(base, curve=caught, points=points, sigma=sigma)


def _on_canvas(curve: Curve, canvas: Canvas, state: SymmetryState) -> Trace:
    """Return the curve on a plane or a surface that one side of ink says all of."""
    views = views_of(curve, state)
    stereo = views[0].stereo
    if isinstance(canvas, LaidInk):
        fit = fitted_on_surface(stereo, canvas, state.plane)
    else:
        fit = fitted_in_plane(stereo, views[0].sides, canvas, state.plane)
    warnings = off_the_ink(fit.rms)
    if isinstance(canvas, LaidInk) and canvas.image_off > IMAGE_OFF * state.diagonal:
        warnings = (*warnings, BESIDE_SURFACE.format(canvas.image_off))
    return Trace(
        fit.curve.reading, fit.curve, fit.points, fit.sigma, rms=fit.rms, choices=1, views=views,
        warnings=warnings,
    )  # fmt: skip


def solve_curve(curve: Curve, state: SymmetryState) -> SpaceCurve | None:
    """Return the curve in space of a recipe; None while it waits for its other side."""
    return trace_of(curve, state).curve


def _read(curve: Curve, state: SymmetryState) -> Trace:
    views = views_of(curve, state, curve.reading)
    box = state.bounds
    readings = [_readings(view, curve.reading, box, len(views)) for view in views]
    across = _across_views(views, readings, curve.reading, box)
    if across is not None:
        number, pair = across
        readings[number] = (pair, *readings[number])
    main = main_view(readings)
    first = _chosen(readings[main], curve.other)
    if first.reading == "half":
        warnings = first.warnings or (WAITING,)
        return Trace("half", cost=first.cost, views=views, warnings=warnings)
    alike = {main: first}
    for number, found in enumerate(readings):
        if number == main:
            continue
        alike_here = (r for r in found if (r.reading, r.closed) == (first.reading, first.closed))
        turned = (facing(r, first) for r in alike_here)
        same = next((r for r in turned if agree(r, first)), None)
        if same is not None:
            alike[number] = same
    fit = _fitted(views, alike, main, curve.detail)
    others = [r for r in readings[main] if r is not first]
    rest = [r for r in others if r.reading != "half"]
    # What is taken to be in the plane may as well wait for its other side.
    against = others if first.reading == "plane" else rest
    sure = all(side.sure for view in views for side in view.sides)
    margin = min((r.cost / max(first.cost, 1e-6) for r in against), default=MOST_MARGIN)
    return Trace(
        first.reading, fit.curve, fit.points, fit.sigma,
        margin=float(min(margin, MOST_MARGIN)), cost=first.cost, rms=fit.rms,
        ghost=_ghost(views[main], first, rest, margin, curve.detail),
        choices=1 + len(rest), views=views, warnings=notices(first, rest, fit.off_ink, sure),
        rest=first.rest, coverage=first.coverage,
        planes=0 if fit.form is None else len(fit.form.planes),
    )  # fmt: skip


def _readings(view: View, asked: str, box: Array, count: int) -> tuple[Read, ...]:
    """Return the readings of one view; beside other views it need not be what is asked."""
    if count > 1 and asked != "half":
        try:
            return view.reader.read(asked, box)
        except UserError:
            return view.reader.read("half", box)
    return view.reader.read(asked, box)


def _across_views(
    views: Sequence[View], readings: Sequence[Sequence[Read]], asked: str, box: Array
) -> tuple[int, Read] | None:
    """Return left in one view and right in another as a pair, and the number of the first view.

    None where a view shows both sides, or where each by itself explains its ink better.
    """
    if asked not in ("auto", "pair") or any(found[0].reading == "pair" for found in readings):
        return None
    seen = [(view.stereo, view.sides) for view in views]
    return pair_across(seen, [found[0].cost for found in readings], box)


def _chosen(found: Sequence[Read], other: bool) -> Read:
    real = [r for r in found if r.reading != "half"]
    return real[1] if other and len(real) > 1 else found[0]


def _meant(
    views: Sequence[View], alike: Mapping[int, Read], main: int, detail: Controls
) -> Hashable:
    return tuple(views), main, detail, tuple((k, read.source) for k, read in alike.items())


@remembered(limit=256, key=_meant)
def _fitted(views: Sequence[View], alike: Mapping[int, Read], main: int, detail: Controls) -> Fit:
    """Return the spline through the ink of all views; remembered.

    A box of another size is asked for at every tick of a slider, and seldom makes another
    reading of the same ink.

    Parameters
    ----------
    views : sequence of View
        All views of the curve.
    alike : mapping of int to Read
        What the views that agree were read as, by their number.
    main : int
        The view that says best what the curve is.
    detail : {"adaptive", "seven"}
        Control points of a half.
    """
    first = alike[main]
    assert first.reading != "half"
    noise = [max((side.noise for side in view.sides), default=0.0) for view in views]
    estimates = [
        Estimate(r.points, r.covariances * max(noise[k], 0.3) ** 2) for k, r in alike.items()
    ]
    whole = estimates[0] if len(estimates) == 1 else fuse(estimates, closed=first.closed)
    # Of views that agree each may show more of the curve than the other.
    alone = len(alike) == 1
    sights = [Sight(views[k].stereo, r.near, r.far, noise[k], alone) for k, r in alike.items()]
    sights += [
        replace(_one_sided(view, noise[k], whole.points, first), whole=is_whole_pair(first))
        for k, view in enumerate(views)
        if k not in alike
    ]
    # What one view cannot say another one does.
    form = first.form if len(views) == 1 else None
    made = adjust_bundle(
        first.reading, whole.points, whole.covariances, sights,
        closed=first.closed, ring=first.ring, controls=detail,
        planes=NO_PLANES if form is None else form.planes,
        surface=None if form is None or form.flat else form.surface,
    )  # fmt: skip
    return Fit(made.curve, made.rms, tuple(sights), form)


def _one_sided(view: View, noise: float, points: Array, first: Read) -> Sight:
    """Return the ink of a view of single sides: each is of the half that it is nearer to."""
    halves: tuple[Array, Array] = points, points * MIRROR
    if first.reading == "self":
        middle = len(points) // 2
        halves = points[: middle + 1], points[middle:]
    images = [view.stereo.project(half) for half in halves]
    ink: tuple[list[Array], list[Array]] = [], []
    for side in view.sides:
        off = [float(np.mean(distances_to_polyline(side.pixels, image))) for image in images]
        nearer = 0 if first.reading == "plane" else int(np.argmin(off))
        if first.reading != "self" or off[nearer] < ALONGSIDE:
            ink[nearer].append(side.pixels)
    return Sight(view.stereo, tuple(ink[0]), tuple(ink[1]), noise)


def _ghost(
    view: View, first: Read, rest: Sequence[Read], margin: float, detail: Controls
) -> SpaceCurve | None:
    """Return what the next best reading gives, where it is about as good."""
    unsure = is_undecided(first, rest) or lies_in_either(first, rest)
    if not rest or (margin > AMBIGUOUS and not unsure):
        return None
    other = min(rest, key=lambda r: r.cost)
    return _fitted([view], {0: other}, 0, detail).curve


def _carried(base: Trace, curve: SpaceCurve) -> tuple[Array, Array]:
    """Return places of a changed curve, with the uncertainty of the nearest old ones."""
    points = sampled(curve.spline)
    return points, base.sigma[tree_of(base.points).query(points)[1]]
