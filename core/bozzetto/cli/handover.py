"""Switches of the commands that hand shapes over to other programs."""

from __future__ import annotations

import argparse
from typing import Any

from bozzetto.errors import UserError


def add_handover(command: argparse.ArgumentParser) -> None:
    """Add the switches to a command."""
    group = command.add_argument_group("how it is handed over")
    group.add_argument("--unit", metavar="UNIT", help="mm, cm, m or in: unit of the file's numbers")
    group.add_argument("--up", metavar="AXIS", help="y or z: the axis of the file that points up")
    group.add_argument("--scale", metavar="S", default="1", help="make it larger or smaller")
    group.add_argument("--triangles", metavar="N", help="at most so many triangles together")
    group.add_argument(
        "--quads", metavar="N", help="about so many quads together, along the shape; OBJ, PLY, USD"
    )
    group.add_argument(
        "--lods", action="store_true", help="two coarser levels of detail in the same GLB"
    )
    group.add_argument(
        "--uvs",
        action="store_true",
        help="places for a picture to be painted on, one for all parts, in GLB, OBJ and USD",
    )
    group.add_argument(
        "--separate-parts",
        action="store_true",
        help="each named part of an object as an object of its own, in GLB, OBJ, USD and 3MF",
    )
    group.add_argument(
        "--curves-alone", action="store_true", help="no surfaces, in STEP, IGES and 3DM"
    )
    group.add_argument(
        "--lay-flat", action="store_true", help="lay it on its steadiest face, for printing"
    )
    group.add_argument(
        "--drawing",
        metavar="KIND",
        help="outlines: edges as a view shows them; blueprint: a sheet with dimensions",
    )
    group.add_argument("--hidden", action="store_true", help="dashed hidden lines in drawings")


def handover_of(options: argparse.Namespace) -> Any:
    """Return the `Handover` that the switches ask for.

    Raises
    ------
    UserError
        If a value is none that can be used.
    """
    from bozzetto.exchange.handover import Handover

    most = options.triangles
    return Handover(
        unit=options.unit,
        up=options.up,
        scale=_number(options.scale, "--scale", float),
        triangles=None if most is None else _number(most, "--triangles", int),
        quads=None if options.quads is None else _number(options.quads, "--quads", int),
        lay_flat=options.lay_flat,
        lines=options.drawing,
        hidden=options.hidden,
        levels=options.lods,
        uvs=options.uvs,
        separate_parts=options.separate_parts,
        curves_alone=options.curves_alone,
    )


def _number(text: str, switch: str, kind: Any) -> Any:
    try:
        return kind(text)
    except ValueError:
        raise UserError(f"{switch} takes a number, not {text!r}.") from None
