"""The preview of one gesture on one model."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from bozzetto.errors import Unfinished, UserError
from bozzetto.scene.display_list import Scene
from bozzetto.workbench.placed import scene_in_world

if TYPE_CHECKING:
    from bozzetto.document.model import Model
    from bozzetto.geometry.placement import Placement
    from bozzetto.plugin.gesture import Gesture
    from bozzetto.plugin.guard.guarded_modeler import GuardedModeler
    from bozzetto.plugin.tool import Preview


@dataclass(frozen=True)
class ModelPreview:
    """A tool's preview, with gestures and scenes in the world.

    Parameters
    ----------
    modeler : GuardedModeler
        Through which it is asked.
    preview : Preview
        The tool's own, in the model's frame.
    model : Model
        As it is while the gesture goes on.
    to_own : Placement
        From the world into the model's frame.
    """

    modeler: GuardedModeler
    preview: Preview[Any]
    model: Model
    to_own: Placement

    def update(self, gesture: Gesture) -> Scene:
        """Return what to show of the gesture so far, marked as the model's own.

        A layer stands in for the model's layer of the same name; see `Scene.under`.
        """
        try:
            scene = self.modeler.preview(self.preview, gesture.moved(self.to_own))
        except (UserError, Unfinished):
            return Scene()  # odd ink may still become something
        return scene_in_world(scene, self.model)
