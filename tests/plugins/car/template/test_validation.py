"""Every kind of fault is found, and none where there is none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from bozzetto_car.template.loader import TEMPLATES, bundled
from bozzetto_car.template.model import Chain, Template, ViewHint
from bozzetto_car.template.validation import check

SEDAN = bundled("sedan")

Change = Callable[[NDArray[np.float64]], object]


@pytest.mark.parametrize("name", TEMPLATES)
def test_there_is_nothing_wrong_with_those_that_come_along(name: str) -> None:
    assert check(bundled(name)) == []


def with_places(change: Change) -> Template:
    places = SEDAN.positions.copy()
    change(places)
    return replace(SEDAN, positions=places)


def with_tangents(change: Change) -> Template:
    tangents = SEDAN.tangents.copy()
    change(tangents)
    return replace(SEDAN, tangents=tangents)


def edge(name: str) -> int:
    return SEDAN.edge_names.index(name)


def scaled(name: str, end: int, factor: object) -> Template:
    """The tangent at one end of an edge changed, and that of its mirror image in the same way."""

    def change(tangents: NDArray[np.float64]) -> None:
        for number in {edge(name), int(SEDAN.mirrored_edges[edge(name)])}:
            tangents[number, end] = tangents[number, end] * factor

    return with_tangents(change)


def said(template: Template, words: str) -> bool:
    return any(words in sentence for sentence in check(template))


# -- nodes -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda p: p.__setitem__((SEDAN.node["C2"], 1), 1e-9), "C2 should lie in the middle"),
        (
            lambda p: p.__setitem__((SEDAN.node["S1.L"], 0), 390.0 + 1e-9),
            "S1.R and its mirror image S1.L do not match",
        ),
        (
            lambda p: p.__imul__(np.array([1.0, -1.0, 1.0])),
            "S1.R should lie on the right side",
        ),
        (
            lambda p: p.__setitem__(SEDAN.node["C2"], p[SEDAN.node["C1"]]),
            "C1 and C2 lie in one place",
        ),
    ],
)
def test_nodes_out_of_place(change: Change, words: str) -> None:
    assert said(with_places(change), words)


def test_nodes_of_no_pair_or_of_two_names() -> None:
    assert said(replace(SEDAN, pairs=SEDAN.pairs[:-1]), "WR.R should be either")
    doubled = (*SEDAN.names[:-1], SEDAN.names[0])
    assert said(replace(SEDAN, names=doubled), "Two nodes are called C0")


def test_wheels_that_are_no_pairs() -> None:
    assert said(replace(SEDAN, wheels=SEDAN.wheels[:1]), "two pairs of wheels")
    crossed = SEDAN.wheels.copy()
    crossed[:, 1] = crossed[::-1, 1]
    assert said(replace(SEDAN, wheels=crossed), "two pairs of wheels")


# -- edges and patches -----------------------------------------------------------------------------


def test_edges_must_match_their_mirror_images() -> None:
    def one_side(tangents: NDArray[np.float64]) -> None:
        tangents[edge("S3.R-B3.R"), 0, 2] += 1e-9

    assert said(with_tangents(one_side), "S3.R-B3.R and of its mirror image differ")


def test_an_edge_on_the_middle_keeps_to_it() -> None:
    def aside(tangents: NDArray[np.float64]) -> None:
        tangents[edge("C0-C1"), 0, 1] = 5.0

    assert said(with_tangents(aside), "C0-C1 and of its mirror image differ")


def test_a_missing_patch_opens_the_shell() -> None:
    without = tuple(patch for patch in SEDAN.patches if patch.name != "hood.R")
    broken = replace(SEDAN, patches=without)
    assert said(broken, "nodes minus edges plus patches are 0")
    assert said(broken, "along one rim of 12 edges")
    assert said(broken, "hood.L has no mirror image")


def test_a_hole_in_the_roof_is_no_rim() -> None:
    """Removing both halves of the bonnet leaves the counts of a disc with a hole."""
    without = tuple(patch for patch in SEDAN.patches if not patch.name.startswith("hood"))
    assert said(replace(SEDAN, patches=without), "edges in 2 rings are open")


def test_a_patch_turned_over_is_inside_out() -> None:
    patches = list(SEDAN.patches)
    first = patches[0]
    a, b, c, d = first.nodes
    edges = tuple(~number for number in reversed(first.edges))
    patches[0] = replace(first, nodes=(a, d, c, b), edges=edges)
    assert said(replace(SEDAN, patches=tuple(patches)), "one is inside out")


def test_all_patches_turned_over_are_inside_out() -> None:
    turned = []
    for patch in SEDAN.patches:
        a, b, c, d = patch.nodes
        turned.append(
            replace(patch, nodes=(a, d, c, b), edges=tuple(~n for n in reversed(patch.edges)))
        )
    assert said(replace(SEDAN, patches=tuple(turned)), "All patches are inside out")


def test_edges_of_a_patch_must_join_its_nodes() -> None:
    patches = list(SEDAN.patches)
    patches[3] = replace(patches[3], edges=tuple(reversed(patches[3].edges)))
    assert said(replace(SEDAN, patches=tuple(patches)), "roof_front.R do not join its nodes")


def test_an_edge_without_a_patch_and_an_edge_to_a_wheel() -> None:
    ends = [(SEDAN.node[f"WF.{side}"], SEDAN.node[f"B1.{side}"]) for side in "RL"]
    more = replace(
        SEDAN,
        edges=np.concatenate((SEDAN.edges, ends)),
        tangents=np.concatenate((SEDAN.tangents, np.ones((2, 2, 3)) * (1.0, 0.0, 1.0))),
    )
    assert said(more, "No patch lies at the edge WF.R-B1.R")
    assert said(more, "WF.R-B1.R ends in the centre of a wheel")


def test_a_corner_whose_edges_run_in_one_line() -> None:
    """The edge to the B-pillar led on from the waistline: the door has no normal there."""

    def bent(tangents: NDArray[np.float64]) -> None:
        for side in "RL":
            along = tangents[SEDAN.edge_names.index(f"S3.{side}-S2.{side}"), 0]
            tangents[SEDAN.edge_names.index(f"S3.{side}-B3.{side}"), 0] = -along

    assert said(with_tangents(bent), "door_front.R at S3.R run in one line (they make 180.0°)")


# -- chains ----------------------------------------------------------------------------------------


def test_a_kink_in_a_chain() -> None:
    broken = scaled("C3-C4", 0, np.array([1.0, 1.0, 1.01]))
    assert said(broken, "roof_centreline has a kink of")
    assert said(scaled("C3-C4", 0, 0.0), "has no direction at C3")


def test_longer_tangents_make_no_kink() -> None:
    assert not said(scaled("C3-C4", 0, 3.0), "kink")


def test_an_arch_crosses_the_middle_at_a_right_angle() -> None:
    def raised(tangents: NDArray[np.float64]) -> None:
        tangents[edge("C4-R2.R"), 0, 2] = 40.0
        tangents[edge("C4-R2.L"), 0, 2] = 40.0

    assert said(with_tangents(raised), "arch_c4 has a kink")


def with_chain(chain: Chain) -> Template:
    return replace(SEDAN, chains=(*SEDAN.chains, chain))


def chain_of(nodes: str, smooth: str) -> Chain:
    numbers = [SEDAN.node[name] for name in nodes.split()]
    edges = [SEDAN.edge_between.get(ends, 0) for ends in pairwise(numbers)]
    return Chain("new", tuple(numbers), tuple(edges), tuple(SEDAN.node[n] for n in smooth.split()))


@pytest.mark.parametrize(
    ("nodes", "smooth", "words"),
    [
        ("C0 C1 C3", "C1", "new is not connected"),
        ("C0 C1 C0", "C1", "new meets a node twice"),
        ("C0 C1 C2", "C0", "new cannot be smooth at C0"),
        ("C2 C3 C4", "C3", "roof_centreline and new are both smooth"),
        ("S2.R R1.R R2.R", "R1.R", "R1.R, a corner of the patch glass_front.R"),
    ],
)
def test_chains_that_cannot_be(nodes: str, smooth: str, words: str) -> None:
    assert said(with_chain(chain_of(nodes, smooth)), words)


# -- rules and marks -------------------------------------------------------------------------------


def test_a_template_keeps_its_own_rules() -> None:
    rule = replace(SEDAN.rules[0], constant=SEDAN.rules[0].constant - 5000.0)
    assert said(replace(SEDAN, rules=(rule,)), f"does not keep its own constraint “{rule.name}”")


def test_every_node_is_asked_for_once_and_in_words() -> None:
    assert said(replace(SEDAN, order=SEDAN.order[1:]), "asks for WF.R 0 times")
    assert said(replace(SEDAN, order=(*SEDAN.order, "C4")), "asks for C4 2 times")
    assert said(replace(SEDAN, prompts={**SEDAN.prompts, "C4": ""}), "C4 has no title or no prompt")


def test_pictures_show_what_they_speak_of() -> None:
    def pictured(picture: ViewHint) -> Template:
        return replace(SEDAN, pictures={**SEDAN.pictures, "C2": picture})

    assert said(pictured(ViewHint(180.0, -40.0)), "C2 looks at the car from where")
    assert said(pictured(ViewHint(0.0, 20.0, ("mast.R",))), "patch mast.R, which there is not")
    wheel = replace(SEDAN, pictures={**SEDAN.pictures, "WF.R": ViewHint(-90.0, 0.0)})
    assert said(wheel, "WF.R looks at the car from where")
    without = {name: shown for name, shown in SEDAN.pictures.items() if name != "C2"}
    assert said(replace(SEDAN, pictures=without), "C2 has no picture")
