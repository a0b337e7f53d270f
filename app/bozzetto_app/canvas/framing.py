"""Framing: what is on the sheet is in view when a document comes onto it.

Shapes and advice arrive one after the other, out of workers. So the view is looked after from
the moment when a document was opened until the person looks elsewhere, draws, or takes a step.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np
from PySide6.QtCore import QObject

from bozzetto.view.navigation import fit_points, pan, with_kind
from bozzetto.view.standard_views import standard_view
from bozzetto_app.session.view_state import FIRST_VIEW

if TYPE_CHECKING:
    from bozzetto.arrays import Array
    from bozzetto.view.camera import Camera
    from bozzetto_app.session.session import Session

__all__ = ["Framing", "framed", "is_in_view", "points_to_frame", "same_view"]


KEPT_SHARE: Final = 0.5
"""Share of the points that must be seen for the view of a saved document to be kept: a person
may have saved while looking at a detail."""

SMALLEST: Final = 0.05
"""Least extent of what is seen for that, in canvas sides: what is smaller is only a speck."""

SAME: Final = 1e-5
"""Largest difference of two views that are the same, in visible heights and as a sine."""

STEPS: Final = 4
"""Times at most that the view of a new sheet is changed: first to the one that its modeler calls
better, then so that all is in it. What is shown there may depend on the view, and there may always
be a better one."""

MOST_COVERED: Final = 0.5
"""Share of the sheet's width up to which things are framed beside what covers it."""

CENTRED: Final = 3
"""Times that what is framed is brought into the middle of the room beside what covers the sheet."""

EDGE: Final = 0.5
"""How far a point may lie beyond the canvas and still count as seen, pixels."""


def points_to_frame(session: Session) -> Array:
    """Return the points that have to be in view, (n, 3) mm: the objects, or the modeler's own.

    On an empty sheet that is for instance the box in which a first curve is drawn.
    """
    points = session.scene.visible.points()
    return points if len(points) else session.scene.advice.points()


def framed(camera: Camera, points: Array, covered: int = 0) -> Camera:
    """Return the view with all points in it, from the same side; one point keeps the scale.

    They lie beside so many pixels of the sheet's left that something covers, if there is room.
    """
    if len(points) and np.ptp(points, axis=0).max() == 0.0:
        points = points[0] + 0.05 * camera.visible_height * np.array([[-1.0], [1.0]])
    width, height = camera.viewport
    if not 0 < covered <= MOST_COVERED * width or not len(points):
        return fit_points(camera, points)
    view = fit_points(camera.with_viewport(width - covered, height), points)
    view = view.with_viewport(width, height)
    for _ in range(CENTRED):  # near and far places move unlike: once more brings them there
        across = view.project(points)[0][:, 0]
        off = 0.5 * (width + covered - float(np.nanmin(across)) - float(np.nanmax(across)))
        view = pan(view, off, 0.0)
    return view


def is_in_view(camera: Camera, points: Array, share: float = 1.0, covered: int = 0) -> bool:
    """Whether at least a share of the points is seen on the canvas, and larger than a speck.

    What lies under the covered pixels of the sheet's left is not seen, unless they are most of it.
    """
    places, depths = camera.project(points)
    size = np.array(camera.viewport)
    with np.errstate(invalid="ignore"):
        inside = (places >= -EDGE).all(axis=1) & (places <= size + EDGE).all(axis=1)
        if covered <= MOST_COVERED * size[0]:
            inside &= places[:, 0] >= covered - EDGE
    seen = inside & (depths > 0.0)
    if not seen.any() or seen.mean() < share:
        return False
    extent = np.ptp(places[seen], axis=0) / size
    return bool(extent.max() >= SMALLEST)


def same_view(one: Camera, other: Camera) -> bool:
    """Whether nobody could tell two views apart."""
    if one.kind != other.kind or one.viewport != other.viewport:
        return False
    near = SAME * one.visible_height
    return (
        np.allclose(one.axes, other.axes, rtol=0.0, atol=SAME)
        and np.allclose((one.eye, one.target), (other.eye, other.target), rtol=0.0, atol=near)
        and abs(one.visible_height - other.visible_height) <= near
    )


class Framing(QObject):
    """Frames the objects until the person takes over the view.

    A saved document comes back in its own view if its objects can be seen there. A document
    without a view is seen three-quarter, or as its last waiting stroke was drawn; an empty one
    as at the start, or as the modeler calls it better.

    Parameters
    ----------
    session : Session
    """

    def __init__(self, session: Session, parent: QObject) -> None:
        super().__init__(parent)
        self._session = session
        self._camera: Camera | None = session.view.camera
        self._share = 1.0
        self._must_fit = False
        self._steps = STEPS
        self._last: Camera | None = None
        session.drawing.opened.connect(self._opened)
        session.toolbox.modeler_changed.connect(self._take_modeler)
        session.scene.changed.connect(self._look)
        session.advice.changed.connect(self._look)
        session.view.camera_changed.connect(self._moved)
        session.drawing.waiting_changed.connect(self.end)
        session.drawing.changed.connect(self._changed)
        session.commands.begun.connect(self._begun)
        session.files.exchange.clipboard.pasted.connect(self._begun)
        session.shapes.begun.connect(self._begun)

    def end(self) -> None:
        """Leave the view to the person, who is at work."""
        self._camera = None

    def _opened(self) -> None:
        session = self._session
        document, pending = session.drawing.document, session.drawing.pending
        size = session.view.camera.viewport
        self._share, self._must_fit, self._steps = 1.0, False, STEPS
        if document.camera is not None:
            self._share = KEPT_SHARE
            self._camera = session.view.camera
        elif pending:
            self._show(pending[-1].camera.with_viewport(*size))
        elif document.models or document.underlays:
            self._must_fit = True
            self._show(standard_view(FIRST_VIEW.with_viewport(*size), "three-quarter"))
        else:
            self._show(FIRST_VIEW.with_viewport(*size))
        self._look()

    def _look(self) -> None:
        """Frame what is there now, unless it is in view."""
        session = self._session
        if self._camera is None:
            return
        points = points_to_frame(session)
        if not len(points):
            return
        advice = session.advice.advice
        fresh = self._is_fresh
        if fresh and not self._steps:
            return
        covered = session.view.covered if fresh else 0  # what lies over an empty sheet goes
        if fresh and advice is not None and not session.advice.is_about(session.view.camera):
            return  # it is about the sheet before, and another is on its way
        better = None if advice is None else advice.better
        if better is not None and (self._steps == STEPS if fresh else self._hides_all()):
            # A sketch is seen from where it was drawn, and from nowhere else; on a new sheet the
            # modeler knows from where one draws best.
            self._steps -= fresh
            self._show(better.with_viewport(*session.view.camera.viewport))
        elif self._must_fit or not is_in_view(session.view.camera, points, self._share, covered):
            self._steps -= fresh
            self._show(framed(session.view.camera, points, covered))
        else:
            return
        self._must_fit = False
        self._share = 1.0

    def _hides_all(self) -> bool:
        """Whether a modeler hides everything in views other than its own."""
        scene = self._session.scene
        return not len(scene.visible.under(scene.advice).points())

    @property
    def _is_fresh(self) -> bool:
        """Whether nothing was drawn yet."""
        drawing = self._session.drawing
        return not (len(drawing.document) or drawing.pending)

    def _take_modeler(self) -> None:
        """Begin again with the first view when another modeler comes to a new sheet."""
        self._steps = STEPS
        if self._camera is not None and self._is_fresh:
            self._show(FIRST_VIEW.with_viewport(*self._session.view.camera.viewport))

    def _show(self, camera: Camera) -> None:
        self._camera = camera
        self._session.view.set_camera(camera)

    def _moved(self) -> None:
        """Keep framing when the sheet has another size or its camera is of another kind.

        A modeler asks for the other kind by itself; any other view is the person's choice.
        """
        now, known = self._session.view.camera, self._camera
        if known is None or now == known:
            return
        if not same_view(now, with_kind(known.with_viewport(*now.viewport), now.kind)):
            self.end()
            return
        self._camera, self._steps = now, STEPS
        self._look()

    def _changed(self) -> None:
        if self._session.drawing.history.undo_label is not None:
            self._last = self._camera
            self.end()

    def _begun(self) -> None:
        """Frame what was put on the sheet at one word, too: nobody drew it where the eye was.

        The view of a person who has looked elsewhere is kept if most of it is seen there.
        """
        self._share = KEPT_SHARE if self._last is None else 1.0
        self._camera, self._steps = self._last or self._session.view.camera, STEPS
        self._look()
