"""Write the templates that are shaped from another one: ``python docs/write_car_templates.py``.

The sedan, the hatchback and the minivan are laid out by hand, node by node and tangent by tangent.
The others have the network of one of these, nodes of their own, and what else `KINDS` says. Lines
through the nodes are made fair as in a solved car, and smooth surfaces stay smooth.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from bozzetto_car.body.chain_smoothing import lock_ratios, smooth_chains
from bozzetto_car.body.fair_lines import (
    STRAIGHT,
    crested,
    double_bends,
    opened,
    turned_with_chords,
)
from bozzetto_car.template.crease_sides import one_sided
from bozzetto_car.template.loader import bundled_file, read_template
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import Network, junctions, with_tangents

Array = NDArray[np.float64]
Point = tuple[float, float, float]

FOLDER: Final = Path(__file__).parents[1] / "plugins/bozzetto_car/templates"

STRAIGHTENINGS: Final = 4
"""Most rounds: one edge that is straightened may bend its neighbour twice."""

DECIMALS: Final = 4
"""Decimals of tangents, mm: a chain that is smooth stays so to 1e-7."""


@dataclass(frozen=True)
class Kind:
    """A template that is shaped from another one.

    Attributes
    ----------
    base : str
        The template whose network it has.
    title, about : str
    nodes : mapping of str to (float, float, float)
        Places of all nodes of the right half and the middle, mm.
    tangents : mapping of str to ((float, float, float), (float, float, float))
        Edges that are not left to the fair lines, by name, as in a template's file.
    words : mapping of str to (str, str)
        By node: another title and another prompt.
    views : mapping of str to (float, float)
        By node: azimuth and elevation from which it is seen best, degrees.
    rules : mapping of str to str or None
        Rules that differ; None for one that it has not.
    glass, shut_lines : tuple of str, optional
        Instead of those of the base.
    insets : mapping of str to mapping
        Lamps and grilles that differ.
    """

    base: str
    title: str
    about: str
    nodes: Mapping[str, Point]
    tangents: Mapping[str, tuple[Point, Point]] = field(default_factory=dict)
    words: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    views: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    rules: Mapping[str, str | None] = field(default_factory=dict)
    glass: tuple[str, ...] | None = None
    shut_lines: tuple[str, ...] | None = None
    insets: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)


DOOR: Final = {
    "S3": (
        "Waistline at the end of the door",
        "Lower edge of the side windows, where the door ends",
    ),
    "R2": (
        "Roof edge at the end of the door",
        "Upper edge of the side windows, where the door ends",
    ),
    "B3": ("Sill at the end of the door", "Lower edge of the body, where the door ends"),
    "C4": ("Roof, highest point", "Top of the roof, in the middle, above the ends of the doors"),
}
"""Words for cars with one door on each side."""

KINDS: Final[Mapping[str, Kind]] = {
    "coupe": Kind(
        "sedan",
        "Coupé",
        "Three boxes, two long doors, a low roof; the size of a middle-class car.",
        {
            "C0": (71, 0, 182), "C1": (91, 0, 646), "C2": (1337, 0, 934), "C3": (2130, 0, 1318),
            "C4": (2631, 0, 1364), "C5": (3193, 0, 1313), "C6": (4137, 0, 1050),
            "C7": (4586, 0, 1025), "C8": (4591, 0, 288),
            "S1": (420, 695, 672), "S2": (1457, 851, 924), "S3": (2812, 896, 939),
            "S4": (4000, 851, 985), "S5": (4423, 685, 970),
            "R1": (2190, 564, 1267), "R2": (2772, 584, 1314), "R3": (3173, 534, 1257),
            "B1": (339, 800, 197), "B2": (1307, 881, 172), "B3": (2772, 891, 172),
            "B4": (3229, 886, 180), "B5": (4374, 790, 303),
            "WF": (870, 791, 335), "WR": (3620, 803, 335),
        },
        words=DOOR,
        shut_lines=(
            "C1-S1", "S1-B1", "S2-S1", "S2-B2", "S3-B3", "C7-S5", "S5-S4", "B5-S5",
        ),
    ),
    "estate": Kind(
        "hatchback",
        "Estate",
        "Two boxes, a long roof and a tailgate; the size of a middle-class car.",
        {
            "C0": (66, 0, 193), "C1": (91, 0, 694), "C2": (1188, 0, 972), "C3": (1944, 0, 1390),
            "C4": (2561, 0, 1464), "C5": (4256, 0, 1390), "C6": (4556, 0, 1023),
            "C7": (4642, 0, 714), "C8": (4647, 0, 288),
            "S1": (385, 681, 699), "S2": (1308, 840, 957), "S3": (2511, 878, 942),
            "S4": (3796, 860, 977), "S5": (4470, 661, 1013), "S6": (4502, 751, 709),
            "R1": (2004, 593, 1340), "R2": (2621, 613, 1421), "R3": (4149, 571, 1342),
            "B1": (324, 792, 208), "B2": (1263, 870, 183), "B3": (2471, 874, 183),
            "B4": (3262, 870, 188), "B5": (4459, 782, 293),
            "WF": (880, 780, 325), "WR": (3635, 792, 325),
        },
    ),
    "suv": Kind(
        "hatchback",
        "SUV",
        "Two tall boxes and a tailgate, high above the ground.",
        {
            "C0": (86, 0, 268), "C1": (106, 0, 882), "C2": (1180, 0, 1115), "C3": (1840, 0, 1591),
            "C4": (2460, 0, 1686), "C5": (4131, 0, 1598), "C6": (4478, 0, 1155),
            "C7": (4559, 0, 813), "C8": (4533, 0, 387),
            "S1": (370, 726, 872), "S2": (1280, 866, 1096), "S3": (2440, 906, 1076),
            "S4": (3630, 893, 1115), "S5": (4382, 716, 1150), "S6": (4423, 801, 803),
            "R1": (1910, 626, 1537), "R2": (2490, 651, 1633), "R3": (4031, 623, 1547),
            "B1": (320, 816, 288), "B2": (1340, 891, 268), "B3": (2390, 901, 263),
            "B4": (3240, 893, 273), "B5": (4372, 816, 392),
            "WF": (920, 801, 362), "WR": (3610, 816, 362),
        },
    ),
    "city_car": Kind(
        "hatchback",
        "City car",
        "Two short boxes and a tailgate, for four.",
        {
            "C0": (75, 0, 189), "C1": (93, 0, 725), "C2": (815, 0, 978), "C3": (1415, 0, 1440),
            "C4": (1995, 0, 1509), "C5": (3154, 0, 1435), "C6": (3486, 0, 1003),
            "C7": (3564, 0, 695), "C8": (3549, 0, 278),
            "S1": (335, 601, 730), "S2": (915, 746, 958), "S3": (1975, 787, 943),
            "S4": (2850, 773, 978), "S5": (3389, 591, 1003), "S6": (3461, 706, 685),
            "R1": (1480, 541, 1388), "R2": (2025, 561, 1462), "R3": (3045, 526, 1385),
            "B1": (285, 701, 204), "B2": (1085, 776, 179), "B3": (1915, 781, 179),
            "B4": (2705, 773, 184), "B5": (3422, 736, 283),
            "WF": (705, 681, 311), "WR": (3105, 689, 311),
        },
    ),
    "van": Kind(
        "minivan",
        "Van",
        "One tall box without windows in the rear, with a short bonnet.",
        {
            "C0": (84, 0, 237), "C1": (114, 0, 886), "C2": (890, 0, 1182), "C3": (1529, 0, 1841),
            "C4": (2620, 0, 1985), "C5": (4994, 0, 1855), "C6": (5114, 0, 1280),
            "C7": (5127, 0, 749), "C8": (5102, 0, 334),
            "S1": (376, 776, 876), "S2": (994, 898, 1152), "S3": (2170, 933, 1113),
            "S4": (4267, 923, 1142), "S5": (5059, 846, 1270), "S6": (5002, 872, 739),
            "R1": (1593, 699, 1758), "R2": (2213, 738, 1897), "R3": (4905, 736, 1797),
            "B1": (316, 849, 247), "B2": (1368, 923, 212), "B3": (2352, 931, 209),
            "B4": (3721, 923, 217), "B5": (4942, 874, 339),
            "WF": (930, 835, 345), "WR": (4138, 852, 345),
        },
        # The roof is flat up to its rear edge, where it turns down.
        tangents={
            "C4-C5": ((2698, 0, 0), (820, 0, -287)), "C5-C6": ((615, 0, -215), (40, 0, -657)),
            "R2-R3": ((2169, 53, 0), (880, -20, -220)),
            "R3-S5": ((660, -15, -165), (62, 142, -706)),
        },
        words={
            "S3": (
                "Waistline at the B-pillar",
                "Lower edge of the door’s window, at the pillar behind the door",
            ),
            "S4": (
                "Waistline above the rear wheel",
                "Side of the load space above the rear wheel, as high as the waistline",
            ),
            "R2": ("Roof edge at the B-pillar", "Edge of the roof, above the pillar of the door"),
            "R3": ("Rear corner of the roof", "Rear corner of the roof, above the rear doors"),
            "B3": (
                "Sill at the B-pillar",
                "Lower edge of the body, below the pillar behind the door",
            ),
            "C4": (
                "Roof, highest point",
                "Top of the roof, in the middle, above the pillars behind the doors",
            ),
        },
        glass=("windscreen", "tailgate_glass", "glass_front"),
        shut_lines=(
            "C1-S1", "S1-B1", "S2-S1", "S2-B2", "S3-B3", "R2-S3", "S4-B4", "C7-S6", "S6-S5",
            "B5-S6",
        ),
        rules={
            "The rear window leans forward": None,
            "The rear window leans rearward by 10 cm at most": "C6.x >= C5.x - 100",
        },
    ),
    "pickup": Kind(
        "sedan",
        "Pickup",
        "A cab with four doors, and a bed under a flat cover.",
        {
            "C0": (103, 0, 347), "C1": (132, 0, 1022), "C2": (1272, 0, 1181), "C3": (1978, 0, 1716),
            "C4": (2553, 0, 1832), "C5": (3309, 0, 1746), "C6": (3495, 0, 1216),
            "C7": (5255, 0, 1171), "C8": (5275, 0, 516),
            "S1": (341, 771, 998), "S2": (1323, 882, 1152), "S3": (2442, 902, 1152),
            "S4": (3440, 892, 1181), "S5": (5127, 862, 1156),
            "R1": (2049, 641, 1668), "R2": (2583, 666, 1779), "R3": (3289, 641, 1693),
            "B1": (332, 842, 377), "B2": (1454, 907, 397), "B3": (2462, 912, 397),
            "B4": (3561, 907, 407), "B5": (5137, 842, 516),
            "WF": (980, 791, 385), "WR": (4100, 791, 385),
        },
        words={
            "C6": ("Rear window, lower edge", "Foot of the rear window, in the middle"),
            "C7": ("Tailgate, upper edge", "Upper edge of the tailgate, in the middle"),
            "S4": ("C-pillar, foot", "Foot of the cab’s rear pillar, where it meets the bed"),
            "S5": ("Bed, rear corner", "Rear corner of the bed, above the tail lamp"),
        },
        rules={
            "The boot lid lies behind the rear window": None,
            "The bed lies behind the cab": "C7.x >= C6.x + 50",
        },
    ),
    "limousine": Kind(
        "sedan",
        "Limousine",
        "Three long boxes, four doors, a boot lid.",
        {
            "C0": (86, 0, 194), "C1": (111, 0, 758), "C2": (1380, 0, 1017), "C3": (2160, 0, 1436),
            "C4": (2910, 0, 1494), "C5": (3830, 0, 1428), "C6": (4568, 0, 1127),
            "C7": (5206, 0, 1077), "C8": (5221, 0, 289),
            "S1": (428, 725, 763), "S2": (1500, 890, 997), "S3": (2860, 930, 982),
            "S4": (4479, 880, 1047), "S5": (5047, 720, 1017),
            "R1": (2225, 625, 1381), "R2": (2980, 650, 1447), "R3": (3840, 610, 1376),
            "B1": (357, 830, 209), "B2": (1310, 915, 184), "B3": (2810, 925, 184),
            "B4": (3710, 920, 189), "B5": (5007, 830, 299),
            "WF": (900, 825, 350), "WR": (4070, 840, 350),
        },
    ),
}  # fmt: skip
"""The templates by their ids."""


def template_of(name: str) -> bytes:
    """Return the file of a template."""
    kind = KINDS[name]
    told: dict[str, Any] = json.loads(bundled_file(kind.base))
    network = shaped(read_template(bundled_file(kind.base)), kind)
    told |= {"id": name, "title": kind.title, "about": kind.about}
    for section in ("centre", "pairs", "wheels"):
        for node, record in told[section].items():
            record["at"] = list(kind.nodes[node])
            if node in kind.words:
                record["title"], record["prompt"] = kind.words[node]
            if node in kind.views:
                azimuth, elevation = kind.views[node]
                record["picture"] |= {"azimuth": azimuth, "elevation": elevation}
    told["edges"] = {key: written(network, key) for key in told["edges"]}
    rules = told["soundness"] | kind.rules
    told["soundness"] = {rule: text for rule, text in rules.items() if text is not None}
    told["insets"] |= kind.insets
    told["glass"] = list(kind.glass or told["glass"])
    told["shut_lines"] = list(kind.shut_lines or told["shut_lines"])
    return laid_out(told).encode()


def shaped(base: Template, kind: Kind) -> Network:
    """Return the network of a kind: fair lines, creases of one side, and smooth surfaces."""
    places = np.array([placed(name, kind) for name in base.names], float)
    network = opened(crested(with_straight_edges(smooth_chains(turned_with_chords(base, places)))))
    given: dict[tuple[int, int], Array] = {}
    for key, tangents in kind.tangents.items():
        edge, sense = found(base, key)
        ends = tangents if sense > 0 else tangents[::-1]
        given |= {(edge, end): sense * np.array(ends[end], float) for end in (0, 1)}
    return lock_ratios(one_sided(smooth_chains(with_tangents(network, given))))


def with_straight_edges(network: Network) -> Network:
    """Return a network whose edges that bend twice run straight, and their neighbours along them.

    Unlike `fair_lines.straightened` it is not continuous in the nodes, and leaves exact straight
    lines: those of a template are designed.
    """
    at = {
        end: joint for joint in junctions(network.template) for end in (joint.before, joint.after)
    }
    for _ in range(STRAIGHTENINGS):
        bends = double_bends(network)
        bad = np.flatnonzero(bends > STRAIGHT)
        if not len(bad):
            break
        changed: dict[tuple[int, int], Array] = {}
        for edge in bad[np.argsort(-bends[bad], kind="stable")].tolist():
            start, finish = network.ends[edge]
            way = (finish - start) / np.linalg.norm(finish - start)
            for end in (0, 1):
                joint = at.get((edge, end))
                if joint is not None and joint.crosses:
                    continue
                together = {(edge, end): 1}
                if joint is not None:
                    together = dict(zip((joint.before, joint.after), joint.senses, strict=True))
                if together.keys() & (changed.keys()):
                    continue
                own = together[edge, end]
                for other, sense in together.items():
                    length = np.linalg.norm(network.tangents[other])
                    changed[other] = sense * own * length * way
        network = with_tangents(network, changed)
    return network


def placed(name: str, kind: Kind) -> Point:
    """Return the place of a node."""
    half, _, side = name.partition(".")
    x, y, z = kind.nodes[half]
    return x, -y if side == "L" else y, z


def found(template: Template, key: str) -> tuple[int, int]:
    """Return the edge that a file calls by its ends, and 1 or -1 for its sense."""
    names = {name.removesuffix(".R"): number for name, number in template.node.items()}
    start, end = key.split("-")
    signed = template.edge_between[names[start], names[end]]
    return max(signed, ~signed), 1 if signed >= 0 else -1


def written(network: Network, key: str) -> list[list[float]]:
    """Return the tangents of an edge as a file has them."""
    edge, sense = found(network.template, key)
    own = sense * network.tangents[edge][::sense]
    rows: list[list[float]] = (np.round(own, DECIMALS) + 0.0).tolist()
    return [[int(value) if value == int(value) else value for value in row] for row in rows]


def laid_out(told: Mapping[str, Any]) -> str:
    """Return JSON with a line for each node's fact, edge, patch and rule."""
    lines = []
    for key, value in told.items():
        if isinstance(value, dict):
            rows = [f"    {_text(name)}: {_entry(entry)}" for name, entry in value.items()]
            lines.append(f"  {_text(key)}: {{\n" + ",\n".join(rows) + "\n  }")
        else:
            lines.append(f"  {_text(key)}: {_text(value)}")
    return "{\n" + ",\n".join(lines) + "\n}\n"


def _entry(value: Any) -> str:
    if isinstance(value, dict) and "at" in value:
        rows = [f"      {_text(name)}: {_text(entry)}" for name, entry in value.items()]
        return "{\n" + ",\n".join(rows) + "\n    }"
    return _text(value)


def _text(value: Any) -> str:
    return json.dumps(value, ensure_ascii=False)


def main(names: list[str]) -> None:
    """Write templates, all unless some are named."""
    for name in names or KINDS:
        (FOLDER / f"{name}.json").write_bytes(template_of(name))


if __name__ == "__main__":
    main(sys.argv[1:])
