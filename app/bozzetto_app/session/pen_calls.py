"""What the canvas calls when a hand is on it, and what it shows of that."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from bozzetto.document.waiting_ink import Waiting, strokes_of
from bozzetto.ink.stroke import Stroke
from bozzetto.plugin.gesture import Drag, Tap
from bozzetto.scene.display_list import Scene
from bozzetto_app.i18n import tr

if TYPE_CHECKING:
    from bozzetto.document.model import Document
    from bozzetto.view.camera import Camera
    from bozzetto_app.session.gestures import Inking
    from bozzetto_app.session.toolbox import Toolbox
    from bozzetto_app.session.view_advice import Advising

__all__ = ["PenCalls"]


class PenCalls:
    """The gestures that the canvas hands to the session.

    The session is one of these; what they need of it is named here.
    """

    if TYPE_CHECKING:
        advising: Advising
        inking: Inking
        toolbox: Toolbox
        camera: Camera

        @property
        def active_tool(self) -> str: ...

        @property
        def document(self) -> Document: ...

        def cancel_work(self) -> None: ...

        def select(self, model_id: str | None) -> None: ...

        def say_hint(self, text: str) -> None: ...

        def say_nothing_changed(self, why: str) -> None: ...

        def tell(self, text: str) -> None: ...

    @property
    def pending(self) -> tuple[Stroke, ...]:
        """Strokes that no modeler has taken yet; see `Document.waiting`."""
        return strokes_of(self.document.waiting)

    @property
    def marked_ink(self) -> Waiting:
        """Those of them with which something is wrong."""
        return tuple(one for one in self.document.waiting if one.is_marked)

    @property
    def live_scene(self) -> Scene:
        """What is shown only for a moment: what hangs on the view, the preview under the pen."""
        return self.advising.scene.under(self.inking.live)

    def pen_moved(self, stroke: Stroke) -> None:
        """Show what the stroke so far would make."""
        self.inking.moved(stroke)

    def pen_lifted(self, stroke: Stroke) -> None:
        """Take a complete stroke and let the tool try the ink."""
        self.inking.lifted(stroke)

    def pen_cancelled(self) -> None:
        """Forget the stroke that was being drawn."""
        self.inking.cancelled()

    def commit_pending(self) -> None:
        """Say that the pending strokes are all; with none, start a new object next time."""
        if self.pending:
            self.inking.commit()
        else:
            self.select(None)
            self.say_hint(tr("Session", "The next stroke starts a new object."))

    def drop_last_pending(self) -> None:
        """Take back the newest pending stroke."""
        if self.pending:
            self.inking.drop_last()

    def clear_pending(self) -> None:
        """Take back all pending strokes."""
        if self.pending:
            self.inking.clear()

    def escape(self) -> bool:
        """Stop the modeler, or else take the waiting ink back (Esc); whether there was any."""
        if self.inking.at_the_modeler:
            self.cancel_work()
        elif self.pending:
            self.inking.clear()
            self.tell(tr("Session", "The waiting ink is taken back. Undo brings it again."))
        else:
            return False
        return True

    def explain_gesture(self, meant: Literal["turn", "tap", "stroke"]) -> None:
        """Say what a press that came to nothing should have been."""
        if meant == "turn":
            self.say_nothing_changed(tr("Session", "Drag to turn the view."))
            return
        hint = self.toolbox.hint_of(self.active_tool)
        if meant == "tap":
            wish = tr("Session", "This tool wants a short tap in one place.")
        else:
            wish = tr("Session", "That was too short for a stroke.")
        self.say_nothing_changed(f"{wish} {hint}".strip())

    def tapped(self, x: float, y: float, *, shift: bool = False, ctrl: bool = False) -> None:
        """A short touch with a tool that takes taps."""
        self.inking.tapped(Tap(x, y, self.camera, shift, ctrl))

    def tap_moved(self, x: float, y: float, *, shift: bool = False, ctrl: bool = False) -> None:
        """Show what a tap would make if the pen were lifted here."""
        self.inking.tap_moved(Tap(x, y, self.camera, shift, ctrl))

    def handle_moved(
        self, handle: str, path: Stroke, *, shift: bool = False, ctrl: bool = False
    ) -> None:
        """Show what a handle dragged so far would make."""
        self.inking.handle_moved(Drag(handle, path, shift, ctrl))

    def handle_released(
        self, handle: str, path: Stroke, *, shift: bool = False, ctrl: bool = False
    ) -> None:
        """A handle was let go."""
        self.inking.handle_released(Drag(handle, path, shift, ctrl))
