"""The base of the tools: one eraser, and while the shape is posed how to drag joints."""

from __future__ import annotations

from typing import Final

from bozzetto.errors import UserError
from bozzetto.plugin import Context, Ink, NextStep, Tool, override
from bozzetto.scene import Handle
from bozzetto_silhouette.model.state import SilhouetteState
from bozzetto_silhouette.rigging.posing import joints_layer
from bozzetto_silhouette.tools.erase import erased

DRAG_A_JOINT: Final = (
    "Drag a joint and the skin follows; the end of a limb draws the limb along. "
    "Switch Pose off to go on drawing."
)
NO_JOINTS: Final = (
    "This shape has no joint to drag. Switch Pose off, and draw a longer shape or a limb."
)


class ErasingTool(Tool[SilhouetteState]):
    """A tool of the modeler: with all of them the eraser and posed shapes work the same."""

    @override
    def erase(self, state: SilhouetteState, ink: Ink, context: Context) -> SilhouetteState:
        """Take away what the eraser's path lies over; see `erased`."""
        return erased(state, ink.strokes[-1])

    @override
    def next_step(self, state: SilhouetteState) -> NextStep:
        """Return how to drag the joints while they are shown, else the tool's own hint."""
        if not state.posing or not state.nodes:
            return NextStep(self.hint)
        try:
            layer = joints_layer(state)
        except UserError:
            return NextStep(self.hint)  # the ink is no outline, which the solve has reported
        # Besides the handles there may be roots, which stay where they are.
        has_joints = layer is not None and any(isinstance(one, Handle) for one in layer.items)
        return NextStep(DRAG_A_JOINT if has_joints else NO_JOINTS)


class ColouringTool(ErasingTool):
    """A tool that colours the surface, of a posed shape as of one at rest."""

    group = "Colours"

    @override
    def next_step(self, state: SilhouetteState) -> NextStep:
        """Return the tool's own hint: a stroke over a posed shape colours it."""
        return NextStep(self.hint)
