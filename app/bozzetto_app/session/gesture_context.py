"""The surroundings of a gesture, as tools get them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from bozzetto.scene.display_list import Image

if TYPE_CHECKING:
    from bozzetto.images.stored_picture import Picture
    from bozzetto.plugin.context import Context
    from bozzetto.workbench.workbench import Workbench
    from bozzetto_app.session.document_model import DocumentModel
    from bozzetto_app.session.scene_model import SceneModel
    from bozzetto_app.session.selection import Selection
    from bozzetto_app.session.toolbox import Toolbox
    from bozzetto_app.session.view_advice import ViewAdviser
    from bozzetto_app.session.view_state import ViewState

__all__ = ["GestureContext"]


class GestureContext:
    """Makes the `Context` of a gesture.

    Attributes
    ----------
    facts, pictures : mapping
        Facts and pictures of the recorded drawing that is being replayed; see `Context.facts`.
    """

    def __init__(
        self,
        workbench: Workbench,
        drawing: DocumentModel,
        selection: Selection,
        view: ViewState,
        toolbox: Toolbox,
        scene: SceneModel,
        advice: ViewAdviser,
    ) -> None:
        self.facts: Mapping[str, Any] = {}
        self.pictures: Mapping[str, Picture] = {}
        self._workbench, self._drawing, self._selection = workbench, drawing, selection
        self._view, self._toolbox, self._scene, self._advice = view, toolbox, scene, advice

    def now(self) -> Context:
        """Return the surroundings of a gesture that is made now."""
        from bozzetto.plugin.context import Context

        document = self._drawing.document
        target = self._selection.target(self._toolbox.modeler)
        underlays = self._workbench.underlay_layers(document)
        images = (item for layer in underlays for item in layer.items if isinstance(item, Image))
        return Context(
            camera=self._view.camera,
            scene=self._scene.visible,
            underlay=next(images, None),
            facts=self.facts,
            pictures=self.pictures,
            curves=self._workbench.curves.of(document),
            seen=self._advice.seen_states(target),
            alone=self._workbench.is_alone(document, target),
            sources={} if target is None else self._workbench.given_sources(target),
        )
