"""Forms show what people reach for first, and everything else in its own order."""

from __future__ import annotations

import pytest

from bozzetto.plugin.host.registry import Registry
from bozzetto.plugin.parts import PartsModeler
from bozzetto_app.session.object_edits import fields_of


@pytest.mark.parametrize("modeler_id", ["silhouette", "symmetry", "car"])
def test_first_parameters_come_first_and_nothing_is_lost(modeler_id) -> None:
    registry = Registry()
    modeler = registry.modeler(registry.resolve(modeler_id))
    assert isinstance(modeler, PartsModeler)
    first = modeler.first_parameters
    assert first
    for kind in (modeler.state_type, *modeler.part_types):
        usual = [field.name for field, _ in fields_of(kind())]
        names = [field.name for field, _ in fields_of(kind(), first)]
        ahead = [name for name in first if name in usual]
        assert names == ahead + [name for name in usual if name not in ahead]
        assert [value for _, value in fields_of(kind(), first)] == [
            getattr(kind(), name) for name in names
        ]
