"""Profile: a stroke from another view says how thick the chosen part is along itself."""

from __future__ import annotations

from dataclasses import replace

from bozzetto.errors import UserError
from bozzetto.ink import Strokes
from bozzetto.plugin import Context, Ink, override
from bozzetto_silhouette.inflation.profile import understood
from bozzetto_silhouette.model.state import Part, SilhouetteState
from bozzetto_silhouette.solids.placements import shown_parts, stroke_in
from bozzetto_silhouette.tools.erasing_tool import ErasingTool


class DrawProfile(ErasingTool):
    """The ink becomes the profile of the chosen part, in place of the one that it had."""

    id = "profile"
    title = "Profile"
    icon = "icons/profile.svg"
    hint = "Turn the view to the side, then draw how thick the chosen part is."

    @override
    def draw(self, state: SilhouetteState, ink: Ink, context: Context) -> SilhouetteState:
        """Give the chosen part a profile.

        Raises
        ------
        UserError
            If no part is chosen, or the ink is no profile of it.
        """
        part = _meant(state)
        profile = Strokes(stroke_in(state, part, stroke) for stroke in ink.strokes)
        changed = replace(part, profile=profile)
        understood(changed)
        return state.with_node(changed)


def _meant(state: SilhouetteState) -> Part:
    """Return the chosen part, or the only one.

    Raises
    ------
    UserError
        If there is none.
    """
    parts = shown_parts(state)
    if not parts:
        raise UserError("There is no part yet. Draw its outline first.")
    chosen = [part for part in parts if part.id == state.selected]
    if not chosen and len(parts) > 1:
        raise UserError("Choose a part in the list first; its profile is drawn then.")
    return (chosen or list(parts))[0]
