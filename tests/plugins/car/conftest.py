"""The templates that the tests of this folder are for."""

from __future__ import annotations

import pytest

from bozzetto_car.template.loader import PAPER_TEMPLATES, bundled
from bozzetto_car.template.model import Template


@pytest.fixture(params=PAPER_TEMPLATES)
def template(request: pytest.FixtureRequest) -> Template:
    """A car of the paper's, before anybody has drawn it."""
    return bundled(request.param)
