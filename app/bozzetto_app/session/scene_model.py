"""The scene on the sheet: the models, the underlays, and what is drawn over them for a moment."""

from __future__ import annotations

from typing import TYPE_CHECKING

from PySide6.QtCore import QObject, QTimer, Signal

from bozzetto.scene.display_list import Layer, Scene

if TYPE_CHECKING:
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.selection import Selection
    from bozzetto_app.session.solver import Solver
    from bozzetto_app.session.toolbox import Toolbox
    from bozzetto_app.session.view_state import ViewState

__all__ = ["SceneModel"]

GHOST_LAYER = "ink"
"""Name of the layers that hold the ink of models; they are hidden together."""


class SceneModel(QObject):
    """The scenes that the viewport draws, in world coordinates.

    Attributes
    ----------
    preview : Scene
        The effect of the gesture under way.

    Signals
    -------
    changed
        `visible` differs.
    live_changed
        `live` differs.
    """

    changed = Signal()
    live_changed = Signal()

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        view: ViewState,
        toolbox: Toolbox,
        solver: Solver,
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._view, self._toolbox, self._solver = view, toolbox, solver
        self._visible: Scene | None = None
        self._last = Scene()
        self._has_ghosts = True
        self.preview = Scene()
        self._advice = self._grips = Scene()
        self._alone = ""
        self._soon = QTimer(self, singleShot=True, interval=0)
        self._soon.timeout.connect(self.changed)
        drawing.models_changed.connect(self._models_changed)
        selection.changed.connect(self._refresh)
        toolbox.tool_changed.connect(self._tool_changed)
        solver.changed.connect(self._solved)
        view.style_changed.connect(self._style_changed)

    @property
    def busy(self) -> bool:
        """Whether shapes have come and the sheet has not been told yet."""
        return self._soon.isActive()

    @property
    def visible(self) -> Scene:
        """All that is visible; the very same object while nothing else is seen."""
        if self._visible is None:
            underlays = self._workbench.underlay_layers(self._drawing.document)
            seen = tuple(filter(self.is_seen, [*underlays, *self._solver.layers()]))
            if seen != self._last.layers:  # a layer is equal to itself alone
                self._last = Scene(seen)
            self._visible = self._last
            self._has_ghosts = self._view.show_ghost_ink
        return self._visible

    @property
    def live(self) -> Scene:
        """The preview under the pen, and the layers that the modeler shows in this view only."""
        return self.advice.under(self.preview)

    @property
    def advice(self) -> Scene:
        """The layers that the modeler shows in this view only, and the handles of an underlay.

        See `ViewAdvice.scene`.
        """
        return Scene((*filter(self.is_seen, self._advice.layers), *self._grips.layers))

    def is_seen(self, layer: Layer) -> bool:
        """Return whether the active tool and the view style let a layer be seen."""
        if layer.name == GHOST_LAYER and not self._view.show_ghost_ink:
            return False
        chosen = layer.owner == self._selection.id
        if (layer.chosen or layer.tool) and not chosen:
            return False
        return layer.tool in ("", self._toolbox.tool) and not self._is_in_the_way(layer)

    def _is_in_the_way(self, layer: Layer) -> bool:
        """Return whether it is of another model of the modeler of the one that is shown alone."""
        if not self._alone or layer.owner in ("", self._alone):
            return False
        modelers = {model.id: model.modeler for model in self._drawing.document}
        return modelers.get(layer.owner) == modelers.get(self._alone)

    def show_preview(self, scene: Scene) -> None:
        """Show a preview until another replaces it; an empty scene removes it."""
        if scene.layers or self.preview.layers:
            self.preview = scene
            self.live_changed.emit()

    def show_alone(self, model_id: str) -> None:
        """Hide the other models of a modeler while a picture of one is looked at; "" for none."""
        if model_id != self._alone:
            self._alone = model_id
            if len(self._drawing.document) > 1:
                self._refresh()

    def show_advice(self, scene: Scene) -> None:
        """Show the layers that belong to the view of this moment."""
        before = self.advice.layers
        self._advice = scene
        now = self.advice.layers
        if len(before) != len(now) or not all(map(_look_alike, before, now)):
            self.live_changed.emit()

    def show_grips(self, scene: Scene) -> None:
        """Show the handles of an underlay until others replace them."""
        if scene.layers or self._grips.layers:
            self._grips = scene
            self.live_changed.emit()

    def _models_changed(self) -> None:
        """Look for another scene; a value that is dragged changes it only once it is solved."""
        before, self._visible = self._last, None
        if not self._drawing.is_dragging or self.visible is not before:
            self.changed.emit()

    def _solved(self) -> None:
        """Look for another scene once all shapes are there that workers have handed over by now.

        Those of a hundred objects come together, and every look goes through all of them.
        """
        self._visible = None
        self._soon.start()

    def _refresh(self) -> None:
        self._visible = None
        self._soon.stop()
        self.changed.emit()

    def _tool_changed(self) -> None:
        self._refresh()
        if any(layer.tool for layer in self._advice.layers):
            self.live_changed.emit()

    def _style_changed(self) -> None:
        if self._view.show_ghost_ink != self._has_ghosts:
            self._refresh()


def _look_alike(one: Layer, other: Layer) -> bool:
    """Return whether two layers hold the very same items in the same way."""
    ways = ((each.name, each.owner, each.tool, each.chosen) for each in (one, other))
    return next(ways) == next(ways) and one.items == other.items
