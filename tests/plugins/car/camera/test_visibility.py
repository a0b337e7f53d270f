"""What faces a camera."""

from __future__ import annotations

import numpy as np
import pytest

from bozzetto.view import Camera
from bozzetto_car.camera.visibility import facing
from bozzetto_car.template.loader import TEMPLATES, bundled


def seen(name: str, eye: tuple[float, float, float], kind: str = "perspective") -> set[str]:
    template = bundled(name)
    camera = Camera(kind, eye, (2300.0, 0.0, 600.0))
    flags = facing(template, template.positions, camera)
    return {node for node, flag in zip(template.names, flags, strict=True) if flag}


@pytest.mark.parametrize("name", TEMPLATES)
@pytest.mark.parametrize("kind", ["perspective", "orthographic"])
def test_a_side_shows_that_side(name: str, kind: str) -> None:
    right = seen(name, (2300.0, 12000.0, 600.0), kind)
    assert {"WF.R", "WR.R", "S2.R", "S3.R", "B3.R", "R2.R"} <= right
    assert not right & {"WF.L", "WR.L", "S3.L", "B2.L", "B3.L", "R2.L"}


@pytest.mark.parametrize("name", TEMPLATES)
def test_a_mirrored_eye_sees_the_mirrored_nodes(name: str) -> None:
    template = bundled(name)
    right = seen(name, (-4000.0, 5000.0, 1800.0))
    left = seen(name, (-4000.0, -5000.0, 1800.0))
    assert {template.names[template.mirrored[template.node[node]]] for node in right} == left


def test_ends_and_roof() -> None:
    nose = seen("sedan", (-9000.0, 0.0, 700.0))
    tail = seen("sedan", (14000.0, 0.0, 900.0))
    assert {"C0", "C1", "C3", "B1.R", "B1.L"} <= nose
    assert {"C5", "C6", "C7", "C8", "B5.R", "B5.L"} <= tail
    assert "C8" not in nose
    assert "C0" not in tail
    above = seen("sedan", (2300.0, 0.0, 15000.0))
    assert {"C1", "C2", "C3", "C4", "C5", "C6", "C7"} <= above


def test_nothing_behind_the_eye_is_seen() -> None:
    template = bundled("sedan")
    away = Camera("perspective", (2300.0, 9000.0, 600.0), (2300.0, 18000.0, 600.0))
    assert not facing(template, template.positions, away).any()


def test_a_car_without_size_shows_nothing_and_warns_of_nothing() -> None:
    template = bundled("sedan")
    camera = Camera("perspective", (0.0, -500.0, 0.0), (0.0, 0.0, 0.0))
    flat = np.zeros_like(template.positions)
    assert not facing(template, flat, camera).any()
    at_eye = facing(template, flat + camera.eye, camera)
    assert not at_eye.any()
