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
from bozzetto_car.body.fair_lines import opened, straightened, turned_with_chords
from bozzetto_car.template.loader import bundled_file, read_template
from bozzetto_car.template.model import Template
from bozzetto_car.template.network import Network, junctions, with_tangents

Array = NDArray[np.float64]
Point = tuple[float, float, float]

FOLDER: Final = Path(__file__).parents[1] / "plugins/bozzetto_car/templates"

LEVEL: Final = ("C4", "R2.R")
"""Highest nodes of the roof, in the middle and above the side windows."""

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
            "C0": (70, 0, 180), "C1": (90, 0, 640), "C2": (1325, 0, 925), "C3": (2115, 0, 1305),
            "C4": (2615, 0, 1350), "C5": (3175, 0, 1300), "C6": (4125, 0, 1040),
            "C7": (4580, 0, 1015), "C8": (4585, 0, 285),
            "S1": (415, 690, 665), "S2": (1445, 845, 915), "S3": (2795, 890, 930),
            "S4": (3985, 845, 975), "S5": (4415, 680, 960),
            "R1": (2175, 560, 1255), "R2": (2755, 580, 1300), "R3": (3155, 530, 1245),
            "B1": (335, 795, 195), "B2": (1295, 875, 170), "B3": (2755, 885, 170),
            "B4": (3210, 880, 178), "B5": (4365, 785, 300),
            "WF": (860, 786, 335), "WR": (3600, 798, 335),
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
            "C0": (67, 0, 195), "C1": (92, 0, 700), "C2": (1182, 0, 980), "C3": (1942, 0, 1400),
            "C4": (2562, 0, 1448), "C5": (4222, 0, 1400), "C6": (4502, 0, 1030),
            "C7": (4582, 0, 720), "C8": (4587, 0, 290),
            "S1": (382, 680, 705), "S2": (1302, 838, 965), "S3": (2512, 876, 950),
            "S4": (3792, 858, 985), "S5": (4422, 660, 1020), "S6": (4452, 750, 715),
            "R1": (2002, 592, 1350), "R2": (2622, 612, 1405), "R3": (4122, 570, 1352),
            "B1": (322, 790, 210), "B2": (1257, 868, 185), "B3": (2472, 872, 185),
            "B4": (3267, 868, 190), "B5": (4412, 780, 295),
            "WF": (872, 778, 325), "WR": (3642, 790, 325),
        },
    ),
    "suv": Kind(
        "hatchback",
        "SUV",
        "Two tall boxes and a tailgate, high above the ground.",
        {
            "C0": (87, 0, 270), "C1": (107, 0, 890), "C2": (1182, 0, 1125), "C3": (1842, 0, 1605),
            "C4": (2462, 0, 1678), "C5": (4132, 0, 1612), "C6": (4477, 0, 1165),
            "C7": (4557, 0, 820), "C8": (4532, 0, 390),
            "S1": (372, 725, 880), "S2": (1282, 865, 1105), "S3": (2442, 905, 1085),
            "S4": (3632, 892, 1125), "S5": (4382, 715, 1160), "S6": (4422, 800, 810),
            "R1": (1912, 625, 1550), "R2": (2492, 650, 1625), "R3": (4032, 622, 1560),
            "B1": (322, 815, 290), "B2": (1342, 890, 270), "B3": (2392, 900, 265),
            "B4": (3242, 892, 275), "B5": (4372, 815, 395),
            "WF": (922, 800, 362), "WR": (3612, 815, 362),
        },
    ),
    "city_car": Kind(
        "hatchback",
        "City car",
        "Two short boxes and a tailgate, for four.",
        {
            "C0": (75, 0, 190), "C1": (93, 0, 730), "C2": (815, 0, 985), "C3": (1415, 0, 1450),
            "C4": (1995, 0, 1500), "C5": (3155, 0, 1445), "C6": (3495, 0, 1010),
            "C7": (3575, 0, 700), "C8": (3560, 0, 280),
            "S1": (335, 600, 735), "S2": (915, 745, 965), "S3": (1975, 785, 950),
            "S4": (2850, 772, 985), "S5": (3395, 590, 1010), "S6": (3470, 705, 690),
            "R1": (1480, 540, 1398), "R2": (2025, 560, 1452), "R3": (3045, 525, 1395),
            "B1": (285, 700, 205), "B2": (1085, 775, 180), "B3": (1915, 780, 180),
            "B4": (2705, 772, 185), "B5": (3430, 735, 285),
            "WF": (705, 680, 311), "WR": (3105, 688, 311),
        },
    ),
    "van": Kind(
        "minivan",
        "Van",
        "One tall box without windows in the rear, with a short bonnet.",
        {
            "C0": (85, 0, 240), "C1": (115, 0, 900), "C2": (885, 0, 1200), "C3": (1485, 0, 1870),
            "C4": (2505, 0, 1975), "C5": (4785, 0, 1900), "C6": (4905, 0, 1300),
            "C7": (4910, 0, 760), "C8": (4885, 0, 340),
            "S1": (375, 790, 890), "S2": (985, 915, 1170), "S3": (2085, 950, 1130),
            "S4": (4055, 940, 1160), "S5": (4850, 862, 1290), "S6": (4785, 888, 750),
            "R1": (1545, 712, 1785), "R2": (2125, 752, 1885), "R3": (4695, 750, 1838),
            "B1": (315, 865, 250), "B2": (1335, 940, 215), "B3": (2255, 948, 212),
            "B4": (3535, 940, 220), "B5": (4725, 890, 345),
            "WF": (925, 850, 345), "WR": (3925, 868, 345),
        },
        glass=("windscreen", "tailgate_glass", "glass_front"),
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
            "C0": (103, 0, 350), "C1": (133, 0, 1030), "C2": (1313, 0, 1190), "C3": (2013, 0, 1730),
            "C4": (2583, 0, 1812), "C5": (3333, 0, 1760), "C6": (3518, 0, 1225),
            "C7": (5293, 0, 1180), "C8": (5313, 0, 520),
            "S1": (353, 770, 1005), "S2": (1363, 880, 1160), "S3": (2473, 900, 1160),
            "S4": (3463, 890, 1190), "S5": (5163, 860, 1165),
            "R1": (2083, 640, 1680), "R2": (2613, 665, 1760), "R3": (3313, 640, 1705),
            "B1": (343, 840, 380), "B2": (1493, 905, 400), "B3": (2493, 910, 400),
            "B4": (3583, 905, 410), "B5": (5173, 840, 520),
            "WF": (1023, 790, 385), "WR": (4108, 790, 385),
        },
    ),
    "limousine": Kind(
        "sedan",
        "Limousine",
        "Three long boxes, four doors, a boot lid.",
        {
            "C0": (86, 0, 195), "C1": (111, 0, 760), "C2": (1376, 0, 1020), "C3": (2156, 0, 1440),
            "C4": (2906, 0, 1492), "C5": (3826, 0, 1432), "C6": (4566, 0, 1130),
            "C7": (5206, 0, 1080), "C8": (5221, 0, 290),
            "S1": (426, 725, 765), "S2": (1496, 890, 1000), "S3": (2856, 930, 985),
            "S4": (4476, 880, 1050), "S5": (5046, 720, 1020),
            "R1": (2221, 625, 1385), "R2": (2976, 650, 1445), "R3": (3836, 610, 1380),
            "B1": (356, 830, 210), "B2": (1306, 915, 185), "B3": (2806, 925, 185),
            "B4": (3706, 920, 190), "B5": (5006, 830, 300),
            "WF": (896, 825, 350), "WR": (4066, 840, 350),
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
    """Return the network of a kind: fair lines through its nodes, and smooth surfaces."""
    places = np.array([placed(name, kind) for name in base.names], float)
    network = levelled(smooth_chains(turned_with_chords(base, places)))
    network = opened(straightened(network))
    given: dict[tuple[int, int], Array] = {}
    for key, tangents in kind.tangents.items():
        edge, sense = found(base, key)
        ends = tangents if sense > 0 else tangents[::-1]
        given |= {(edge, end): sense * np.array(ends[end], float) for end in (0, 1)}
    return lock_ratios(with_tangents(network, given))


def levelled(network: Network) -> Network:
    """Return a network whose roof is level at its highest nodes."""
    template = network.template
    level = {template.node[name] for name in LEVEL}
    changed = {}
    for joint in junctions(template):
        if joint.node in level and not joint.crosses:
            forth = np.sign(np.diff(network.positions[list(joint.neighbours), 0]))[0]
            for end, sense in zip((joint.before, joint.after), joint.senses, strict=True):
                length = float(np.linalg.norm(network.tangents[end]))
                changed[end] = np.array([sense * forth * length, 0.0, 0.0])
    return with_tangents(network, changed)


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
