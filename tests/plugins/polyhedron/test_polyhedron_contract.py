"""The contract suite on the polyhedron modeler."""

from __future__ import annotations

from bozzetto.testing import ModelerContract, Pen, Shell
from tests.plugins.polyhedron.drawn_bodies import VIEW, fitted, strokes_of
from tests.plugins.polyhedron.objects import OBJECTS


class TestPolyhedron(ModelerContract):
    modeler = "bozzetto.polyhedron"

    def sketch(self, shell: Shell, pen: Pen) -> None:
        """A house, drawn by the hand of the pen's seed."""
        house = OBJECTS["house"]
        shell.camera = VIEW
        for stroke in strokes_of(fitted(house), house.edges, jitter=1.5, seed=pen.seed):
            shell.draw(stroke)
