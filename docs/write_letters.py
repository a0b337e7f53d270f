"""Write the outlines of letters that come with the product modeler, from a font file.

Run ``python docs/write_letters.py FONT.ttf``, with fontTools at hand; it writes
``plugins/bozzetto_product/lettering/letters.json``. What stands there was made of Roboto Medium
(Apache License 2.0, of which LICENSE holds a copy). So neither a font nor a reader of fonts is
needed where documents are opened, and a text has the same outline on every machine.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

CHARACTERS = "".join(
    chr(code)
    for low, high in (
        (0x20, 0x7E),
        (0xA1, 0x17F),
        (0x386, 0x3CE),
        (0x401, 0x45F),
        (0x2013, 0x2022),
        (0x20AC, 0x20AC),
        (0x2122, 0x2122),
        (0x2190, 0x2193),
    )
    for code in range(low, high + 1)
)
"""Latin of Europe, Greek, Cyrillic, and signs."""

TARGET = Path(__file__).parents[1] / "plugins/bozzetto_product/lettering/letters.json"


def main() -> None:
    """Read the font and write the letters."""
    from fontTools.pens.recordingPen import DecomposingRecordingPen
    from fontTools.ttLib import TTFont

    font = TTFont(sys.argv[1])
    names, glyphs = font.getBestCmap(), font.getGlyphSet()
    wanted = [c for c in CHARACTERS if ord(c) in names and names[ord(c)] in glyphs]
    letters: dict[str, Any] = {}
    for letter in wanted:
        name = names[ord(letter)]
        pen = DecomposingRecordingPen(glyphs)
        glyphs[name].draw(pen)
        letters[letter] = [font["hmtx"][name][0], _contours(pen.value)]
    made = {
        "font": font["name"].getDebugName(4),
        "licence": "Apache-2.0",
        "cap": font["OS/2"].sCapHeight,
        "letters": letters,
        "kerning": _kerning(font, {names[ord(c)]: c for c in wanted}),
    }
    TARGET.write_text(json.dumps(made, ensure_ascii=False, separators=(",", ":")), "utf-8")


def _contours(drawn: list[tuple[str, Any]]) -> list[list[list[int]]]:
    """Return contours as rows of [x, y, 1 on the outline, 0 a control point of a parabola]."""
    rows: list[list[list[int]]] = []
    for step, points in drawn:
        if step == "moveTo":
            rows.append([[*points[0], 1]])
        elif step == "lineTo":
            rows[-1].append([*points[0], 1])
        elif step == "qCurveTo":
            *controls, end = points
            if end is None:  # a contour of parabolas only begins half-way between two controls
                end = [0.5 * (a + b) for a, b in zip(controls[-1], controls[0], strict=True)]
                rows.append([[*end, 1]])
            rows[-1] += [[*point, 0] for point in controls]
            rows[-1].append([*end, 1])
    for row in rows:
        if row[0] == row[-1] and len(row) > 1:
            row.pop()
    return rows


def _kerning(font: Any, letters: dict[str, str]) -> dict[str, int]:
    """Return by how much pairs of letters come together: of the first rule that names a pair."""
    found: dict[str, int] = {}
    for lookup in font["GPOS"].table.LookupList.Lookup:
        for table in lookup.SubTable:
            table = getattr(table, "ExtSubTable", table)
            if table.LookupType == 2:
                for a, b, value in _pairs(table, letters):
                    found.setdefault(letters[a] + letters[b], value)
    return {pair: value for pair, value in found.items() if value}


def _pairs(table: Any, letters: dict[str, str]) -> Iterator[tuple[str, str, int]]:
    firsts = [name for name in table.Coverage.glyphs if name in letters]
    for number, name in enumerate(table.Coverage.glyphs):
        if table.Format == 1 and name in letters:
            for pair in table.PairSet[number].PairValueRecord:
                if pair.SecondGlyph in letters:
                    yield name, pair.SecondGlyph, getattr(pair.Value1, "XAdvance", 0)
    if table.Format == 2:
        for one in firsts:
            row = table.Class1Record[table.ClassDef1.classDefs.get(one, 0)].Class2Record
            for other in letters:
                record = row[table.ClassDef2.classDefs.get(other, 0)]
                if record.Value1 is not None:
                    yield one, other, getattr(record.Value1, "XAdvance", 0)


if __name__ == "__main__":
    main()
