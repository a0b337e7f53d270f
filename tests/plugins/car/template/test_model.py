"""What holds of every template that comes along: counts, symmetry, surfaces, pictures."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from bozzetto_car.template.model import Template, ViewHint, twin

COUNTS = {False: (39, 62, 28, 63), True: (41, 66, 30, 66)}
"""Without and with a tailgate: nodes, edges, patches (Kara & Shimada 2008), and variables: 3 for a
pair, 2 in the middle."""

MIDDLE = [f"C{number}" for number in range(9)]
TAILGATE = {"hatchback", "minivan", "estate", "city_car", "suv", "van"}
PAIRS = ["S1", "S2", "S3", "S4", "S5", "R1", "R2", "R3", "B1", "B2", "B3", "B4", "B5", "WF", "WR"]


# -- the network -----------------------------------------------------------------------------------


def test_the_counts_are_those_of_the_paper(template: Template) -> None:
    nodes, edges, patches, variables = COUNTS[template.id in TAILGATE]
    assert template.positions.shape == (nodes, 3)
    assert template.edges.shape == (edges, 2)
    assert template.tangents.shape == (edges, 2, 3)
    assert len(template.patches) == patches
    assert template.basis.shape == (3 * nodes, variables)


def test_the_nodes_keep_their_names(template: Template) -> None:
    pairs = [*PAIRS, "S6"] if template.id in TAILGATE else PAIRS
    named = {*MIDDLE, *(f"{name}.{side}" for name in pairs for side in "RL")}
    assert set(template.names) == named
    assert len(template.names) == len(named)
    wheels = [[template.names[node] for node in pair] for pair in template.wheels]
    assert wheels == [["WF.R", "WF.L"], ["WR.R", "WR.L"]]


def test_no_edge_ends_in_a_wheel_and_three_to_five_meet_elsewhere(template: Template) -> None:
    degree = np.bincount(template.edges.ravel(), minlength=len(template.names))
    wheels = template.wheels.ravel()
    assert not degree[wheels].any()
    rest = np.delete(degree, wheels)
    assert rest.min() >= 3
    assert rest.max() <= 5


def test_the_left_half_is_the_mirror_image_to_the_last_bit(template: Template) -> None:
    places = {name: template.positions[number] for name, number in template.node.items()}
    for name, (x, y, z) in places.items():
        assert tuple(places[twin(name)]) == (x, -y, z) if name != twin(name) else y == 0.0
    curves = {tuple(map(tuple, points)) for points in (template.control_points + 0.0).tolist()}
    for points in template.control_points * (1.0, -1.0, 1.0) + 0.0:
        there, back = (tuple(map(tuple, way.tolist())) for way in (points, points[::-1]))
        assert there in curves or back in curves
    image = template.mirrored_edges
    for number, other in enumerate(image.tolist()):
        ends = [twin(template.names[node]) for node in template.edges[number]]
        found = template.edges[other] if other >= 0 else template.edges[~other][::-1]
        assert [template.names[node] for node in found] == ends


def test_edges_are_cubics_with_the_given_derivatives(template: Template) -> None:
    from scipy.interpolate import CubicHermiteSpline

    at = np.linspace(0.0, 1.0, 7)
    for ends, tangents, bezier in zip(
        template.edges, template.tangents, template.control_points, strict=True
    ):
        curve = CubicHermiteSpline([0.0, 1.0], template.positions[ends], tangents)
        u = at[:, None]
        weights = np.hstack(((1 - u) ** 3, 3 * u * (1 - u) ** 2, 3 * u**2 * (1 - u), u**3))
        np.testing.assert_allclose(weights @ bezier, curve(at), atol=1e-9)


def test_edges_are_found_by_their_ends_in_both_senses(template: Template) -> None:
    for number, (start, end) in enumerate(template.edges.tolist()):
        assert template.edge_between[start, end] == number
        assert ~template.edge_between[end, start] == number
        assert template.edge_names[number] == f"{template.names[start]}-{template.names[end]}"


def test_a_template_cannot_be_changed(template: Template) -> None:
    with pytest.raises(ValueError, match="read-only"):
        template.positions[0, 0] = 1.0
    with pytest.raises(dataclasses.FrozenInstanceError):
        template.title = "Boat"  # type: ignore[misc]
    with pytest.raises(TypeError):
        template.prompts["C0"] = ""  # type: ignore[index]


# -- symmetric cars as numbers ---------------------------------------------------------------------


def test_its_own_variables_give_the_template_back(template: Template) -> None:
    assert (template.whole(template.variables) == template.positions).all()
    assert (template.reduced(template.positions) == template.variables).all()


def test_any_variables_give_a_symmetric_car(template: Template) -> None:
    rng = np.random.default_rng(5)
    for _ in range(20):
        variables = rng.normal(0.0, 1e4, len(template.variables))
        places = template.whole(variables)
        right, left = template.pairs.T
        assert (places[right] * (1.0, -1.0, 1.0) == places[left]).all()
        assert not places[template.centre, 1].any()
        assert (template.reduced(places) == variables).all()


def test_every_symmetric_car_has_variables(template: Template) -> None:
    """The space of them has as many dimensions as there are variables: none is left out."""
    constraints = []
    for right, left in template.pairs.tolist():
        for axis, sign in enumerate((-1.0, 1.0, -1.0)):
            row = np.zeros(template.positions.shape)
            row[right, axis], row[left, axis] = 1.0, sign
            constraints.append(row.ravel())
    for node in template.centre.tolist():
        row = np.zeros(template.positions.shape)
        row[node, 1] = 1.0
        constraints.append(row.ravel())
    rows = np.array(constraints)
    assert not (rows @ template.basis).any()
    free = template.positions.size - np.linalg.matrix_rank(rows)
    assert np.linalg.matrix_rank(template.basis) == template.basis.shape[1] == free


# -- marks -----------------------------------------------------------------------------------------


def test_every_node_is_asked_for_once_on_the_near_side_first(template: Template) -> None:
    for near, far in ("RL", "LR"):
        order = [template.names[node] for node in template.asked(near)]
        assert sorted(order) == sorted(template.names)
        assert order[:2] == [f"WF.{near}", f"WR.{near}"]
        for name in order:
            if name.endswith(f".{near}"):
                assert order.index(name) < order.index(f"{name[:-1]}{far}")


def test_prompts_are_different_sentences_for_people(template: Template) -> None:
    assert template.prompts["C2"] == "Lowest point of the windscreen, in the middle"
    for told in (template.prompts, template.titles):
        for name in template.names:
            text = told[name]
            assert text[0].isupper()
            assert not text.endswith(".")
            assert "_" not in text
        halves = {name.partition(".")[0] for name in template.names}
        assert len(set(told.values())) == len(halves)


def test_pictures_of_a_pair_are_mirror_images(template: Template) -> None:
    for name, picture in template.pictures.items():
        other = template.pictures[twin(name)]
        if name != twin(name):
            assert (picture.azimuth, picture.elevation) == (-other.azimuth, other.elevation)
            assert picture.patches == tuple(twin(patch) for patch in other.patches)
            right = name.endswith(".R")
            assert (picture.toward_eye[1] > 0.0) == right


@pytest.mark.parametrize(
    ("azimuth", "elevation", "eye"),
    [
        (0.0, 0.0, (-1.0, 0.0, 0.0)),
        (90.0, 0.0, (0.0, 1.0, 0.0)),
        (180.0, 0.0, (1.0, 0.0, 0.0)),
        (-90.0, 0.0, (0.0, -1.0, 0.0)),
        (37.0, 90.0, (0.0, 0.0, 1.0)),
    ],
)
def test_a_picture_looks_from_where_it_says(
    azimuth: float, elevation: float, eye: tuple[float, float, float]
) -> None:
    np.testing.assert_allclose(ViewHint(azimuth, elevation).toward_eye, eye, atol=1e-15)
