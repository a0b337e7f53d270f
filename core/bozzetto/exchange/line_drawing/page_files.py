"""Pages as SVG and as DXF."""

from __future__ import annotations

import io
import math
from collections.abc import Iterable
from typing import Final
from xml.sax.saxutils import escape, quoteattr

from bozzetto.exchange.cad.dxf import UNIT_NUMBERS
from bozzetto.exchange.handover import MM_PER, Unit
from bozzetto.exchange.line_drawing.page import LAYERS, LayerName, Page, PageLine, PageText
from bozzetto.exchange.optional_libraries import library
from bozzetto.exchange.safe_xml import writable

SPACE: Final = "http://www.w3.org/2000/svg"

INK: Final = "#22211f"

WIDTHS: Final[dict[LayerName, float]] = {
    "visible": 0.5,
    "hidden": 0.25,
    "dimensions": 0.25,
    "frame": 0.35,
}
"""Widths of lines on a sheet of `USUAL` size, mm (ISO 128-2)."""

USUAL: Final = (420.0, 297.0)
"""Sheet to which line widths and dashes belong, mm; other pages have them in proportion."""

DASHES: Final = (3.0, 1.5)
"""Lengths of dashes and gaps, mm."""

DIGITS: Final = 7
"""Of a place, as many as the longer side of a page has."""

DXF_DASH: Final = 0.5
"""Length of a dash of the library's line type, in drawing units."""

DXF_VERSION: Final = "R2010"

UNITLESS: Final = 0
"""The value of $INSUNITS where numbers are in no unit."""

DXF_LINETYPES: Final[dict[LayerName, str]] = {"hidden": "DASHED"}


def page_svg(page: Page) -> bytes:
    """Return a page as SVG: a group for each layer, and in it one for each part, with ids."""
    x, y = page.corner
    share = _share(page)
    digits = max(0, DIGITS - 1 - math.floor(math.log10(max(page.width, page.height))))
    rows = [
        f'<svg xmlns="{SPACE}" viewBox="{x:.9g} {y:.9g} {page.width:.9g} {page.height:.9g}" '
        f'width="{page.width:.9g}{page.unit}" height="{page.height:.9g}{page.unit}">',
        f'<g fill="none" stroke="{INK}" stroke-linecap="round" stroke-linejoin="round">',
    ]
    for layer in LAYERS:
        own = [line for line in page.lines if line.layer == layer]
        if not own:
            continue
        dash = ""
        if layer == "hidden":
            dash = f' stroke-dasharray="{" ".join(f"{d * share:.4g}" for d in DASHES)}"'
        rows.append(f'<g id="{layer}" stroke-width="{WIDTHS[layer] * share:.4g}"{dash}>')
        for number, (name, lines) in enumerate(_by_name(own), 1):
            label = f" data-part={quoteattr(writable(name))}" if name else ""
            rows.append(f'<g id="{layer}-{number}"{label}>')
            rows += [f'<path d="{_path(line, digits)}"/>' for line in lines]
            rows.append("</g>")
        rows.append("</g>")
    rows.append("</g>")
    if page.texts:
        rows.append(f'<g id="words" fill="{INK}" font-family="sans-serif">')
        rows += [_text(text) for text in page.texts]
        rows.append("</g>")
    rows.append("</svg>\n")
    return "\n".join(rows).encode()


def _by_name(lines: Iterable[PageLine]) -> list[tuple[str, list[PageLine]]]:
    found: dict[str, list[PageLine]] = {}
    for line in lines:
        found.setdefault(line.name, []).append(line)
    return list(found.items())


def _share(page: Page) -> float:
    """Return how large a page is beside a usual sheet."""
    return max(page.width / USUAL[0], page.height / USUAL[1])


def _path(line: PageLine, digits: int) -> str:
    """Return a line as path data, with so many digits after the point."""
    points = line.points
    closed = len(points) > 3 and bool((points[0] == points[-1]).all())
    rows = points[:-1] if closed else points
    return (
        "M"
        + "L".join(f"{x:.{digits}f},{y:.{digits}f}" for x, y in rows.tolist())
        + ("Z" if closed else "")
    )


def _text(text: PageText) -> str:
    x, y = text.place
    anchor = ' text-anchor="middle"' if text.centered else ""
    turn = f' transform="rotate(-90 {x:.7g} {y:.7g})"' if text.upwards else ""
    return (
        f'<text x="{x:.7g}" y="{y:.7g}" font-size="{text.height * 1.4:.4g}"{anchor}{turn}>'
        f"{escape(writable(text.words))}</text>"
    )


def page_dxf(page: Page, unit: Unit = "mm") -> bytes:
    """Return a page as DXF: a layer for each kind of line.

    Parameters
    ----------
    page : Page
        In millimetres or in pixels.
    unit : {"mm", "cm", "m", "in"}
        Of the numbers of a page in millimetres; one in pixels has none.

    Raises
    ------
    UserError
        If ezdxf is not installed.
    """
    ezdxf = library("ezdxf", "dxf")
    measured = page.unit == "mm"
    share = 1.0 / MM_PER[unit] if measured else 1.0
    units = UNIT_NUMBERS[unit] if measured else UNITLESS
    document = ezdxf.new(DXF_VERSION, setup=["linetypes"], units=units)
    document.header["$LTSCALE"] = share * _share(page) * DASHES[0] / DXF_DASH
    space = document.modelspace()
    for layer in LAYERS:
        weight = round(100 * WIDTHS[layer])
        document.layers.add(
            layer, linetype=DXF_LINETYPES.get(layer, "CONTINUOUS"), lineweight=weight
        )
    for line in page.lines:
        space.add_lwpolyline(
            [(x, -y) for x, y in (share * line.points).tolist()], dxfattribs={"layer": line.layer}
        )
    for text in page.texts:
        made = space.add_text(
            text.words,
            height=share * text.height,
            rotation=90.0 if text.upwards else 0.0,
            dxfattribs={"layer": "dimensions"},
        )
        x, y = (share * value for value in text.place)
        align = ezdxf.enums.TextEntityAlignment
        made.set_placement((x, -y), align=align.BOTTOM_CENTER if text.centered else align.LEFT)
    stream = io.StringIO()
    document.write(stream)
    encoded: bytes = document.encode(stream.getvalue())
    return encoded
