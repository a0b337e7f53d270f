"""Base of tools that change a solid by one touch or stroke."""

from __future__ import annotations

from typing import ClassVar

from bozzetto.plugin import Context, Gesture, NextStep, override
from bozzetto.scene import Scene
from bozzetto_polyhedron.model.changes import Change
from bozzetto_polyhedron.model.state import PolyhedronState
from bozzetto_polyhedron.solve.picking import solids_in
from bozzetto_polyhedron.tools.erase import ErasingTool
from bozzetto_polyhedron.view.scene import scene_after


class ChangeTool(ErasingTool):
    """A tool that changes a solid.

    Attributes
    ----------
    makes : type of Change
        What it adds to the recipe.
    then : NextStep, optional
        What may be done with the change while it is chosen.
    """

    makes: ClassVar[type[Change]]
    then: ClassVar[NextStep | None] = None

    @override
    def preview(self, state: PolyhedronState, gesture: Gesture, context: Context) -> Scene:
        """Return the solid as it would be."""
        return scene_after(self.apply(state, gesture, context), context.sources)

    @override
    def next_step(self, state: PolyhedronState) -> NextStep:
        """Return what may be done with the chosen change, the hint, or what comes before."""
        if not solids_in(state):
            return NextStep("Turn a drawing into a solid first.", tool="turn")
        if self.then is not None and state.chosen_of(self.makes) is not None:
            return self.then
        return NextStep(self.hint)
