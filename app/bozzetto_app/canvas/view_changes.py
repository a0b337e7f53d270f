"""Changes of the view that a person can ask for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from bozzetto.errors import UserError
from bozzetto.scene.display_list import Scene
from bozzetto.view.camera import Camera
from bozzetto.view.navigation import with_kind
from bozzetto.view.standard_views import look_along, standard_view
from bozzetto_app.canvas.framing import framed, points_to_frame, same_view
from bozzetto_app.i18n import tr

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from bozzetto.view.camera import Point
    from bozzetto_app.canvas.animation import ViewMotion
    from bozzetto_app.session.session import Session

__all__ = ["ViewChanges"]

NO_TURN = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0)
"""The rotation of an object that stands as it was made."""


class ViewChanges:
    """Goes to other views.

    Parameters
    ----------
    session : Session
    motion : ViewMotion
        Carries the view there.
    """

    def __init__(self, session: Session, motion: ViewMotion) -> None:
        self._session, self._motion = session, motion

    def animate_to(self, camera: Camera) -> None:
        """Go to another view, or say that it is shown."""
        self._motion.finish()
        if same_view(camera, self._session.view.camera):
            self._session.notices.tell(tr("Canvas", "This view is shown already."))
        else:
            self._motion.animate_to(camera)

    def show_camera(self, camera: Camera) -> None:
        """Go to a view that was kept, perhaps on a sheet of another size."""
        self.animate_to(camera.with_viewport(*self._session.view.camera.viewport))

    def look(self, name: str) -> None:
        """Go to a standard view by its name: "front", "three-quarter" and so on."""
        self._motion.finish()
        side = self.sides.get(name, name)
        self.animate_to(standard_view(self._own_view(), side))

    @property
    def sides(self) -> Mapping[str, str]:
        """The object's own names of sides with the world's; empty where both are the same.

        They are those of what the active modeler makes, as long as it stands as it was made.
        """
        session = self._session
        model, modeler = session.selection.model, session.toolbox.modeler
        if model is not None:
            if model.placement.rotation != NO_TURN:
                return {}
            modeler = model.modeler
        try:
            return session.registry.info(modeler).sides if modeler else {}
        except UserError:
            return {}  # its plugin is not here

    def toggle_projection(self) -> None:
        """Change between perspective and parallel projection."""
        self._motion.finish()
        camera: Camera = self._session.view.camera
        other = "perspective" if camera.kind == "orthographic" else "orthographic"
        self.animate_to(with_kind(camera, other))  # type: ignore[arg-type]

    @property
    def better_view(self) -> Camera | None:
        """Where the modeler would rather have the person draw; None where it names no view."""
        advice = self._session.advice.advice
        return None if advice is None else advice.better

    def turn_to_better(self) -> None:
        """Go to the view that the modeler calls better."""
        if self.better_view is not None:
            self.show_camera(self.better_view)

    def fit(self) -> None:
        """Show everything; on an empty sheet what the modeler shows there, such as its box."""
        self._frame(points_to_frame(self._session))

    def show_news(self) -> None:
        """Show everything once something has come, without a word if that is so: nobody asked."""
        self._motion.finish()
        camera = framed(
            self._own_view(), points_to_frame(self._session), self._session.view.covered
        )
        if not same_view(camera, self._session.view.camera):
            self._motion.animate_to(camera)

    def frame_selection(self) -> None:
        """Show the selected model, or everything where none is selected."""
        selected = self._session.selection.id
        layers = tuple(
            layer for layer in self._session.scene.visible.layers if layer.owner == selected
        )
        if selected and layers:
            self._frame(Scene(layers).points())
        else:
            self.fit()

    def look_from(self, direction: Point) -> None:
        """Look at what is shown from a direction."""
        self._motion.finish()
        x, y, z = direction
        self.animate_to(look_along(self._own_view(), (-x, -y, -z)))

    def turn(self, camera: Camera) -> None:
        """Take a view at once, as a drag of the view cube goes on."""
        self._motion.finish()
        self._session.view.set_camera(camera)

    def _frame(self, points: NDArray[np.float64]) -> None:
        self._motion.finish()
        self.animate_to(framed(self._own_view(), points, self._session.view.covered))

    def _own_view(self) -> Camera:
        """Return the view, as an ordinary one if it stands where a picture was drawn from.

        There the opening angle was the picture's, and zooming has changed it: from elsewhere
        nothing would look right with it. The scale stays.
        """
        camera: Camera = self._session.view.camera
        if camera.kind == "orthographic" or not self._session.advice.holds_eye(camera):
            return camera
        flat = with_kind(camera, "orthographic")
        return with_kind(replace(flat, fov_y=Camera().fov_y), "perspective")
