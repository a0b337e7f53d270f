"""Creases: declared with a reason, checked, and nowhere else, in templates and in solved cars."""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto.errors import FormatError
from bozzetto.geometry.patches import crease_angles
from bozzetto_car.body.build import body_of
from bozzetto_car.body.chain_smoothing import lock_ratios
from bozzetto_car.body.fair_lines import fair_network
from bozzetto_car.state import CarState
from bozzetto_car.template.fair_patches import fair_nets
from bozzetto_car.template.loader import TEMPLATES, bundled, bundled_file, read_template
from bozzetto_car.template.model import MIRROR, Template
from bozzetto_car.template.network import Network, edge_called
from bozzetto_car.template.smooth_edges import smooth_by_chains
from bozzetto_car.template.writer import template_file
from tests.plugins.car.sketched import rubbery, styled

Array = NDArray[np.float64]

KINDS = {
    "front edge of the bonnet": ("C1-S1",),
    "corners of the bumpers": ("S1-B1", "B5-S5", "B5-S6"),
    "sides of the bonnet and of the boot or tailgate": ("S2-S1", "S5-S4", "S6-S5"),
    "feet of the screens": ("C2-S2", "C6-S4", "C6-S5"),
    "heads of the screens": ("C3-R1", "C5-R3"),
    "pillars of the screens": ("R1-S2", "S4-R3", "S5-R3"),
    "roof rails": ("R2-R1", "R3-R2"),
    "rear edge of the boot": ("C7-S5",),
    "lower end of the tailgate": ("C7-S6",),
    "waistline": ("S3-S2", "S4-S3", "S6-S4"),
}
"""All kinds of creases that a bundled template has: docs/car.md gives the reason of each."""


def angles_of(network: Network) -> Array:
    template = network.template
    return crease_angles(fair_nets(network), template.sides, len(template.edges))


@pytest.mark.parametrize("name", TEMPLATES)
def test_a_template_breaks_where_it_declares_it_and_nowhere_else(name: str) -> None:
    template = bundled(name)
    angles = angles_of(Network.of(template))
    assert angles[template.smooth_edges].max() < 1e-4
    assert angles[sorted(template.creases)].min() > 3.0
    assert len(template.creases) <= 32


@pytest.mark.parametrize("name", TEMPLATES)
def test_every_crease_is_of_a_kind_with_a_reason(name: str) -> None:
    declared = set(json.loads(bundled_file(name))["creases"])
    known = {key for keys in KINDS.values() for key in keys}
    assert declared <= known


@pytest.mark.parametrize("name", TEMPLATES)
def test_cars_that_have_moved_are_smooth_where_their_template_is(name: str) -> None:
    template = bundled(name)
    for seed in range(4):
        for make in (styled, rubbery):
            network = lock_ratios(fair_network(template, make(template, seed)))
            angles = angles_of(network)
            assert np.isfinite(network.tangents).all()
            assert angles[template.smooth_edges].max() < 1e-6
            again = lock_ratios(network)
            assert np.abs(again.tangents - network.tangents).max() < 1e-9


# -- files -----------------------------------------------------------------------------------------


def changed(**keys: Any) -> bytes:
    told = json.loads(bundled_file("sedan")) | keys
    return json.dumps({key: value for key, value in told.items() if value is not None}).encode()


def test_a_file_without_creases_loads_and_breaks_where_its_lines_do() -> None:
    template = read_template(changed(creases=None))
    inner = set(range(len(template.edges))) - template.rim
    assert template.creases == inner - smooth_by_chains(template)
    assert len(smooth_by_chains(template)) == 18
    angles = angles_of(lock_ratios(Network.of(template)))
    assert angles[template.smooth_edges].max() < 1e-6


def test_a_third_party_may_declare_more_creases() -> None:
    own = json.loads(bundled_file("sedan"))["creases"]
    template = read_template(changed(creases=[*own, "R2-C4"]))
    extra = template.creases - bundled("sedan").creases
    assert {template.edge_names[edge] for edge in extra} == {"C4-R2.R", "C4-R2.L"}


@pytest.mark.parametrize(
    ("creases", "words"),
    [
        (["C1-S9"], "no node S9"),
        (["C1-R3"], "no edge between"),
        (["B2-B1"], "lower rim"),
        (["C1"], "no node"),
        ([7], "creases"),
        ("C1-S1", "creases"),
        ([], "breaks by"),
    ],
)
def test_creases_that_are_wrong_are_refused_in_words(creases: Any, words: str) -> None:
    with pytest.raises(FormatError, match=words):
        read_template(changed(creases=creases))


def test_an_edge_that_breaks_without_being_declared_is_named() -> None:
    own = json.loads(bundled_file("sedan"))["creases"]
    own.remove("S3-S2")
    with pytest.raises(FormatError, match=r"breaks by 3\d° over the edge S3\.R-S2\.R"):
        read_template(changed(creases=own))


def test_a_car_that_was_not_kept_smooth_is_saved_with_its_creases() -> None:
    template = bundled("sedan")
    tangents = template.tangents.copy()
    edge = edge_called(template, "S3.R-B3.R")
    image = template.mirrored_edges[edge]
    for name in ("S3.R-S2.R", "B3.R-B2.R"):
        neighbour = edge_called(template, name)
        tangents[neighbour, 0] *= 0.2 if name == "S3.R-S2.R" else 5.0
        tangents[template.mirrored_edges[neighbour], 0] = tangents[neighbour, 0] * MIRROR
    broken = Network(template, template.positions, tangents)
    made = read_template(template_file(bundled_file("sedan").decode(), broken, "Broken"))
    extra = made.creases - template.creases
    assert {edge, image} <= extra


def test_between_two_templates_what_breaks_in_either_may_break() -> None:
    state = CarState(template="sedan", blend="pickup", share=0.5)
    template: Template = body_of(state).template
    assert template.creases == bundled("sedan").creases | bundled("pickup").creases
    assert body_of(state).creases[template.smooth_edges].max() < 1e-4
    assert replace(template, creases=frozenset()).smooth_edges.sum() == 50
