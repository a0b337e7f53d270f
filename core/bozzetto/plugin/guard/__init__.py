"""The border that a call into a plugin passes: limits, checks of answers, faults."""
