"""How much of a long test is done: a share in CI, all of it with ``BOZZETTO_LONG=1``."""

from __future__ import annotations

import os

FULL = bool(os.environ.get("BOZZETTO_LONG"))


def sized(share: int, full: int) -> int:
    """Return how many cases to try: the share, or the full number where all is asked for."""
    return full if FULL else share
