"""The contract suite on the silhouette modeler."""

from __future__ import annotations

from bozzetto.testing import ModelerContract


class TestSilhouette(ModelerContract):
    modeler = "bozzetto.silhouette"
