"""Reading templates: what is in the file comes in, and nothing else does."""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bozzetto.errors import FormatError
from bozzetto_car.state import TITLES
from bozzetto_car.template.loader import (
    TEMPLATES,
    bundled,
    faults_in,
    is_template,
    read_template,
)
from bozzetto_car.template.model import Template

Edit = Callable[[dict[str, Any]], object]


def content(name: str = "sedan") -> bytes:
    return files("bozzetto_car").joinpath(f"templates/{name}.json").read_bytes()


def edited(edit: Edit) -> bytes:
    told = json.loads(content())
    edit(told)
    return json.dumps(told).encode()


@pytest.mark.parametrize("name", TEMPLATES)
def test_what_a_file_says_comes_in(name: str) -> None:
    told = json.loads(content(name))
    template = bundled(name)
    assert (template.id, template.title) == (name, told["title"])
    for section in ("centre", "pairs", "wheels"):
        for node, record in told[section].items():
            full = node if section == "centre" else f"{node}.R"
            assert template.positions[template.node[full]].tolist() == record["at"]
            assert template.prompts[full] == record["prompt"]
    for key, (out, into) in told["edges"].items():
        start, end = (
            template.node.get(part, template.node.get(f"{part}.R")) for part in key.split("-")
        )
        assert start is not None
        assert end is not None
        edge = template.edge_between[start, end]
        assert template.tangents[edge].tolist() == [out, into]
    assert {patch.name for patch in template.patches} == {
        f"{key}.{side}" for key in told["patches"] for side in "RL"
    }
    assert {rule.name: rule.text for rule in template.rules} == told["soundness"]


def test_a_patch_runs_round_its_nodes() -> None:
    template = bundled("sedan")
    patch = next(patch for patch in template.patches if patch.name == "hood.R")
    assert [template.names[node] for node in patch.nodes] == ["C1", "C2", "S2.R", "S1.R"]
    image = next(patch for patch in template.patches if patch.name == "hood.L")
    assert [template.names[node] for node in image.nodes] == ["C1", "S1.L", "S2.L", "C2"]
    for patch in template.patches:
        for number, edge in enumerate(patch.edges):
            ends = template.edges[edge] if edge >= 0 else template.edges[~edge][::-1]
            assert ends.tolist() == [patch.nodes[number], patch.nodes[(number + 1) % 4]]


def test_chains_go_over_the_middle_where_they_are_smooth_there() -> None:
    template = bundled("hatchback")
    chains = {
        chain.name: [template.names[node] for node in chain.nodes] for chain in template.chains
    }
    assert chains["roof_centreline"] == ["C2", "C3", "C4", "C5", "C6"]
    assert chains["arch_c4"] == ["R2.L", "C4", "R2.R"]
    assert chains["sill.L"] == ["B1.L", "B2.L", "B3.L", "B4.L", "B5.L"]
    assert len(chains) == 16


def test_bundled_templates_are_read_once() -> None:
    assert bundled("minivan") is bundled("minivan")


def test_there_is_no_other_bundled_template() -> None:
    for name in ("tank", "../sedan", ""):
        with pytest.raises(FormatError, match="sedan, hatchback, minivan"):
            bundled(name)


def test_a_third_partys_file_is_read(tmp_path: Path) -> None:
    path = tmp_path / "van.json"
    path.write_bytes(b"\xef\xbb\xbf" + edited(lambda told: told.update(id="van", title="Van")))
    template = read_template(path.read_bytes())
    assert template.title == "Van"
    assert (template.positions == bundled("sedan").positions).all()
    assert faults_in(path) == []


# -- what is wrong is named ------------------------------------------------------------------------


def node(told: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = told["pairs"]["S1"]
    return found


def lamp(told: dict[str, Any]) -> dict[str, Any]:
    found: dict[str, Any] = told["insets"]["headlamp"]
    return found


WRONG: list[tuple[Edit, str]] = [
    (lambda t: t.pop("order"), "“order” is missing"),
    (lambda t: t.pop("format"), "“format” must be"),
    (lambda t: t.update(format="bozzetto-car-template/9"), "“format” must be"),
    (lambda t: t.update(wings=2), "wings"),
    (lambda t: t.update(id="../x"), "a word such as roof_rail.*id"),
    (lambda t: t.update(title=""), "title"),
    (lambda t: t.update(about="long" * 100), "about"),
    (lambda t: t.update(pairs=[]), "pairs: an object"),
    (lambda t: t.update(edges={f"A{i}-B{i}": 0 for i in range(500)}), "edges: 500 entries"),
    (lambda t: node(t).update(at=[1, 2]), "pairs, S1"),
    (lambda t: node(t).update(at=[1, 2, "3"]), "pairs, S1"),
    (lambda t: node(t).update(at=[1, 2, 1e6]), "pairs, S1"),
    (lambda t: node(t).update(at=[1, 2, 10**400]), "pairs, S1"),
    (lambda t: node(t).update(at=[1, 2, None]), "pairs, S1"),
    (lambda t: node(t).update(prompt=7), "pairs, S1"),
    (lambda t: node(t).update(colour="red"), "pairs, S1.*colour"),
    (lambda t: node(t).pop("picture"), "pairs, S1.*picture"),
    (lambda t: node(t)["picture"].update(azimuth=1000), "pairs, S1.*azimuth"),
    (lambda t: node(t)["picture"].update(patches=["mast"]), "patch mast.R"),
    (lambda t: t["pairs"].update({"s 1": node(t)}), "the name “s 1”.* such as S1"),
    (lambda t: t["pairs"].update(C1=node(t)), "C1 stands in two"),
    (lambda t: t["wheels"].pop("WR"), "wheels: .* two entries"),
    (lambda t: t["edges"].update({"C0-C1-C2": [[0, 0, 0]] * 2}), "edges, C0-C1-C2"),
    (lambda t: t["edges"].update({"C0-C0": [[0, 0, 0]] * 2}), "edges, C0-C0"),
    (lambda t: t["edges"].update({"C0-X9": [[0, 0, 0]] * 2}), "edges, C0-X9: .* no node X9"),
    (lambda t: t["edges"].update({"C1-C0": [[0, 0, 0]] * 2}), "two edges between C1 and C0"),
    (lambda t: t["edges"].update({"C0-C1": [[0, 0, 0]]}), "edges, C0-C1"),
    (lambda t: t["edges"].pop("C0-C1"), "patches, front_fascia: .* between C0 and C1"),
    (lambda t: t["patches"].update(hood=["C1", "C2", "S2"]), "patches, hood"),
    (lambda t: t["patches"].update(hood=["C1", "C2", "S2", "S9"]), "patches, hood: .* S9"),
    (lambda t: t["patches"].update(Hood=["C1", "C2", "S2", "S1"]), "the name “Hood”"),
    (lambda t: t["chains"]["sill"].update(nodes=["B1", "B3"]), "chains, sill: .* B1.R and B3.R"),
    (lambda t: t["chains"]["sill"].update(smooth=[]), "chains, sill"),
    (lambda t: t["chains"]["sill"].update(smooth=["Q1"]), "chains, sill: .* Q1"),
    (lambda t: t["soundness"].update({"It flies": "C9.z >= 100"}), "soundness, “It flies”"),
    (lambda t: lamp(t).update(patch="mast"), "insets, headlamp: .* no patch mast without"),
    (lambda t: lamp(t).update(patch="windscreen"), "insets, headlamp: .* windscreen without"),
    (lambda t: lamp(t).update(kind="fog"), "insets, headlamp.*kind"),
    (lambda t: lamp(t).update(u=[0.9, 0.7]), "insets, headlamp: .* smaller number first"),
    (lambda t: lamp(t).update(u=[0.7, 0.7]), "insets, headlamp: it has no size"),
    (lambda t: lamp(t).update(u=[0.7, 1.0]), "insets, headlamp: it reaches over an edge"),
    (lambda t: lamp(t).update(v=[-0.1, 0.5]), "insets, headlamp"),
    (lambda t: lamp(t).update(v=[0.5]), "insets, headlamp"),
    (lambda t: lamp(t).update(glow=1), "insets, headlamp.*glow"),
    (lambda t: lamp(t).pop("u"), "insets, headlamp.*u"),
    (lambda t: t["insets"].update(fog=lamp(t)), "insets, fog: it lies over headlamp"),
    (lambda t: t.update(insets=["headlamp"]), "insets: an object"),
    (lambda t: t.update(shut_lines="C1-S1"), "shut_lines"),
    (lambda t: t["shut_lines"].append(7), "shut_lines"),
    (lambda t: t["shut_lines"].append("C1"), "shut_lines, C1"),
    (lambda t: t["shut_lines"].append("C1-Q1"), "shut_lines, C1-Q1: .* Q1"),
    (lambda t: t["shut_lines"].append("C1-B5"), "shut_lines, C1-B5"),
    (lambda t: t["order"].append("S1"), "order: “S1” should be"),
    (lambda t: t["order"].append("S1.left"), "order: “S1.left” should be"),
    (lambda t: t["order"].append("C1.near"), "order: “C1.near” should be"),
    (lambda t: t["order"].append("Q1"), "order: there is no node Q1"),
    (lambda t: t["order"].append("C1"), "asks for C1 2 times"),
]


@pytest.mark.parametrize(("edit", "named"), WRONG, ids=[named for _, named in WRONG])
def test_the_message_names_what_is_wrong(edit: Edit, named: str, tmp_path: Path) -> None:
    data = edited(edit)
    with pytest.raises(FormatError, match=named):
        read_template(data)
    path = tmp_path / "wrong.json"
    path.write_bytes(data)
    assert faults_in(path)


@pytest.mark.parametrize(
    ("data", "named"),
    [
        (b"", "not valid JSON"),
        (b"\xff\xfe{", "UTF-8"),
        (b"[]", "not a JSON object"),
        (b"[" * 100_000, "nested too deeply"),
        (b'{"format": NaN}', "NaN is not a number"),
        (b'{"format": -Infinity}', "-Infinity is not a number"),
        (b'{"id": 1, "id": 2}', "“id” stands twice"),
        (b" " * ((1 << 20) + 1), "larger than"),
    ],
)
def test_what_is_no_template_at_all_is_refused(data: bytes, named: str) -> None:
    with pytest.raises(FormatError, match=named):
        read_template(data)


def test_a_doubled_node_is_not_swallowed() -> None:
    doubled = content().replace(b'"S2": {', b'"S1": {', 1)
    with pytest.raises(FormatError, match="“S1” stands twice"):
        read_template(doubled)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(FormatError, match=r"none\.json cannot be read"):
        is_template(tmp_path / "none.json")
    assert len(faults_in(tmp_path)) == 1  # a folder


def test_many_faults_are_counted_not_listed() -> None:
    def flat(told: dict[str, Any]) -> None:
        for record in told["pairs"].values():
            record["at"][1] = -1.0

    with pytest.raises(FormatError, match=r"There are \d+ more faults") as problem:
        read_template(edited(flat))
    assert len(problem.value.message) < 1000


def test_no_damage_to_a_file_does_worse_than_a_message() -> None:
    """Bytes exchanged, cut out and doubled: a template or a FormatError, nothing else."""
    rng = np.random.default_rng(2)
    data = content("minivan")
    refused = 0
    for _ in range(400):
        broken = bytearray(data)
        at, span = int(rng.integers(len(data))), int(rng.integers(1, 40))
        match rng.integers(4):
            case 0:
                broken[at] = int(rng.integers(32, 127))
            case 1:
                del broken[at : at + span]
            case 2:
                broken[at:at] = broken[at : at + span]
            case _:
                broken[at : at + 1] = b"-9" if rng.random() < 0.5 else b"7e3"
        try:
            assert isinstance(read_template(bytes(broken)), Template)
        except FormatError:
            refused += 1
    assert refused > 200


def test_templates_are_called_in_the_parameters_as_they_call_themselves() -> None:
    assert TITLES == tuple((name, bundled(name).title) for name in TEMPLATES)
