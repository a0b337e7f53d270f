"""Colours and materials of surfaces and details."""

from __future__ import annotations

from typing import Literal

Color = tuple[int, int, int]


Finish = Literal["matt", "gloss", "rubber", "metal", "glass"]


FINISHES = (
    ("matt", "Matt"),
    ("gloss", "Gloss"),
    ("rubber", "Rubber"),
    ("metal", "Metal"),
    ("glass", "Glass"),
)
