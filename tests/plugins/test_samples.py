"""The samples of the bundled plugins, opened as any other file of a person is."""

from __future__ import annotations

from pathlib import Path

import pytest

from bozzetto.exchange.import_file import read_drawing
from bozzetto.plugin.host.registry import Registry

REGISTRY = Registry()

SAMPLES = [(info.id, sample) for info in REGISTRY.modelers() for sample in info.samples]


@pytest.mark.parametrize(("modeler", "sample"), SAMPLES, ids=lambda each: Path(each).stem)
def test_a_sample_goes_to_its_modeler_whichever_is_in_the_hand(modeler: str, sample: Path) -> None:
    facts = read_drawing(sample).facts
    meant = facts.get("modeler")
    told = REGISTRY.resolve(str(meant)) if meant is not None else REGISTRY.told_by(facts)
    assert told == modeler
