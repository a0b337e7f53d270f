"""The templates that the tests of this folder are for."""

from __future__ import annotations

import pytest

from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import Template


@pytest.fixture(params=TEMPLATES)
def template(request: pytest.FixtureRequest) -> Template:
    """Any car that comes with the program, before anybody has drawn it."""
    return bundled(request.param)
