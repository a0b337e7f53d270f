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
from bozzetto_car.template.network import Network, with_tangents

Array = NDArray[np.float64]
Point = tuple[float, float, float]

FOLDER: Final = Path(__file__).parents[1] / "plugins/bozzetto_car/templates"

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
            "C0": (75, 0, 180), "C1": (95, 0, 640), "C2": (1330, 0, 925), "C3": (2120, 0, 1305),
            "C4": (2620, 0, 1350), "C5": (3180, 0, 1300), "C6": (4130, 0, 1040),
            "C7": (4585, 0, 1015), "C8": (4590, 0, 285),
            "S1": (420, 690, 665), "S2": (1450, 845, 915), "S3": (2800, 890, 930),
            "S4": (3990, 845, 975), "S5": (4420, 680, 960),
            "R1": (2180, 560, 1255), "R2": (2760, 580, 1300), "R3": (3160, 530, 1245),
            "B1": (340, 795, 195), "B2": (1300, 875, 170), "B3": (2760, 885, 170),
            "B4": (3215, 880, 178), "B5": (4370, 785, 300),
            "WF": (865, 790, 335), "WR": (3605, 805, 335),
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
            "C0": (75, 0, 195), "C1": (100, 0, 700), "C2": (1190, 0, 980), "C3": (1950, 0, 1400),
            "C4": (2570, 0, 1448), "C5": (4230, 0, 1400), "C6": (4510, 0, 1030),
            "C7": (4590, 0, 720), "C8": (4595, 0, 290),
            "S1": (390, 680, 705), "S2": (1310, 838, 965), "S3": (2520, 876, 950),
            "S4": (3800, 858, 985), "S5": (4430, 660, 1020), "S6": (4460, 750, 715),
            "R1": (2010, 592, 1350), "R2": (2630, 612, 1405), "R3": (4130, 570, 1352),
            "B1": (330, 790, 210), "B2": (1265, 868, 185), "B3": (2480, 872, 185),
            "B4": (3275, 868, 190), "B5": (4420, 780, 295),
            "WF": (880, 778, 325), "WR": (3650, 790, 325),
        },
    ),
    "suv": Kind(
        "hatchback",
        "SUV",
        "Two tall boxes and a tailgate, high above the ground.",
        {
            "C0": (75, 0, 270), "C1": (95, 0, 890), "C2": (1170, 0, 1125), "C3": (1830, 0, 1605),
            "C4": (2450, 0, 1678), "C5": (4120, 0, 1612), "C6": (4465, 0, 1165),
            "C7": (4545, 0, 820), "C8": (4520, 0, 390),
            "S1": (360, 725, 880), "S2": (1270, 865, 1105), "S3": (2430, 905, 1085),
            "S4": (3620, 892, 1125), "S5": (4370, 715, 1160), "S6": (4410, 800, 810),
            "R1": (1900, 625, 1550), "R2": (2480, 650, 1625), "R3": (4020, 622, 1560),
            "B1": (310, 815, 290), "B2": (1330, 890, 270), "B3": (2380, 900, 265),
            "B4": (3230, 892, 275), "B5": (4360, 815, 395),
            "WF": (910, 800, 362), "WR": (3600, 815, 362),
        },
    ),
    "city_car": Kind(
        "hatchback",
        "City car",
        "Two short boxes and a tailgate, for four.",
        {
            "C0": (60, 0, 190), "C1": (78, 0, 730), "C2": (800, 0, 985), "C3": (1400, 0, 1450),
            "C4": (1980, 0, 1500), "C5": (3140, 0, 1445), "C6": (3480, 0, 1010),
            "C7": (3560, 0, 700), "C8": (3545, 0, 280),
            "S1": (320, 600, 735), "S2": (900, 745, 965), "S3": (1960, 785, 950),
            "S4": (2850, 770, 985), "S5": (3390, 590, 1010), "S6": (3455, 705, 690),
            "R1": (1465, 540, 1398), "R2": (2010, 560, 1452), "R3": (3055, 525, 1395),
            "B1": (270, 700, 205), "B2": (1070, 775, 180), "B3": (1900, 780, 180),
            "B4": (2690, 772, 185), "B5": (3425, 735, 285),
            "WF": (690, 690, 311), "WR": (3090, 700, 311),
        },
    ),
    "van": Kind(
        "minivan",
        "Van",
        "One tall box without windows in the rear, with a short bonnet.",
        {
            "C0": (80, 0, 240), "C1": (110, 0, 900), "C2": (880, 0, 1200), "C3": (1480, 0, 1870),
            "C4": (2500, 0, 1975), "C5": (4780, 0, 1900), "C6": (4855, 0, 1300),
            "C7": (4890, 0, 760), "C8": (4880, 0, 340),
            "S1": (370, 790, 890), "S2": (980, 915, 1170), "S3": (2080, 950, 1130),
            "S4": (4050, 940, 1160), "S5": (4800, 862, 1290), "S6": (4800, 888, 750),
            "R1": (1540, 740, 1790), "R2": (2120, 785, 1890), "R3": (4700, 775, 1840),
            "B1": (310, 865, 250), "B2": (1330, 940, 215), "B3": (2250, 948, 212),
            "B4": (3530, 940, 220), "B5": (4720, 890, 345),
            "WF": (920, 850, 345), "WR": (3920, 868, 345),
        },
        glass=("windscreen", "tailgate_glass", "glass_front"),
    ),
    "pickup": Kind(
        "sedan",
        "Pickup",
        "A cab with four doors, and a bed under a flat cover.",
        {
            "C0": (80, 0, 350), "C1": (110, 0, 1060), "C2": (1290, 0, 1190), "C3": (1990, 0, 1730),
            "C4": (2560, 0, 1812), "C5": (3330, 0, 1760), "C6": (3480, 0, 1225),
            "C7": (5270, 0, 1180), "C8": (5290, 0, 520),
            "S1": (330, 770, 1030), "S2": (1340, 880, 1160), "S3": (2450, 900, 1160),
            "S4": (3440, 890, 1190), "S5": (5170, 860, 1165),
            "R1": (2060, 640, 1680), "R2": (2590, 665, 1760), "R3": (3290, 640, 1705),
            "B1": (320, 840, 380), "B2": (1470, 905, 400), "B3": (2470, 910, 400),
            "B4": (3560, 905, 410), "B5": (5150, 840, 520),
            "WF": (1000, 790, 385), "WR": (4085, 790, 385),
        },
    ),
    "limousine": Kind(
        "sedan",
        "Limousine",
        "Three long boxes, four doors, a boot lid.",
        {
            "C0": (80, 0, 195), "C1": (105, 0, 760), "C2": (1370, 0, 1020), "C3": (2150, 0, 1440),
            "C4": (2900, 0, 1492), "C5": (3820, 0, 1432), "C6": (4560, 0, 1130),
            "C7": (5200, 0, 1080), "C8": (5215, 0, 290),
            "S1": (420, 725, 765), "S2": (1490, 890, 1000), "S3": (2850, 930, 985),
            "S4": (4470, 880, 1050), "S5": (5040, 720, 1020),
            "R1": (2215, 625, 1385), "R2": (2970, 650, 1445), "R3": (3830, 610, 1380),
            "B1": (350, 830, 210), "B2": (1300, 915, 185), "B3": (2800, 925, 185),
            "B4": (3700, 920, 190), "B5": (5000, 830, 300),
            "WF": (890, 825, 350), "WR": (4060, 840, 350),
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
    network = opened(straightened(smooth_chains(turned_with_chords(base, places))))
    given: dict[tuple[int, int], Array] = {}
    for key, tangents in kind.tangents.items():
        edge, sense = found(base, key)
        ends = tangents if sense > 0 else tangents[::-1]
        given |= {(edge, end): sense * np.array(ends[end], float) for end in (0, 1)}
    return lock_ratios(with_tangents(network, given))


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
