"""The contract suite on the symmetry modeler."""

from __future__ import annotations

from bozzetto.plugin.testing import ModelerContract


class TestSymmetry(ModelerContract):
    modeler = "bozzetto.symmetry"
