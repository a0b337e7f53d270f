"""Views of drawings as they were drawn, and where such a view goes when drawings are moved."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from bozzetto.plugin import ViewAdvice
from bozzetto.view import Camera, with_kind
from bozzetto_polyhedron.model.same_view import is_one_sheet, view_of, way_of
from bozzetto_polyhedron.model.state import Body


def advice_before(bodies: Iterable[Body], camera: Camera) -> ViewAdvice | None:
    """Return the view without perspective until a drawing is turned.

    Lines are nearly always drawn without it, and a solid covers its lines only where it is seen as
    they were drawn.
    """
    if camera.kind == "orthographic" or any(body.choice for body in bodies):
        return None
    return ViewAdvice(
        "good",
        "Lines are read best without perspective",
        with_kind(camera, "orthographic"),
        follow=True,
    )


def advice_on_drawings(
    bodies: Sequence[Body], camera: Camera, seen: Iterable[Sequence[Body]]
) -> ViewAdvice | None:
    """Return whether a view shows drawings as they were drawn, or the one that does so now.

    Parameters
    ----------
    bodies : sequence of Body
        The drawings that are shown.
    camera : Camera
        The view.
    seen : iterable of sequence of Body
        The drawings as they were a moment ago, newest first, when the view showed them so.
    """
    before = advice_before(bodies, camera)
    if before is not None:
        return before
    drawn = {body.id: body for body in bodies if len(body.strokes)}
    if any(is_one_sheet(camera, view_of(body)) for body in drawn.values()):
        return ViewAdvice("good", "", as_drawn=True)
    for earlier in seen:
        for body in earlier:
            now = drawn.get(body.id)
            if now is not None and len(body.strokes) and is_one_sheet(camera, view_of(body)):
                return ViewAdvice(
                    "good",
                    "The drawing stands elsewhere now",
                    camera.moved(way_of(body, now)),
                    as_drawn=True,
                    follow=True,
                )
    return None
