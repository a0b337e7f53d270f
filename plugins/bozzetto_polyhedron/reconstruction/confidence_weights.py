"""Numbers that correct the confidence; ``python -m tests.plugins.polyhedron.fit_corrections``."""

from __future__ import annotations

from typing import Final

BIAS: Final = -3.289
"""Log odds that the first answer is right, without what follows."""

CORRECTIONS: Final = {
    "log odds by random solids": (-0.4666, 8.278, 0.4076),
    "lead over other shapes": (-0.7783, 6.0, 0.75),
    "whether it is open": (0.0, 1.0, -8.133),
    "whether a part hangs nowhere": (0.0, 1.0, -10.22),
    "logarithm of the number of lines": (2.197, 3.871, 1.415),
    "frame coverage": (0.3854, 1.0, -1.522),
}
"""Of each trait the least and the largest value, and what it adds to the log odds."""
