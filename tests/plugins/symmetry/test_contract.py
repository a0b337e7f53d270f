"""The contract suite on the symmetry modeler."""

from __future__ import annotations

from bozzetto.testing import ModelerContract, Pen, Shell
from bozzetto_symmetry.stereo.mirror_camera import MIRROR
from tests.plugins.symmetry import scenes as s


class TestSymmetry(ModelerContract):
    modeler = "bozzetto.symmetry"

    def sketch(self, shell: Shell, pen: Pen) -> None:
        """Both sides of a pair, and a stroke across."""
        view = s.camera(35, 20)
        aside = pen.but(camera=view)
        for curve in (s.PAIRS["roof rail"], s.PAIRS["roof rail"] * MIRROR, s.ACROSS["hood U"]):
            shell.draw(aside.along(view.project(curve)[0]))
