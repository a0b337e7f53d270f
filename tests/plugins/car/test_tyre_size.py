"""Sizes of tyres: read as they are written, followed by wheels, arches and report."""

from dataclasses import replace

import numpy as np
import pytest

from bozzetto.errors import UserError
from bozzetto.geometry import brep_mesh
from bozzetto.parameters import set_parameters
from bozzetto.plugin import Job
from bozzetto_car.body.build import body_of
from bozzetto_car.body.wheels import on_tyres
from bozzetto_car.export import shapes_of
from bozzetto_car.parts.closed_body import closed_body
from bozzetto_car.parts.wheel_arches import RADII, cut_panels
from bozzetto_car.parts.wheels import wheels_of
from bozzetto_car.report import report_of
from bozzetto_car.state import CarState
from bozzetto_car.tyre_size import tyre_size
from tests.plugins.car.marked_car import marked


@pytest.mark.parametrize(
    ("text", "width", "rim", "diameter"),
    [
        ("185/65 R15", 185, 381.0, 621.5),
        ("205/55R16", 205, 406.4, 631.9),
        ("225/50 R17 98Y", 225, 431.8, 656.8),
        ("235/60 ZR18", 235, 457.2, 739.2),
        ("P205/55-16", 205, 406.4, 631.9),
        (" 205 / 55 r 16 ", 205, 406.4, 631.9),
        ("195/70 R15C 104/102R", 195, 381.0, 654.0),
    ],
)
def test_sizes_are_those_of_tables(text, width, rim, diameter):
    """Diameters from tables of makers, to the millimetre that these print."""
    size = tyre_size(text)
    assert (size.width, round(size.rim, 1)) == (width, rim)
    assert abs(size.diameter - diameter) < 0.6


def test_no_text_is_no_size():
    assert tyre_size("") is tyre_size("  ") is None


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("big", "such as 205/55 R16"),
        ("205/55", "such as 205/55 R16"),
        ("205/55 R16 and more", "such as 205/55 R16"),
        ("205/99 R16", "from 20 to 95 %"),
        ("999/55 R16", "from 105 to 405 mm"),
        ("205/55 R99", "from 10 to 26 inches"),
        ("9" * 900, "such as 205/55 R16"),
        ("٢٠٥/٥٥ R١٦", "such as 205/55 R16"),
    ],
)
def test_what_is_no_size_is_refused_with_what_to_write(text, told):
    with pytest.raises(UserError, match=told):
        CarState(tyre=text)
    with pytest.raises(UserError, match=told):
        set_parameters(CarState(), {"tyre": text})


def test_wheels_have_the_size_and_stand_on_the_ground():
    car = body_of(CarState())
    network = on_tyres(car.network, "225/45 R18")
    parts = wheels_of(network, car.nets, "225/45 R18")
    for part in parts:
        low, high = brep_mesh(part.exact(), 0.2).bounds.astype(float)
        if part.name.startswith("Tyre"):
            assert high[2] - low[2] == pytest.approx(659.7, abs=1.0)
            assert high[1] - low[1] == pytest.approx(225.0, abs=0.5)
            assert abs(low[2]) < 0.5
        else:
            assert high[2] - low[2] == pytest.approx(457.2, abs=1.0)
    low = min(part.mesh().bounds[0, 2] for part in parts)
    assert abs(low) < 2.0


def test_arches_go_with_the_wheels():
    car = body_of(CarState())
    network = on_tyres(car.network, "205/55 R16")
    assert closed_body(network, car.nets).is_closed
    for number, panel in cut_panels(network, car.nets).items():
        for arc in panel.arcs:
            u, v = arc.value([0.5])[0]
            weights = [np.array([(1 - t) ** 3, 3 * t * (1 - t) ** 2, 3 * t**2 * (1 - t), t**3])
                       for t in (u, v)]  # fmt: skip
            place = np.einsum("i,j,ijk->k", *weights, car.nets[number])
            axles = network.positions[network.template.wheels[:, 0]]
            away = np.linalg.norm((place - axles)[:, ::2], axis=1).min() / 315.95
            assert min(abs(away - share) for share in RADII) < 1e-3


def test_without_a_size_everything_is_as_before():
    car = body_of(CarState())
    assert on_tyres(car.network, "") is car.network
    plain = wheels_of(car.network, car.nets)
    for one, other in zip(plain, wheels_of(car.network, car.nets, ""), strict=True):
        np.testing.assert_array_equal(one.mesh().vertices, other.mesh().vertices)
    radius = car.network.positions[car.template.wheels[0, 0], 2]
    (tyre,) = [p for p in plain if p.name == "Tyre front right"]
    low, high = brep_mesh(tyre.exact(), 0.2).bounds.astype(float)
    assert high[1] - low[1] == pytest.approx(0.62 * radius, abs=0.5)


def test_the_report_tells_the_sizes():
    body = body_of(marked(3))
    drawn = report_of(body, (), Job())["wheels"]
    radii = body.network.positions[body.template.wheels[:, 0], 2]
    assert [drawn[w]["diameter"] for w in ("front", "rear")] == pytest.approx(2.0 * radii)
    sized = report_of(body, (), Job(), "205/55 R16")["wheels"]
    for wheel in sized.values():
        assert wheel == pytest.approx({"diameter": 631.9, "width": 205.0, "rim": 406.4})


def test_body_and_surfaces_do_not_depend_on_tyres():
    plain = marked(3)
    sized = replace(plain, tyre="225/45 R18")
    (one,) = shapes_of(plain, body_of(plain)).patchworks
    (other,) = shapes_of(sized, body_of(sized)).patchworks
    np.testing.assert_array_equal(one.nets, other.nets)


def test_a_size_is_saved_and_taken_back(shell):
    shell.open("bozzetto.car")
    shell.set(tyre="205/55 R16")
    assert shell.undo()
    assert shell.state.tyre == ""
    assert shell.redo()
    with pytest.raises(UserError, match="205/55 R16"):
        shell.set(tyre="large ones")
    shell.save()
    assert not shell.reopen()
    assert shell.state.tyre == "205/55 R16"
